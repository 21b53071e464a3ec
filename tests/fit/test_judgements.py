"""Tables of judgements: what is read, and what is said of every mistake."""

from __future__ import annotations

from pathlib import Path

import pytest

from i2pdsl.errors import StoryError
from i2pdsl.fit.judgements import Choice, Judgement, Pair, read_judgements, repeated

HEAD = "participant,script,frame,question,answer\n"


def table(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_table_is_read(tmp_path: Path) -> None:
    rows = 'ann,a.json,3,P(rho > 0 | script[:t]),0.25\n\nben, b.json ,T,"P(G = ""x"" | s), y",1\n'
    found = read_judgements(table(tmp_path, HEAD + rows))
    assert found == (
        Judgement("ann", "a.json", 3, "P(rho > 0 | script[:t])", 0.25),
        Judgement("ben", "b.json", None, 'P(G = "x" | s), y', 1.0),
    )
    assert found[1].spans["answer"].source.position(found[1].spans["answer"].start) == (4, 38)


def test_columns_may_be_left_out_and_stand_in_any_order(tmp_path: Path) -> None:
    text = "answer,who,participant,script\r\n50,x,ann,a.json\r\n"
    (found,) = read_judgements(table(tmp_path, text), scale=100, question="P(rho > 0)")
    assert found == Judgement("ann", "a.json", None, "P(rho > 0)", 0.5, None, {"who": "x"})


@pytest.mark.parametrize("sign", [";", "\t"])
def test_cells_may_be_apart_by_other_signs(tmp_path: Path, sign: str) -> None:
    text = (HEAD + 'ann,a.json,3,"P(a, b)",0?25\n').replace(",", sign).replace("?", ",")
    (found,) = read_judgements(table(tmp_path, text.replace(f"a{sign} b", "a, b")))
    assert found == Judgement("ann", "a.json", 3, "P(a, b)", 0.25)


def test_the_same_asked_twice_is_said(tmp_path: Path) -> None:
    rows = "ann,a.json,1,q,0\nann,a.json,2,q,0\nben,a.json,1,q,0\n"
    assert repeated(read_judgements(table(tmp_path, HEAD + rows))) is None
    told = repeated(read_judgements(table(tmp_path, HEAD + rows + rows)))
    assert told is not None
    assert told.startswith("3 of 6 answers")
    assert "in line 5" in told


def test_a_choice_is_answered_by_a_label(tmp_path: Path) -> None:
    choices = {"why": Choice({"help": "P(rho > 0)", "hinder": "P(rho < 0)"})}
    rows = "ann,a.json,1,why,help\nben,a.json,1,why,hnder\n"
    with pytest.raises(StoryError, match="`hnder` is none of the choices") as caught:
        read_judgements(table(tmp_path, HEAD + rows), named=choices)
    assert "did you mean `hinder`?" in str(caught.value)
    (found,) = read_judgements(table(tmp_path, HEAD + rows.split("ben")[0]), named=choices)
    assert found.answer == "help"


def test_of_two_films_one_is_chosen(tmp_path: Path) -> None:
    """Rows about two films stand beside others; what is wrong with them is told at its cell."""
    named = {"more": Pair("E[rho | script[:T]]"), "why": Choice({"a": "T", "b": "1"})}
    head = HEAD.replace("frame", "other,frame")
    rows = "ann,a.json,b.json,T,more,second\nann,a.json,,T,q,1\n"
    pair, slider = read_judgements(table(tmp_path, head + rows), named=named)
    assert pair == Judgement("ann", "a.json", None, "more", "second", "b.json")
    assert list(pair.scripts) == [("script", "a.json"), ("other", "b.json")]
    assert (slider.other, slider.answer) == (None, 1.0)
    rows = "ann,a,b,T,more,secnd\nann,a,,T,more,first\nann,a,b,T,why,first\nann,a,b,T,q,0.5\n"
    with pytest.raises(StoryError) as caught:
        read_judgements(table(tmp_path, head + rows), named=named)
    for place, said in (
        ("2:16", "`secnd` is neither `first` nor `second`"),
        ("3:7", "`more` is about two films"),
        ("4:7", "`why` is a choice among events"),
        ("5:13", "`0.5` is neither"),
    ):
        assert f"table.csv:{place}: error[table]: " in str(caught.value)
        assert said in str(caught.value)
    assert "did you mean `second`?" in str(caught.value)
    assert len(caught.value.diagnostics) == 4


@pytest.mark.parametrize(
    ("text", "line", "column", "said"),
    [
        ("", 1, 1, "the table is empty"),
        (HEAD, 2, 1, "the table has no answers"),
        ("participant,script,frame,question\n", 1, 1, "no column `answer`"),
        ("participant,script,answer\na,b,1\n", 1, 1, "--question EXPRESSION"),
        ("answer," + HEAD, 1, 1, "two columns are called `answer`"),
        (HEAD + "a,b,1,q,2\n", 2, 9, "`--scale 100`"),
        (HEAD + "a,b,1,q,-1\n", 2, 9, "no answer between 0 and 1"),
        (HEAD + "a,b,1,q,nan\n", 2, 9, "no answer between 0 and 1"),
        (HEAD + "a,b,1,q,1e999\n", 2, 9, "no answer between 0 and 1"),
        (HEAD + "a,b,1.5,q,0\n", 2, 5, "`1.5` is no frame"),
        (HEAD + "a,b,-1,q,0\n", 2, 5, "`-1` is no frame"),
        (HEAD + "a,b,٣,q,0\n", 2, 5, "is no frame"),
        (HEAD + "a,,1,q,0\n", 2, 3, "`script` is empty"),
        (HEAD + ",b,1,q,0\n", 2, 1, "`participant` is empty"),
        (HEAD + "a,b,1,,0\n", 2, 7, "nothing was asked"),
        (HEAD + "a,b,1,P(x, y),0\n", 2, 1, "6 cells, and 5 columns"),
        (HEAD + 'a,b,1,"q"x,0\n', 2, 10, "behind the closing quote"),
    ],
)
def test_mistakes_have_their_place(
    tmp_path: Path, text: str, line: int, column: int, said: str
) -> None:
    with pytest.raises(StoryError) as caught:
        read_judgements(table(tmp_path, text))
    assert f"table.csv:{line}:{column}: error[table]" in str(caught.value)
    assert said in str(caught.value)


def test_all_mistakes_are_told_and_not_thousands(tmp_path: Path) -> None:
    with pytest.raises(StoryError) as caught:
        read_judgements(table(tmp_path, HEAD + "a,b,1,q,7\n" * 1000))
    assert len(caught.value.diagnostics) == 201


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(StoryError, match="no such file"):
        read_judgements(tmp_path / "nothing.csv")


def test_parquet(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    rows = {"participant": ["a"], "script": ["b"], "frame": [3], "question": ["q"], "answer": [2.0]}
    pandas.DataFrame(rows).to_parquet(tmp_path / "t.parquet")
    with pytest.raises(StoryError, match=r"t\.parquet:2:9: .*`2\.0` is no answer"):
        read_judgements(tmp_path / "t.parquet")
    (tmp_path / "bad.parquet").write_text("no")
    with pytest.raises(StoryError, match="no Parquet table"):
        read_judgements(tmp_path / "bad.parquet")
