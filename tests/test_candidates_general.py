"""A user's own effect on a rig of bodies: scored as the effect of the catalogue that it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from bodies_lab import Laboratory, riding, stribeck
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of
from stickslip.discovery.laboratory.hypothesis import label, place_of, term
from stickslip.discovery.laboratory.screen import columns
from stickslip.errors import InputError
from stickslip.likelihoods.fit_state import begin

Floats = NDArray[np.float64]
SPEED = 0.1  # m/s
RIG = ss.BodiesRig(
    body={"a": ss.Body(mass=1.0), "b": ss.Body(mass=1.1)},
    link=[
        ss.Link(between=("a", "ground"), stiffness=40.0, damping=0.2),
        ss.Link(between=("b", "ground"), stiffness=36.0, damping=0.2),
        ss.Link(between=("a", "b"), stiffness=20.0),
    ],
    contact=[ss.Contact(body=name, against="belt", law="rubber") for name in ("a", "b")],
)
FADING = 150.0  # N s/m^3
LAWS = {"rubber": ss.StribeckFriction(F_c=3.2, F_s=4.8, v_s=0.25)}


def chain(
    seed: int, lasts: float, more: Callable[[float, Floats], Floats] | None = None, role: str = "train"
) -> ss.Recording:
    """Two blocks on a belt."""
    lab = Laboratory(
        M=np.diag([1.0, 1.1]), C=0.2 * np.eye(2), K=np.array([[60.0, -20.0], [-20.0, 56.0]]), D=np.eye(2),
        laws=[stribeck(3.0, 5.0, 0.2)] * 2, kinetic=[], static=[], V=[riding(SPEED)] * 2, force=np.zeros(2),
        level_sd=0.02, static_sd=0.02, rng=np.random.default_rng(seed), more=more,
    )  # fmt: skip
    t = np.arange(0.0, 4.0 + lasts, 0.01)
    x = lab.record(np.array([0.02, -0.01, SPEED, SPEED]), t)[400:, :2]
    x = x + 1e-4 * lab.rng.standard_normal(x.shape)
    columns = {"t": t[400:] - t[400], "a": x[:, 0], "b": x[:, 1]}
    return ss.load_recording(columns, RIG, belt_speed=SPEED, role=role)  # type: ignore[arg-type]


def bench(*candidates: ss.declared.effect.FormulaEffect) -> GeneralBench:
    model = ss.Model(RIG, friction=LAWS)
    known = Uncertainty.usual(RIG, channels=("a", "b"))
    return bench_of(model, [chain(20, 6.0)], known, candidates=candidates)


def test_the_columns_of_a_formula_are_those_of_the_effect_that_it_is() -> None:
    same = [
        ({"where": "link_1", "force": "-c*deflection**3"}, 5e3, "spring_cubic_k1@link_1", "k"),
        ({"where": "a", "factor": "1 + c*t"}, 1, "friction_drift@a", "r"),
        ({"where": "b", "reading": "reading + c*t"}, 1, "sensor_drift@b", "r"),
    ]
    for given, most, name, number in same:
        own = bench(ss.candidate("mine", ranges={"c": [0, most]}, **given))
        fit = begin(own.windows())
        kinds = {label(kind): kind for kind in own.kinds()}
        assert place_of(kinds["mine"]) == place_of(kinds[name])
        ours = columns(own, fit, (), term(kinds["mine"], {"c": 0.0}), ("mine.c",))
        theirs = columns(own, fit, (), term(kinds[name], {number: 0.0}), (f"{name}.{number}",))
        for a, b in zip(ours, theirs, strict=True):
            assert a is not None
            assert b is not None
            np.testing.assert_allclose(a, b, atol=1e-6 * np.abs(b).max())


def test_one_that_acts_on_no_place_of_the_rig_is_refused() -> None:
    lost = ss.candidate("lost", where="link_4", force="-c*deflection**3", ranges={"c": [0, 5]})
    with pytest.raises(InputError, match="link_4"):
        ss.discover([chain(20, 6.0)], friction=LAWS, candidates=[lost])


@pytest.mark.study
def test_what_acts_is_named_by_its_formula_with_an_interval_that_covers() -> None:
    def damped(_: float, z: Floats) -> Floats:
        return np.array([-FADING * z[0] ** 2 * z[2], 0.0])

    runs = [chain(seed, 7.0, damped) for seed in (30, 31)] + [chain(32, 5.0, damped, role="validate")]
    own = ss.candidate(
        "fading", where="link_1", force="-c*deflection**2*deflection_rate", ranges={"c": [0, 1e3]}
    )
    found = ss.discover(runs, friction=LAWS, candidates=[own], threads=1)
    (one,) = found.effects
    assert (one.name, one.where) == ("fading", "link_1")
    c = one.parameters["c"]
    assert c.low < FADING < c.high
    assert c.high - c.low < 0.5 * FADING
