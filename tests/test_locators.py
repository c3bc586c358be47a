"""Hénon's landing and plain bisection, compared on every kind of transition.

Bisection on the same series is slow and cannot go wrong; Hénon's step must land where it does.
"""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("stickslip._core")
from stickslip.declared.effect import Effect, Tabulated, effect, tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.simulated.simulate import simulate
from stickslip.simulated.trajectory import Trajectory

RIG = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
START = (0.1, 0.1, 0.0, 0.0)
TIGHT = {"rtol": 1e-13, "atol": 1e-13}
CHANGES = [(0, -1), (0, 1), (-1, 0), (1, 0), (-1, 1), (1, -1)]
LAWS = {
    "paper": PaperFriction(),
    "coulomb": CoulombFriction(static=5, kinetic=3),
    "hyperbolic": HyperbolicFriction(scale=5, decay=3),
}


def both(model: Model, **how: object) -> tuple[Trajectory, Trajectory]:
    henon, bracket = (simulate(model, locator=name, **TIGHT, **how) for name in ("henon", "bracket"))  # type: ignore[arg-type]
    assert henon.status.ok
    assert bracket.status.ok
    return henon, bracket


def assert_same(henon: Trajectory, bracket: Trajectory) -> None:
    assert henon.transitions.before.tolist() == bracket.transitions.before.tolist()
    assert henon.transitions.after.tolist() == bracket.transitions.after.tolist()
    assert henon.transitions.t == pytest.approx(bracket.transitions.t, abs=1e-12)
    assert henon.transitions.state == pytest.approx(bracket.transitions.state, abs=1e-12)
    assert henon.kinks == pytest.approx(bracket.kinks, abs=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_every_change_of_contact_under_forcing(law: str) -> None:
    # from a forcing that leaves the block sticking to one that throws it across the belt's speed both ways
    seen = set()
    for v_b in (0.1, -0.1):
        for a in (1.0, 2.0, 4.0, 6.0):
            model = Model(RIG, friction=LAWS[law], effects=[effect("harmonic_forcing", a=a, w=0.7, phi=0.3)])
            henon, bracket = both(model, belt_speed=v_b, initial=START, t_end=40)
            assert_same(henon, bracket)
            changes = henon.transitions
            seen |= set(zip(changes.before.tolist(), changes.after.tolist(), strict=True))
    assert seen == set(CHANGES)


@pytest.mark.parametrize("v_b", [0.1, -0.1])
def test_without_effects(v_b: float) -> None:
    # the plain rig goes through code of its own
    henon, bracket = both(Model(RIG, friction=PaperFriction()), belt_speed=v_b, initial=START, t_end=40)
    assert_same(henon, bracket)
    assert len(henon.transitions) >= 5
    swing = both(
        Model(RIG, friction=PaperFriction()), belt_speed=0.02, initial=(2.0, 0.0, 0.5, 0.0), t_end=20
    )
    assert_same(*swing)
    seen = set(zip(swing[0].transitions.before.tolist(), swing[0].transitions.after.tolist(), strict=True))
    assert {(-1, 1), (1, -1)} <= seen


@pytest.mark.parametrize(("start", "contact"), [((0.36, -0.25, 0.0, 0.0), -1), ((-0.36, 0.5, 0.0, 0.0), 1)])
def test_kinks_of_both_branches_both_ways(start: tuple[float, ...], contact: int) -> None:
    # onto the floor of the branch and off it again: pieces of their own
    henon, bracket = both(Model(RIG, friction=PaperFriction()), belt_speed=0.1, initial=start, t_end=12)
    assert_same(henon, bracket)
    assert len(henon.kinks) >= 2
    assert henon.mode[0] == contact


@pytest.mark.parametrize(
    "extra",
    [
        effect("spring_gap_k3", k=3, d=0.05),
        effect("pivot_dry_friction", f=0.1),
        effect("normal_force_feedback", beta2=60, eta2=0),
        tabulated("block", "x1", (-0.2, 0.0, 0.2, 0.3), (0.0, 0.3, -0.2, 0.1)),
        tabulated("angle_body", "y2", (-0.1, 0.0, 0.1), (0.1, 0.0, -0.2)),
        tabulated("contact", "v_w", (-0.2, -0.05, 0.0), (0.1, 0.0, -0.1)),
        tabulated("block", "t", (1.0, 3.0, 4.5, 9.0), (0.0, 1.0, -1.0, 0.0)),
        effect("block_quadratic_damping", c=0.5),
        effect("friction_memory", tau=0.1),
        effect("contact_compliance", k=200, c=2),
    ],
    ids=lambda e: f"{e.name}-{e.depends_on}" if isinstance(e, Tabulated) else e.name,
)
def test_surfaces_of_effects(extra: Effect | Tabulated) -> None:
    model = Model(RIG, friction=PaperFriction(), effects=[extra, effect("harmonic_forcing", a=2, w=0.9)])
    henon, bracket = both(model, belt_speed=0.1, initial=START, t_end=20)
    assert_same(henon, bracket)
    assert len(henon.kinks) + len(henon.transitions) > 4


@pytest.mark.parametrize("reach", np.linspace(0.2001, 0.6, 9))
def test_capture_from_a_graze_to_a_plunge(reach: float) -> None:
    model = Model(BlockOnBelt(), friction=CoulombFriction(static=1, kinetic=0.5))
    henon, bracket = both(model, belt_speed=0.2, initial=(0.5, -reach), t_end=6)
    assert_same(henon, bracket)
    assert henon.transitions.after[0] == 0
