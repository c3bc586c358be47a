"""`stickslip simulate` of rigs of bodies."""

from pathlib import Path

import numpy as np
from click.testing import CliRunner

import stickslip as ss
from stickslip.cli.commands import main
from test_general_rigs import DRILL


def command(*words: str) -> str:
    result = CliRunner().invoke(main, ["simulate", *words], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_the_command_simulates_a_rig_of_bodies_in_its_units(tmp_path: Path) -> None:
    model, out = tmp_path / "drill.toml", tmp_path / "run.csv"
    model.write_text(DRILL)
    told = command(str(model), "--drive-speed", "30 rpm", "--t-end", "4 s", "--out", str(out), "--figure")
    assert "stick fraction: bit" in told
    head, *rows = out.read_text().splitlines()
    assert head == "t [s],table [rad],bit [rad],v_table [rad/s],v_bit [rad/s],mode_bit"
    last = [float(one) for one in rows[-1].split(",")]
    run = ss.simulate(ss.load_model(model), drive_speed=np.pi, t_end=4, t_eval=[4.0])
    np.testing.assert_allclose(last[1:5], run.state[0], rtol=1e-9)
    assert (tmp_path / "run.svg").stat().st_size > 1000


def test_the_command_takes_formulas_steps_and_measured_speeds(tmp_path: Path) -> None:
    model, out = tmp_path / "model.toml", tmp_path / "run.csv"
    model.write_text(
        "[rig]\nkind='block_on_belt'\nm=1\nk=1\n[friction]\nkind='coulomb'\nstatic=0.6\nkinetic=0.3\n"
    )
    (tmp_path / "steps.toml").write_text(
        "[[speed]]\nfrom = 0\nvalue = 0.1\n[[speed]]\nfrom = 2\nvalue = '0.02*t'\n"
    )
    t = np.linspace(0, 5, 51)
    samples = "\n".join(f"{x!r},{y!r}" for x, y in zip(t.tolist(), (0.1 * np.cos(t)).tolist(), strict=True))
    (tmp_path / "belt.csv").write_text(f"t,belt\n{samples}\n")
    loaded = ss.load_model(model)
    for given, speed in [
        ("0.5*sin(1.7*t)", "0.5*sin(1.7*t)"),
        (str(tmp_path / "steps.toml"), ss.Speed.steps([0, 2], [0.1, "0.02*t"])),
        (str(tmp_path / "belt.csv"), ss.Speed.measured(t, 0.1 * np.cos(t))),
    ]:
        command(
            str(model), "--belt-speed", given, "--t-end", "5 s", "--initial", "0.05, 0.2", "--out", str(out)
        )
        last = [float(one) for one in out.read_text().splitlines()[-1].split(",")]
        run = ss.simulate(loaded, belt_speed=speed, initial=(0.05, 0.2), t_end=5, t_eval=[5.0])  # type: ignore[arg-type]
        np.testing.assert_allclose(last[1:3], run.state[0], rtol=1e-9)


def test_a_measured_speed_of_a_drive_is_in_a_column_of_its_name(tmp_path: Path) -> None:
    model, out = tmp_path / "model.toml", tmp_path / "run.csv"
    model.write_text(
        "[rig]\nkind='bodies'\nbody.a.mass=1\nlink=[{between=['a','drive'],stiffness=4}]\ncontact=[{body='a'}]\n"
        "[friction]\nkind='coulomb'\nstatic=0.6\nkinetic=0.3\n"
    )
    given = tmp_path / "drive.csv"
    given.write_text("t,drive\n0,0.1\n1,0.3\n5,0.3\n")
    command(str(model), "--drive-speed", str(given), "--t-end", "5 s", "--out", str(out))
    speed = ss.Speed.measured([0, 1, 5], [0.1, 0.3, 0.3])
    run = ss.simulate(ss.load_model(model), drive_speed=speed, t_end=5, t_eval=[5.0])
    last = [float(one) for one in out.read_text().splitlines()[-1].split(",")]
    np.testing.assert_allclose(last[1:3], run.state[0], rtol=1e-9)
    given.write_text("t,belt\n0,0.1\n1,0.3\n")
    words = ["simulate", str(model), "--drive-speed", str(given), "--t-end", "5 s", "--out", str(out)]
    assert "column 'drive': missing" in CliRunner().invoke(main, words).output
