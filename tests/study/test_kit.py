"""The kit: what lies in its folders, and its pages in a browser from the first to the table."""

from __future__ import annotations

import csv
import io
import json
import re
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from browser_for_tests import chromium  # noqa: F401
from commands_for_tests import PATIENCE
from i2pdsl import cli
from i2pdsl.fit.judgements import Choice, read_judgements
from i2pdsl.fit.questions import study as study_of_fit
from i2pdsl.study.kit import fit_options, read_key
from i2pdsl.study.parse import load_study
from i2pdsl.study.people import collect
from i2pdsl.sweep import planning
from i2pdsl.sweep.work import run_job
from studies_for_tests import TINY
from worlds_for_tests import with_small_world

ASKED = '    ask = "What was the robot doing?"\n'
ANSWERS = TINY[TINY.index("answer helping") : TINY.index("people help")]
STUDIES = {
    "tiny": TINY,
    "sliding": TINY.replace(ANSWERS, "")
    .replace(ASKED, f'{ASKED}    kind = slider\n    event = "rho > 0"\n    low = "no"\n')
    .replace("right = helping", "right = high")
    .replace("right = hindering", "right = low"),
    "pairs": TINY.replace(
        ANSWERS,
        'pair both\n    label = "both"\n    first = help\n    second = hinder\n',
    )
    .replace(ASKED, f'{ASKED}    kind = pair\n    event = "rho > 0"\n')
    .replace("    right = helping\n", "")
    .replace("    right = hindering\n", "")
    .replace("people help\n    naive = 0.5\n", ""),
}
EACH = {"tiny": "4", "sliding": "1", "pairs": "2"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Kits of all kinds of question, in folders of their names; films are made once."""
    place = with_small_world(tmp_path_factory.mktemp("kits"))
    for name, event in (("help", "rho > 0"), ("hinder", "rho < 0")):
        text = f"world small\nlength 4\nmaximize depict({event})\n"
        (place / f"{name}.story").write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        here = lambda jobs, *_: ((job, run_job(job)) for job in jobs)
        patch.setattr(planning, "done_here", here)
        for name, text in STUDIES.items():
            study = place / f"{name}.study"
            study.write_text(text, encoding="utf-8")
            arguments = ["study", study, "--seeds", "0-1", "--out", place / "out"]
            arguments += ["--kit", place / name, "--each", EACH[name]]
            assert cli.run_command([str(each) for each in arguments]) == 0
    return place


def written(folder: Path, name: str) -> Any:
    """What study.js says."""
    text = (folder / name / "public" / "study.js").read_text(encoding="utf-8")
    return json.loads(text.removeprefix("window.STUDY = ").rstrip().removesuffix(";"))


def test_what_is_published_does_not_tell_what_a_film_is(folder: Path) -> None:
    public = folder / "tiny" / "public"
    key = read_key(folder / "tiny" / "key.csv")
    assert len(key) == 8
    assert {film.place for film in key.values()} == {
        f"{c}/{m}/seed-{s}" for c in ("help", "hinder") for m in ("naive", "short") for s in "01"
    }
    for name in key:
        assert re.fullmatch("f[a-z2-7]{9}", name)
        assert (folder / "tiny" / "scripts" / f"{name}.json").is_file()
        film = (public / "films" / f"{name}.js").read_text(encoding="utf-8")
        for word in ("naive", "short", "help", "hinder", "rho", "seed", "score", "P("):
            assert word not in film
    told = written(folder, "tiny")
    assert sorted(film for (film,) in told["items"]) == sorted(key)
    assert [film for (film,) in told["items"]] == sorted(key), "by names that tell nothing"
    assert not {"naive", "condition", "method"} & set(re.findall(r"\w+", json.dumps(told)))
    names = {path.name for path in public.iterdir()}
    wanted = {"index.html", "kit.js", "study.js", "settings.js", "stage.js", "style.css", "films"}
    assert names == wanted
    for path in public.glob("*.*"):
        assert not re.search(r"(?:src|href|url)[=(]\W*(?:https?:)?//", path.read_text("utf-8"))


def test_a_second_kit_keeps_what_researchers_wrote_and_the_films_names(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = folder / "tiny" / "public" / "settings.js"
    before, key = settings.read_text(encoding="utf-8"), read_key(folder / "tiny" / "key.csv")
    settings.write_text("mine", encoding="utf-8")
    (folder / "tiny" / "key.csv").write_text(
        "script,condition,method,seed\nscripts/old.json,help,naive,9\n", encoding="utf-8"
    )
    arguments = ["study", folder / "tiny.study", "--seeds", "0-1", "--out", folder / "out"]
    arguments += ["--kit", folder / "tiny", "--each", "4"]
    assert cli.run_command([str(each) for each in arguments]) == 0
    assert settings.read_text(encoding="utf-8") == "mine"
    again = read_key(folder / "tiny" / "key.csv")
    assert again.pop("old").place == "help/naive/seed-9"
    assert again == key
    settings.write_text(before, encoding="utf-8")


# ------------------------------------------------------------------------------- in a browser


class Visit:
    """A participant's page, whose clock runs when told to, and what went wrong in it."""

    def __init__(self, context: Any, address: str):
        self.trouble: list[str] = []
        self.page = context.new_page()
        self.page.on("console", lambda message: self.trouble.append(message.text))
        self.page.on("pageerror", lambda problem: self.trouble.append(str(problem)))
        self.page.clock.install()
        self.page.goto(address)

    def heading(self) -> str:
        """Of the page that is shown: what the focus moved to, so that it is read out."""
        focused = self.page.evaluate(
            "document.activeElement.matches('h1') && document.activeElement.textContent"
        )
        assert focused == self.page.locator("h1:visible").inner_text()
        return str(focused)

    def keys(self, *names: str) -> None:
        for name in names:
            self.page.keyboard.press(name)

    def play(self) -> None:
        """Once the film has come: what is hidden takes no focus, and no key."""
        self.page.locator("#play").wait_for()
        self.page.locator("#play").press("Enter")

    def watch(self) -> None:
        """Until the film has ended."""
        self.page.locator("#theatre svg").first.wait_for()
        begun = time.monotonic()
        while time.monotonic() - begun < PATIENCE:  # it begins when the machine has time for it
            self.page.clock.run_for(500)
            if self.page.locator("#play").inner_text() == "Replay":
                assert self.page.locator("#answers:enabled").count() == 1
                return
        raise AssertionError("the film does not end")

    def fits(self, width: int) -> None:
        assert self.page.evaluate("document.documentElement.scrollWidth") <= width

    def table(self) -> list[dict[str, str]]:
        with self.page.expect_download() as download:
            self.page.locator("#download").press("Enter")
        self.name = download.value.suggested_filename
        self.text = Path(download.value.path()).read_text(encoding="utf-8")
        return list(csv.DictReader(io.StringIO(self.text)))


@pytest.fixture
def visit(chromium: Any) -> Iterator[Callable[..., Visit]]:  # noqa: F811
    """Opens a kit's page; in the end nothing may have been said on the console."""
    contexts: list[Any] = []
    visits: list[Visit] = []

    def come(address: str, width: int = 400, motion: str = "reduce", **more: Any) -> Visit:
        size = {"width": width, "height": 800}
        contexts.append(chromium.new_context(viewport=size, reduced_motion=motion, **more))
        visits.append(Visit(contexts[-1], address))
        return visits[-1]

    yield come
    for context in contexts:
        context.close()
    assert [text for visit in visits for text in visit.trouble] == []


@pytest.mark.browser
def test_by_keyboard_from_the_first_page_to_a_table_that_is_read(
    folder: Path, visit: Callable[..., Visit]
) -> None:
    """On a phone, from the disk, with a reload in the middle; somebody who does not read."""
    there = visit(f"{(folder / 'tiny/public/index.html').as_uri()}?participant=ann%3D1,&list=7")
    assert there.heading() == "Help or hinder"
    assert there.page.locator("#unfilled").is_visible()
    there.keys("Tab", "Space", "Tab", "Enter")
    assert there.heading() == "What you will do"
    there.keys("Tab", "Enter")
    assert there.heading() == "Practice"
    page = there.page
    page.locator("#theatre svg").wait_for()
    page.clock.run_for(5000)
    assert page.locator("#play").inner_text() == "Play", "nothing moves by itself"
    assert page.locator("#answers:disabled").count() == 1
    there.keys("Tab", "Enter")
    assert page.locator("#play").inner_text() == "Pause"
    there.watch()
    assert "You can answer now" in page.locator("#caption[role=status]").inner_text()
    there.keys("Tab", "Space", "ArrowDown", "Enter")
    assert there.heading() == "That was to practise"
    assert "“hindering”" in page.locator("#feedback-text").inner_text()
    there.keys("Tab", "Tab", "Enter")
    films = written(folder, "tiny")["lists"][7]
    for number in range(1, len(films) + 1):
        assert there.heading() == f"Film {number} of {len(films)}"
        there.fits(400)
        if number == 3:
            page.reload()
            assert there.heading() == f"Film {number} of {len(films)}"
        page.locator("#play").wait_for()  # what is hidden takes no focus
        there.keys("Tab", "Enter")
        there.watch()
        there.keys("Tab", "Tab", "Enter")  # without an answer
        assert page.locator("#missing").inner_text() == "Please choose an answer."
        there.keys("Space", "Enter")
    assert there.heading() == "Thank you!"
    rows = there.table()
    assert there.name == f"{written(folder, 'tiny')['id']}-ann1.csv"
    assert len(rows) == 4
    items = written(folder, "tiny")["items"]
    shown = [items[number][0] for number in films if number >= 0]
    assert [row["script"] for row in rows] == [f"scripts/{film}.json" for film in shown]
    same = {name: {row[name] for row in rows} for name in rows[0]}
    assert same["participant"] == {"ann1"}, "nothing else of a name gets into a table"
    assert (same["answer"], same["question"], same["list"]) == ({"helping"}, {"tiny"}, {"7"})
    assert (same["attention"], same["complete"], same["frame"]) == ({"failed"}, {"yes"}, {"T"})
    assert [row["order"] for row in rows] == ["1", "2", "3", "4"]
    assert all(float(row["seconds"]) >= 1 and row["plays"] == "1" for row in rows)
    table = folder / "tiny" / "answers.csv"
    table.write_text(there.text * 2, encoding="utf-8")  # two tables, one behind the other
    _, _, labels = fit_options(load_study(folder / "tiny.study")).split('"')[1].partition(":")
    choice = Choice(dict(label.split("=", 1) for label in labels.split(";")))
    judgements = read_judgements(table, named={"tiny": choice})
    study = load_study(folder / "tiny.study")
    found = collect(study, [table], lambda path: None, keep_all=True)
    assert (found.twice, found.answers.participants) == (4, ("ann1",))
    key = read_key(folder / "tiny" / "key.csv")
    assert set(found.items) == {i for i in study.items if i.films[0] in {key[f] for f in shown}}
    # `i2p fit` finds the scripts beside the table, and understands what was asked.
    fitted = study_of_fit(judgements, table.parent, 1.0, {"tiny": choice})
    assert (len(fitted.asked.answer), sorted(fitted.scripts)) == (8, sorted(same["script"]))
    table.unlink()


@pytest.fixture
def host(folder: Path) -> Iterator[Any]:
    """Serves the kit `tiny`; what is posted to it is refused as often as it says."""

    class Handler(SimpleHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"])).decode()
            server.posted.append(body)  # type: ignore[attr-defined]
            self.send_response(200 if len(server.posted) > 1 else 500)  # type: ignore[attr-defined]
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_: Any) -> None:
            pass

    handler = partial(Handler, directory=str(folder / "tiny" / "public"))
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    server.posted = []  # type: ignore[attr-defined]
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield server
    server.shutdown()
    server.server_close()
    thread.join()


@pytest.mark.browser
def test_answers_are_posted_and_kept_where_that_fails(
    folder: Path, visit: Callable[..., Visit], host: Any
) -> None:
    settings = folder / "tiny" / "public" / "settings.js"
    before = settings.read_text(encoding="utf-8")
    text = before.replace('post: ""', 'post: "/answers"').replace("[[", "").replace("]]", "")
    text = text.replace('completionCode: ""', 'completionCode: "C1234"')
    settings.write_text(text, encoding="utf-8")
    address = f"http://127.0.0.1:{host.server_address[1]}/index.html?PROLIFIC_PID=b-7"
    there = visit(address, width=1280, motion="no-preference")
    page = there.page
    assert not page.locator("#unfilled").is_visible()
    page.locator("#agreed").check()
    page.locator("#consent button").click()
    page.locator("#instructions button").click()
    there.watch()  # it begins by itself
    page.get_by_label("helping", exact=True).check()
    page.locator("#next").click()
    page.locator("#feedback .main").click()
    told = written(folder, "tiny")
    while there.heading() != "Thank you!":
        there.watch()
        page.locator("#play").click()
        there.watch()
        check = "This question is different" in page.locator("#question").inner_text()
        label = "unclear" if check else "hindering"
        page.get_by_label(label, exact=True).check()
        page.locator("#next").click()
    page.get_by_text("could not be sent").wait_for()
    assert page.locator("#download").is_visible()
    assert there.trouble.pop() == (
        "Failed to load resource: the server responded with a status of 500 (Internal Server Error)"
    )
    page.reload()  # what was not sent is sent then
    page.get_by_text("have been sent").wait_for()
    assert page.locator("#code-text").inner_text() == "C1234"
    page.reload()
    page.get_by_text("have been sent").wait_for()
    assert len(host.posted) == 2, "what was sent is not sent again"
    rows = there.table()
    assert host.posted == [there.text] * 2
    assert {(r["participant"], r["attention"], r["complete"]) for r in rows} == {
        ("b-7", "passed", "yes")
    }
    assert {row["plays"] for row in rows} == {"2"}
    assert rows[0]["study"] == told["id"]
    settings.write_text(before, encoding="utf-8")


@pytest.mark.browser
def test_pairs_stand_either_way_round_and_who_stops_can_erase(
    folder: Path, visit: Callable[..., Visit]
) -> None:
    address = (folder / "pairs/public/index.html").as_uri()
    told = written(folder, "pairs")
    there = visit(f"{address}?workerId=w&list=0")
    page = there.page
    page.evaluate(
        """() => { const key = Object.keys(localStorage).find((k) => k.endsWith(" w"));
        const at = (n, answer) => ({at: n, answer, plays: 1, seconds: 3, words: false});
        localStorage[key ?? `i2p-study ${STUDY.id} w`] = JSON.stringify({participant: "w",
        list: 0, started: "now", page: "trial", answers: [at(0, "second")], practised: "first"});
        }"""
    )
    page.reload()
    assert there.heading() == f"Pair 2 of {len(told['lists'][0])}"
    page.locator("#theatre .film >> nth=1").wait_for()
    assert page.locator("#theatre svg").count() == 2
    labels = page.locator("#theatre svg").evaluate_all("s => s.map(e => e.ariaLabel)")
    assert labels == ["Film A", "Film B"]
    here = lambda: page.locator("#theatre [data-actor=robot]").evaluate_all(
        "s => s.map(e => e.getAttribute('transform'))"
    )
    before = here()
    page.locator("#play").click()
    there.watch()
    assert len(before) == 2
    assert before != here(), "both were drawn anew"
    there.fits(400)
    page.locator("#stop").click()
    assert there.heading() == "You have stopped"
    page.locator("#hand-over").click()
    (row,) = there.table()
    films = told["items"][told["lists"][0][0]]
    assert [row["script"], row["other"]] == [f"scripts/{film}.json" for film in films]
    assert (row["answer"], row["complete"]) == ("second", "no")
    table = folder / "pairs" / "w.csv"
    table.write_text(there.text, encoding="utf-8")
    study = load_study(folder / "pairs.study")
    found = collect(study, [table], lambda path: None, keep_all=True)
    key = read_key(folder / "pairs" / "key.csv")
    chosen = key[films[1]]
    (item,) = found.answers.items
    assert found.answers.given.tolist() == [[float(item.films.index(chosen))]]
    page.evaluate("localStorage.setItem('other', '1')")
    page.goto(f"{address}?participant=x&list=1")
    page.locator("#agreed").check()
    page.locator("#consent button").click()
    page.locator("#instructions button").click()
    page.locator("#stop").click()
    page.locator("#erase").click()
    assert there.heading() == "Your answers are erased"
    kept = page.evaluate("Object.keys(localStorage).sort()")
    assert [k for k in kept if k.endswith(" x")] == []
    assert "other" in kept


@pytest.mark.browser
def test_a_slider_suggests_nothing(folder: Path, visit: Callable[..., Visit]) -> None:
    there = visit(f"{(folder / 'sliding/public/index.html').as_uri()}?participant=s")
    page = there.page
    there.keys("Tab", "Space", "Tab", "Enter", "Tab", "Enter")
    there.play()
    there.watch()
    slider = page.locator("#slider")
    assert slider.get_attribute("aria-valuetext") == "not answered yet"
    page.locator("#next").press("Enter")
    assert page.locator("#missing").inner_text() == "Please move the slider."
    there.keys("ArrowRight", "ArrowLeft")
    assert slider.get_attribute("aria-valuetext") == "50 of 100"
    page.locator("#next").press("Enter")
    assert "the slider at 50 of 100" in page.locator("#feedback-text").inner_text()
    there.keys("Tab", "Tab", "Enter")
    for _ in range(2):
        there.play()
        there.watch()
        page.locator("#slider").press("End")
        there.keys("ArrowLeft", "ArrowRight")
        page.locator("#next").press("Enter")
    (row,) = there.table()
    assert (row["answer"], row["attention"]) == ("100", "passed")
    assert row["question"] == "P(rho > 0 | script[:T])"
    table = folder / "sliding" / "s.csv"
    table.write_text(there.text, encoding="utf-8")
    (judgement,) = read_judgements(table, 100)
    assert judgement.answer == 1.0
