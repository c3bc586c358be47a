"""LabVIEW measurement files: laid out as LabVIEW lays them out, read as a reader written elsewhere reads them."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.measured.readers.tables import open_table, read_columns

STEP = 0.002
FORCE = np.round(1.5 + 0.4 * np.sin(0.3 * np.arange(30)), 6)
PLACE = np.round(np.cos(0.3 * np.arange(30)), 6)
END = "***End_of_Header***"


@dataclass(frozen=True)
class Writer:
    """What LabVIEW's "Write To Measurement File" lets one choose."""

    columns: str = "One"
    sign: str = "."
    separator: str = "\t"
    comments: bool = False
    segments: int = 1
    again: bool = False  # each segment's times begin at 0
    units: tuple[str, str] = ("Newtons", "m")

    def text(self) -> str:
        name = "Tab" if self.separator == "\t" else "Comma"
        head = [
            ["LabVIEW Measurement", ""],
            ["Writer_Version", "2"],
            ["Separator", name],
            ["Decimal_Separator", self.sign],
            ["Multi_Headings", "Yes"],
            ["X_Columns", self.columns],
            ["Time_Pref", "Relative"],
            ["Time", "10:11:12" + self.sign + "123456"],
            [END, ""],
            [""],
        ]
        lines = [self.separator.join(one) for one in head]
        for i, part in enumerate(np.array_split(np.arange(30), self.segments)):
            lines += [self.separator.join(one) for one in self.segment(i, part)]
        return "\r\n".join(lines) + "\r\n"

    def segment(self, i: int, part: np.ndarray) -> list[list[str]]:
        start = 0.0 if self.again else STEP * part[0]
        gap = [""] if self.columns == "Multi" else []
        both = {
            "Channels": ["2", *gap, ""],
            "Samples": [str(part.size), *gap, str(part.size)],
            "Y_Unit_Label": [self.units[0], *gap, self.units[1]],
            "X_Dimension": ["Time", *gap, "Time"],
            "X0": [self.number(start), *gap, self.number(start)],
            "Delta_X": [self.number(STEP), *gap, self.number(STEP)],
        }
        out = [[key, *cells, ""] for key, cells in both.items()] + [[END, *gap, "", ""]]
        second = ["X_Value"] if self.columns == "Multi" else []
        out.append(["X_Value", "Force", *second, "Place", "Comment"])
        for k, j in enumerate(part):
            t = "" if self.columns == "No" else self.number(start + STEP * k)
            row = [t, self.number(FORCE[j]), *([t] if second else []), self.number(PLACE[j])]
            out.append(row + ["all well"] * (self.comments and k == 3))
        return [*out, [""]] if i + 1 < self.segments else out

    def number(self, x: float) -> str:
        return f"{x:.6f}".replace(".", self.sign)


writers = st.builds(
    Writer,
    columns=st.sampled_from(["One", "Multi", "No"]),
    sign=st.sampled_from(".,"),
    comments=st.booleans(),
    segments=st.integers(1, 3),
    again=st.just(False),
)


@settings(max_examples=60, deadline=None)
@given(writer=writers, encoding=st.sampled_from(["utf-8", "utf-8-sig", "latin-1", "utf-16"]))
def test_every_way_of_writing_gives_the_same_numbers(writer: Writer, encoding: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.txt"  # known by its content
        file.write_bytes(writer.text().encode(encoding))
        source = open_table(file)
        assert source.contents.units["Force"] == "newtons"
        assert source.contents.units["X_Value"] == "s"
        columns = source.read(["X_Value", "Force", "Place"], {})
    np.testing.assert_allclose(columns.values["X_Value"], STEP * np.arange(30), atol=1e-9)
    np.testing.assert_array_equal(columns.values["Force"], FORCE)
    np.testing.assert_array_equal(columns.values["Place"], PLACE)
    assert columns.doubts == ()


@settings(max_examples=30, deadline=None)
@given(writer=st.builds(Writer, columns=st.sampled_from(["One", "Multi", "No"]), sign=st.sampled_from(".,")))
def test_a_reader_written_elsewhere_reads_the_same(writer: Writer) -> None:
    lvm_read = pytest.importorskip("lvm_read")
    theirs = lvm_read.read_str(writer.text().replace("\r\n", "\n"))[0]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "run.lvm").write_text(writer.text(), newline="")
        ours = read_columns(Path(folder) / "run.lvm", ["Force", "Place"]).values
    for name, values in ours.items():
        np.testing.assert_array_equal(theirs["data"][:, theirs["Channel names"].index(name)], values)


def write(folder: Path, text: str) -> Path:
    (folder / "run.lvm").write_text(text, newline="")
    return folder / "run.lvm"


def test_commas_between_cells(tmp_path: Path) -> None:
    columns = read_columns(write(tmp_path, Writer(separator=",").text()), ["X_Value", "Force"])
    np.testing.assert_array_equal(columns.values["Force"], FORCE)


def test_segments_that_begin_anew_are_told_apart(tmp_path: Path) -> None:
    file = write(tmp_path, Writer(segments=3, again=True).text())
    with pytest.raises(
        ss.InputError, match=r"begins anew at 0 in segment 2; name the columns of one, like '2/X_Value'"
    ):
        read_columns(file, ["X_Value", "Force"])
    columns = read_columns(file, ["2/X_Value", "2/Force"])
    np.testing.assert_array_equal(columns.values["2/Force"], FORCE[10:20])
    with pytest.raises(ss.InputError, match="columns of segments 1, 2; name those of one"):
        read_columns(file, ["1/X_Value", "2/Force"])


def test_the_line_of_a_row_is_that_of_an_editor(tmp_path: Path) -> None:
    text = Writer(segments=2).text()
    columns = read_columns(write(tmp_path, text), ["Force"])
    lines = text.split("\r\n")
    assert [lines[columns.place(row=row).line - 1].split("\t")[1] for row in (0, 14, 15, 29)] == [  # type: ignore[operator]
        f"{FORCE[row]:.6f}" for row in (0, 14, 15, 29)
    ]


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("1.500000\t", "oops\t", "'oops' is text"),
        ("0.000000\t1.500000\t", "0.000000\t", "2 cells where the header names 4 columns"),
        (f"{END}\t\t\r\nX_Value", "X_Value", "a row of numbers outside a segment|ends within a header"),
        ("X_Columns\tOne", "X_Columns\tNo", ""),
    ],
)
def test_faults_have_their_line(tmp_path: Path, before: str, after: str, words: str) -> None:
    text = Writer().text()
    assert before in text
    file = write(tmp_path, text.replace(before, after, 1))
    if words:
        with pytest.raises(ss.InputError, match=words):
            read_columns(file, ["X_Value", "Force"])
    else:
        np.testing.assert_array_equal(read_columns(file, ["X_Value", "Force"]).values["Force"], FORCE)


def test_a_file_cut_off_says_so(tmp_path: Path) -> None:
    lines = Writer().text().split("\r\n")
    columns = read_columns(write(tmp_path, "\r\n".join(lines[:-10])), ["X_Value", "Force"])
    assert columns.doubts == ("21 samples where the header tells of 30; was the file cut off?",)


def test_a_unit_of_labview_speaks_against_the_declared_one(tmp_path: Path) -> None:
    file = write(tmp_path, Writer(units=("mN", "m")).text())
    channels = {"t": ss.Channel("X_Value", "s"), "spring_force": ss.Channel("Force", "N")}
    with pytest.raises(ss.InputError, match="the file has 'Force in mN', but its channel is declared in 'N'"):
        ss.load_recording(
            file, ss.BlockOnBelt(mass=0.5, stiffness=500.0), channels=channels, belt_speed="5 mm/s"
        )


@settings(max_examples=200, deadline=None)
@given(writer=writers, data=st.data())
def test_a_damaged_file_gives_numbers_or_one_line(writer: Writer, data: st.DataObject) -> None:
    content = bytearray(writer.text().encode())
    how = data.draw(st.sampled_from(["flip", "cut", "zeros", "magic", "nothing"]))
    at = data.draw(st.integers(0, len(content) - 1))
    if how == "flip":
        content[at] ^= 1 << data.draw(st.integers(0, 7))
    elif how == "zeros":
        content[at : at + 16] = bytes(len(content[at : at + 16]))
    elif how == "magic":
        content[:7] = b"OTHERWI"
    else:
        del content[0 if how == "nothing" else at :]
    refusal = ""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.lvm"
        file.write_bytes(content)
        try:
            columns = read_columns(file, ["X_Value", "Force", "Place"])
        except ss.InputError as error:
            refusal = str(error)
    assert refusal.isprintable()
    assert refusal or all(np.isfinite(one).all() for one in columns.values.values())
    if not refusal and how == "flip":  # no row is lost or found without a word
        assert columns.values["Force"].size == 30 or columns.doubts
