"""A law of which each window has its own: slow sliding goes with the static limit, and nothing sticks again at once."""

import numpy as np
import pytest

import stickslip as ss
from bodies_lab import Laboratory, at_rest
from stickslip.declared.formula.value import value
from stickslip.declared.law_form import LawForm
from stickslip.likelihoods.contact_scatter import scattering

SPEED, FAST = 0.02, 1e9
AGING = ss.FormulaFriction(
    kinetic="F_c + (F_s - F_c)*exp(-u/v_s)", static="F_s*(1 + b*log(1 + dwell/tau))",
    F_c="2 N", F_s="3 N", v_s="0.1 m/s", b=0.02, tau="1 s",
)  # fmt: skip
CONTINUOUS = {
    "stribeck": ss.StribeckFriction(F_c=2.0, F_s=3.0, v_s=0.1),
    "hyperbolic": ss.HyperbolicFriction(scale=2.0, decay=8.0, constant=1.0),
    "grows in rest": AGING,
}


def forces(law: LawForm, static: float, kinetic: float = 0.0) -> tuple[float, float, float]:
    """The static limit, and friction of the slowest and of the fastest sliding, under a window's own numbers."""
    own = {**law.numbers, "own_static_0": static, "own_kinetic_0": kinetic, "t": 0.0, "dwell": 0.0}
    branch = law.minus
    assert branch.static is not None
    assert branch.kinetic is not None
    slow, fast = (float(value(branch.kinetic, {**own, "u": u})) for u in (0.0, FAST))
    return float(value(branch.static, own)), slow, fast


@pytest.mark.parametrize("name", CONTINUOUS)
@pytest.mark.parametrize("own", [-0.1, 0.05])
def test_slow_sliding_goes_with_a_limit_that_it_begins_at(name: str, own: float) -> None:
    law = scattering(CONTINUOUS[name].form(), 0)
    was, now = forces(law, 0.0), forces(law, own)
    assert now[0] == pytest.approx((1 + own) * was[0], rel=1e-12)
    assert now[1] == pytest.approx(now[0], rel=1e-12)
    assert now[2] == pytest.approx(was[2], rel=1e-6)
    assert forces(law, own, 0.1) == pytest.approx([1.1 * one for one in now], rel=1e-12)


def test_a_limit_apart_from_sliding_moves_alone_and_not_below_it() -> None:
    law = scattering(ss.CoulombFriction(static=4.0, kinetic=3.0).form(), 0)
    assert forces(law, -0.1) == pytest.approx((3.6, 3.0, 3.0))
    assert forces(law, -0.3) == pytest.approx((3.0, 3.0, 3.0))


def pulled(seed: int, lasts: float = 12.0) -> ss.Recording:
    """A slider pulled through a spring, by SciPy, whose friction is hyperbolic and scatters by 2 %."""

    def hyperbolic(level: float, own: float) -> tuple[object, float]:
        top = (1 + own) * 3.0
        return lambda u: (1 + level) * (1.0 + (top - 1.0) / (1 + 8.0 * max(u, 0.0))), (1 + level) * top

    laboratory = Laboratory(
        M=np.array([[0.5]]), C=np.array([[1.0]]), K=np.array([[500.0]]), D=np.array([[1.0]]),
        laws=[hyperbolic], level_sd=0.02, static_sd=0.02, kinetic=[], static=[], V=[at_rest],  # type: ignore[list-item]
        force=np.zeros(1), more=lambda t, _: np.array([500.0 * SPEED * t + SPEED]), rng=np.random.default_rng(seed),
    )  # fmt: skip
    t = np.arange(0.0, lasts, 0.004)
    state = laboratory.record(np.zeros(2), t)
    x = state[:, 0] + 1e-5 * np.random.default_rng([seed, 1]).normal(size=len(t))
    return ss.load_recording({"t": t, "slider": x}, SLIDER, drive_speed=SPEED)


SLIDER = ss.BodiesRig(
    body={"slider": ss.Body(mass=0.5)},
    link=[ss.Link(between=("slider", "drive"), stiffness=500.0, damping=1.0)],
    contact=[ss.Contact(body="slider", against="ground")],
)


def test_a_hyperbolic_law_is_identified_under_scatter() -> None:
    """No window of such a record could be simulated once its static limit had come out below the sliding friction."""
    declared = ss.HyperbolicFriction(scale=1.8, decay=6.0, constant=1.1)
    found = ss.identify([pulled(0), pulled(1)], rig=SLIDER, friction=declared)
    assert isinstance(found, ss.IdentifiedRig)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    law = found.model.friction
    u = np.array([0.0, 0.02, 0.05, 0.1])
    assert law.magnitude(u) == pytest.approx(
        1.0 + 2.0 / (1 + 8.0 * u), rel=0.03
    )  # 60 events that scatter by 2 %
