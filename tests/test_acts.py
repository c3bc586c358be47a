"""What a model accepts acts: every effect and every curve changes the motion or the readings, as the reference says."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from every_effect import made
from stickslip.declared.effect import CONSTANTS, KINDS
from stickslip.declared.laws import LAWS as DECLARED
from stickslip.declared.model import idle
from stickslip.errors import InputError
from stickslip.simulated.reference import integrate as reference

RIGS = {
    "two_degree": (ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), (0.1, 0.1, 0.02, 0.0), 0.1),
    "block_on_belt": (ss.BlockOnBelt(mass=1, stiffness=1, damping=0.02), (0.1, 0.1), 0.2),
}
LAWS = {
    "paper": ss.PaperFriction(),
    "coulomb": ss.CoulombFriction(static=1.0, kinetic=0.5),
    "hyperbolic": ss.HyperbolicFriction(scale=0.7, decay=3.0, constant=0.3),
}
PAIRS = [("two_degree", "paper"), ("block_on_belt", "coulomb"), ("block_on_belt", "hyperbolic")]
UNEVEN = {  # every number of every law; of one that is not here, its defaults
    **{
        kind: law(**{f"{name}_plus": 1.2 * getattr(law, name) for name in law.each_way})
        for kind, law in DECLARED.items()
    },
    "paper": ss.PaperFriction(),
    "coulomb": ss.CoulombFriction(static=1, kinetic=0.5, static_plus=1.2, kinetic_plus=0.7),
    "hyperbolic": ss.HyperbolicFriction(
        scale=0.7, decay=3, constant=0.3, quadratic=0.1,
        scale_plus=0.8, decay_plus=2, constant_plus=0.2, quadratic_plus=0.05,
    ),
}  # fmt: skip
TIMES = np.linspace(0.0, 8.0, 161)


def watched(rig: str, law: ss.FrictionLaw, *effects: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The core's states, the reference's, and the reference's readings."""
    declared, start, v_b = RIGS[rig]
    model = ss.Model(declared, friction=law, effects=effects)  # type: ignore[arg-type]
    ours = ss.simulate(
        model, belt_speed=v_b, initial=start, t_end=TIMES[-1], t_eval=TIMES, rtol=1e-12, atol=1e-12
    )
    theirs = reference.simulate(model, belt_speed=v_b, initial=start, t_end=float(TIMES[-1]))
    assert ours.status.ok
    states = theirs.at(TIMES, interpolated=True)[:, : len(start)]
    return ours.state, states, reference.readings(model, theirs, TIMES, interpolated=True)


@pytest.fixture(scope="module", params=PAIRS, ids="-".join)
def plain(request: pytest.FixtureRequest) -> tuple[str, ss.FrictionLaw, np.ndarray, np.ndarray]:
    rig, law = request.param
    ours, theirs, read = watched(rig, LAWS[law])
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
    return rig, LAWS[law], ours, read


def acts(plain: tuple[str, ss.FrictionLaw, np.ndarray, np.ndarray], term: object, of_reading: bool) -> None:
    rig, law, still, read_still = plain
    ours, theirs, read = watched(rig, law, term)
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
    if of_reading:
        np.testing.assert_allclose(ours, still, atol=1e-8)
        assert np.max(np.abs(read - read_still)) > 1e-7
    else:
        assert np.max(np.abs(ours - still)) > 1e-7


@pytest.mark.parametrize("name", KINDS)
def test_every_effect_acts_or_is_refused(
    plain: tuple[str, ss.FrictionLaw, np.ndarray, np.ndarray], name: str
) -> None:
    rig, law = plain[:2]
    kind = KINDS[name]
    wrong = kind.two_degree if rig == "block_on_belt" else name in {*CONSTANTS} - {"rig_stiffness"}
    if wrong or name not in {**ss.CATALOGUE, **CONSTANTS}:
        with pytest.raises(InputError, match=name):
            ss.Model(RIGS[rig][0], friction=law, effects=[made(name)])
        return
    if idle(law, [name]):
        assert (name, type(law)) == ("friction_memory", ss.CoulombFriction)
        with pytest.raises(InputError, match=f"'{name}' does nothing"):
            ss.Model(RIGS[rig][0], friction=law, effects=[made(name)])
        return
    acts(plain, made(name), KINDS[name].where.endswith("channel"))


@pytest.mark.parametrize("where", ["block", "angle_body", "contact", "x1 channel", "y1 channel"])
@pytest.mark.parametrize("variable", ["x1", "x2", "y1", "y2", "v_w", "t"])
def test_every_curve_acts_or_is_refused(
    plain: tuple[str, ss.FrictionLaw, np.ndarray, np.ndarray], where: str, variable: str
) -> None:
    rig, law = plain[:2]
    knots, values = [-0.6, -0.2, 0.1, 0.4, 1.0], [0.02, -0.03, 0.05, 0.02, -0.04]
    if where.endswith("channel") and variable == "v_w":
        with pytest.raises(InputError, match="a curve of a reading depends on"):
            ss.tabulated(where, variable, knots, values)
        return
    curve = ss.tabulated(where, variable, knots, values)
    if rig == "block_on_belt" and (where in ("angle_body", "y1 channel") or variable.startswith("y")):
        with pytest.raises(InputError, match="angle body"):
            ss.Model(RIGS[rig][0], friction=law, effects=[curve])
        return
    acts(plain, curve, where.endswith("channel"))


def moving(name: str, rig: str) -> ss.Model | None:
    """A model with an effect under the first law that takes it; None where the rig has no such."""
    for law in reversed(LAWS.values()):  # under the paper's a block on a belt may never stick
        try:
            return ss.Model(RIGS[rig][0], friction=law, effects=[made(name)])
        except InputError as error:
            if "does nothing" not in str(error):
                return None
    return None


def motions(model: ss.Model, rig: str) -> np.ndarray:
    """States on either way of the belt, from two starts."""
    _, start, v_b = RIGS[rig]
    t = np.linspace(0, 40, 81)
    return np.array(
        [
            ss.simulate(
                model,
                belt_speed=v,
                initial=tuple(k * x for x in start),
                t_end=40,
                t_eval=t,
                rtol=1e-11,
                atol=1e-11,
            ).state
            for v in (v_b, -v_b)
            for k in (1, -4)
        ]
    )


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("law", UNEVEN)
def test_every_number_of_rig_and_law_acts(rig: str, law: str) -> None:
    base = ss.Model(RIGS[rig][0], friction=UNEVEN[law])
    still = motions(base, rig)
    for name, value in base.parameters.items():
        moved = motions(base.replace({name: 1.05 * value + 0.01}), rig)
        assert np.max(np.abs(moved - still)) > 1e-8, name


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("name", [*ss.CATALOGUE, *CONSTANTS])
def test_a_sweep_over_any_number_of_an_effect_is_the_simulations(rig: str, name: str) -> None:
    model = moving(name, rig)
    if model is None:
        return
    _, start, v_b = RIGS[rig]
    settings = {"belt_speed": v_b, "initial": start, "t_end": 12, "rtol": 1e-12, "atol": 1e-12}
    for key, value in model.effects[0].parameters.items():
        full, values = f"{name}.{key}", np.array([value, 1.3 * value + 0.1 * (value == 0)])
        if name in CONSTANTS or KINDS[name].where.endswith("channel"):
            with pytest.raises(InputError, match=f"{full}: (acts on the reading|corrects a number)"):
                ss.sweep(model, over={full: values}, **settings)
            continue
        swept = ss.sweep(model, over={full: values}, observe="final_state", **settings).final_state.values
        each = [ss.simulate(model.replace({full: one}), **settings).state[-1] for one in values]
        np.testing.assert_allclose(swept[:, : len(start)], each, atol=1e-8)
        assert np.max(np.abs(swept[1] - swept[0])) > 1e-8, full


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("beside", ["contact_compliance", "stribeck_peak", "friction_memory"])
@pytest.mark.parametrize("name", ss.CATALOGUE)
def test_every_effect_acts_beside_another_or_is_refused(rig: str, beside: str, name: str) -> None:
    """Friction that ages beside bristles, which never stick, and memory of a friction that is constant were accepted
    and did nothing.
    """
    if name == beside or KINDS[name].where.endswith("channel"):
        return
    if RIGS[rig][0].state_names == ("x1", "x2") and KINDS[name].two_degree:
        return
    for law in LAWS.values():
        if idle(law, [beside]) and name != "stribeck_peak":
            continue
        effects = [made(beside), made(name)]
        if idle(law, [beside, name]):
            with pytest.raises(InputError, match="does nothing"):
                ss.Model(RIGS[rig][0], friction=law, effects=effects)
            continue
        both = ss.Model(RIGS[rig][0], friction=law, effects=effects)
        alone = both.with_effects([] if idle(law, [beside]) else effects[:1])
        assert np.max(np.abs(motions(both, rig) - motions(alone, rig))) > 1e-8, law
