"""Rigs of bodies in the compiled core, with laws as tapes: the named rigs again, closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stickslip as ss
from bodies_core import Bodies, Law
from stickslip import _core

PAPER = ss.PaperFriction()
PAPER_NUMBERS = {
    name: getattr(PAPER, name)
    for name in (
        "T_s_minus", "A1", "A2", "t1", "t2", "v_w_min", "T_min_minus", "T_s_plus", "T_min_plus", "v_w_max",
    )
}  # fmt: skip
PAPER_LAW = Law(
    force="max(T_min_minus, T_s_minus - A1*exp((u + v_w_min)/t1) - A2*exp((u + v_w_min)/t2))",
    limit="T_s_minus",
    force_plus="max(T_min_plus, T_s_plus - u*(T_s_plus - T_min_plus)/v_w_max)",
    limit_plus="T_s_plus",
)
COULOMB = ss.CoulombFriction(static=1.0, kinetic=0.5, static_plus=0.8, kinetic_plus=0.6)
COULOMB_LAW = Law("Fk", "Fs", force_plus="Fk_plus", limit_plus="Fs_plus")
COULOMB_NUMBERS = {"Fk": 0.5, "Fs": 1.0, "Fk_plus": 0.6, "Fs_plus": 0.8}
HYPERBOLIC = ss.HyperbolicFriction(scale=1.0, decay=3.0, constant=0.3, quadratic=0.2)
HYPERBOLIC_LAW = Law("scale/(1 + decay*u) + constant + quadratic*u**2", "scale + constant")
HYPERBOLIC_NUMBERS = {"scale": 1.0, "decay": 3.0, "constant": 0.3, "quadratic": 0.2}
ALL = [
    (COULOMB, COULOMB_LAW, COULOMB_NUMBERS),
    (HYPERBOLIC, HYPERBOLIC_LAW, HYPERBOLIC_NUMBERS),
    (PAPER, PAPER_LAW, PAPER_NUMBERS),
]


def block(law: Law, numbers: dict[str, float], speed: float, damping: float = 0.0) -> Bodies:
    return Bodies(
        np.eye(1), np.array([[damping]]), np.eye(1), np.eye(1), [law], numbers, speeds=[[(0.0, repr(speed))]]
    )


def two(law: Law, numbers: dict[str, float], speed: float) -> Bodies:
    M, C, K = np.diag([16.0, 8.0]), np.array([[0.1, 0.1], [0.1, 0.2]]), np.array([[16.0, 1.0], [1.0, 4.0]])
    return Bodies(M, C, K, np.array([[1.0, 0.0]]), [law], numbers, speeds=[[(0.0, repr(speed))]])


def same(got: dict, want: ss.Trajectory, order: list[int], tol: float) -> None:
    """The core's own rig and the rig of bodies: the same modes in the same order, times and states within `tol`."""
    assert got["outcome"] == _core.Outcome.finished
    assert len(want.transitions) >= 3
    np.testing.assert_array_equal(got["transition_before"][:, 0], want.transitions.before)
    np.testing.assert_array_equal(got["transition_after"][:, 0], want.transitions.after)
    np.testing.assert_allclose(got["transition_t"], want.transitions.t, rtol=0, atol=tol)
    np.testing.assert_allclose(got["transition_state"][:, order], want.transitions.state, rtol=0, atol=tol)
    np.testing.assert_allclose(got["state"][:, order], want.state, rtol=0, atol=tol)
    np.testing.assert_array_equal(got["mode"][:, 0], want.mode)
    assert len(got["kink_t"]) == len(want.kinks)


@pytest.mark.parametrize("speed", [0.2, -0.2])
@pytest.mark.parametrize(("friction", "law", "numbers"), ALL)
def test_block_on_belt_is_the_named_rig(
    friction: ss.FrictionLaw, law: Law, numbers: dict[str, float], speed: float
) -> None:
    model = ss.Model(rig=ss.BlockOnBelt(mass=1.0, stiffness=1.0, damping=0.05), friction=friction)
    t = np.linspace(0.1, 60.0, 41)
    want = ss.simulate(
        model, belt_speed=speed, initial=(0.3, 0.1), t_end=60.0, t_eval=t, rtol=1e-12, atol=1e-14
    )
    got = block(law, numbers, speed, 0.05).run([0.3, 0.1], 60.0, t_eval=t, rtol=1e-12, atol=1e-14)
    same(got, want, [0, 1], 1e-10)


@pytest.mark.parametrize(("friction", "law", "numbers"), ALL)
def test_two_degree_is_the_named_rig(friction: ss.FrictionLaw, law: Law, numbers: dict[str, float]) -> None:
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    t = np.linspace(0.1, 100.0, 57)
    want = ss.simulate(
        ss.Model(rig=rig, friction=friction), belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=100.0, t_eval=t,
        rtol=1e-12, atol=1e-14,
    )  # fmt: skip
    got = two(law, numbers, 0.1).run([0.1, 0, 0.1, 0], 100.0, t_eval=t, rtol=1e-12, atol=1e-14)
    same(got, want, [0, 2, 1, 3], 1e-9)


@pytest.mark.parametrize(("static", "kinetic", "v"), [(1.0, 0.5, 0.2), (1.0, 0.5, 0.5), (1.0, 0.25, 0.1)])
def test_coulomb_in_closed_form(static: float, kinetic: float, v: float) -> None:
    """Slip lasts 2 (pi - atan(A/v)), stick 2 A/v, A = static - kinetic; one expansion an event in stick."""
    numbers = {"Fk": kinetic, "Fs": static}
    got = block(Law("Fk", "Fs"), numbers, v).run([0.0, v], 200.0)
    drop = static - kinetic
    lasted = np.diff(got["transition_t"])
    np.testing.assert_allclose(lasted[0::2], 2 * (math.pi - math.atan(drop / v)), rtol=0, atol=1e-13)
    np.testing.assert_allclose(lasted[1::2], 2 * drop / v, rtol=0, atol=1e-12)
    np.testing.assert_allclose(got["transition_state"][0::2, 0], static, rtol=0, atol=1e-13)
    np.testing.assert_allclose(got["transition_state"][1::2, 0], 2 * kinetic - static, rtol=0, atol=1e-12)
    slips, sticks = len(lasted[0::2]), len(lasted[1::2]) + 1
    assert got["steps"] <= 3 * (slips + 1) + sticks
