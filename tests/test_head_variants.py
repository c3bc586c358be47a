"""Heads as people and instruments write them: the numbers right, or one clear line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.measured.heads import unit_in
from stickslip.measured.inspection import inspect
from stickslip.measured.readers.tables import read_columns

N = 60
T = np.round(0.002 * np.arange(N), 4)
F = np.round(1.5 + 0.4 * np.sin(0.3 * np.arange(N)), 6)
RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)


def rows(separator: str = ",", end: str = "", words: tuple[str, ...] = ()) -> str:
    told = [separator + word for word in words] + [separator * bool(words)] * (N - len(words))
    return "".join(f"{t:.4f}{separator}{f:.6f}{word}{end}\n" for t, f, word in zip(T, F, told, strict=True))


def load(file: Path) -> ss.Recording:
    channels = {"t": ss.Channel("t", "s"), "spring_force": ss.Channel("F", "N")}
    return ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s")


RIGHT = {
    "Sec in a head": "t [Sec],F [N]\n" + rows(),
    "SEC in a row of units": "t,F\nSEC,NEWTON\n" + rows(),
    "rows, names and units end in separators": "t;F;\ns;N;\n" + rows(";", ";"),
    "units alone end in one": "t;F\n[s];[N];\n" + rows(";"),
    "names and units do, rows do not": "t;F;\ns;N;\n" + rows(";"),
    "a note that names both": "t and F over time\nt,F\n" + rows(),
    "a note in cells": "Channels,t,F\nt,F\ns,N\n" + rows(),
    "a note among white space": "note on t F here\nt F\n" + rows(" "),
    "rows of a preamble below a note": "t and F over time\nRange 10.0 -10.0 5\nChannel 1 2 3\nt F\n"
    + rows(" "),
    "an empty row of units": "t;F\n;\n" + rows(";"),
    "an empty row of units in quotes": 't,F\n"",""\n' + rows(),
    "an empty row of units as wide as its names": "t,F,\n,,\n" + rows(),
    "no-break spaces around names": "\u00a0t;F\u202f\n" + rows(";"),
    "a comment at the first row": "t [s],F [N],Comment\n" + rows(words=("begin",)),
}


@pytest.mark.parametrize("text", RIGHT.values(), ids=RIGHT)
def test_the_numbers_are_right(tmp_path: Path, text: str) -> None:
    (tmp_path / "run.csv").write_text(text)
    run = load(tmp_path / "run.csv")
    assert [one.head for one in inspect(tmp_path / "run.csv").columns][:2] == ["t", "F"]
    np.testing.assert_array_equal(run.raw["t"], T)
    np.testing.assert_array_equal(run.raw["spring_force"], F)


REFUSED = {
    "a note of as many words, among them the names": (
        "t;x;F\nF over t\n" + rows(";").replace(";", ";0;"),
        "line 2: 1 cell where the header names 3",
    ),
    "names twice, in two orders": (
        "F,t\nt,F\n" + rows(),
        "line 2: names the columns in another order than line 1",
    ),
    "siemens": ("t [S],F [N]\n" + rows(), r"the file has 't \[S\]', but its channel is declared in 's'"),
    "a note below the names": (
        "t,F\nt and F over time\n" + rows(),
        "line 2: 1 cell where the header names 2",
    ),
    "force in seconds": ("t [s],F [SEC]\n" + rows(), "but its channel is declared in 'N'"),
}


@pytest.mark.parametrize(("text", "words"), REFUSED.values(), ids=REFUSED)
def test_what_is_doubtful_gets_one_line(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(ss.InputError, match=words) as caught:
        load(tmp_path / "run.csv")
    assert "\n" not in str(caught.value)


def test_a_note_of_as_many_words_as_columns_is_not_their_names(tmp_path: Path) -> None:
    """White space parted it into names: time was read as the force."""
    file = tmp_path / "run.csv"
    for note in ("F over t\nt;x;F\n", "t;x;F\nF over t\n"):
        file.write_text(note + rows(";").replace(";", ";0;"))
        assert [one.head for one in inspect(file).columns] == ["t", "x", "F"]


@pytest.mark.parametrize("word", ["begin", "ok, 5 mm"])
def test_a_column_of_words_is_not_doubtful(tmp_path: Path, word: str) -> None:
    (tmp_path / "run.csv").write_text("t [s];F [N];Comment\n" + rows(";", words=(word,)))
    found = inspect(tmp_path / "run.csv")
    assert not found.doubts
    assert [one.values is None for one in found.columns] == [False, False, True]


def test_a_column_of_numbers_with_a_word_is_doubtful(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("t [s],F [N]\n" + rows().replace(f"{F[7]:.6f}", "lost"))
    assert any("'lost' is text" in one for one in inspect(tmp_path / "run.csv").doubts)


@pytest.mark.parametrize("word", ["Min", "MAX", "Ms", "Pa s x", "AVG"])
def test_words_in_capitals_are_not_made_units(word: str) -> None:
    assert unit_in(word) != word.lower()


def test_a_comment_that_names_the_columns_in_another_order_is_refused(tmp_path: Path) -> None:
    """Its order was taken: time and force were swapped."""
    file = tmp_path / "run.csv"
    rows = "".join(f"{k},{2 * k}\n" for k in range(9))
    file.write_text("t,F\n# F,t\n" + rows)
    with pytest.raises(ss.InputError, match="line 2: names the columns in another order than line 1"):
        read_columns(file, ["t", "F"])
    file.write_text("t,F\n# t,F\n" + rows)
    assert read_columns(file, ["t", "F"]).values["F"][1] == 2


@pytest.mark.parametrize("head", ["t,F\n# F,t\n", "t [s],F [N]\n# F,t\n", "t,F\ns,N\n# F [N],t [s]\n"])
def test_inspect_refuses_what_load_refuses(tmp_path: Path, head: str) -> None:
    """The comment was taken for the names: time and force were swapped."""
    file = tmp_path / "run.csv"
    file.write_text(head + rows())
    for look in (load, inspect):
        with pytest.raises(ss.InputError, match="names the columns in another order than line 1"):
            look(file)


@pytest.mark.parametrize("head", ["t,F\n# t,F\n", "t [s],F [N]\n# t,F\n", "t,F\n# t [s],F [N]\n"])
def test_a_comment_that_repeats_the_names_is_harmless(tmp_path: Path, head: str) -> None:
    """One with the units left out was refused as another order."""
    file = tmp_path / "run.csv"
    file.write_text(head + rows())
    np.testing.assert_array_equal(load(file).raw["spring_force"], F)
    assert [one.head for one in inspect(file).columns] == ["t", "F"]


@pytest.mark.parametrize("blank", ["\u00a0", "\u202f"])
@pytest.mark.parametrize("separator", [";", " "])
@pytest.mark.parametrize("cell", ["{}1.5", "1.5{}", "1{}000.5"])
def test_a_no_break_space_in_a_number_has_its_line(
    tmp_path: Path, cell: str, separator: str, blank: str
) -> None:
    """The line was not named, or another number of cells was."""
    file = tmp_path / "run.csv"
    lines = rows(separator).splitlines()
    lines[7] = f"0.0140{separator}{cell.format(blank)}"
    file.write_text("\n".join([f"t{separator}F", *lines, ""]))
    with pytest.raises(ss.InputError, match=f"line 9, column 'F': .* no-break space .U.{ord(blank):04X}"):
        load(file)
    assert any("no-break space" in one for one in inspect(file).doubts)


def test_rows_above_the_names_are_said_to_be_left_out(tmp_path: Path) -> None:
    """The names had been moved some rows down: the run was shorter, and nothing said so."""
    file = tmp_path / "run.csv"
    lines = rows().splitlines()
    file.write_text("\n".join(["Range 10", *lines[:3], "t [s],F [N]", *lines[3:], ""]))
    run = load(file)
    assert len(run) == N - 3
    words = "3 rows of numbers above the names, in line 5, left out"
    assert any(words in str(one) for one in run.findings)
    assert inspect(file).doubts  # where no names are declared, they are a fault among the numbers
