"""Forces that effects add to a rig of bodies in the compiled core, against closed forms and SciPy."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy

from bodies_core import Bodies, Law, Push
from stickslip import _core

FREE = Law("0*u", "0*dwell")  # a contact without friction
TIMES = np.linspace(0.0, 20.0, 201)
TIGHT = {"rtol": 1e-12, "atol": 1e-12}


def rig(*pushes: Push, law: Law = FREE, numbers: dict[str, float] | None = None, k: float = 1.0) -> Bodies:
    return Bodies(
        np.eye(1), 0.02 * np.eye(1), k * np.eye(1), np.eye(1), [law], numbers or {}, contact_speed=[-1],
        pushes=pushes,
    )  # fmt: skip


def solved(field: Callable[[float, np.ndarray], list[float]], start: list[float]) -> np.ndarray:
    run = scipy.integrate.solve_ivp(
        field, (0, TIMES[-1]), start, method="DOP853", rtol=1e-13, atol=1e-13, t_eval=TIMES, max_step=0.02
    )
    return run.y.T


def motion(bodies: Bodies, start: list[float], **options: object) -> np.ndarray:
    run = bodies.run(start, TIMES[-1], t_eval=TIMES, **{**TIGHT, **options})
    assert run["outcome"] == _core.Outcome.finished
    return run["state"]


def test_a_harmonic_force_moves_an_oscillator_as_its_closed_form() -> None:
    bodies = rig(Push([1.0], "a*sin(w*t)"), numbers={"a": 0.3, "w": 1.7})
    bodies.C = np.zeros((1, 1))
    run = bodies.run([0.0, 0.0], TIMES[-1], t_eval=TIMES, seeds=["a", "w"], **TIGHT)
    a, w = 0.3, 1.7

    def x(a: float, w: float) -> np.ndarray:
        return a / (1 - w**2) * (np.sin(w * TIMES) - w * np.sin(TIMES))

    np.testing.assert_allclose(run["state"][:, 0], x(a, w), atol=1e-11)
    np.testing.assert_allclose(run["sensitivity"][:, 0, 0], x(1, w), atol=1e-10)
    by_w = (x(a, w + 1e-6) - x(a, w - 1e-6)) / 2e-6
    np.testing.assert_allclose(run["sensitivity"][:, 0, 1], by_w, atol=1e-8)


@pytest.mark.parametrize(
    ("force", "same"),
    [
        ("0 - 2*q0**3 - 0.3*v0*abs(v0)", lambda q, v: -2 * q**3 - 0.3 * v * abs(v)),
        ("0 - 5*max(0, abs(q0) - 0.2)*sign(q0)", lambda q, _: -5 * max(0, abs(q) - 0.2) * np.sign(q)),
        ("0 - 4*abs(q0)**1.5*sign(q0)", lambda q, _: -4 * abs(q) ** 1.5 * np.sign(q)),
        ("0 - tanh(v0/0.05)", lambda _, v: -math.tanh(v / 0.05)),
        ("1/(3 + q0) - exp(0 - (q0 + v0)**2)", lambda q, v: 1 / (3 + q) - math.exp(-((q + v) ** 2))),
    ],
)
@pytest.mark.parametrize("start", [[0.5, 0.3], [0.0, -0.4]])
def test_a_force_by_a_formula_moves_as_scipy_says(force: str, same: Callable, start: list[float]) -> None:
    ours = motion(rig(Push([1.0], force)), start)
    theirs = solved(lambda _, y: [y[1], -y[0] - 0.02 * y[1] + float(same(y[0], y[1]))], start)
    np.testing.assert_allclose(ours, theirs, atol=3e-8)


@pytest.mark.parametrize("seed", range(40))
def test_surfaces_that_are_met_together_are_passed_together(seed: int) -> None:
    """By rounding alone the trajectory was on the one side of abs(q0) and on the other of sign(q0), without end."""
    rng = np.random.default_rng(seed)
    start, k = rng.uniform(-0.5, 0.5, 2).tolist(), float(rng.uniform(0.5, 3.0))
    run = rig(Push([1.0], "0 - 5*max(0, abs(q0) - 0.2)*sign(q0)"), k=k).run(
        start, 100.0, t_eval=[100.0], **TIGHT
    )
    assert run["outcome"] == _core.Outcome.finished
    assert (np.diff(run["kink_t"]) > 0).all()


def test_a_force_on_two_coordinates_at_once() -> None:
    K = np.array([[2.0, -1.0], [-1.0, 2.0]])
    bodies = Bodies(
        np.diag([1.0, 0.5]), np.zeros((2, 2)), K, np.array([[1.0, 0.0]]), [FREE], {"k": 3.0}, contact_speed=[-1],
        pushes=[Push([1.0, -1.0], "0 - k*(q0 - q1)**3")],
    )  # fmt: skip

    def field(_: float, y: np.ndarray) -> list[float]:
        f = -3.0 * (y[0] - y[1]) ** 3
        return [y[2], y[3], -2 * y[0] + y[1] + f, (y[0] - 2 * y[1] - f) / 0.5]

    np.testing.assert_allclose(
        motion(bodies, [0.5, -0.3, 0.1, 0.2]), solved(field, [0.5, -0.3, 0.1, 0.2]), atol=1e-9
    )


def test_a_stuck_block_lets_go_when_a_force_says_so() -> None:
    bodies = rig(
        Push([1.0], "a*sin(w*t)"), law=Law("Fk", "Fs"), numbers={"a": 0.8, "w": 0.3, "Fk": 0.2, "Fs": 0.5}
    )
    run = bodies.run([0.0, 0.0], 5.0, seeds=["a", "Fs"], **TIGHT)
    t = math.asin(0.5 / 0.8) / 0.3
    assert run["transition_t"][0] == pytest.approx(t, abs=1e-12)
    rate = 0.8 * 0.3 * math.cos(0.3 * t)
    np.testing.assert_allclose(
        run["transition_sensitivity"][0, 0], [-math.sin(0.3 * t) / rate, 1 / rate], atol=1e-10
    )


def test_friction_that_reads_the_motion() -> None:
    """Kinetic friction that grows along the track: one slip, and where it ends."""
    law = Law("Fk*(1 + r*q0)", "Fs*(1 + r*q0)")
    bodies = rig(law=law, numbers={"Fk": 0.2, "Fs": 0.5, "r": 0.4})
    run = bodies.run([-1.0, 0.0], 10.0, **TIGHT)
    # q'' = -q - 0.02 q' - 0.2 (1 + 0.4 q), from rest at -1
    k, f, c = 1 + 0.08, -0.2, 0.02
    w = math.sqrt(k - c**2 / 4)
    stop = math.pi / w
    reached = f / k + (1 + f / k) * math.exp(-c / 2 * stop)
    assert run["transition_t"][0] == pytest.approx(stop, abs=1e-11)
    assert run["transition_state"][0, 0] == pytest.approx(reached, abs=1e-11)


def test_states_without_a_force_follow_the_motion_and_leave_it_alone() -> None:
    alone = motion(rig(Push([1.0], "0 - q0**3")), [0.5, 0.0])
    lagged = motion(rig(Push([1.0], "0 - q0**3"), Push([0.0], "0*t", {"m": "(q0 - m)/0.3"})), [0.5, 0.0, 0.2])
    np.testing.assert_allclose(lagged[:, :2], alone, atol=1e-11)
    theirs = solved(
        lambda _, y: [y[1], -y[0] - 0.02 * y[1] - y[0] ** 3, (y[0] - y[2]) / 0.3], [0.5, 0.0, 0.2]
    )
    np.testing.assert_allclose(lagged, theirs, atol=1e-10)


def test_where_the_belt_is() -> None:
    """A wave of friction along a belt, while the block slips one way."""
    law = Law("Fk*(1 + a*sin(k*(x0 - q0)))", "Fs")
    bodies = rig(law=law, numbers={"Fk": 0.2, "Fs": 0.5, "a": 0.5, "k": 9.0})
    bodies.speeds, bodies.contact_speed = [[(0.0, "3 + 0.1*t")]], [0]
    ours = motion(bodies, [0.1, 0.0])[:, :2]

    def field(t: float, y: np.ndarray) -> list[float]:
        belt = 3 * t + 0.05 * t**2
        return [y[1], -y[0] - 0.02 * y[1] + 0.2 * (1 + 0.5 * math.sin(9 * (belt - y[0])))]

    np.testing.assert_allclose(ours, solved(field, [0.1, 0.0]), atol=1e-9)


def test_derivatives_through_a_stop() -> None:
    bodies = rig(Push([1.0], "0 - k*max(0, q0 - d)"), numbers={"k": 20.0, "d": 0.2})
    run = bodies.run([0.5, 0.0], 7.3, t_eval=[7.3], seeds=["k", "d", ("initial", 0)], **TIGHT)
    for i, (place, h) in enumerate([("k", 1e-4), ("d", 1e-6), (("initial", 0), 1e-6)]):
        up, down = (
            bodies.run([0.5, 0.0], 7.3, t_eval=[7.3], shifts={place: sign * h}, **TIGHT)["state"]
            for sign in (1, -1)
        )
        np.testing.assert_allclose(
            run["sensitivity"][0, :, i], ((up - down) / (2 * h))[0], rtol=1e-6, atol=1e-8
        )


def test_a_push_reads_what_is_there() -> None:
    for force in ("q1", "x0", "u", "dwell"):
        with pytest.raises(ValueError, match="a push reads"):
            rig(Push([1.0], force)).run([0.0, 0.0], 1.0)
