"""Tables as instruments write them: whatever is moved over a good file, the same numbers or one clear line."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.measured.readers.tables import column_names, open_table, read_columns

RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
N = 30
T = np.round(0.002 * np.arange(N), 6)
F = np.round(1.5 + 0.4 * np.sin(0.3 * np.arange(N)), 6)
TEMP = 23 + np.arange(N)

PREAMBLES = (
    (),
    ("Friction test 12, dry",),
    ("Model,DPO4104", "Firmware Version,2.68", "", "Sample Interval,0.002,,", "Label,,,"),
    ("[Header];", "Radius [mm];3,00", "Lin. Speed [cm/s];0,50", ""),
    ("HBM_CATMAN_DATAFILE_40", "DATE\t05.03.2024", "", 'Probe: 5" pin'),
    ("File Name: test_01.csv", "Operator: M\u00fcller, lab", "", "", "Force F over time t"),
    ("sep=;",),
    ("Samples\t2000\t\t", "X0\t0,0\t\t", "Delta_X\t0,002\t\t"),
)
HEADS = (
    ("t", "F", "temp"),
    ("t [s]", "F [N]", "temp [\u00b0C]"),
    ("t(s)", "F(N)", "temp(K)"),
    ('"t"', '"F"', '"temp"'),
)
UNITS = (None, ("s", "N", "\u00b0C"), ("(s)", "(N)", "-"), ("second", "Newtons", ""), ("sec", "V", "V"))


@dataclass(frozen=True)
class Dialect:
    separator: str = ","
    sign: str = "."
    preamble: tuple[str, ...] = ()
    heads: tuple[str, ...] = HEADS[0]
    units: tuple[str, ...] | None = None
    encoding: str = "utf-8"
    end: str = "\n"
    blank: bool = False
    time: str = "number"

    def cells(self, i: int) -> list[str]:
        t = f"{T[i]:.6f}"
        if self.time == "clock":
            t = f"10:11:{12 + T[i]:09.6f}"
        elif self.time == "date":
            t = f"2024-03-05T10:11:{12 + T[i]:09.6f}+01:00"
        elif self.time == "spaced":
            t = f"2024/03/05 10:11:{12 + T[i]:09.6f}"
        return [t.replace(".", self.sign), f"{F[i]:.6f}".replace(".", self.sign), f"{TEMP[i]}"]

    def text(self, rows: list[list[str]] | None = None) -> str:
        rows = rows or [self.cells(i) for i in range(N)]
        lines = [*self.preamble, self.separator.join(self.heads)]
        lines += [] if self.units is None else [self.separator.join(self.units)]
        lines += [""] * self.blank + [self.separator.join(row) for row in rows]
        return self.end.join(lines) + self.end

    def bytes(self, rows: list[list[str]] | None = None) -> bytes:
        return self.text(rows).encode(self.encoding)


@st.composite
def dialects(draw: st.DrawFn) -> Dialect:
    separator = draw(st.sampled_from([",", ";", "\t", " "]))
    heads = draw(st.sampled_from(HEADS if separator != " " else (HEADS[0], HEADS[2], HEADS[3])))
    units = draw(st.sampled_from(UNITS))
    if units and (separator == " " and "" in units):
        units = None
    return Dialect(
        separator=separator,
        sign="." if separator == "," else draw(st.sampled_from(".,")),
        preamble=draw(st.sampled_from(PREAMBLES)),
        heads=heads,
        units=units if "[" not in heads[0] and "(" not in heads[0] else None,
        encoding=draw(st.sampled_from(["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le", "utf-16-be"])),
        end=draw(st.sampled_from(["\n", "\r\n"])),
        blank=draw(st.booleans()),
        time=draw(st.sampled_from(["number", "number", "clock", "date"] + ["spaced"] * (separator != " "))),
    )


def load(content: bytes) -> ss.Recording:
    channels = {"t": ss.Channel("t", "s"), "spring_force": ss.Channel("F", "N")}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.csv"
        file.write_bytes(content)
        return ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s")


@settings(max_examples=150, deadline=None)
@given(dialect=dialects())
def test_every_dialect_gives_the_same_numbers(dialect: Dialect) -> None:
    run = load(dialect.bytes())
    np.testing.assert_allclose(run.t, T, atol=2e-9)
    np.testing.assert_allclose(run.x1 * 500, F)


@settings(max_examples=150, deadline=None)
@given(dialect=dialects(), at=st.integers(0, N - 1), column=st.integers(0, 1), data=st.data())
def test_a_fault_in_any_dialect_gets_one_line_and_shifts_nothing(
    dialect: Dialect, at: int, column: int, data: st.DataObject
) -> None:
    rows = [dialect.cells(i) for i in range(N)]
    fault = data.draw(st.sampled_from(["blank", "short", "long", "text", "quote", "split", "nan"]))
    if fault == "blank":
        rows[at][column] = ""
    elif fault == "short":
        del rows[at][column]
    elif fault == "long":
        rows[at].insert(column, "7")
    else:
        rows[at][column] = {
            "text": "n/a",
            "quote": '"1.0',
            "split": f"1{dialect.separator}234",
            "nan": "nan",
        }[fault]
    with pytest.raises(ss.InputError) as refused:
        load(dialect.bytes(rows))
    assert str(refused.value).isprintable()


@pytest.mark.parametrize("text", ['"', '"\n"\n', ";;\n", '# alone\n"\n'])
def test_a_file_of_marks_alone_is_empty(tmp_path: Path, text: str) -> None:
    """A file cut after its first quote ended in a traceback."""
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(ss.InputError, match="empty; it needs a line of column names"):
        ss.load_recording(tmp_path / "run.csv", RIG, belt_speed="5 mm/s")


@settings(max_examples=100, deadline=None)
@given(dialect=dialects(), data=st.data())
def test_damaged_text_gets_numbers_or_one_line(dialect: Dialect, data: st.DataObject) -> None:
    content = bytearray(dialect.bytes())
    how = data.draw(st.sampled_from(["flip", "cut", "zeros"]))
    at = data.draw(st.integers(0, len(content) - 1))
    if how == "flip":
        content[at] ^= 1 << data.draw(st.integers(0, 7))
    elif how == "cut":
        del content[at:]
    else:
        content[at : at + 16] = bytes(len(content[at : at + 16]))
    run = refusal = None
    try:
        run = load(bytes(content))
    except ss.InputError as refused:
        refusal = str(refused)
    if run is None:
        assert refusal is not None
        assert refusal.isprintable()
    else:
        assert np.isfinite(run.x1).all()
        assert run.t.size >= N - 2 or how == "cut"


@settings(max_examples=100, deadline=None)
@given(dialect=dialects())
def test_names_are_found_where_none_are_declared(dialect: Dialect) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.csv"
        file.write_bytes(dialect.bytes())
        names = column_names(file)
    assert [name[0] for name in names] == ["t", "F", "t"]


def test_a_row_of_units_speaks_against_the_declared_ones() -> None:
    with pytest.raises(ss.InputError, match="the file has 'F in mN', but its channel is declared in 'N'"):
        load(replace(Dialect(), units=("s", "mN", "K")).bytes())


def test_a_row_of_volts_is_a_doubt() -> None:
    run = load(replace(Dialect(), units=("s", "Volt", "K")).bytes())
    assert "file: spring_force: the file says volt; 1 volt is taken for 1 N, as declared" in map(
        str, run.findings
    )


def test_names_without_cells_are_a_doubt_unless_they_are_asked_for() -> None:
    rows = [Dialect().cells(i)[:2] for i in range(N)]
    run = load(Dialect().bytes(rows))
    np.testing.assert_allclose(run.x1 * 500, F)
    assert "file: each row ends before the last 1 of 3 names" in map(str, run.findings)
    with pytest.raises(ss.InputError, match="2 cells where the header names 3 columns"):
        load(replace(Dialect(), heads=("t", "temp", "F")).bytes(rows))
    with pytest.raises(ss.InputError, match="2 cells where the header names 3 columns"):
        load(replace(Dialect(), separator=" ").bytes([row[:2] for row in rows]))


def test_a_quotation_mark_cannot_swallow_rows(tmp_path: Path) -> None:
    rows = [[*Dialect().cells(i)[:2], "ok"] for i in range(N)]
    rows[4][2], rows[9][2] = '"here', 'there"'
    (tmp_path / "run.csv").write_bytes(Dialect().bytes(rows))
    with pytest.raises(ss.InputError, match="a quotation mark is opened and not closed"):
        read_columns(tmp_path / "run.csv", ["t", "F"])


@pytest.mark.parametrize(
    ("cells", "unit", "words"),
    [
        (["10:00:00", "10:00:01", "soon"], "s", "line 4, column 't': 'soon' is no time like '10:00:00'"),
        (["10:00:00", "10:00:01", "10:00:61.5"], "s", "is no time like"),
        (["10:00:00", "10:00:01", "10:00:02"], "mm", "the channel is declared in 'mm'; give a unit of time"),
        (["10:00:00", "10:00:01", "10:00:02"], "1", "the channel is declared in '1'; give a unit of time"),
        (["05.03.2024", "05.03.2024", "05.03.2024"], "s", "'05.03.2024' is text"),
    ],
)
def test_times_that_are_none(tmp_path: Path, cells: list[str], unit: str, words: str) -> None:
    (tmp_path / "run.csv").write_text("t,F\n" + "".join(f"{cell},1.5\n" for cell in cells))
    with pytest.raises(ss.InputError, match=words):
        read_columns(tmp_path / "run.csv", ["t", "F"], {"t": unit, "F": "N"})


def test_clock_times_come_in_the_declared_unit(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("t,F\n10:00:00,1\n10:00:00.5,2\n10:01:00,3\n")
    columns = read_columns(tmp_path / "run.csv", ["t"], {"t": "ms"})
    np.testing.assert_allclose(columns.values["t"], [0, 500, 60000])


def test_what_is_said_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_bytes("Zeit;Kraft\ns;\u00b5N\n0;1,5\n1;2,5\n".encode("latin-1"))
    contents = open_table(tmp_path / "run.csv").contents
    assert contents.units == {"Zeit": "s", "Kraft": "\u00b5N"}
    assert "text in LATIN-1" in contents.facts
