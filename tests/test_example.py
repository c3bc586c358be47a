"""`stickslip example`: files that a reader of the pages begins with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner

import stickslip as ss
from stickslip.cli.commands import main
from stickslip.cli.practice import PRACTICE, WEIGHT
from stickslip.data import example


@pytest.mark.parametrize("name", PRACTICE)
def test_it_writes_the_files_that_it_names(name: str, tmp_path: Path) -> None:
    result = CliRunner().invoke(main, ["example", name, "--out", str(tmp_path / "new")])
    assert result.exit_code == 0, result.output
    written = {str(path.relative_to(tmp_path / "new")) for path in (tmp_path / "new").rglob("[!.]*.*")}
    assert written == {*PRACTICE[name][1]}
    for case in (tmp_path / "new").rglob("rig.toml"):
        assert ss.load_case(case).runs


def test_nothing_of_the_users_is_written_over(tmp_path: Path) -> None:
    (tmp_path / "slider.lvm").write_text("mine")
    result = CliRunner().invoke(main, ["example", "labview", "--out", str(tmp_path)])
    assert result.exit_code == 2
    assert (tmp_path / "slider.lvm").read_text() == "mine"


def test_the_labview_file_is_the_recording(tmp_path: Path) -> None:
    CliRunner().invoke(main, ["example", "labview", "--out", str(tmp_path)])
    record = scipy.io.loadmat(example("paper_slider") / "k168Nm_v1100.mat")
    rig = ss.BlockOnBelt(mass=0.0307, stiffness=168.0)
    channels = {"t": ss.Channel("X_Value", "s"), "spring_force": ss.Channel("Force", "N")}
    run = ss.load_recording(tmp_path / "slider.lvm", rig, channels=channels)
    np.testing.assert_allclose(run.raw["t"], record["t"].ravel(), atol=1e-7)
    np.testing.assert_allclose(run.raw["spring_force"], WEIGHT * record["Fnorm"].ravel(), atol=1e-7)


def test_comments_of_a_labview_file_are_no_empty_column(tmp_path: Path) -> None:
    CliRunner().invoke(main, ["example", "labview", "--out", str(tmp_path)])
    result = CliRunner().invoke(main, ["inspect", str(tmp_path / "slider.lvm")])
    assert "Comment" not in result.output
    assert "empty cell" not in result.output
