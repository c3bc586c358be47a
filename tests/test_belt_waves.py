"""A belt that wanders within a window: its columns against the core with such a belt, its line against a process."""

import numpy as np
import pytest
import scipy.signal

import stickslip as ss
from stickslip.likelihoods import belt_waves

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
KNOTS, BELT, SLOW = 10, 0.1, (0.3, 2.5)


def window(a: float, w: float, phi: float) -> tuple[np.ndarray, ss.Trajectory]:
    """One window from a stick on, on a belt that goes a sin(w t + phi) faster."""
    t = np.arange(0.0, 14.0, 0.02)
    ripple = (ss.effect("belt_speed_ripple", a=a, w=w, phi=phi),)
    speed = BELT * (1 + a * np.sin(phi))
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=ripple)
    return t, ss.simulate(model, belt_speed=BELT, initial=(0.1, speed, 0, 0), t_end=t[-1], t_eval=t)


@pytest.mark.parametrize(("w", "phi"), [(0.5, 0.0), (0.7, 2.0), (0.9, 1.0), (1.1, -1.0)])
def test_a_block_that_sticks_rides_a_belt_that_wanders(w: float, phi: float) -> None:
    """In each stick, from where it begins: what a slip does before is friction's own to take."""
    a = 0.004
    t, plain = window(0.0, w, phi)
    _, moved = window(a, w, phi)
    shapes, at = belt_waves.hats(t, KNOTS), np.linspace(t[0], t[-1], KNOTS)
    columns = belt_waves.ridden(plain.state[:, 1], plain.mode, BELT, belt_waves.times(t, shapes))
    found = columns @ (a * np.sin(w * at + phi))
    truth = moved.state[:, 0] - plain.state[:, 0]
    edges = [0, *np.flatnonzero(np.diff((plain.mode != 0).astype(int))) + 1]
    assert len(edges) >= 3
    for begin, end in zip(edges[:-1:2], edges[1::2], strict=False):
        both = slice(begin, end - 20)  # to where either breaks away
        of_core, of_line = truth[both] - truth[begin], found[both] - found[begin]
        # a line between ten knots is no sine: a third of it
        assert np.abs(of_line - of_core).max() < 0.33 * np.abs(of_core).max()


def test_the_leg_follows_the_block() -> None:
    """The leg's equation alone, driven by a place that swings: SciPy's own integration of it."""
    values = {"alpha2": 8.0, "eta1": 0.1, "eta12": 0.2, "beta3": 4.0}
    t = np.arange(0.0, 12.0, 0.02)
    place = np.sin(np.outer(t, [0.5, 2.0]))
    rate = np.cos(np.outer(t, [0.5, 2.0])) * [0.5, 2.0]
    system = scipy.signal.StateSpace(
        [[0.0, 1.0], [-values["beta3"] / values["alpha2"], -values["eta12"] / values["alpha2"]]],
        [[0.0], [1.0 / values["alpha2"]]],
        [[1.0, 0.0]],
        [[0.0]],
    )
    found = belt_waves.leg(place, 0.02, values)
    for k in range(2):
        truth = scipy.signal.lsim(system, -place[:, k] - values["eta1"] * rate[:, k], t)[1]
        assert np.abs(found[:, k] - truth).max() < 0.01 * np.abs(truth).max()


def test_a_belt_that_is_faster_throughout_is_one_that_is_not_apart_from_its_mean() -> None:
    t, plain = window(0.0, 1.0, 0.0)
    shapes = belt_waves.hats(t, KNOTS)
    assert np.allclose(shapes.sum(axis=1), 1.0)
    rides = belt_waves.ridden(plain.state[:, 1], plain.mode, BELT, belt_waves.times(t, shapes)).sum(axis=1)
    stuck = int(np.flatnonzero(plain.mode != 0)[0])
    assert np.allclose(rides[:stuck], BELT * t[:stuck])


def test_the_line_has_the_variance_and_the_memory_of_slow_waves() -> None:
    length = 9.0
    rng = np.random.default_rng(1)
    w, phi = rng.uniform(*SLOW, (20_000, 1)), rng.uniform(0, 2 * np.pi, (20_000, 1))
    at = np.linspace(0.0, length, KNOTS)
    drawn = np.sqrt(2.0) * np.sin(w * at + phi)
    mean = drawn @ belt_waves.weights(KNOTS)
    drawn = np.column_stack([drawn - mean[:, None], mean])
    factor = belt_waves.root(length, KNOTS, SLOW)
    assert np.abs(factor @ factor.T - drawn.T @ drawn / len(drawn)).max() < 0.04
