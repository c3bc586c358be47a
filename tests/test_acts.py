"""What a model accepts acts: every effect and every curve changes the motion or the readings, as the reference says."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip.declared.effects import CONSTANTS, KINDS
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
# numbers of a size that shows within twelve units of time
NUMBERS = {
    "c": 0.2, "k": 0.5, "d": 1e-3, "f": 0.1, "a": 0.1, "w": 1.3, "phi": 0.4, "beta2": 0.5, "eta2": 0.3,
    "dT": 0.3, "v_s": 0.1, "tau": 0.5, "r": 0.01, "L": 0.7, "delay": 0.1, "q": 0.1, "e": 0.1,
}  # fmt: skip
TIMES = np.linspace(0.0, 12.0, 241)


def made(name: str) -> ss.Effect:
    kind = KINDS[name]
    own = {"contact_compliance": {"k": 200.0, "c": 1.0}}.get(name, {})
    return ss.effect(
        name,
        **{one.name: own.get(one.name, NUMBERS[one.name]) for one in kind.parameters if not one.optional},
    )


def watched(rig: str, law: ss.FrictionLaw, *effects: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The core's states, the reference's, and the reference's readings."""
    declared, start, v_b = RIGS[rig]
    model = ss.Model(declared, friction=law, effects=effects)  # type: ignore[arg-type]
    ours = ss.simulate(
        model, belt_speed=v_b, initial=start, t_end=TIMES[-1], t_eval=TIMES, rtol=1e-12, atol=1e-12
    )
    theirs = reference.simulate(model, belt_speed=v_b, initial=start, t_end=float(TIMES[-1]))
    assert ours.status.ok
    return ours.state, theirs.at(TIMES)[:, : len(start)], reference.readings(model, theirs, TIMES)


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
    wrong = kind.two_degree if rig == "block_on_belt" else name in CONSTANTS
    if wrong or name not in {**ss.CATALOGUE, **CONSTANTS}:
        with pytest.raises(InputError, match=name):
            ss.Model(RIGS[rig][0], friction=law, effects=[made(name)])
        return
    if name == "friction_memory" and isinstance(law, ss.CoulombFriction):
        return  # friction that does not depend on the speed remembers nothing
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
