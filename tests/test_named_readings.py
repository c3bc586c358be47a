"""What the sensors of named rigs read of a simulated motion, in Python and in the file of `stickslip simulate`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import stickslip as ss
from stickslip.cli.commands import main
from stickslip.fitted.readings import Chain, read
from stickslip.simulated.reference.integrate import readings
from stickslip.simulated.reference.integrate import simulate as plainly
from stickslip.simulated.states import COUNT

BLOCK = ss.BlockOnBelt(mass=1.2, stiffness=2400, damping=2)
COULOMB = ss.CoulombFriction(static=8, kinetic=5)
TWO = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
OF_TWO = {
    "sensor_lag": {"tau": 0.3},
    "sensor_delay": {"delay": 0.37},
    "sensor_nonlinearity": {"q": 0.3},
    "sensor_drift": {"r": 0.01},
    "sensor_crosstalk": {"c": 0.2},
}
START = (0.1, 0.1, 0.0, 0.0)


@pytest.mark.parametrize("name", OF_TWO)
def test_readings_are_those_of_the_plain_simulator(name: str) -> None:
    model = ss.Model(TWO, friction=ss.PaperFriction(), effects=[ss.effect(name, **OF_TWO[name])])
    t = np.linspace(0, 12, 49)
    m = {"sensor_lag": (*START, 0.0, 0.0, 0.0, 0.1)}.get(name, START)  # the plain lag begins at x1
    run = ss.simulate(model, belt_speed=0.1, initial=m, t_end=12, t_eval=t)
    expected = readings(model, plainly(model, belt_speed=0.1, initial=START, t_end=12), t)
    np.testing.assert_allclose(run.readings["x1"], expected[:, 0], atol=1e-6)
    np.testing.assert_allclose(run.readings["y1"], expected[:, 1], atol=1e-6)
    assert [*run.read_otherwise] == ["y1" if name == "sensor_delay" else "x1"]


def test_a_delay_is_as_exact_at_the_integrators_own_steps() -> None:
    model = ss.Model(TWO, friction=ss.PaperFriction(), effects=[ss.effect("sensor_delay", delay=0.37)])
    run = ss.simulate(model, belt_speed=0.1, initial=START, t_end=12)
    late = run.t[run.t > 0.37] - 0.37
    plain = ss.simulate(model, belt_speed=0.1, initial=START, t_end=12, t_eval=late)
    np.testing.assert_allclose(run.readings["y1"][run.t > 0.37], plain.y1, atol=1e-12)
    assert (run.readings["y1"][run.t <= 0.37] == 0).all()


@pytest.mark.parametrize(
    ("effect", "reads"),
    [
        (ss.effect("sensor_lag", tau=0.004), lambda run: run.m),
        (ss.effect("sensor_gain", e=0.1), lambda run: 1.1 * run.x1),
        (ss.effect("sensor_drift", r=0.001), lambda run: run.x1 + 0.001 * run.t),
        (ss.tabulated("x1 channel", "x1", [-1, 0, 1], [0.1, 0, 0.1]), None),
        (ss.effect("formula", called="bent", where="x1", reading="2*reading"), lambda run: 2 * run.x1),
    ],
)
def test_a_block_has_its_reading(effect: ss.Effect, reads: object) -> None:
    run = ss.simulate(ss.Model(BLOCK, friction=COULOMB, effects=[effect]), belt_speed=0.02, t_end=1)
    expected = reads(run) if callable(reads) else run.x1 + effect.curve(run.x1)
    np.testing.assert_allclose(run.readings["x1"], expected, atol=1e-12)
    assert [*run.read_otherwise] == ["x1"]


def test_without_an_effect_on_it_a_reading_is_the_state() -> None:
    model = ss.Model(TWO, friction=ss.PaperFriction(), effects=[ss.effect("constant_load", f=0.1)])
    run = ss.simulate(model, belt_speed=0.1, initial=START, t_end=5)
    assert [*run.readings] == ["x1", "y1"]
    assert run.read_otherwise == {}
    np.testing.assert_array_equal(run.readings["y1"], run.y1)


def written(folder: Path, model: ss.Model, *options: str) -> pd.DataFrame:
    model.save(folder / "model.toml")
    arguments = ["simulate", str(folder / "model.toml"), *options, "--out", str(folder / "run.csv")]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    return pd.read_csv(folder / "run.csv")


def test_the_file_has_what_is_read_beside_the_state(tmp_path: Path) -> None:
    channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}
    lag = ss.effect("sensor_lag", tau=0.004)
    model = ss.Model(BLOCK, friction=COULOMB, effects=[lag], channels=channels)
    frame = written(tmp_path, model, "--belt-speed", "20 mm/s", "--t-end", "1", "--dt", "0.002", "--figure")
    assert [*frame] == ["t [s]", "x1 [mm]", "x2 [mm/s]", "x1_read [mm]", "mode"]
    run = ss.simulate(model, belt_speed=0.02, t_end=1, t_eval=frame["t [s]"])
    np.testing.assert_allclose(frame["x1 [mm]"], 1e3 * run.x1, atol=1e-8)
    np.testing.assert_allclose(frame["x1_read [mm]"], 1e3 * run.m, atol=1e-8)
    read = {**channels, "x1": ss.Channel("x1_read", "mm")}
    back = ss.load_recording(tmp_path / "run.csv", BLOCK, channels=read, belt_speed=0.02)
    np.testing.assert_allclose(back.x1, run.m, atol=1e-11)


def test_the_file_of_a_rig_of_bodies_has_what_its_sensors_read(tmp_path: Path) -> None:
    rig = ss.BodiesRig(
        body={"x_block": ss.Body(mass=1.2)},
        link=[ss.Link(between=("x_block", "ground"), stiffness=2400, damping=2)],
        contact=[ss.Contact(body="x_block", against="belt", law="pad")],
    )
    gain = ss.effect("sensor_gain", where="x_block", e=0.1)
    model = ss.Model(rig, friction={"pad": COULOMB}, effects=[gain])
    frame = written(tmp_path, model, "--belt-speed", "20 mm/s", "--t-end", "1 s")
    np.testing.assert_allclose(frame["x_block_read [m]"], 1.1 * frame["x_block [m]"], atol=1e-12)


def test_help_says_what_the_columns_are() -> None:
    said = " ".join(CliRunner().invoke(main, ["simulate", "--help"]).output.split())
    assert "x1_read and y1_read" in said


def test_fits_read_a_gain_as_simulate_does_and_know_its_slope() -> None:
    """Friction took a gain that fits did not know."""
    p = {"sensor_gain": {"e": 0.1}, "sensor_nonlinearity": {"q": 2.0}, "sensor_drift": {"r": 0.001}}

    def chain(e: float) -> tuple[ss.Trajectory, Chain]:
        effects = [
            ss.effect(name, **(one | {"e": e} if name == "sensor_gain" else one)) for name, one in p.items()
        ]
        model = ss.Model(BLOCK, friction=COULOMB, effects=effects)
        t = np.linspace(0.0, 1.0, 60)
        run = ss.simulate(model, belt_speed=0.02, t_end=1.0, t_eval=t)
        state = np.pad(run.state, ((0, 0), (0, COUNT - run.state.shape[1])))
        slopes = dict.fromkeys(range(COUNT), np.zeros((len(t), 1)))
        return run, read(t, state, slopes, ("sensor_gain.e",), model.parameters, 0.02, 1)

    run, here = chain(0.1)  # (n, channels), (n, channels, names)
    np.testing.assert_allclose(here.values[:, 0], run.readings["x1"], rtol=1e-13)  # noqa: PD011
    there = chain(0.1 + 1e-6)[1].values - chain(0.1 - 1e-6)[1].values  # noqa: PD011
    np.testing.assert_allclose(here.slopes[:, 0, 0], there[:, 0] / 2e-6, atol=1e-9)
