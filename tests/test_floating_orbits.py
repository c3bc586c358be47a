"""Cycles and steady sliding of what no spring holds to the ground."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from rig_cycles import LEINE, by_differences


def afloat() -> ss.Model:
    """Two masses and a spring: one rubs on the belt, the other on the ground."""
    rig = ss.BodiesRig(
        body={"a": ss.Body(mass=1), "b": ss.Body(mass=1)},
        link=[ss.Link(between=("a", "b"), stiffness=1, damping=0.1)],
        contact=[ss.Contact(body="a", against="belt"), ss.Contact(body="b")],
    )
    return ss.Model(rig, friction=LEINE)


def test_a_coordinate_that_no_spring_holds_is_no_direction_of_a_cycle() -> None:
    sliding = ss.steady_sliding(afloat(), 0.6, (0, 0, 0.25, 0.32))
    assert sliding.state[2:] == pytest.approx([0.3, 0.3], abs=1e-12)  # by symmetry
    assert len(sliding.eigenvalues) == 3
    # of the deflection: l^2 + (2 c - s) l + 2, of the speed of both: l - s, with s = 3/(1 + 3 v)^2 at v = 0.3
    s = 3 / (1 + 3 * 0.3) ** 2
    want = np.append(np.roots([1, 2 * 0.1 - s, 2]), s)
    assert np.sort_complex(sliding.eigenvalues) == pytest.approx(np.sort_complex(want), abs=1e-9)


def floating(damping: float) -> ss.Model:
    """A mass that the belt drags along by friction, a spring and a second mass in a fluid: no spring to the ground."""
    rig = ss.MatricesRig(
        M=np.eye(2).tolist(), C=[[0.02, -0.02], [-0.02, damping + 0.02]], K=[[1, -1], [-1, 1]], contact=[1, 0],
        names=["p", "q"], unit="1",
    )  # fmt: skip
    return ss.Model(rig, friction=LEINE)


def test_the_cycle_of_what_floats_repeats_but_for_a_translation() -> None:
    cycle = ss.limit_cycle(floating(2.1), 0.6, (0, 0, 0.2, 0.2))
    assert cycle.sticks
    assert len(cycle.multipliers) == 2  # of four states: not the translation, not the motion itself
    run = cycle.trajectory(3)
    gone = run.state[-1] - run.state[0]
    assert gone[0] == pytest.approx(gone[1], abs=1e-10)
    assert gone[0] > 1
    assert gone[2:] == pytest.approx([0, 0], abs=1e-10)
    np.testing.assert_allclose(cycle.monodromy, by_differences(cycle, {"belt_speed": 0.6}, 1e-5), atol=1e-7)
    assert np.trace(cycle.monodromy) == pytest.approx(cycle.multipliers.sum().real + 2, abs=1e-9)
    asked = {"initial": cycle.state, "t_end": 60 * cycle.period, "interval": cycle.period}
    spectrum = ss.lyapunov(floating(2.1), belt_speed=0.6, **asked)  # type: ignore[arg-type]
    rate = np.log(abs(cycle.multipliers[0])) / cycle.period
    assert spectrum.exponents[:2] == pytest.approx([0, rate], abs=1e-3)
    assert spectrum.exponents[2] == -np.inf


def test_the_branch_of_what_floats_ends_where_its_sliding_loses_stability() -> None:
    cycle = ss.limit_cycle(floating(2.1), 0.6, (0, 0, 0.2, 0.2))
    branch = ss.continuation(floating(2.1), 0.6, span=(0.55, 0.9), guess=cycle, step=0.05)
    assert branch.ends == ("span", "hopf")
    at = branch.special[-1].value
    for share, stable in ((0.999, False), (1.001, True)):
        guess = ss.steady_sliding(floating(2.1), at, (0, 0, 0.15, 0.15)).state
        assert ss.steady_sliding(floating(2.1), share * at, guess).stable == stable
