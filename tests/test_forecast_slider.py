"""Forecasts of a block on a belt by the model that made the record are as good as that model's own run."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from every_effect import usual
from stickslip.declared.catalogue import CATALOGUE, CONSTANTS, KINDS
from stickslip.declared.laws import LAWS as DECLARED
from stickslip.fitted.block_events.predict import BlockForecaster
from stickslip.fitted.block_events.table import measure, prepare

RIG = ss.BlockOnBelt(mass=1.0, stiffness=1.0, damping=0.02)
COULOMB = ss.CoulombFriction(static=1.0, kinetic=0.6)
LAWS = {  # of one that is not here, what it is drawn with
    **{kind: law(**law.drawn) for kind, law in DECLARED.items()},
    "coulomb": COULOMB,
    "uneven": ss.CoulombFriction(static=1.0, kinetic=0.6, static_plus=1.3, kinetic_plus=0.7),
    "hyperbolic": ss.HyperbolicFriction(scale=0.6, decay=5.0, constant=0.4),
    "paper": ss.PaperFriction(),
}
NOISE, DT, SEEN, AHEAD = 1e-4, 0.05, 1600, 200
ACCEPTED = [name for name, kind in {**CATALOGUE, **CONSTANTS}.items() if not kind.two_degree]
NUMBERS: dict[str, Mapping[str, float]] = {
    **{name: usual(name) for name in ACCEPTED},
    "block_viscous_damping": {"c": 0.2},
    "block_quadratic_damping": {"c": 0.3},
    "spring_cubic_k1": {"k": 0.2},
    "constant_load": {"f": 0.2},
    "harmonic_forcing": {"a": 0.1, "w": 1.7, "phi": 0.3},
    "stribeck_peak": {"dT": 0.3, "v_s": 0.1},
    "static_aging": {"dT": 0.4, "tau": 2.0},
    "friction_memory": {"tau": 0.3},
    "friction_drift": {"r": 0.003},
    "belt_seam": {"a": 0.1, "L": 2.0, "phi": 0.4},
    "contact_compliance": {"k": 100.0, "c": 0.5},
    "belt_speed_ripple": {"a": 0.1, "w": 4.0, "phi": 0.2},
    "belt_load_droop": {"k": 0.01, "tau": 2.0},
    "sensor_lag": {"tau": 0.2},
    "sensor_nonlinearity": {"q": 0.05},
    "sensor_drift": {"r": 0.001},
    "rig_mass": {"e": 0.1},
    "rig_stiffness": {"e": 0.1},
    "sensor_gain": {"e": 0.1},
}
CURVES = {
    "block x1": ss.tabulated("block", "x1", [-1, 0, 1.5], [0.2, -0.2, 0.2]),
    "block x2": ss.tabulated("block", "x2", [-1, 0, 1], [0.2, -0.1, 0.2]),
    "block t": ss.tabulated("block", "t", [0, 40, 100], [0.0, 0.2, -0.1]),
    "contact v_w": ss.tabulated("contact", "v_w", [-1, 0, 1], [0.2, 0.0, 0.2]),
    "contact t that repeats": ss.tabulated(
        "contact", "t", [0, 1, 2, 3], [0, 0.2, -0.1, 0], period=3, phi=-2.5
    ),
    "x1 channel": ss.tabulated("x1 channel", "x1", [-1, 0, 1.5], [0.02, -0.02, 0.02]),
    "x1 channel t": ss.tabulated("x1 channel", "t", [0, 40, 100], [0.02, -0.02, 0.02]),
}


def model_of(name: str, law: ss.FrictionLaw = COULOMB) -> ss.Model:
    effects = [CURVES[name]] if name in CURVES else [ss.effect(name, **NUMBERS[name])] if name else []
    return ss.Model(RIG, friction=law, effects=effects)


def readings(name: str, out: ss.Trajectory) -> np.ndarray:
    """What the channel x1 shows of a run, by the formulas of the catalogue."""
    x, p = out.state[:, 0], NUMBERS.get(name, {})
    match name:
        case "sensor_lag":
            return out.hidden["m"]
        case "sensor_nonlinearity":
            return x + p["q"] * x**2
        case "sensor_drift":
            return x + p["r"] * out.t
        case "sensor_gain":
            return (1 + p["e"]) * x
        case "x1 channel":
            return x + CURVES[name].curve(x)
        case "x1 channel t":
            return x + CURVES[name].curve(out.t)
    if name in KINDS and KINDS[name].physics == "reading":
        return stated(name, x, out)
    return x


def stated(name: str, x: np.ndarray, out: ss.Trajectory) -> np.ndarray:
    """What a sensor reads by the formula that its effect states for rigs of any kind."""
    text = KINDS[name].anywhere.reading
    assert text is not None, f"say above what a sensor with {name} reads"
    functions = {"sin": np.sin, "exp": np.exp, "abs": abs, "pi": np.pi}
    return np.asarray(eval(text, {**functions, **NUMBERS[name], **out.hidden, "reading": x, "t": out.t}))


def off(
    model: ss.Model,
    name: str,
    speed: float,
    *,
    told: ss.Model | None = None,
    seen: int = SEEN,
    noise: float = NOISE,
) -> tuple[float, float]:
    """Root mean square of forecast minus truth over the noise, and of the truth about its mean."""
    t = DT * np.arange(seen + AHEAD + 1)
    start = (0.1 * np.sign(speed), 0.1 * np.sign(speed))
    out = ss.simulate(model, belt_speed=speed, initial=start, t_end=t[-1], t_eval=t)
    read = readings(name, out)
    noisy = read[:seen] + noise * np.random.default_rng(0).standard_normal(seen)
    past = ss.load_recording(pd.DataFrame({"t": t[:seen], "x1": noisy}), RIG, belt_speed=speed, name="past")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*the band is noise alone")
        ahead = ss.forecast(told or model, past, belt_speed=speed, horizon=AHEAD * DT)
    truth = read[seen : seen + AHEAD]
    return float(np.sqrt(np.mean((ahead.x1.to_numpy() - truth) ** 2))) / NOISE, float(truth.std()) / NOISE


@pytest.mark.sampled(9)
@pytest.mark.parametrize("speed", [0.2, -0.2])
@pytest.mark.parametrize("name", ["", *NUMBERS, *CURVES])
def test_a_forecast_is_as_good_as_the_model_s_own_run(name: str, speed: float) -> None:
    """Effects were dropped, levels of friction replaced: forecasts by the true model missed by the motion's size."""
    # bristles know no static friction, and constant friction has no memory
    law = LAWS["hyperbolic" if name in ("contact_compliance", "friction_memory") else "coulomb"]
    error, size = off(model_of(name, law), name, speed)
    assert error < 5
    assert size > 1000


@pytest.mark.sampled(2)
@pytest.mark.parametrize("speed", [0.2, -0.2])
@pytest.mark.parametrize("law", LAWS)
def test_every_law_is_forecast_as_it_is(law: str, speed: float) -> None:
    error, size = off(model_of("", LAWS[law]), "", speed)
    assert error < 5
    assert size > 100


@pytest.mark.study
@settings(max_examples=12, deadline=None)
@given(
    seen=st.integers(300, 2000), name=st.sampled_from(["", "static_aging", "harmonic_forcing", "sensor_lag"])
)
def test_a_forecast_may_begin_anywhere_in_the_cycle(seen: int, name: str) -> None:
    """After two sticks, that is: the rest before the first slip of a record is known to a sample only."""
    error, _ = off(model_of(name), name, 0.2, seen=seen)
    assert error < 5


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["harmonic_forcing", "belt_seam", "belt_speed_ripple"])
def test_the_phase_of_another_run_is_not_that_of_this_one(name: str) -> None:
    model = model_of(name)
    error, size = off(model, name, 0.2, told=model.replace({f"{name}.phi": 2.9}))
    assert error < 5
    assert size > 1000


def test_effects_together() -> None:
    effects = [ss.effect(name, **NUMBERS[name]) for name in ("belt_seam", "harmonic_forcing", "static_aging")]
    error, size = off(ss.Model(RIG, friction=COULOMB, effects=effects), "", 0.2)
    assert error < 5
    assert size > 1000


def test_a_record_without_noise_is_forecast() -> None:
    """The events of a simulated record ended in "Singular matrix"."""
    error, _ = off(model_of(""), "", 0.2, noise=0.0)
    assert error < 1e-3


def test_a_belt_that_the_model_slows_is_no_wrong_set_point() -> None:
    model = ss.Model(RIG, friction=COULOMB, effects=[ss.effect("belt_load_droop", k=0.1, tau=1.0)])
    error, _ = off(model, "", 0.2)
    assert error < 5


def test_what_comes_after_does_not_change_a_forecast() -> None:
    """A forecaster that has seen later samples must not use them for an earlier one."""
    t = DT * np.arange(SEEN)
    rng = np.random.default_rng(0)
    x = ss.simulate(model_of(""), belt_speed=0.2, initial=(0.1, 0.1), t_end=t[-1], t_eval=t).state[:, 0]
    frame = pd.DataFrame({"t": t, "x1": x + NOISE * rng.standard_normal(SEEN)})
    one = measure(prepare(ss.load_recording(frame, RIG, belt_speed=0.2, name="past")))
    model = ss.Model(
        RIG, friction=ss.CoulombFriction(static=1.2, kinetic=0.72)
    )  # its level comes from the past
    fresh, used = BlockForecaster(model, one), BlockForecaster(model, one)
    used.forecast(1500, t[1500:])
    np.testing.assert_array_equal(
        used.forecast(900, t[900:1000]).reading, fresh.forecast(900, t[900:1000]).reading
    )
