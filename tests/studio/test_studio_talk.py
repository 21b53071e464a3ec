"""The studio's protocol, spoken with a real server over a real socket, on a small world."""

from __future__ import annotations

import json
import os
import time
from base64 import b64encode
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest

pytest.importorskip("starlette")


import i2pdsl
from i2pdsl.studio.folder import digest_of
from studio_for_tests import HELP, SEARCH, Refused, Served, Talk, fill

CAT = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><circle r="4"/></svg>'


@pytest.fixture
def talk(served: Served) -> Iterator[Talk]:
    fill(served.folder)
    with Talk(served.address) as talk:
        talk.open("help.story")
        yield talk


def places(film: dict[str, Any], frame: int) -> dict[str, Any]:
    script = film["script"]
    state: dict[str, Any] = script["frames"][frame - 1]["state"] if frame else script["start"]
    return state


def outline(talk: Talk) -> dict[str, Any]:
    """What is said of the text as it is."""
    talk.told.clear()
    talk.begin("i2p/solve", talk.here)
    told = talk.until("i2p/story", version=talk.version)
    talk.ask("i2p/cancel", {"uri": talk.uri})
    return told


def curve(talk: Talk, film: dict[str, Any], expression: str) -> list[float]:
    told = talk.ask("i2p/query", {"film": film["id"], "expression": expression})
    values: list[float] = told["series"][0]["values"]
    return values


# The language server.


def test_the_language_server_answers_as_it_is(talk: Talk) -> None:
    assert talk.capabilities["hoverProvider"]
    talk.write("world small\nlength 6\nmaximize depit(rho > 0)\n")
    told = talk.until("textDocument/publishDiagnostics", version=talk.version)
    assert "depict" in told["diagnostics"][0]["message"] + str(told["diagnostics"][0])
    here = {"textDocument": {"uri": talk.uri}, "position": {"line": 0, "character": 7}}
    assert "small" in str(talk.ask("textDocument/hover", here))
    items = talk.ask("textDocument/completion", {**here, "position": {"line": 2, "character": 12}})
    assert "depict" in {item["label"] for item in items["items"]}
    talk.write("world   small\nlength 6\nmaximize depict(rho>0)\n")
    options = {"tabSize": 4, "insertSpaces": True}
    edits = talk.ask(
        "textDocument/formatting", {"textDocument": {"uri": talk.uri}, "options": options}
    )
    assert "world small\n" in edits[0]["newText"]


def test_no_document_of_elsewhere(talk: Talk, tmp_path: Path) -> None:
    secret = tmp_path / "secret.story"
    secret.write_text("world kitchen\n")
    place = {"textDocument": {"uri": secret.as_uri()}, "position": {"line": 0, "character": 1}}
    with pytest.raises(Refused, match="no file of this folder"):
        talk.ask("textDocument/hover", place)
    with pytest.raises(Refused, match="no file of this folder"):
        talk.ask("i2p/solve", {"uri": secret.as_uri(), "version": 1})
    with pytest.raises(Refused, match="no path"):
        talk.ask("i2p/open", {"path": "../secret.story"})


# Solving.


def test_a_text_becomes_a_film(talk: Talk, served: Served) -> None:
    talk.write(HELP.replace(SEARCH, "search beam(starts = 40, polish = 1)\n"))
    (served.folder / "help.story").write_text(talk.text)
    film = talk.solve(seed=0)
    assert film["quality"] == "best"
    films = [m["params"]["film"] for m in talk.told if m["method"] == "i2p/film"]
    assert films[0]["quality"] == "preview"
    worth = [found["score"] for found in films if found["quality"] != "best"]
    assert worth == sorted(worth)
    assert film["unmet"] == []
    assert film["length"] == film["play"]["last"] == 6
    assert film["play"]["stage"].lstrip().startswith("<svg")
    assert {one["name"] for one in film["cast"]} == {"cheese", "robot", "table"}
    assert all(len(one["at"]) == 7 for one in film["cast"])
    told = next(m["params"] for m in talk.told if m["method"] == "i2p/story")
    assert told["can"]["drag"] == ["cheese", "robot", "table"]
    assert told["wishes"][0]["text"] == "maximize depict(rho > 0)"
    # It is what `i2p run` makes of the file.
    made = i2pdsl.load(served.folder / "help.story").solve(seed=0)
    assert made.script.record.frames == tuple(film["script"]["frames"])
    assert film["score"] == pytest.approx(made.score)
    assert film["panel"]["mean"] == pytest.approx(made.judgements[0].mean)


def test_a_text_that_is_no_story(talk: Talk) -> None:
    talk.write("world small\nlength six\n")
    with pytest.raises(Refused) as problem:
        talk.solve()
    assert problem.value.kind == "story"
    assert {found["line"] for found in problem.value.data["diagnostics"]} == {1, 2}


def test_versions(talk: Talk) -> None:
    old = talk.here
    talk.write(HELP.replace("rho > 0", "rho < 0"))
    for method, params in (
        ("solve", {}),
        ("pin", {"frame": 1, "who": "robot", "place": None}),
        ("play", {"frame": 1, "who": "robot"}),
        ("candidates", {}),
    ):
        with pytest.raises(Refused) as problem:
            talk.ask(f"i2p/{method}", {**old, **params})
        assert problem.value.kind == "stale"
    # A newer one takes the place of an older one, of which nothing is heard any more.
    numbers = []
    for k in range(6):
        talk.write(HELP + f"pin script[{k + 1}]: at(robot, (0, 0))\n")
        numbers.append(talk.begin("i2p/solve", talk.here))
    talk.until("i2p/film", version=talk.version)
    for number in numbers[:-1]:
        with pytest.raises(Refused) as problem:
            talk.reply(number)
        assert problem.value.kind in ("cancelled", "stale")


def test_what_is_cancelled(talk: Talk) -> None:
    number = talk.begin("i2p/solve", talk.here)
    talk.ask("i2p/cancel", {"uri": talk.uri})
    with pytest.raises(Refused) as problem:
        talk.reply(number)
    assert problem.value.kind == "cancelled"


# By hand.


def test_somebody_is_dragged(talk: Talk) -> None:
    talk.film()
    spots = talk.ask("i2p/play", {**talk.here, "frame": 3, "who": "robot"})["spots"]
    possible = [spot["place"] for spot in spots if spot["possible"]]
    assert len(possible) == 8
    place = "(2, 0)"
    text = talk.by_hand("pin", frame=3, who="robot", place=place)
    assert text.rstrip().endswith("pin script[3]: at(robot, (2, 0))")
    film = talk.film()
    assert film["unmet"] == []
    assert places(film, 3)["robot"] == [2, 0]
    # A frame later it cannot be far away, and it can be where it is said to be.
    spots = talk.ask("i2p/play", {**talk.here, "frame": 4, "who": "robot"})["spots"]
    near = {spot["place"] for spot in spots if spot["possible"]}
    assert near == {"(2, 0)", "(1, 0)", "(2, 1)"}
    # Dragged again in frame 3 it may be anywhere: its pin moves along.
    spots = talk.ask("i2p/play", {**talk.here, "frame": 3, "who": "robot"})["spots"]
    assert sum(spot["possible"] for spot in spots) == 8
    text = talk.by_hand("pin", frame=3, who="robot", place="(0, 0)")
    assert text.count("pin") == 1
    assert places(talk.film(), 3)["robot"] == [0, 0]
    assert talk.by_hand("unpin", frame=3, who="robot").rstrip() == HELP.rstrip()


def test_the_first_picture_is_set(talk: Talk) -> None:
    talk.by_hand("pin", frame=0, who="table", place=None)
    text = talk.by_hand("pin", frame=0, who="robot", place="(2, 2)")
    assert "start absent(table) and at(robot, (2, 2))\n" in text
    film = talk.film()
    assert places(film, 0) == {**places(film, 0), "robot": [2, 2], "table": None}
    spots = talk.ask("i2p/play", {**talk.here, "frame": 0, "who": "cheese"})["spots"]
    taken = {spot["place"] for spot in spots if not spot["possible"]}
    assert taken == {"(2, 2)"}
    text = talk.by_hand("edit", what="start", film=film["id"])
    assert places(talk.film(), 0) == places(film, 0)


def test_what_cannot_be_done_by_hand(talk: Talk) -> None:
    for method, params in (
        ("pin", {"frame": 1, "who": "robot) or (", "place": "(0, 0)"}),
        ("pin", {"frame": 1, "who": "robot", "place": "(0, 0)) or at(robot, (1, 0)"}),
        ("play", {"frame": 7, "who": "robot"}),
        ("play", {"frame": 1, "who": "nobody"}),
        ("edit", {"what": "everything"}),
        ("edit", {"what": "start", "film": "f999"}),
        ("hold", {"film": "f999", "first": 1, "last": 2}),
        ("curve", {"points": [[0, 0], [1, 1]]}),
        ("pattern", {"name": "nothing"}),
        ("nothing", {}),
    ):
        with pytest.raises(Refused) as problem:
            talk.ask(f"i2p/{method}", {**talk.here, **params})
        assert problem.value.kind in ("usage", "refused"), method


def test_a_drawn_curve_is_followed(talk: Talk) -> None:
    drawn = [[0, 0.4], [0.5, 0.95], [1, 0.05]]
    belief = "P(rho > 0 | script[:t])"
    talk.write(HELP.replace("maximize depict(rho > 0)\n", "maximize 0\n").replace("6", "12"))
    text = talk.by_hand("curve", points=drawn, expression=belief, low=0, high=1)
    assert "points((0, 0.4), (0.5, 0.95), (1, 0.05))" in text
    film = talk.film()
    up = curve(talk, film, belief)
    assert up[6] - up[12] > 0.5
    told = outline(talk)
    (known,) = told["curves"]
    assert known["expression"] == belief
    assert known["points"] == drawn
    # Drawn again, the other way round: what stands in the text is drawn anew.
    other = [[0, 0.4], [0.5, 0.05], [1, 0.95]]
    talk.by_hand("curve", points=other, range=known["range"], low=0, high=1)
    assert talk.text.count("points(") == 1
    down = curve(talk, talk.film(), belief)
    assert down[12] - down[6] > 0.5


def test_frames_are_held(talk: Talk) -> None:
    film = talk.film()
    talk.by_hand("hold", film=film["id"], first=1, last=3)
    talk.write(talk.text.replace("rho > 0", "rho < 0"))
    other = talk.film()
    assert other["unmet"] == []
    assert [places(other, k) for k in range(4)] == [places(film, k) for k in range(4)]


def test_numbers_and_moments(talk: Talk) -> None:
    talk.write(HELP.replace("depict(rho > 0)", "twist(rho > 0, rho < 0)") + "liveliness 0.5\n")
    told = outline(talk)
    by_name = {number["what"]: number for number in told["numbers"]}
    assert by_name["liveliness"]["value"] == 0.5
    assert by_name["turn"]["frame"] == 3
    start = by_name["turn"]["range"]["start"]
    line = talk.text.splitlines()[start["line"]]
    at = start["character"]
    written = f"{line[:at]}{by_name['turn']['prefix']}2{line[at:]}"
    talk.write(talk.text.replace(line, written))
    told = outline(talk)
    turn = next(number for number in told["numbers"] if number["what"] == "turn")
    assert (turn["value"], turn["frame"]) == (2, 2)


# About films.


def test_questions_about_a_film(talk: Talk) -> None:
    film = talk.film()
    about = {"film": film["id"]}
    assert len(curve(talk, film, "P(rho > 0 | script[:t])")) == 7
    found = talk.ask("i2p/query", {**about, "expression": "P(G_robot | script[:t])"})
    assert [one["label"] for one in found["series"]][:2] == ["pink", "green"]
    with pytest.raises(Refused):
        talk.ask("i2p/query", {**about, "expression": "P(rho >"})
    offered = [one["expression"] for one in talk.ask("i2p/curves", about)["curves"]]
    assert {"P(rho > 0 | script[:t])", "E[V(robot) | script[:t]]"} <= set(offered)
    why = talk.ask("i2p/why", about)
    assert [one["first"] for one in why["moments"]] == sorted(m["first"] for m in why["moments"])
    assert any(moment["changes"] for moment in why["moments"])
    wishes = talk.ask("i2p/wishes", about)["wishes"]
    assert wishes[0]["source"] == "maximize depict(rho > 0)"
    assert wishes[0]["reached"] == pytest.approx(
        sum(curve(talk, film, "P(rho > 0 | script[:t])")[1:]), abs=1e-4
    )


def test_candidates_differ(talk: Talk) -> None:
    found = talk.ask("i2p/candidates", {**talk.here, "seed": 1, "count": 6})
    films = found["candidates"]
    assert 1 < len(films) <= 6
    scripts = [json.dumps(film["script"]["frames"]) for film in films]
    assert len(set(scripts)) == len(scripts)
    assert all(film["panel"] and film["lively"] is not None for film in films)
    assert films[0]["contact"] == pytest.approx(
        sum(curve(talk, films[0], "[adjacent(robot, cheese) @ script[t]]")[-6:]) / 6, abs=1e-4
    )


def test_how_it_could_go_on(talk: Talk) -> None:
    film = talk.film()
    found = talk.ask("i2p/suggest", {"film": film["id"], "frame": 2})["suggestions"]
    assert 1 <= len(found) <= 3
    assert [one["score"] for one in found] == sorted((s["score"] for s in found), reverse=True)
    first = found[0]["film"]
    assert first["length"] == 3
    assert first["script"]["frames"][:2] == film["script"]["frames"][:2]
    talk.by_hand("hold", film=first["id"], first=1, last=3)
    assert talk.film()["unmet"] == []


def test_what_comes_out(talk: Talk, served: Served) -> None:
    film = talk.film()
    wanted = ["html", "svg", "timeline", "script"]
    files = talk.ask("i2p/export", {"film": film["id"], "formats": wanted})["files"]
    assert {"page.html", "comic.svg", "timeline.json", "script.json"} < {f["name"] for f in files}
    for file in files:
        with urlopen(talk.base + file["url"]) as answer:
            assert "attachment" in answer.headers["content-disposition"]
            assert len(answer.read()) == file["size"]
    for formats in (["exe"], ["html", "../x"]):
        with pytest.raises(Refused):
            talk.ask("i2p/export", {"film": film["id"], "formats": formats})
    kept = talk.ask("i2p/keep", {"film": film["id"], "path": "help.script.json"})
    again = talk.ask("i2p/keep", {"film": film["id"], "path": "help.script.json"})
    assert (kept["path"], again["path"]) == ("help.script.json", "help.script-2.json")
    script = i2pdsl.Script.load(served.folder / kept["path"])
    assert script.record.frames == tuple(film["script"]["frames"])
    with pytest.raises(Refused):
        talk.ask("i2p/keep", {"film": film["id"], "path": "../out.json"})


# Patterns, beginnings, worlds.


def test_patterns_are_found_by_words(talk: Talk) -> None:
    talk.film()
    ask = lambda words: talk.ask("i2p/patterns", {"uri": talk.uri, "words": words})["patterns"]
    for words, name in (
        ("a friend turns out to be a foe", "twist"),
        ("rises and then falls when nearly there", "icarus"),
        ("viewers cannot tell, keep them in the dark", "mystery"),
        ("the audience knows more than somebody in it", "irony"),
    ):
        assert name in [found["name"] for found in ask(words)[:4]], words
    for words in ("seems to help, then hinders", "a betrayal"):  # the first is what the page offers
        assert ask(words)[0]["name"] == "twist"
    twist = next(found for found in ask("twist") if found["name"] == "twist")
    slots = {slot["name"]: slot for slot in twist["slots"]}
    assert "rho > 0" in slots["before"]["offers"]
    assert slots["turn"]["default"] == "T/2"
    with urlopen(talk.base + twist["picture"]) as answer:
        assert answer.headers["content-type"] == "image/png"
    given = {"before": "rho > 0", "after": "rho < 0", "steady": "0.2", "turn": ""}
    text = talk.by_hand("pattern", name="twist", arguments=given)
    assert "maximize twist(rho > 0, rho < 0, steady = 0.2)\n" in text
    talk.film()


def test_stories_to_begin_with(talk: Talk, served: Served) -> None:
    told = talk.ask("i2p/beginnings")
    assert {"help", "betrayal"} <= {each["name"] for each in told["beginnings"]}
    assert {"kitchen", "small", "new map"} <= {each["name"] for each in told["worlds"]}
    new = {"name": "mine", "beginning": "betrayal", "world": "small"}
    found = talk.ask("i2p/new", new)
    assert not (served.folder / "mine.story").exists()
    saved = {"path": found["path"], "text": found["text"] + SEARCH, "digest": None}
    talk.ask("i2p/save", saved)
    talk.open("mine.story")
    assert talk.film()["length"] == 15
    with pytest.raises(Refused, match="already"):
        talk.ask("i2p/new", new)
    with pytest.raises(Refused):
        talk.ask("i2p/new", {**new, "name": "../mine"})
    (served.folder / "mine.story").unlink()


def test_a_world_is_painted(talk: Talk, served: Served) -> None:
    talk.open("small.world")
    number = talk.begin("i2p/solve", talk.here)
    told = talk.until("i2p/world")
    assert talk.reply(number)["finished"]
    assert told["map"]["rows"] == ["P..", "#.G", "..."]
    assert told["stage"].startswith("<svg")
    assert [each["name"] for each in told["entities"]] == ["cheese", "robot", "table"]
    talk.by_hand("paint", cells=[[2, 0], [2, 2]], symbol="#")
    assert "    P.#\n    #.G\n    ..#\n" in talk.text
    talk.by_hand("side", sides=[[[1, 0], [1, 1]]], wall=True)
    talk.by_hand("side", sides=[[[0, 2], [1, 2]]], wall=True)
    talk.by_hand("side", sides=[[[0, 2], [1, 2]]], wall=False)
    talk.by_hand("size", columns=4, rows=3)
    talk.by_hand("entity", what="object", name="chair", settings={"sprite": '"table"'})
    talk.by_hand("entity", what="object", name="chair", settings={"color": '"#123456"'})
    talk.by_hand("entity", what="object", name="table", settings=None)
    talk.by_hand("entity", what="event", name="deus", settings=None)
    upload = {"path": "cat.svg", "data": b64encode(CAT.encode()).decode()}
    assert talk.ask("i2p/upload", upload)["sprite"] == "cat.svg"
    talk.by_hand("entity", what="character", name="robot", settings={"sprite": '"cat.svg"'})
    talk.write(talk.text.replace("pushes = {cheese, table}", "pushes = {cheese}"))
    found = i2pdsl.worlds.find.parse_world  # the parser that stories use
    from i2pdsl.errors import Source
    from i2pdsl.worlds.drawings import beside

    spec = found(Source("small.world", talk.text), "small", beside(served.folder))
    assert spec.rows == ("P.#.", "#.G.", "..#.")
    assert spec.walls == (((1, 0), (1, 1)),)
    assert [thing.name for thing in spec.things] == ["chair"]
    for wrong in (
        ("paint", {"cells": [[9, 9]], "symbol": "#"}),
        ("paint", {"cells": [[0, 0]], "symbol": "Z"}),
        ("side", {"sides": [[[0, 0], [2, 0]]]}),
        ("size", {"columns": 1000, "rows": 1}),
        ("entity", {"what": "planet", "name": "mars", "settings": {}}),
        ("entity", {"what": "object", "name": "a b", "settings": {}}),
        ("entity", {"what": "object", "name": "b", "settings": {"color": "1\nmap"}}),
    ):
        with pytest.raises(Refused):
            talk.ask(f"i2p/{wrong[0]}", {**talk.here, **wrong[1]})
    (served.folder / "cat.svg").unlink()


# Files.


def test_two_pages_on_one_story(talk: Talk, served: Served) -> None:
    with Talk(served.address) as other:
        other.open("help.story")
        mine = {"path": "help.story", "text": talk.text + "# mine\n", "digest": talk.digest}
        saved = talk.ask("i2p/save", mine)
        other.until("i2p/changed", path="help.story", digest=saved["digest"])
        with pytest.raises(Refused) as problem:
            other.ask("i2p/save", {**mine, "text": "theirs\n", "digest": other.digest})
        assert problem.value.kind == "conflict"
        assert problem.value.data["text"].endswith("# mine\n")
        # Both solve at once, and neither stops the other.
        for page in (talk, other):
            page.begin("i2p/solve", page.here)
        for page in (talk, other):
            assert page.until("i2p/film")["version"] == page.version


def test_a_file_is_changed_outside(talk: Talk, served: Served) -> None:
    path = served.folder / "help.story"
    other = served.folder / "help.story~"
    other.write_text("world small\nlength 3\nmaximize depict(rho > 0)\n")
    os.replace(other, path)  # as some editors save
    digest = digest_of(path.read_bytes())
    talk.until("i2p/changed", path="help.story", digest=digest)
    with pytest.raises(Refused) as problem:
        talk.ask("i2p/save", {"path": "help.story", "text": "x", "digest": talk.digest})
    assert problem.value.data == {
        "kind": "conflict",
        "text": path.read_text(),
        "digest": digest,
    }
    path.unlink()
    talk.until("i2p/changed", path="help.story", digest=None)


def test_killed_in_the_middle(tmp_path: Path) -> None:
    """Whatever it was doing, files are whole: as they were, or as they were to be."""
    studio = Served(fill(tmp_path))
    path = tmp_path / "help.story"
    versions = [HELP, HELP + "# " + "x" * 400_000 + "\n"]
    for delay in (0.0, 0.01):
        studio.start()
        talk = Talk(studio.address)
        talk.open("help.story")
        talk.begin("i2p/solve", talk.here)
        new = versions[1] if path.read_text() == versions[0] else versions[0]
        talk.begin("i2p/save", {"path": "help.story", "text": new, "digest": talk.digest})
        time.sleep(delay)
        studio.kill()
        studio.port = ""  # any will do: another may have been quick
        talk.__exit__()
        assert path.read_text() in versions
    studio.start()
    with Talk(studio.address) as talk:
        talk.open("help.story")
        assert talk.text in versions
    studio.kill()
