"""Files larger than memory: every row still counted, neighbours averaged and it is said, nothing shifted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.measured import findings
from stickslip.measured.readers import filled_columns, row_counts
from stickslip.measured.readers.dialect import find_layout
from stickslip.measured.readers.tables import read_columns

N = 1000
T = np.round(0.002 * np.arange(N), 6)
F = np.round(1.5 + 0.4 * np.sin(0.3 * np.arange(N)), 6)
RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)


def load(file: Path, **more: object) -> ss.Recording:
    channels = {"t": ss.Channel("t", "s"), "spring_force": ss.Channel("F", "N")}
    return ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s", **more)  # type: ignore[arg-type]


def write(file: Path, t: np.ndarray = T, force: np.ndarray = F) -> Path:
    np.savetxt(file, np.c_[t, force], "%.6f", ",", header="t,F", comments="")
    return file


CELLS = st.sampled_from(["1.5", "-2", "", '"3"', '"4,5"', "#", "# note", "%", "/", "//", "é", "6 7"])
ROWS = st.lists(st.lists(CELLS, min_size=0, max_size=5), min_size=0, max_size=12)


@given(
    plain=st.integers(0, 12),
    rows=ROWS,
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    last=st.booleans(),
    encoding=st.sampled_from(["utf-8", "utf-16", "latin-1"]),
    block=st.integers(1, 60),
)
def test_rows_are_counted_by_blocks_as_line_by_line(
    tmp_path_factory, plain, rows, delimiter, end, last, encoding, block
):
    cells = [["1", "2", "3"]] * plain + rows + [["4", "5", "6"]] * plain
    text = end.join(delimiter.join(one) for one in (["a", "b", "c"], ["0", "0", "0"], *cells)) + end * last
    file = tmp_path_factory.getbasetemp() / "counted.csv"
    file.write_bytes(text.encode(encoding))
    layout = find_layout(file, ("a", "b", "c"))
    with file.open(encoding=layout.encoding) as stream:
        stream.seek(layout.mark)
        lines = [line for i, line in enumerate(stream, 1) if i >= layout.first]
    count, wrong = row_counts._line_by_line(lines, layout)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(row_counts, "BLOCK", 4 * block)
        assert row_counts.count_rows(layout)[:2] == (count, count if wrong else -1)


def test_a_row_too_short_beside_one_too_long_is_found(tmp_path: Path) -> None:
    lines = ["t,x,F", *(f"{t},0,{f}" for t, f in zip(T, F, strict=True))]
    lines[500], lines[501] = "0.998,1.5", "1,0,2,3"
    file = tmp_path / "run.csv"
    file.write_text("\n".join(lines) + "\n")
    with pytest.raises(ss.InputError, match="line 501: 2 cells where the header names 3 columns"):
        read_columns(file, ["t", "x"])


@pytest.mark.parametrize("chunk", [7, 1 << 18])
def test_rows_that_cannot_be_held_are_averaged_and_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chunk: int
) -> None:
    monkeypatch.setattr(filled_columns, "HELD", 300)
    monkeypatch.setattr("stickslip.measured.readers.rows.CHUNK", chunk)
    run = load(write(tmp_path / "run.csv"), noise={"spring_force": 0.01})
    k = 7  # 2000 numbers, 300 held
    assert run.averaged == k
    np.testing.assert_allclose(run.raw["t"], T[: N // k * k].reshape(-1, k).mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(
        run.raw["spring_force"], F[: N // k * k].reshape(-1, k).mean(axis=1), rtol=1e-12
    )
    assert any(
        "1000 rows are too many to hold; 7 neighbours averaged: 142 samples" in str(f) for f in run.findings
    )
    assert run.noise["x1"] == pytest.approx(0.01 / 500 / np.sqrt(k))


def test_a_time_that_goes_back_is_found_though_the_means_increase(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(filled_columns, "HELD", 300)
    t = T.copy()
    t[[500, 501]] = t[[501, 500]]
    with pytest.raises(ss.InputError, match="line 503, column 't': not after the time before it"):
        load(write(tmp_path / "run.csv", t))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("% a note", "line 702: a comment among the rows"),
        ("// a note", "line 702: a comment among the rows"),
        ('1.4,"5', "line 702: a quotation mark is opened and not closed"),
        ("1.4,1_0", "line 702, column 'F': '1_0' has a character"),
        ("1.4,\uff15", "line 702, column 'F': .* has a character"),
    ],
)
def test_what_only_a_person_reads_has_its_line(tmp_path: Path, line: str, said: str) -> None:
    file = write(tmp_path / "run.csv")
    lines = file.read_text().splitlines()
    lines[701] = line
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(ss.InputError, match=said):
        load(file)


def test_a_cell_that_is_no_number_has_its_line_though_rows_are_averaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(filled_columns, "HELD", 300)
    force = F.copy()
    force[700] = np.nan
    with pytest.raises(ss.InputError, match="line 702, column 'F': nan"):
        load(write(tmp_path / "run.csv", force=force))


def test_stretches_of_a_long_record_show_what_the_whole_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    force = np.minimum(np.round(F, 1), 1.8)
    whole = [one.kind for one in load(write(tmp_path / "run.csv", force=force)).findings]
    monkeypatch.setattr(findings, "LOOKED_AT", 640)
    seen = load(write(tmp_path / "run.csv", force=force)).findings
    assert [one.kind for one in seen] == whole
    assert whole
    assert all("16 stretches of 40 samples" in str(one) for one in seen if one.channel == "spring_force")
