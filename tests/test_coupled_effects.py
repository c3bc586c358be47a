"""Effects that couple a place of a rig to another coordinate: what presses a contact, what a sensor reads, too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from bodies_cases import CASES, recording
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of
from stickslip.discovery.laboratory.screen import screened
from stickslip.errors import InputError
from stickslip.likelihoods.fit import begun, fitted, null
from stickslip.likelihoods.fit_state import unexplained

PIN = CASES["pin"]()
PRESSED = ss.effect("normal_force_feedback", where="contact_1", by="across", beta2=900.0, eta2=2.0)
CROSSED = ss.effect("sensor_crosstalk", where="along", by="across", c=0.05)
T = np.arange(0.0, PIN.settling + PIN.lasts / 4, PIN.dt)


def model(*effects: ss.Effect) -> ss.Model:
    return ss.Model(PIN.model.rig, friction=PIN.model.friction, effects=effects)


def run(one: ss.Model, **more: object) -> ss.Trajectory:
    return ss.simulate(one, **PIN.speeds, initial=PIN.initial, t_end=T[-1], t_eval=T, **more)


@pytest.mark.parametrize("effect", [PRESSED, CROSSED], ids=lambda one: one.name)
def test_it_is_the_formula_that_it_stands_for(effect: ss.Effect) -> None:
    limit = PIN.model.friction.static_limits[0]
    own = {
        "normal_force_feedback": ss.effect(
            "formula",
            where="contact_1",
            factor=f"max(0, 1 + (b*across + e*v_across)/{limit!r})",
            b=900.0,
            e=2.0,
        ),
        "sensor_crosstalk": ss.effect("formula", where="along", reading="reading + c*across", c=0.05),
    }
    ours, theirs = run(model(effect)), run(model(own[effect.name]))
    np.testing.assert_allclose(ours.state, theirs.state, atol=1e-9)
    if effect is CROSSED:
        np.testing.assert_allclose(ours.readings["along"], ours.along + 0.05 * ours.across, atol=1e-15)
    else:
        assert np.abs(ours.state - run(model()).state).max() > 1e-4


def test_the_limit_that_friction_is_a_share_of_is_that_of_the_law_now() -> None:
    """The derivative by the static limit has what the feedback makes of it, too."""
    short = {"rtol": 1e-13, "atol": 1e-13}
    at, h = PIN.model.friction.static_limits[0], 1e-5

    def moved(static: float) -> np.ndarray:
        return run(model(PRESSED).replace({"static": static}), **short).state[:400]

    slope = (moved(at + h) - moved(at - h)) / (2 * h)
    seeds = run(model(PRESSED), sensitivity=["static"], **short).sensitivity[:400, :, 0]
    np.testing.assert_allclose(seeds, slope, atol=1e-6 * np.abs(slope).max())


def test_the_limit_is_the_declared_law_s_whatever_acts_beside_it() -> None:
    """As in the core of the named rigs, where friction has a peak too."""
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    pressed = ss.effect("normal_force_feedback", beta2=1.5, eta2=0.3)
    peak = ss.effect("stribeck_peak", dT=0.6, v_s=0.05)
    both = ss.Model(rig, friction=ss.HyperbolicFriction(scale=0.7, decay=3.0), effects=[peak, pressed])
    t = np.linspace(0, 30, 61)
    ours, named = (
        ss.simulate(
            both, belt_speed=speed, initial=(0.1, 0.1, 0.02, 0.0), t_end=30, t_eval=t, rtol=1e-11, atol=1e-11
        )
        for speed in ("0.1 + 0*t", 0.1)
    )
    np.testing.assert_allclose(ours.state, named.state, atol=1e-8)


def test_its_numbers_go_by_place_and_coordinate(tmp_path: Path) -> None:
    both = model(PRESSED, CROSSED)
    names = {"normal_force_feedback@contact_1+across.beta2", "sensor_crosstalk@along+across.c"}
    assert names <= both.parameters.keys()
    both.save(tmp_path / "model.toml")
    assert ss.load_model(tmp_path / "model.toml") == both
    swept = ss.sweep(
        both, {"normal_force_feedback@contact_1+across.beta2": [0.0, 900.0]}, **PIN.speeds, t_end=1.0
    )
    assert np.ptp(swept.final_state.values, axis=0).max() > 0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"name": "sensor_crosstalk", "where": "along", "c": 0.1},
            "lacks the coordinate that it couples to: one of along",
        ),
        (
            {"name": "sensor_crosstalk", "where": "along", "by": "acros", "c": 0.1},
            "no coordinate 'acros'; .*across",
        ),
        ({"name": "sensor_lag", "where": "along", "by": "across", "tau": 0.1}, "acts at its own place alone"),
    ],
)
def test_what_cannot_be_meant_is_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        model(ss.effect(**given))


def test_a_named_rig_takes_none() -> None:
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    with pytest.raises(InputError, match="couples the angle body of a named rig; leave it out"):
        ss.Model(rig, friction=ss.PaperFriction(), effects=[ss.effect("sensor_crosstalk", by="y1", c=0.1)])


def bench(effect: ss.Effect) -> GeneralBench:
    made = run(model(effect))
    read = [made.readings.get(one, made.state[:, made.state_names.index(one)]) for one in PIN.channels]
    noise = PIN.noise * np.random.default_rng(3).standard_normal((len(T), len(read)))
    known = Uncertainty.usual(PIN.model.rig, channels=PIN.channels)
    return bench_of(PIN.model, [recording(PIN, T, np.transpose(read) + noise)], known)


@pytest.mark.parametrize("effect", [PRESSED, CROSSED], ids=lambda one: one.name)
def test_the_search_has_it_and_it_explains_the_readings(effect: ss.Effect) -> None:
    own = bench(effect)
    ranked = screened(own, null(own.windows(), own.policy), ()).ranked
    found = next(one for one in ranked if one.term.name == effect.label)
    assert found.gain > 100
    fit = fitted(begun(own.windows((found.term,))), own.policy)
    assert unexplained(fit) == pytest.approx(1.0, abs=0.1)
    for name, size in effect.parameters.items():
        assert fit.windows.values(fit.at)[f"{effect.label}.{name}"] == pytest.approx(size, rel=0.2)


def test_places_are_those_of_another_coordinate_of_the_same_unit() -> None:
    kinds = [(one.name, one.where, one.by) for one in bench(CROSSED).kinds() if one.by]
    assert kinds == [
        ("normal_force_feedback", "contact_1", "across"),
        ("sensor_crosstalk", "across", "along"),
        ("sensor_crosstalk", "along", "across"),
    ]
