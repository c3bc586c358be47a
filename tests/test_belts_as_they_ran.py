"""Belts and drives that are not quite as set, however their speed is written, and effects on a belt that is read."""

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import drill
from differences import held_against_differences
from stickslip.declared.uncertainty import Uncertainty
from stickslip.likelihoods.bodies_bench import BodiesBench, bench_of
from stickslip.likelihoods.fit import begun, fitted
from stickslip.likelihoods.fit_state import unexplained
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]
BLOCK = ss.BodiesRig(
    body={"block": ss.Body(mass=1.0)},
    link=[ss.Link(between=("block", "ground"), stiffness=40.0, damping=0.3)],
    contact=[ss.Contact(body="block", against="belt")],
)
LAW = ss.CoulombFriction(static=5.0, kinetic=3.0)
TO_AND_FRO, NOISE, BELT_NOISE = "0.15*sin(0.7*t)", 2e-4, 1e-3
RIPPLE = ss.effect("belt_speed_ripple", a=0.25, w=3.1, phi=1.0)


def columns_of(
    speed: float | str,
    *,
    faster: float = 1.0,
    belt: bool = False,
    effects: tuple[ss.Effect, ...] = (),
    lasts: float = 25.0,
) -> dict[str, Floats]:
    """A block whose belt is faster than it is said to be; the belt's own sensor reads what it does."""
    model, t = ss.Model(BLOCK, friction=LAW, effects=effects), np.arange(0.0, lasts, 0.01)
    true = f"{faster}*({speed})" if isinstance(speed, str) else faster * speed
    run = ss.simulate(model, belt_speed=true, initial=(0.0, 0.0), t_end=t[-1], t_eval=t)
    rng = np.random.default_rng(0)
    columns = {"t": t, "block": run.block + NOISE * rng.normal(size=len(t))}
    if belt:
        went = ss.Speed.of(true)(t)
        for one in effects:
            went = went * (1 + one.parameters["a"] * np.sin(one.parameters["w"] * t + one.parameters["phi"]))
        columns["belt"] = went + BELT_NOISE * rng.normal(size=len(t))
    return columns


def recorded(speed: float | str, **other: object) -> ss.Recording:
    """The same as the package takes it."""
    return ss.load_recording(columns_of(speed, **other), BLOCK, belt_speed=speed, friction=LAW)  # type: ignore[arg-type]


def held(ahead: pd.DataFrame, columns: dict[str, Floats], name: str) -> float:
    """The share of the readings to come that a band holds."""
    come = np.interp(ahead["t"], columns["t"], columns[name])
    return float(np.mean((ahead[f"{name}_low"] <= come) & (come <= ahead[f"{name}_high"])))


def bench(run: ss.Recording, effects: tuple[ss.Effect, ...] = ()) -> BodiesBench:
    """A record cut into windows."""
    known = Uncertainty.usual(BLOCK, channels=("block", "belt"))
    return bench_of(ss.Model(BLOCK, friction=LAW, effects=effects), [run], known)


@pytest.mark.parametrize("belt", [False, True])
@pytest.mark.parametrize("effects", [(), (RIPPLE,)], ids=["even", "ripple"])
@pytest.mark.parametrize("speed", [0.1, TO_AND_FRO])
def test_derivatives_are_those_of_differences(
    speed: float | str, effects: tuple[ss.Effect, ...], belt: bool
) -> None:
    made = bench(recorded(speed, belt=belt, effects=effects), effects)
    windows = made.windows()
    at = np.array([one.start for one in windows.numbers])
    at[[one.name == "belt_off" for one in windows.numbers]] = 0.002
    held_against_differences(windows, at, f"{speed}, {belt}")


def test_a_belt_to_and_fro_faster_than_set_is_no_gain_of_a_sensor() -> None:
    """A formula was taken as exact: of two records the gain was 4 and 10 standard errors off."""
    made = bench(recorded(TO_AND_FRO, faster=1.003))
    fit = fitted(begun(made.windows()), POLICY)
    assert unexplained(fit) == pytest.approx(1.0, abs=0.2)
    assert fit.solution is not None
    found = {one.name: (x, sd) for one, x, sd in zip(
        fit.windows.numbers, fit.at, np.sqrt(np.diag(fit.solution.covariance)), strict=True)}  # fmt: skip
    gain, sd = found["gain.block"]
    assert abs(gain) < 2 * sd
    assert found["belt_off"][0] == pytest.approx(0.003, abs=2 * found["belt_off"][1])


def test_a_ripple_of_a_belt_that_is_read_leaves_noise() -> None:
    """Its sensor was taken to read the set-point, and the ripple, found, made chi-squared larger."""
    run = recorded(0.12, belt=True, effects=(RIPPLE,))
    fit = fitted(begun(bench(run, (RIPPLE,)).windows()), POLICY)
    left = np.concatenate([one[:, 1, -1] for one in fit.blocks if one is not None])
    assert fit.windows.data[0].channels == ("block", "belt")
    assert np.mean(left**2) == pytest.approx(1.0, abs=0.15)
    assert unexplained(fit) == pytest.approx(1.0, abs=0.2)


def test_a_forecast_finds_phase_and_speed_of_the_run() -> None:
    columns = columns_of(0.12, faster=1.002, belt=True, effects=(RIPPLE,), lasts=40.0)
    past = {name: one[:3000] for name, one in columns.items()}
    other = ss.effect("belt_speed_ripple", a=0.25, w=3.1, phi=4.0)
    model = ss.Model(BLOCK, friction=LAW, effects=(other,))
    ahead = ss.forecast(model, ss.load_recording(past, BLOCK, belt_speed=0.12, friction=LAW), horizon=4.0)
    assert held(ahead, columns, "block") > 0.9


def test_a_drive_that_is_not_quite_as_set_does_not_drift_from_its_forecast() -> None:
    """Of an angle that grows bands held 63 to 78 % of the readings: the set-point was exact."""
    case = drill()
    t = np.arange(0.0, 24.0, case.dt)
    run = ss.simulate(case.model, drive_speed=1.26 * 0.998, initial=case.initial, t_end=t[-1], t_eval=t)
    rng = np.random.default_rng(3)
    columns = {"t": t}
    for name in case.channels:
        true = run.state[:, run.state_names.index(name)]
        columns[name] = true + case.noise * rng.normal(size=len(t))
    past = {name: one[:2000] for name, one in columns.items()}
    recording = ss.load_recording(past, case.model.rig, **case.speeds, friction=case.model.friction)  # type: ignore[arg-type]
    ahead = ss.forecast(case.model, recording, horizon=3.0)
    for name in case.channels:
        off = ahead[name] - np.interp(ahead["t"], t, columns[name])
        assert held(ahead, columns, name) > 0.9, name
        assert abs(np.mean(off)) < 5 * case.noise, name
