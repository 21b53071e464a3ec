"""A story becomes a pattern that, called with its parts, says what the story says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from commands_for_tests import Run
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.format import format_source
from i2pdsl.library.extract import Extracted, extract
from i2pdsl.library.parts import read_part
from i2pdsl.resources import data_folder
from i2pdsl.worlds.find import find_vocabulary

STORIES = data_folder("stories")
HEAD = "# A story.\nworld kitchen\nlength 6\nstart absent(table)\nallow deus(table)\n"


def extracted(text: str, folder: Path, *parts: str, defaults: bool = False) -> Extracted:
    source = Source(str(folder / "tale.story"), text)
    target = folder / "made.story"
    found = extract(source, folder, [read_part(p) for p in parts], "made", target, defaults)
    target.write_text(found.text, encoding="utf-8")
    return found


def same(text: str, found: Extracted, folder: Path, *lets: str) -> None:
    """The story with the call for its objective has the objective that it had."""
    kept = [line for line in text.splitlines() if line.split(" ")[0] not in ("maximize", "minimize")
            and not line.startswith("    ")]  # fmt: skip
    new = "\n".join([*kept, *lets, "import made", f"maximize {found.call}"])
    before = check_source(Source("before", text), find_vocabulary, folder)
    after = check_source(Source("after", new), find_vocabulary, folder)
    assert isinstance(before, TypedStory)
    assert isinstance(after, TypedStory)
    if len(before.objective) == 1 and before.objective[0][0] == 1:
        assert after.objective == before.objective
    assert after.assumption == before.assumption


def refused(text: str, folder: Path, *parts: str) -> str:
    with pytest.raises(StoryError) as caught:
        extracted(text, folder, *parts)
    assert not (folder / "made.story").exists()
    return str(caught.value)


def test_a_part_becomes_a_parameter(tmp_path: Path) -> None:
    text = HEAD + "maximize twist(rho > 0, rho < 0)\nsearch beam(starts = 9)\n"
    found = extracted(text, tmp_path, "before=rho > 0", "after=rho<0")
    assert found.text == (
        "# A story.\n"
        "# Taken from tale.story: world kitchen, length 6, start absent(table), "
        "allow deus(table), search\n# beam(starts = 9).\n"
        "pattern made(before, after) =\n    twist(before, after)\n"
    )
    assert (found.signature, found.call) == ("made(before, after)", "made(rho > 0, rho<0)")
    assert found.replaced == {"before": 1, "after": 1}
    same(text, found, tmp_path)


@pytest.mark.parametrize(
    ("objective", "parts", "body"),
    [
        ("maximize depict(rho = 0)", ["e=rho = 0"], "depict(e)"),
        ("maximize depict(event = (rho > 0))", ["e=rho > 0"], "depict(event = (e))"),
        ("maximize depict(rho > 0) + depict(rho > 0)", ["e=rho>0"], "depict(e) + depict(e)"),
        ("maximize sum_t P(not (rho > 0) | script[:t])", ["e=rho > 0"],
         "sum_t P(not (e) | script[:t])"),
        ("maximize 2 * depict(rho > 0)", ["w=2"], "w * depict(rho > 0)"),
        ("maximize arc(robot, shape = sin(t/T * 3*pi))", ["s=sin(t/T * 3*pi)", "who=robot"],
         "arc(who, shape = s)"),
        ("maximize sum_t P(G_cheese = pink | script[:t])", ["x=G_cheese", "v=pink"],
         "sum_t P(x = v | script[:t])"),
        ("maximize P(rho > 0 | (script ++ [cheese: stay, robot: east])[:T])",
         ["how=east", "s=script"], "P(rho > 0 | (s ++ [cheese: stay, robot: how])[:T])"),
        ("maximize sum_t [at(robot, (4, 4)) @ script[t]]", ["where=(4, 4)"],
         "sum_t [at(robot, where) @ script[t]]"),
    ],
)  # fmt: skip
def test_where_a_part_can_stand(
    tmp_path: Path, objective: str, parts: list[str], body: str
) -> None:
    text = f"{HEAD}{objective}\n"
    found = extracted(text, tmp_path, *parts)
    assert found.text.endswith(f"=\n    {body}\n")
    same(text, found, tmp_path)


def test_several_objectives_become_one_sum(tmp_path: Path) -> None:
    text = (
        HEAD + "minimize depict(rho > 0) + 1\nmaximize if T > 3 then 1 else 2\n"
        "minimize sum_t t * P(rho < 0 | script[:t])\nmaximize 3 * depict(rho < 0)\n"
    )
    found = extracted(text, tmp_path, "bad=rho < 0")
    assert found.text.endswith(
        "    -(depict(rho > 0) + 1)\n"
        "    + (if T > 3 then 1 else 2)\n"
        "    - sum_t t * P(bad | script[:t])\n"
        "    + 3 * depict(bad)\n"
    )
    assert found.replaced == {"bad": 2}


def test_lets_are_carried_along_or_put_in(tmp_path: Path) -> None:
    text = (
        HEAD + "let early = T/3\nlet helps = rho > 0 and G_cheese = pink\nlet twice = helps\n"
        "let unused = 4\nmaximize sum_t (if t < early then P(twice | script[:t]) else 0)\n"
    )
    found = extracted(text, tmp_path, "goal=G_cheese = pink")
    assert found.carried == ["early"]
    assert "let early = T/3\n" in found.text
    assert "P((rho > 0 and goal) | script[:t])" in found.text
    assert "unused" not in found.text
    assert "helps" not in found.text
    same(text, found, tmp_path)


def test_patterns_and_imports_are_carried_along(tmp_path: Path) -> None:
    (tmp_path / "mine.story").write_text("pattern half(x) = x / 2\n", encoding="utf-8")
    text = (
        HEAD + "import mine\n# Weighs.\npattern own(e, w) = w * weigh(e)\n"
        "pattern weigh(e) = half(depict(e))\nmaximize own(rho > 0, 3)\n"
    )
    found = extracted(text, tmp_path, "e=rho > 0")
    assert found.carried == ["own", "weigh"]
    assert found.text.startswith("import mine\n\n# Weighs.\npattern own(e, w)")
    inner = tmp_path / "inner"
    inner.mkdir()
    source = Source("tale.story", text)
    made = extract(source, tmp_path, [read_part("e=rho > 0")], "made", inner / "made.story")
    assert made.text.startswith('import "../mine.story"\n')


def test_defaults(tmp_path: Path) -> None:
    text = HEAD + "let middle = T/2\nmaximize twist(rho > 0, rho < 0, turn = middle)\n"
    found = extracted(text, tmp_path, "e=rho > 0", "turn_at=middle", defaults=True)
    assert "pattern made(e = rho > 0, turn_at = middle) =" in found.text
    assert found.call == "made()"
    assert found.carried == ["middle"]


def test_a_name_or_a_part_that_is_wrong(tmp_path: Path) -> None:
    text = (
        HEAD + "let mine = 2\nmaximize irony(G_cheese = green, G_cheese = pink, rho > 0, rho < 0)\n"
    )
    for part, message in {
        "rho=rho > 0": "`rho` is a latent of the world",
        "sum_t=rho > 0": "`sum_t` is a word of the language",
        "sin=rho > 0": "`sin` is a word of the language",
        "robot=rho > 0": "`robot` is a name of the world",
        "pink=rho > 0": "`pink` is a name of the world",
        "depict=rho > 0": "`depict` is the name of a pattern already",
        "mine=rho > 0": "`mine` is the name of a `let` already",
        "made=rho > 0": "`made` is the name of the pattern",
    }.items():
        assert refused(text, tmp_path, part).startswith(f"--param:1:1: error[extract]: {message}")
    assert "is given twice" in refused(text, tmp_path, "a=rho > 0", "a=rho < 0")
    said = refused(text, tmp_path, "a=rho > 1")
    assert said.startswith("--param:1:3: error[extract]: `rho > 1` does not occur in the objective")
    assert "did you mean `rho > 0`?" in said
    said = refused(text, tmp_path, "a=rho > 0", "zero=0")
    assert "--param:1:6: error[extract]: `0` for `zero` overlaps another part" in said
    assert "tale.story:7:57)" in said or "tale.story:7:" in said
    assert "overlaps" in refused(text, tmp_path, "a=rho > 0", "b=rho > 0")


@pytest.mark.parametrize(
    ("part", "place"),
    [("rho > 0", "1:1"), ("=rho", "1:1"), ("a=", "1:3"), ("a=(rho", "1:3"), ("a=rho >", "1:7"),
     ("1=rho", "1:1"), ("a=rho\x00", "1:6")],
)  # fmt: skip
def test_parts_that_cannot_be_read(part: str, place: str) -> None:
    with pytest.raises(StoryError) as caught:
        read_part(part)
    assert str(caught.value).startswith(f"--param:{place}: error[")


def test_stories_that_have_nothing_to_extract(tmp_path: Path) -> None:
    assert "the story has no objective" in refused(HEAD + "search naive\n", tmp_path)
    assert "it is a library" in refused("pattern p = 1\n", tmp_path)
    assert "error[unknown-name]" in refused(HEAD + "maximize depict(roh > 0)\n", tmp_path)


@pytest.mark.parametrize(
    "path",
    sorted(p for p in STORIES.rglob("*.story") if p.parent.name != "patterns"),
    ids=lambda p: f"{p.parent.name}/{p.stem}",
)
def test_every_story_of_ours(path: Path, tmp_path: Path) -> None:
    """Without parameters the whole objective is carried over; the proof is in `extract`."""
    source = Source(str(path), path.read_text(encoding="utf-8"))
    if "search naive" in source.text:
        return
    found = extract(source, path.parent, [], "made_here", tmp_path / "made_here.story")
    neat = format_source(Source("made", found.text))
    assert neat == found.text


def test_the_command(tmp_path: Path, i2p: Run) -> None:
    story = STORIES / "kitchen" / "betrayal.story"
    target = tmp_path / "change.story"
    arguments = ("extract", story, "--param", "before=rho > 0", "-o", target)
    done = i2p(*arguments)
    assert done.status == 0, done.err
    assert done.out == (
        f"{target}: change(before)\n  before for rho > 0 in 1 place\n"
        "  the story's objective is change(rho > 0)\n"
    )
    said = json.loads(i2p(*arguments, "--json", "--name", "turned").out)
    assert said["signature"] == "turned(before)"
    assert i2p("check", target).status == 0
    assert "turned(before)" in i2p("patterns", target).out
    before = target.read_bytes()
    done = i2p("extract", story, "--param", "before=rho > 9", "-o", target)
    assert (done.status, target.read_bytes()) == (1, before)
    assert i2p("extract", story, "-o", tmp_path / "x.txt").status == 2
    copy = tmp_path / "copy.story"
    copy.write_bytes(story.read_bytes())
    assert i2p("extract", copy, "-o", copy).status == 2
    assert i2p("extract", tmp_path / "none.story", "-o", tmp_path / "y.story").status == 1
