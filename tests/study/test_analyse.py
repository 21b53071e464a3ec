"""People's answers: tables read, who counts, what they come to."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from commands_for_tests import Run
from i2pdsl.errors import StoryError
from i2pdsl.study import mixed
from i2pdsl.study.analyse import p_by_people
from i2pdsl.study.analysis import analyse
from i2pdsl.study.answers import Answers
from i2pdsl.study.check import check_study
from i2pdsl.study.kit import asked_as, fit_options
from i2pdsl.study.parse import load_study, parse_study
from i2pdsl.study.people import collect, tables_in
from i2pdsl.study.spec import Study
from studies_for_tests import TINY

HEAD = "participant,script,frame,question,answer,attention,complete,seconds"
KEY = "script,condition,method,seed"


@pytest.fixture
def study(tmp_path: Path) -> Study:
    """The tiny one, and the key of its kit beside `tmp_path / "answers"`."""
    (tmp_path / "tiny.study").write_text(TINY, encoding="utf-8")
    found = load_study(tmp_path / "tiny.study")
    rows = [
        f"scripts/f{n}.json,{f.condition},{f.method},{f.seed}" for n, f in enumerate(found.films)
    ]
    (tmp_path / "key.csv").write_text("\n".join([KEY, *rows, ""]), encoding="utf-8")
    (tmp_path / "answers").mkdir()
    return found


def write(folder: Path, *rows: str, name: str = "a.csv") -> Path:
    path = folder / "answers" / name
    path.write_text("\n".join([HEAD, *rows, ""]), encoding="utf-8")
    return path


def wrong(study: Study, *tables: Path) -> list[str]:
    with pytest.raises(StoryError) as caught:
        collect(study, tables, lambda path: None, keep_all=False)
    return [line for d in caught.value.diagnostics for line in d.render().splitlines()[:1]]


def test_rows_become_answers_and_who_does_not_count_is_told(study: Study, tmp_path: Path) -> None:
    write(
        tmp_path,
        "ann,scripts/f0.json,T,tiny,helping,passed,yes,9",
        "ann,scripts/f13.json,T,tiny,helping,passed,yes,8",
        "ben,scripts/f0.json,T,tiny,unclear,failed,yes,1",
        "cy,scripts/f1.json,T,tiny,hindering,passed,no,7",
        HEAD,
        "ann,scripts/f0.json,T,tiny,unclear,passed,yes,3",
    )
    write(tmp_path, "dee,scripts/f13.json,,,hindering,,,", name="b.csv")
    places = tables_in([tmp_path / "answers"])
    found = collect(study, places, lambda path: None, keep_all=False)
    assert found.answers.participants == ("ann", "dee")
    assert [item.films[0] for item in found.answers.items] == [study.films[0], study.films[13]]
    np.testing.assert_equal(found.answers.given, [[0, 0], [np.nan, 1]])
    np.testing.assert_equal(found.answers.matches, [[1, 0], [np.nan, 1]])
    assert found.excluded == {"attention": ("ben",), "incomplete": ("cy",)}
    assert found.twice == 1
    assert [row.more["seconds"] for row in found.rows] == ["9", "8", ""]
    everybody = collect(study, places, lambda path: None, keep_all=True)
    assert everybody.answers.participants == ("ann", "ben", "cy", "dee")
    assert everybody.excluded == {}


def test_films_are_known_by_columns_too(study: Study, tmp_path: Path) -> None:
    table = tmp_path / "r.csv"
    (tmp_path / "key.csv").unlink()
    table.write_text(
        "participant,script,question,answer,condition,method,seed\n"
        "ann,x.mp4,tiny,helping,hinder,short,2\n",
        encoding="utf-8",
    )
    found = collect(study, [table], lambda path: None, keep_all=False)
    assert [item.films[0].place for item in found.items] == ["hinder/short/seed-2"]


def test_mistakes_are_told_at_their_cells(study: Study, tmp_path: Path) -> None:
    table = write(
        tmp_path,
        "ann,scripts/f0.json,T,tiny,helpin,passed,yes,9",
        ",scripts/f1.json,T,tiny,helping,passed,yes,9",
    )
    assert wrong(study, table) == [
        f"{table}:2:28: error[table]: `helpin` is none of the choices of `tiny`",
        f"{table}:3:1: error[table]: `participant` is empty",
    ]
    table = write(tmp_path, "ann,scripts/f99.json,T,tiny,helping,passed,yes,9")
    assert wrong(study, table) == [
        f"{table}:2:5: error[judgement]: `scripts/f99.json` is no film of the study"
    ]
    (tmp_path / "key.csv").write_text(f"{KEY}\nscripts/f0.json,help,naive,77\n", encoding="utf-8")
    table = write(tmp_path, "ann,scripts/f0.json,T,tiny,helping,passed,yes,9")
    assert wrong(study, table) == [
        f"{table}:2:5: error[judgement]: the study does not show help/naive/seed-77"
    ]
    table = write(tmp_path, "ann,scripts/f0.json,T,other,1,passed,yes,9")
    assert wrong(study, table) == [f"{table}:2:23: error[judgement]: the study asks `tiny`"]
    table = write(tmp_path, "ann,scripts/f0.json,T,tiny,helping,failed,yes,9")
    (tmp_path / "key.csv").write_text(f"{KEY}\nscripts/f0.json,help,naive,x\n", encoding="utf-8")
    assert wrong(study, table) == [
        f"{tmp_path / 'key.csv'}:2:1: error[table]: this is no line of a key"
    ]
    (tmp_path / "key.csv").write_text(f"{KEY}\nscripts/f0.json,help,naive,0\n", encoding="utf-8")
    assert "nobody is left" in wrong(study, table)[0]
    with pytest.raises(StoryError, match="there is no table of answers here"):
        tables_in([tmp_path / "answers", tmp_path])


SLIDING = """
question
    ask = "Did it help?"
    kind = slider
    event = "rho > 0"
    when = {}
"""


@pytest.mark.parametrize(
    ("when", "right", "wrong_ones"),
    [
        (
            "end",
            ["P(rho>0|script[:t])", "P(0 < rho | script[:T])", "P(rho > 0 | script[:t]),4"],
            ["P(rho < 0 | script[:t])", "P(rho > 0 | script[:t]),3", "mean_t P(rho > 0)", "?"],
        ),
        (
            "throughout",
            ["mean_t P(rho > 0 | script[:t])", "mean_t (P(rho>0|script[:t]))"],
            ["mean_t P(rho > 0 | script[:T])", "P(rho > 0 | script[:t])"],
        ),
    ],
)
def test_a_question_in_other_words_is_known_by_its_meaning(
    place: Path, when: str, right: list[str], wrong_ones: list[str]
) -> None:
    text = TINY.partition("question")[0] + SLIDING.format(when)
    text = text.replace("helping\ncond", "high\ncond").replace("hindering\n\n", "low\n\n")
    path = place / "tiny.study"
    path.write_text(text.replace("method short", "method other").replace("length = 2", "beta = 1"))
    study = load_study(path)
    grounds = check_study(study)
    own = asked_as(study)
    for asked, is_known in [*((q, True) for q in right), *((q, False) for q in wrong_ones)]:
        question, _, frame = asked.partition(",")
        table = place / "a.csv"
        table.write_text(
            "participant,script,frame,question,answer,condition,method,seed\n"
            f'ann,x.mp4,{frame or "T"},"{question}",80,hinder,other,2\n',
        )
        read = partial(collect, study, [table], lambda path: None, keep_all=False)
        if is_known:
            assert [row.question for row in read(grounds=grounds).rows] == [own]
        else:
            with pytest.raises(StoryError, match=r"the study asks `"):
                read(grounds=grounds)
        if question != own:
            with pytest.raises(StoryError, match=r"the study asks `"):
                read()


def answered(study: Study, rights: Sequence[Sequence[float]]) -> Answers:
    """What each participant answered about `help`, by naive and then by short; 1 is right."""
    items = tuple(item for item in study.items if item.group == "help")
    given = 1 - np.array(rights, float)
    return Answers(study, tuple(f"p{n}" for n in range(len(given))), items, given)


def test_p_by_people_is_that_of_all_changes_of_sign(study: Study) -> None:
    rights = [[0, 0, 0, 0, 1, 1, 1, 1]] * 4 + [[1, 0, 0, 0, 1, np.nan, 0, np.nan]]
    answers = answered(study, rights)
    naive, short = p_by_people(answers, analyse(answers))
    assert naive is None
    apart = np.array([1, 1, 1, 1, 0.25])
    every = [(np.array([b >> k & 1 for k in range(5)]) * 2 - 1) @ apart for b in range(32)]
    exact = np.mean(np.abs(every) >= apart.sum() - 1e-12)
    assert short == pytest.approx(exact, abs=0.01)


class Estimate:
    """In the place of the model, which takes seconds: it says what was asked of it."""

    def __call__(self, matches: np.ndarray, cell: np.ndarray, seed: int = 0) -> mixed.Posterior:
        self.matches, self.cell = matches, cell
        share = np.linspace(0, 1, 1001)[:, None] * np.ones(cell.max() + 1) / (1 + np.arange(4))
        ones = np.ones(1001)
        return mixed.Posterior(share, ones, ones, share, self.rhat, 400.0)

    rhat = 1.0


def test_from_tables_to_a_report_and_on_to_fit(
    place: Path, i2p: Run, here: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a panel answered is read again as if people had; `i2p fit` reads the joined table."""
    from i2pdsl.commands.fit import _choice
    from i2pdsl.fit.judgements import read_judgements
    from i2pdsl.fit.questions import study as read_by_fit

    arguments = ("study", place / "tiny.study", "--out", place / "out")
    before = json.loads(i2p(*arguments, "--json").out)
    model = Estimate()
    monkeypatch.setattr(mixed, "estimate", model)
    table = place / "out" / "answers-viewers.csv"
    done = i2p("study", place / "tiny.study", "--out", place / "out", "--analyse", table, "--json")
    assert done.status == 0, done.err
    told = json.loads(done.out)
    alone = [dict(share) for share in told["shares"]]
    p = [share.pop("p_people") for share in alone]
    assert alone == before["panels"][0]["shares"]
    assert [one is None for one in p] == [True, False, True, False]
    assert (told["participants"], told["answers"], told["excluded"]) == (6, 96, {})
    assert told["by_participant"]["viewers-1"]["answers"] == 16
    assert model.matches.shape == (6, 16)
    assert model.cell.tolist() == [n // 4 for n in range(16)]
    effects = told["mixed"]["effects"]
    assert effects[0]["low"] == pytest.approx(0.025)
    assert effects[1]["difference"] == pytest.approx([-0.25, -0.4875, -0.0125])
    assert (effects[1]["more"], effects[0]["difference"]) == (0.0, None)
    with open(told["files"]["answers"], encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 96
    for row in rows:
        assert (
            row["script"]
            == f"films/{row['condition']}/{row['method']}/seed-{row['seed']}/script.json"
        )
    option = fit_options(load_study(place / "tiny.study"))
    assert option.endswith('" --assume "nothing"')
    name, choice = _choice(option.removeprefix('--choice "').removesuffix('" --assume "nothing"'))
    assert list(choice.options) == ["helping", "hindering", "unclear"]
    judgements = read_judgements(told["files"]["answers"], named={name: choice})
    fitted = read_by_fit(judgements, place / "out", 1.0, {name: choice})
    assert len(fitted.asked.answer) == 96
    words = i2p("study", place / "tiny.study", "--out", place / "out", "--analyse", table)
    for text in (
        "96 answers of 6 people to 16 films",
        "new people, new films",
        "by participant: from",
    ):
        assert text in words.out
    model.rhat = 1.2
    done = i2p("study", place / "tiny.study", "--out", place / "out", "--analyse", table)
    assert done.status == 1
    assert "the mixed-effects model has not converged: R-hat 1.200" in done.err
    both = i2p("study", place / "tiny.study", "--kit", place / "kit", "--analyse", table)
    assert both.status == 2


def test_a_key_of_pairs_and_sliders_tells_how_fit_reads(tmp_path: Path) -> None:
    from i2pdsl.errors import Source

    hill = load_study(Path(__file__).parents[2] / "studies" / "hill.study")
    assert (
        fit_options(hill) == '--pair "hill:mean_t P(weight = 0.5 | script[:t])" --assume "nothing"'
    )
    text = 'study\ncondition a\n    right = high\n    story = "a.story"\n'
    text += 'question\n    ask = "?"\n    kind = slider\n    event = "rho > 0"\n'
    slider = parse_study(Source("s.study", text), tmp_path / "s.study")
    assert fit_options(slider) == '--scale 100 --assume "nothing"'
