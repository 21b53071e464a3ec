"""What hands do to a text: it says what was meant, and the rest stays as it was written."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import pytest

from i2pdsl.studio import hands
from i2pdsl.studio.protocol import Curve, Entity, Pin, Refusal, Solve
from i2pdsl.studio.reading import read
from i2pdsl.studio.text import StoryText
from studio_for_tests import edited

TEXT = """\
# Of a robot.
world kitchen
length 14
start absent(table)

maximize beats(depict(rho > 0), depict(rho < 0), depict(rho = 0))

pin script[4]: at(robot, pink) and at(cheese, green)  # why
pin script[8..10]: at(robot, (3, 1))
pin script[T-1]: pushes(robot, cheese)
pin script[2] = [robot: south, cheese: west]
"""
OF_8, OF_2 = (
    "pin script[8..10]: at(robot, (3, 1))\n",
    "pin script[2] = [robot: south, cheese: west]\n",
)


def otherwise(*pairs: tuple[str, str]) -> str:
    text = TEXT
    for old, new in pairs:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def after(name: str, *arguments: object) -> str:
    """The text after a function of hands; the edits that lead there are tried, too."""
    old = StoryText(TEXT)
    new = getattr(hands, name)(old, *arguments).text
    assert edited(TEXT, old.edits(new)) == new
    return new


def test_pins() -> None:
    pink = "at(robot, pink) and at(cheese, green)"
    assert after("pin", 4, "robot", "(0, 0)") == otherwise((pink, pink.replace("pink", "(0, 0)")))
    last = TEXT + "pin script[4]: absent(table)\n"
    assert after("pin", 4, "table", None) == last
    assert after("pin", 5, "cheese", "pink") == TEXT + "pin script[5]: at(cheese, pink)\n"
    # One frame of a longer pin is another thing now.
    left = "pin script[8]: at(robot, (3, 1))\npin script[10]: at(robot, (3, 1))\n"
    assert after("pin", 9, "robot", "pink") == (
        otherwise((OF_8, left)) + "pin script[9]: at(robot, pink)\n"
    )


def test_the_first_picture() -> None:
    said = "start absent(table)"
    assert after("pin", 0, "table", "pink") == otherwise((said, "start at(table, pink)"))
    assert after("pin", 0, "robot", "pink") == otherwise((said, f"{said} and at(robot, pink)"))
    assert after("unpin", 0, "table") == otherwise((f"{said}\n", ""))
    assert after("start", "at(robot, pink)") == otherwise((said, "start at(robot, pink)"))
    bare = StoryText("world kitchen\nlength 3\n\nmaximize depict(rho > 0)\n")
    begun = bare.text.replace("length 3", "length 3\nstart absent(table)")
    assert hands.pin(bare, 0, "table", None).text == begun
    either = StoryText("world kitchen\nstart at(robot, pink) or at(robot, green)\n")
    assert "start (at(robot, pink) or at(robot, green)) and absent(table)\n" in (
        hands.pin(either, 0, "table", None).text
    )


def test_pins_that_go() -> None:
    assert after("unpin", 4, "cheese") == otherwise((" and at(cheese, green)", ""))
    assert after("unpin", 4, "robot") == otherwise(("at(robot, pink) and ", ""))
    pin = "pin script[4]: at(robot, pink) and at(cheese, green)  # why\n"
    assert after("unpin", 4, None) == otherwise((pin, "# why\n"))
    assert after("unpin", 13, None) == otherwise(("pin script[T-1]: pushes(robot, cheese)\n", ""))
    assert after("unpin", 8, "robot") == otherwise((OF_8, OF_8.replace("8", "9")))
    assert after("unpin", 2, "cheese") == otherwise((", cheese: west", ""))
    assert after("unpin", 2, "robot") == otherwise(("robot: south, ", ""))
    for frame, who in ((5, None), (4, "table"), (0, "robot")):
        with pytest.raises(Refusal):
            hands.unpin(StoryText(TEXT), frame, who)


def test_a_contradiction_can_be_taken_back() -> None:
    wrong = StoryText(TEXT + "pin script[4]: at(robot, green\npin script[3]: absent(table)\n")
    assert hands.unpin(wrong, 3, "table").text == wrong.text.replace(
        "pin script[3]: absent(table)\n", ""
    )


def test_pins_that_move() -> None:
    assert after("move", 4, "robot", 6) == (
        otherwise(("at(robot, pink) and ", "")) + "pin script[6]: at(robot, pink)\n"
    )
    assert after("move", 2, "robot", 6) == (
        otherwise(("robot: south, ", "")) + "pin script[6] = [robot: south]\n"
    )
    assert after("move", 13, None, 6) == otherwise(("script[T-1]", "script[6]"))
    with pytest.raises(Refusal):
        hands.move(StoryText(TEXT), 5, "robot", 6)


def test_turns_more_and_less() -> None:
    assert after("insert", 5) == otherwise(("length 14", "length 15"), ("8..10", "9..11"))
    assert after("insert", 9) == otherwise(("length 14", "length 15"), ("8..10", "8..11"))
    more = (("length 14", "length 15"), ("8..10", "9..11"), ("[4]", "[5]"), ("[2]", "[3]"))
    assert after("insert", 1) == otherwise(*more)
    assert after("cut", 9) == otherwise(("length 14", "length 13"), ("8..10", "8..9"))
    less = otherwise((OF_2, ""), ("length 14", "length 13"), ("8..10", "7..9"), ("[4]", "[3]"))
    assert after("cut", 2) == less
    for name, frame in (("insert", 16), ("insert", 0), ("cut", 15), ("cut", 0)):
        with pytest.raises(Refusal):
            getattr(hands, name)(StoryText(TEXT), frame)
    with pytest.raises(Refusal):
        hands.cut(StoryText("world kitchen\nlength 2 * 7\n"), 1)


def test_a_stretch_goes_as_a_whole() -> None:
    line = "pin script[2..5]: at(a, b) and at(c, d)\n"
    both = StoryText(f"world small\nlength 9\n{line}pin script[5]: at(e, f)\n")
    assert hands.unpin(both, 2, None, 5).text == both.text.replace(line, "")
    assert hands.unpin(both, 2, "c", 5).text == both.text.replace(" and at(c, d)", "")
    with pytest.raises(Refusal):
        hands.unpin(both, 3, None, 5)


def test_frames_that_are_kept() -> None:
    lines = ["pin script[8]: at(robot, pink)", "pin script[8] = [robot: stay]"]
    assert after("hold", lines, 8, 10) == otherwise((OF_8, "")) + "".join(f"{x}\n" for x in lines)
    with pytest.raises(Refusal):
        hands.hold(StoryText(TEXT), lines, 9, 10)


def test_frames_of_a_script_are_a_pin_as_others_are() -> None:
    line = 'pin script[2..5] = "a.json"\n'
    text = StoryText(f"world hill\nlength 9\n{line}")
    assert hands.unpin(text, 3, None).text.endswith(
        'pin script[2] = "a.json"\npin script[4..5] = "a.json"\n'
    )
    assert hands.unpin(text, 2, None, 5).text == "world hill\nlength 9\n"
    assert hands.hold(text, ['pin script[1..6] = "b.json"'], 1, 6).text == (
        'world hill\nlength 9\n\npin script[1..6] = "b.json"\n'
    )
    assert "length 10" in hands.insert(text, 6).text
    for do in (lambda: hands.insert(text, 3), lambda: hands.cut(text, 1)):
        with pytest.raises(Refusal, match=r"a\.json"):
            do()
    for do in (lambda: hands.unpin(text, 3, "hopper"), lambda: hands.move(text, 3, "box", 4)):
        with pytest.raises(Refusal):
            do()


def test_lengths_beats_wishes() -> None:
    assert after("length", 20) == otherwise(("length 14", "length 20"))
    beats = "depict(rho > 0), depict(rho < 0), depict(rho = 0)"
    turned = "depict(rho = 0), depict(rho > 0), depict(rho < 0)"
    assert after("beats", [2, 0, 1]) == otherwise((beats, turned))
    assert "0))\nminimize 1\n" in after("wish", "minimize 1")
    for order in ([0, 1], [0, 0, 1], [1, 2, 3]):
        with pytest.raises(Refusal):
            hands.beats(StoryText(TEXT), order)


def test_every_change_can_be_made_by_an_editor() -> None:
    """Whatever happens to a text, the edits lead from the old one to the new one."""
    random = Random(0)
    pieces = ["world a", "", "# b", "pin script[3]: at(a, b)", "length 3", "äöü 𝄞", "x" * 9]
    for _ in range(300):
        old, new = ("\n".join(random.choices(pieces, k=random.randrange(6))) for _ in "ab")
        utf16 = lambda text: text.replace("𝄞", "ab")  # as many units
        edits = StoryText(old).edits(new)
        for edit in edits:
            edit["newText"] = utf16(edit["newText"])
        assert edited(utf16(old), edits) == utf16(new)


def at(curve: str, x: float) -> float:
    """The height of `points(...)` at x, straight between its points."""
    points = eval(f"[{curve.removeprefix('points(').removesuffix(')')}]")
    for (x0, y0), (x1, y1) in pairwise(points):
        if x0 <= x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    raise AssertionError(x)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-30.0, 2.0), (-0.02, 0.03)])
def test_drawn_curves(low: float, high: float) -> None:
    random = Random(1)
    for _ in range(20):
        steps = [random.gauss(0, 0.04) for _ in range(80)]
        heights = [0.5 + sum(steps[:k]) for k in range(80)]
        drawn = [[k / 79, low + (high - low) * h] for k, h in enumerate(heights)]
        random.shuffle(drawn)  # as the pointer went
        curve = hands.drawn(drawn, low, high)
        assert 2 <= curve.count("(") - 1 <= hands.MOST_POINTS
        away = max(abs(at(curve, x) - y) for x, y in drawn)
        assert away <= 0.25 * (high - low)
    straight = hands.drawn([[0, low], [0.25, low + (high - low) / 4], [1, high]], low, high)
    assert straight.count("(") == 3
    for points in ([], [[0, 0]], [[0, 0], [0, 1]], [[0], [1]]):
        with pytest.raises(Refusal):
            hands.drawn(points, low, high)


def test_what_shall_follow_a_curve() -> None:
    told = hands.followed("P(rho > 0 | script[:t])", "points((0, 0), (1, 1))", 0, 2)
    assert told == "minimize 1 * sum_t (P(rho > 0 | script[:t]) - points((0, 0), (1, 1)))^2"
    for expression in ("P(", "1)\nworld other\nmaximize (2", ""):
        with pytest.raises(Refusal):
            hands.followed(expression, "points((0, 0), (1, 1))", 0, 1)


def test_parameters_are_read_strictly() -> None:
    given = {"uri": "a", "version": 1, "frame": 3, "who": "robot", "place": None}
    assert read(Pin, given) == Pin("a", 1, 3, "robot", None)
    for wrong in (
        {**given, "frame": "3"},
        {**given, "frame": 3.0},
        {**given, "frame": True},
        {**given, "more": 1},
        {"version": 1},
        {**given, "who": None},
        {**given, "who": "x" * 2_000_000},
        {**given, "frame": 2**40},
        [1],
        "text",
    ):
        with pytest.raises(Refusal):
            read(Pin, wrong)
    curve = {"uri": "a", "points": [[0, 0.5], [1, 1]], "low": 0}
    start = {"line": 0, "character": 2}
    found = read(Curve, {**curve, "range": {"start": start, "end": start}})
    assert found.points == [[0.0, 0.5], [1.0, 1.0]]
    assert found.range.start.character == 2
    for wrong in (
        {**curve, "points": [[0, float("inf")]]},
        {**curve, "points": [["0", 1]]},
        {**curve, "points": [[0, 1]] * 20_000},
        {**curve, "low": float("nan")},
        {**curve, "low": 10**400},
        {**curve, "range": {"start": start}},
    ):
        with pytest.raises(Refusal):
            read(Curve, wrong)
    assert read(Entity, {"uri": "a", "settings": {"color": "1"}}).settings == {"color": "1"}
    with pytest.raises(Refusal):
        read(Entity, {"uri": "a", "settings": {"color": 1}})
    assert read(Solve, {"uri": "a", "version": 2}) == Solve("a", 2, 0, 1)
