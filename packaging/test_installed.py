"""Is an installed wheel alive? Run outside the sources, by every build of a wheel."""

import subprocess
import sys
from pathlib import Path

import numpy as np

import stickslip as ss
from stickslip.cli.practice import write_lvm, write_simulated


def test_a_block_sticks_and_slips_with_the_period_of_the_closed_form() -> None:
    static, kinetic, speed = 1.0, 0.5, 0.2
    law = ss.CoulombFriction(static=static, kinetic=kinetic)
    run = ss.simulate(ss.Model(ss.BlockOnBelt(), friction=law), belt_speed=speed, t_end=100.0)
    releases = run.transitions.t[run.transitions.before == 0]
    fall = static - kinetic
    period = 2 * (np.pi - np.arctan(fall / speed)) + 2 * fall / speed
    np.testing.assert_allclose(np.diff(releases), period, rtol=1e-9)


def test_the_core_says_how_it_was_built() -> None:
    config = ss.build_config()
    assert config["version"] == ss.__version__
    assert config["isa"] in config["isa_compiled"]


def test_the_command_answers() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from stickslip.cli.commands import main; main(['--version'])"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert ss.__version__ in done.stdout


def test_the_files_that_the_pages_begin_with_are_written(tmp_path: Path) -> None:
    write_simulated(tmp_path)
    write_lvm(tmp_path)
    assert ss.load_case(tmp_path / "CASE").runs
    assert (tmp_path / "slider.lvm").exists()
