"""Files that cannot be read, or not now: a line each."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.measured.inspection import inspect
from stickslip.measured.readers import text
from stickslip.measured.readers.tables import read_columns

TABLE = "t,F\n" + "".join(f"{0.002 * k:.4f},{1.5 + 0.1 * (k % 7):.3f}\n" for k in range(300))


@pytest.mark.parametrize("how", ["grows", "shrinks", "is deleted", "is replaced", "becomes no text"])
def test_a_file_that_is_written_while_it_is_read_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    """An open quotation mark was blamed, the numbers of two files were mixed, or it ended in a traceback."""
    file = tmp_path / "run.csv"

    def meanwhile(*given: object) -> object:
        match how:
            case "grows":
                file.write_text(TABLE + "0.6,1.5\n")
            case "shrinks":
                file.write_text(TABLE[:2000])
            case "is deleted":
                file.unlink()
            case "is replaced":
                file.write_text("F,t\n" + TABLE[4:])
            case "becomes no text":
                file.write_bytes(TABLE.encode()[:500] + b"\xff\xfe\0zz\n")
        return read(*given)

    read = text.read_rows
    monkeypatch.setattr(text, "read_rows", meanwhile)
    for look in (lambda: read_columns(file, ["t", "F"]), lambda: inspect(file)):
        file.write_text(TABLE)
        os.utime(file, ns=(0, 0))
        with pytest.raises(ss.InputError, match=r"run\.csv: was changed while it was read"):
            look()


@pytest.mark.parametrize("kind", ["tdms", "h5", "mat", "parquet", "wav", "lvm"])
def test_an_empty_file_is_said_to_be_empty(tmp_path: Path, kind: str) -> None:
    """It was "not a TDMS file", or ended within a header in line 0."""
    (tmp_path / f"run.{kind}").write_bytes(b"")
    with pytest.raises(ss.InputError, match="empty: it has 0 bytes"):
        inspect(tmp_path / f"run.{kind}")


def test_a_link_that_leads_nowhere_is_not_proposed_instead_of_itself(tmp_path: Path) -> None:
    (tmp_path / "run.csv").symlink_to("gone.csv")
    with pytest.raises(ss.InputError, match=r"run\.csv: a link that leads to no file"):
        inspect(tmp_path / "run.csv")


def test_a_channel_in_the_models_own_unit_is_not_copied() -> None:
    t = np.arange(0, 2, 0.01)
    channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x", "mm")}
    rig = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
    run = ss.load_recording({"t": t, "x": np.sin(t)}, rig, channels=channels, belt_speed=5.0)
    assert run.t is run.raw["t"]
    assert not np.shares_memory(run.t, t)


@pytest.mark.parametrize(
    ("time", "refused"), [("1e5", False), ("1e12", True), ("1e300", True), ("1.7e308", True)]
)
def test_a_time_next_to_infinite_gets_a_line(tmp_path: Path, time: str, refused: bool) -> None:
    """A bit that flips in a binary file makes one: `OverflowError`. A gap of 1e6 s took gigabytes."""
    file = tmp_path / "run.csv"
    file.write_text(TABLE + f"{time},1.5\n")
    rig = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
    channels = {"t": ss.Channel("t", "s"), "spring_force": ss.Channel("F", "N")}
    assert any("1 gap(s)" in one for one in inspect(file).doubts)
    if refused:
        with pytest.raises(
            ss.InputError, match=r"line 302, column 't': .* after 0.598: .* is the time damaged"
        ):
            ss.load_recording(file, rig, channels=channels, belt_speed="5 mm/s")
        run = ss.load_recording(file, rig, channels=channels, belt_speed="5 mm/s", window=(None, 0.6))
        assert len(run) == 300
    else:
        run = ss.load_recording(file, rig, channels=channels, belt_speed="5 mm/s")
        assert any("1 gap(s)" in str(one) for one in run.findings)
