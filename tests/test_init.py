"""`stickslip init`: a rig.toml that loads, with what is doubtful in its comments; or what must be given."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.cli.commands import main

RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
LAW = ss.CoulombFriction(static=2.0, kinetic=1.2)
SPEED = 0.005
T = np.arange(0.0, 12.0, 0.002)
X = ss.simulate(
    ss.Model(RIG, friction=LAW), belt_speed=SPEED, initial=(0.0, SPEED), t_end=T[-1], t_eval=T
).state[:, 0]
X = X + 1e-6 * np.random.default_rng(0).standard_normal(X.size)
CONSTANTS = ("--constant", "m=0.5", "--constant", "k=500")
SI = {
    "m": 42.3,
    "J": 0.277,
    "r": 0.1256,
    "k1": 6243.0,
    "k2": 362.1,
    "k3": 1234.0,
    "c1": 2.48,
    "c2": 2.94,
    "length": 0.0089,
}


def write(file: Path, **columns: np.ndarray) -> Path:
    rows = np.column_stack(list(columns.values()))
    file.write_text(
        ",".join(columns) + "\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in rows) + "\n"
    )
    return file


def init(*words: object, answers: str | None = None) -> Result:
    return CliRunner().invoke(main, ["init", *map(str, words)], input=answers)


@settings(max_examples=12, deadline=None)
@given(
    t=st.sampled_from([("Time [s]", 1.0), ("t (ms)", 1e3), ("zeit", 1.0)]),
    x=st.sampled_from([("Force [N]", 500.0), ("F [mN]", 5e5), ("block / mm", 1e3), ("x1 [um]", 1e6)]),
    belt=st.sampled_from([None, ("belt [mm/s]", 1e3), ("v_b [m/s]", 1.0)]),
)
def test_units_and_belt_speeds_are_found(
    tmp_path_factory: pytest.TempPathFactory,
    t: tuple[str, float],
    x: tuple[str, float],
    belt: tuple[str, float] | None,
) -> None:
    folder = tmp_path_factory.mktemp("case")
    columns = {t[0]: T * t[1], x[0]: X * x[1]}
    if belt is not None:
        columns[belt[0]] = np.full(T.size, SPEED * belt[1])
    result = init(write(folder / "run.csv", **columns), *CONSTANTS)
    assert result.exit_code == 0, result.output
    case = ss.load_case(folder)
    assert [run.role for run in case.runs] == ["train", "validate"]
    np.testing.assert_allclose(case.train[0].belt_speed, SPEED, rtol=0.01)
    np.testing.assert_allclose(case.train[0].x1, X[: len(case.train[0])], atol=1e-8)
    assert math.isclose(case.friction.static, 2.0, rel_tol=0.03)  # type: ignore[attr-defined]
    assert math.isclose(case.friction.kinetic, 1.2, rel_tol=0.05)  # type: ignore[attr-defined]
    text = (folder / "rig.toml").read_text()
    assert ("doubtful: the file says no unit" in text) == (t[0] == "zeit")
    assert "read from the sticks of the record" in text or belt is not None


def test_the_case_runs(tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        write(tmp_path / name, **{"t [s]": T[::4], "F [N]": 500 * X[::4]})
    assert init(tmp_path / "a.csv", tmp_path / "b.csv", *CONSTANTS, "--belt-speed", "5 mm/s").exit_code == 0
    case = ss.load_case(tmp_path)
    assert [(run.name, run.role) for run in case.runs] == [("a", "train"), ("b", "validate")]
    found = ss.identify(case)
    assert math.isclose(found.law.static, 2.0, rel_tol=0.01)  # type: ignore[attr-defined]


def test_so_few_samples_a_slip_that_two_numbers_are_one_are_fitted(tmp_path: Path) -> None:
    """It ended in `Singular matrix`."""
    for name in ("a.csv", "b.csv"):
        write(tmp_path / name, **{"t [s]": T[::8], "F [N]": 500 * X[::8]})
    assert init(tmp_path / "a.csv", tmp_path / "b.csv", *CONSTANTS, "--belt-speed", "5 mm/s").exit_code == 0
    assert math.isclose(ss.identify(ss.load_case(tmp_path)).law.static, 2.0, rel_tol=0.02)  # type: ignore[attr-defined]


def test_the_rig_with_two_degrees(tmp_path: Path) -> None:
    t = np.arange(0.0, 30.0, 0.01)
    columns = {
        "time [s]": t,
        "block [mm]": 5 * np.sin(3 * t),
        "angle [deg]": np.cos(2 * t),
        "belt [mm/s]": 6 + 0 * t,
    }
    constants = [word for name, value in SI.items() for word in ("--constant", f"{name}={value}")]
    result = init(write(tmp_path / "run.csv", **columns), *constants)
    assert result.exit_code == 0, result.output
    case = ss.load_case(tmp_path)
    assert isinstance(case.rig, ss.Rig)
    assert case.channels["y1"] == ss.Channel("angle [deg]", "deg")
    np.testing.assert_allclose(case.rig.to_si()["k1"], SI["k1"])


def test_a_nondimensional_rig(tmp_path: Path) -> None:
    write(tmp_path / "run.csv", t=T, x1=X, y1=-X, belt=0.1 + 0 * T)
    numbers = [
        w for n in ("alpha1=16", "alpha2=8", "beta3=4", "eta1=0.1", "eta12=0.2") for w in ("--constant", n)
    ]
    result = init(tmp_path / "run.csv", *numbers)
    assert result.exit_code == 0, result.output
    case = ss.load_case(tmp_path)
    assert {one.unit for one in case.channels.values()} == {"1"}
    assert case.runs[0].belt_speed == 0.1


def test_a_driven_slider(tmp_path: Path) -> None:
    write(tmp_path / "run.csv", **{"t [s]": T, "position [mm]": 1e3 * X, "command [V]": np.sin(T)})
    words = ("--rig", "driven_slider", "--constant", "m=95.1", "--channel", "drive=command:V:35.15")
    result = init(tmp_path / "run.csv", *words)
    assert result.exit_code == 0, result.output
    assert ss.load_case(tmp_path).channels["drive"].scale == 35.15


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "the constant m of the rig (block_on_belt, in kg); give --constant 'm=...'"),
        (("--constant", "m=0.5"), "the constant k of the rig"),
        (("--constant", "m=0.5 m", "--constant", "k=1"), "measures"),
        (("--constant", "q=1"), "unknown constant of this rig"),
        ((*CONSTANTS, "--channel", "x1=nix"), "no such column"),
        ((*CONSTANTS, "--channel", "y1=load"), "no channel of this rig"),
        ((*CONSTANTS, "--channel", "spring_force=load"), "the unit of column 'load', taken for spring_force"),
        ((*CONSTANTS, "--channel", "spring_force=load:N", "--validate", "c.csv"), "no such file here"),
        ((*CONSTANTS, "--channel", "spring_force=load:N", "--belt-speed", "c.csv=1"), "no such file here"),
        ((*CONSTANTS, "--channel", "spring_force=load:N", "--belt-speed", "5 mm"), "measures"),
        ((*CONSTANTS, "--channel", "spring_force=load:N", "--out", "elsewhere"), "lies outside 'elsewhere'"),
    ],
)
def test_what_lacks_or_is_wrong_is_said_in_one_line(
    tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    write(tmp_path / "run.csv", **{"t [s]": T, "load": 500 * X})
    result = init(tmp_path / "run.csv", *words)
    assert result.exit_code == 2, result.output
    assert said in result.output
    assert len(result.output.splitlines()) == 1
    assert {one.name for one in tmp_path.iterdir()} == {"run.csv"}


def test_on_a_terminal_what_lacks_is_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stickslip.cli.running.init.on_terminal", lambda: True)
    write(tmp_path / "run.csv", **{"t [s]": T, "load": np.round(500 * X, 6)})
    result = init(tmp_path / "run.csv", answers="500 g\n500\nN\n")
    assert result.exit_code == 0, result.output
    assert ss.load_case(tmp_path).rig == RIG


def test_a_changed_case_is_not_written_over(tmp_path: Path) -> None:
    file = write(tmp_path / "run.csv", **{"t [s]": T, "F [N]": 500 * X})
    (tmp_path / "rig.toml").write_text("mine\n")
    result = init(file, *CONSTANTS)
    assert result.exit_code == 2
    assert "--force to replace it" in result.output
    assert (tmp_path / "rig.toml").read_text() == "mine\n"
    assert init(file, *CONSTANTS, "--force").exit_code == 0
    ss.load_case(tmp_path)


def test_odd_names_are_written_so_that_they_are_read(tmp_path: Path) -> None:
    folder = tmp_path / 'a "rig"'
    folder.mkdir()
    file = write(folder / "löp 'x'.csv", **{"t [s]": T, "F [N]": 500 * X})
    result = init(file, *CONSTANTS, "--title", 'say "dry" \\ wet')
    assert result.exit_code == 0, result.output
    assert ss.load_case(folder).title == 'say "dry" \\ wet'


def test_a_column_that_cannot_be_read_is_named_rather_than_asked_for(tmp_path: Path) -> None:
    rows = [f"{0.002 * i:.3f},{'nan' if i == 40 else 0.1 * (i % 30)}" for i in range(300)]
    (tmp_path / "run.csv").write_text("\n".join(["Time [s],Deflection [mm]", *rows, ""]))
    result = init(tmp_path / "run.csv", "--constant", "m=0.5", "--constant", "k=500")
    assert result.exit_code == 2
    assert "run.csv, column 'Deflection': line 42: nan; every sample needs a finite number" in result.output


@pytest.mark.parametrize("kind", ["bodies", "matrices"])
def test_a_rig_whose_parts_no_record_shows_is_written_by_hand(tmp_path: Path, kind: str) -> None:
    result = init(write(tmp_path / "a.csv", **{"t [s]": T[:100], "x [mm]": X[:100]}), "--rig", kind)
    assert result.exit_code == 2
    assert result.output.count("\n") == 1
    assert "write its rig.toml by hand" in result.output
    assert not (tmp_path / "rig.toml").exists()
