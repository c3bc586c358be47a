"""`stickslip inspect`: what is in a file, whatever is in it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner, Result

import stickslip as ss
from stickslip.cli.commands import main
from stickslip.files import RECORD
from stickslip.measured.inspection import inspect

T = np.round(0.002 * np.arange(400), 6)
F = np.round(1.5 + 0.4 * np.sin(3 * T), 6)


def write(folder: Path, rows: list[str], head: str = "Time [s],Force [mN],note") -> Path:
    (folder / "run.csv").write_text("\n".join([head, *rows]) + "\n")
    return folder / "run.csv"


def rows(t: np.ndarray = T) -> list[str]:
    return [f"{a:.6f},{b:.6f},ok" for a, b in zip(t, F, strict=True)]


def run(*words: object) -> Result:
    return CliRunner().invoke(main, ["inspect", *map(str, words)])


def test_columns_units_and_rates_are_said(tmp_path: Path) -> None:
    result = run(write(tmp_path, rows()))
    assert result.exit_code == 0, result.output
    assert "Time (the times)" in result.output
    assert "Force" in result.output
    assert "mN" in result.output
    assert "lasts 0.798 s in steps of 0.002 s: 500 samples a second" in result.output
    assert re.search(r"note +\? +words", result.output)
    assert "doubtful" not in result.output


def test_a_gap_is_doubtful(tmp_path: Path) -> None:
    result = run(write(tmp_path, rows(np.where(np.arange(400) < 200, T, T + 0.1))))
    assert "t: 1 gap(s), 50 sample(s) missing, the first from 0.398 to 0.5 s" in result.output


def test_clock_times_are_the_times(tmp_path: Path) -> None:
    lines = [f"10:11:{12 + t:09.6f},{f:.6f},ok" for t, f in zip(T, F, strict=True)]
    found = inspect(write(tmp_path, lines, "when,Force [mN],note"))
    assert found.time is not None
    assert found.time.name == "when"
    assert found.rate == pytest.approx(500)


def test_the_figure_is_drawn_beside_nothing_it_reads(tmp_path: Path) -> None:
    file = write(tmp_path, rows())
    result = run(file, "--figure", tmp_path / "columns.svg")
    assert result.exit_code == 0, result.output
    assert {one.name for one in tmp_path.iterdir()} == {"run.csv", "columns.svg", "columns.png", RECORD}
    (tmp_path / "data.svg").write_bytes(file.read_bytes())
    refused = run(tmp_path / "data.svg", "--figure", tmp_path / "data")
    assert refused.exit_code == 2
    assert "would overwrite FILE" in refused.output


@pytest.mark.parametrize("content", [b"", b"\0" * 100, b"word\n" * 50, b"1,2\n3,4\n"])
def test_a_file_without_a_table_gets_one_line_or_a_doubt(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "run.csv").write_bytes(content)
    result = run(tmp_path / "run.csv")
    assert result.exit_code in (0, 2)
    assert "Traceback" not in result.output
    assert not isinstance(result.exception, ValueError)
    if result.exit_code == 0:
        assert "What is doubtful" in result.output


def test_a_file_of_simulate_says_all_of_its_units(tmp_path: Path) -> None:
    model = ss.Model(
        ss.BlockOnBelt(mass=1.0, stiffness=1.0), friction=ss.CoulombFriction(static=0.4, kinetic=0.25)
    )
    trajectory = ss.simulate(model, belt_speed=0.1, initial=(0.0, 0.1), t_end=60.0)
    trajectory.to_dataframe().to_csv(tmp_path / "run.csv", index=False)
    found = inspect(tmp_path / "run.csv")
    assert found.time is not None
    assert found.time.name == "t"


def test_a_file_that_says_nothing_of_itself_ends_its_line(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "run.mat", {"t": np.arange(20) * 0.5, "F": np.sin(np.arange(20.0))})
    printed = run(tmp_path / "run.mat").output
    assert printed.splitlines()[0].endswith("a MATLAB file")
    assert "2 samples in 1, of a unit that the file does not say" in printed
