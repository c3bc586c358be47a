"""Windows of rigs of bodies and matrices with effects: derivatives, starts of hidden states, readings."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES, recording
from differences import held_against_differences
from stickslip.declared.uncertainty import Uncertainty
from stickslip.likelihoods.bodies_bench import BodiesBench, bench_of
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.fit import begun, fitted, null
from stickslip.likelihoods.fit_state import unexplained
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared, SharedNumber

Floats = NDArray[np.float64]
PLACED = [
    ("pin", "sensor_lag", "along", {"tau": 0.004}),
    ("pin", "sensor_nonlinearity", "across", {"q": 30.0}),
    ("pin", "belt_seam", "contact_1", {"a": 0.05, "L": 0.02, "phi": 0.4}),
    ("pin", "belt_speed_ripple", "belt", {"a": 0.05, "w": 30.0, "phi": 0.4}),
    ("pin", "stribeck_peak", "contact_1", {"dT": 0.4, "v_s": 0.05}),
    ("pin", "harmonic_forcing", "across", {"a": 0.1, "w": 50.0, "phi": 1.0}),
    ("pin", "pivot_dry_friction", "across", {"f": 0.06}),
    ("drill", "pivot_dry_friction", "link_1", {"f": 0.1}),
    ("drill", "spring_cubic_k1", "link_1", {"k": 2.0}),
    ("drill", "block_quadratic_damping", "table", {"c": 0.05}),
    ("drill", "belt_speed_ripple", "drive", {"a": 0.02, "w": 3.0, "phi": 0.4}),
    ("drill", "sensor_lag", "bit", {"tau": 0.03}),
    ("drill", "sensor_lag", "table", {"tau": 0.03}),  # which does not go steadily where the bit sticks
    ("chain", "friction_drift", "b", {"r": 0.01}),
    ("chain", "static_aging", "a", {"dT": 0.3, "tau": 0.5}),
]


def simulated(
    name: str, effect: str, where: str, numbers: dict[str, float]
) -> tuple[ss.Model, ss.Effect, BodiesBench]:
    """A model with an effect, and a record of it without noise, as its sensors read it."""
    case = CASES[name]()
    one = ss.effect(effect, where=where, **numbers)
    model = ss.Model(case.model.rig, friction=case.model.friction, effects=(one,))
    t = np.arange(0.0, case.settling + case.lasts / 4, case.dt)
    run = ss.simulate(model, **case.speeds, initial=case.initial, t_end=t[-1], t_eval=t)  # type: ignore[arg-type]
    names = run.state_names
    read = [run.readings.get(one, run.state[:, names.index(one)]) for one in case.channels]
    noise = case.noise * np.random.default_rng(1).standard_normal((len(t), len(read)))
    known = Uncertainty.usual(case.model.rig, channels=case.channels)
    return model, one, bench_of(case.model, [recording(case, t, np.transpose(read) + noise)], known)


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("name", "effect", "where", "numbers"), PLACED)
def test_windows_of_the_true_model_leave_the_noise(
    name: str, effect: str, where: str, numbers: dict[str, float]
) -> None:
    model, _, bench = simulated(name, effect, where, numbers)
    exact = null(BodiesWindows(model, bench.data, bench.stretches, [], Declared()), POLICY)
    assert unexplained(exact) == pytest.approx(1.0, abs=0.2)
    lacking = null(BodiesWindows(bench.model, bench.data, bench.stretches, [], Declared()), POLICY)
    assert lacking.deviance > exact.deviance + 20


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("name", "effect", "where", "numbers"), PLACED)
def test_derivatives_with_an_effect_are_those_of_differences(
    name: str, effect: str, where: str, numbers: dict[str, float]
) -> None:
    model, one, bench = simulated(name, effect, where, numbers)
    own = [SharedNumber(f"{one.label}.{key}", size, size, 1.0) for key, size in numbers.items()]
    windows = replace(bench, policy=replace(POLICY, tolerance=1e-11)).windows(model, own)
    names = {one.name for one in windows.numbers}
    assert "drive_speed" in names or name != "drill"
    assert ("belt_off" in names) == (name != "drill")
    at = np.array([one.start + 0.002 * (one.name == "belt_off") for one in windows.numbers])
    held_against_differences(windows, at, name)


@pytest.mark.parametrize("name", ["pin", "chain"])
def test_a_belt_faster_than_set_is_no_gain_of_a_sensor(name: str) -> None:
    """The gain was known to 0.04 %, as it is read in every stick, and 0.3 % off, as much as the set-point was."""
    case = CASES[name]()
    t = np.arange(0.0, case.settling + case.lasts / 2, case.dt)
    faster = {key: 1.004 * size for key, size in case.speeds.items()}
    run = ss.simulate(case.model, **faster, initial=case.initial, t_end=t[-1], t_eval=t)  # type: ignore[arg-type]
    read = np.column_stack([run.state[:, run.state_names.index(one)] for one in case.channels])
    noise = case.noise * np.random.default_rng(1).standard_normal(read.shape)
    known = Uncertainty.usual(case.model.rig, channels=case.channels)
    bench = bench_of(case.model, [recording(case, t, read + noise)], known)
    fit = fitted(begun(bench.windows()), POLICY)
    assert unexplained(fit) == pytest.approx(1.0, abs=0.2)
    assert fit.solution is not None
    told = 0
    for i, one in enumerate(fit.windows.numbers):
        if one.name.startswith("gain."):
            assert abs(fit.at[i]) < 2.5 * fit.solution.covariance[i, i] ** 0.5, one.name
            told += 1
    off = [x for one, x in zip(fit.windows.numbers, fit.at, strict=True) if one.name == "belt_off"]
    assert told == len(case.channels)
    assert 0.0005 < off[0] < 0.0045
