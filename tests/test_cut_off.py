"""Tables in text that were cut off, anywhere: no number that lost its end is used without a word."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss

T = np.arange(40) * 0.01
X = 0.1 * np.sin(9 * T) - 0.02
FIXED = [f"{a:.3f},{b:.6f}" for a, b in zip(T, X, strict=True)]
SHORT = [f"{a:.3g},{b:.5g}" for a, b in zip(T, X, strict=True)]  # as many digits as they need
EXPONENT = [f"{a:.4e},{b:.4e}" for a, b in zip(T, X, strict=True)]


def load(file: Path, content: bytes) -> ss.Recording:
    file.write_bytes(content)
    channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x", "mm")}
    return ss.load_recording(file, ss.BlockOnBelt(), channels=channels, belt_speed=0.1)


def said(run: ss.Recording) -> list[str]:
    return [str(one) for one in run.findings if "file:" in str(one)]


@pytest.mark.parametrize("rows", [FIXED, SHORT, EXPONENT], ids=["fixed", "short", "exponent"])
@pytest.mark.parametrize(("encoding", "end"), [("utf-8", "\n"), ("utf-16", "\r\n")])
def test_a_file_cut_anywhere_is_refused_or_said_or_whole(
    tmp_path: Path, rows: list[str], encoding: str, end: str
) -> None:
    text = end.join(["t,x", *rows]) + end
    whole = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    refused = doubted = 0
    for cut in range(1, 2 * max(map(len, rows))):
        try:
            run = load(tmp_path / "run.csv", text[:-cut].encode(encoding))
        except ss.InputError as error:
            refused += f"line {len(text[:-cut].splitlines())}" in str(error)
            continue
        if said(run):
            doubted += 1
            assert "its last number" in said(run)[0]
            continue
        assert run.raw["t"] == pytest.approx(whole[: len(run), 0], abs=0)
        assert run.raw["x1"] == pytest.approx(whole[: len(run), 1], abs=0)
    assert refused > 5
    assert doubted > 5 if rows is SHORT else doubted == 0


def test_a_number_that_lost_digits_is_refused_with_its_place(tmp_path: Path) -> None:
    text = "\n".join(["t,x", *FIXED])
    with pytest.raises(
        ss.InputError, match=r"run.csv line 41, column 'x': '-0.0560' ends the file, with fewer digits"
    ):
        load(tmp_path / "run.csv", text[:-2].encode())
    with pytest.raises(
        ss.InputError, match="line 41: 1 cell where the header names 2 columns, and the file ends there"
    ):
        load(tmp_path / "run.csv", text[:-12].encode())


@pytest.mark.parametrize("end", ["\n", " ", ",", ""])
def test_a_file_without_a_last_line_end_is_read_where_its_last_number_is_whole(
    tmp_path: Path, end: str
) -> None:
    run = load(tmp_path / "run.csv", ("\n".join(["t,x", *FIXED]) + end).encode())
    assert len(run) == 40
    assert not said(run)


@pytest.mark.parametrize(
    "head", ["t,x", "# recorded in room 3\nt,x", "t,x\ns,mm", "Gain,12.5\nDate,today\nt,x"]
)
def test_lines_above_the_rows_do_not_tell_how_numbers_are_written(tmp_path: Path, head: str) -> None:
    text = "\n".join([head, *FIXED])
    run = load(tmp_path / "run.csv", text.encode())
    assert len(run) == 40
    assert not said(run)
    with pytest.raises(ss.InputError, match=r"'-0.0560' ends the file, with fewer digits"):
        load(tmp_path / "run.csv", text[:-2].encode())


def test_a_column_that_nobody_asks_for_may_be_cut(tmp_path: Path) -> None:
    rows = [f"{row},{k}" for k, row in enumerate(SHORT)]
    assert not said(load(tmp_path / "run.csv", "\n".join(["t,x,count", *rows]).encode()))


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("# samples: 100", True),
        ("Samples;100", True),
        ("Record Length,2500,Points", True),
        ('"Number of points","41"', True),
        ("Anzahl Messwerte = 80", True),
        ("Points 40", False),  # as many as there are
        ("Samples per second: 100", False),
        ("Sample rate: 100", False),
    ],
)
def test_a_number_of_samples_above_the_names_is_held_against_the_rows(
    tmp_path: Path, line: str, told: bool
) -> None:
    run = load(tmp_path / "run.csv", "\n".join([line, "t,x", *FIXED, ""]).encode())
    assert [one for one in said(run) if one.startswith("file: 40 samples where line 1 tells of")] == said(run)
    assert bool(said(run)) == told


def test_a_labview_file_that_ends_in_a_number_says_so(tmp_path: Path) -> None:
    head = (
        "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
        "X_Columns\tOne\n***End_of_Header***\t\n\t\nChannels\t1\nSamples\t40\n***End_of_Header***\t\nX_Value\tx\tComment\n"
    )
    file = tmp_path / "run.lvm"
    channels = {"t": ss.Channel("X_Value", "s"), "x1": ss.Channel("x", "mm")}
    file.write_text(head + "\n".join(SHORT).replace(",", "\t"))
    run = ss.load_recording(file, ss.BlockOnBelt(), channels=channels, belt_speed=0.1)
    assert any("its last number" in one for one in said(run))
    file.write_text(head + "\n".join(SHORT).replace(",", "\t") + "\n")
    assert not said(ss.load_recording(file, ss.BlockOnBelt(), channels=channels, belt_speed=0.1))
