"""Long stretches of linear modes on general rigs, whose cost is that of their events, against sums of exponentials."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize

import stickslip as ss
from bodies_core import Bodies, Floats, Law
from stickslip import _core

COULOMB = Law("Fk", "Fs")
NUMBERS = {"Fk": 0.6, "Fs": 1.0}


class Held:
    """A chain whose first block sticks to a belt of speed a + b t: a polynomial and the modes of what is left."""

    def __init__(self, n: int, damping: float, a: float, b: float, seed: int) -> None:
        rng = np.random.default_rng(seed)
        L = rng.normal(size=(n, n)) * 0.3
        M = np.diag(rng.uniform(0.5, 2, n)) + 0.1 * L @ L.T
        K = np.eye(n) * 2.5 - 0.8 * (np.eye(n, k=1) + np.eye(n, k=-1)) + L @ L.T
        C = damping * (K + 0.3 * M)
        self.n, self.M, self.C, self.K = n, M, C, K
        self.rig = Bodies(M, C, K, np.eye(n)[:1], [COULOMB], NUMBERS, [[(0.0, f"{a!r} + {b!r}*t")]])
        self.start = np.concatenate([0.05 * rng.normal(size=n), 0.02 * rng.normal(size=n)])
        self.start[n] = a
        self.path = np.zeros((3, n))  # q as a polynomial of t
        self.path[:, 0] = self.start[0], a, b / 2
        for k in (2, 1, 0):
            known = K @ (self.path[k] * (np.arange(n) == 0))
            known = (
                known
                + (k + 1) * (C @ self.path[k + 1] if k < 2 else 0)
                + (2 * M @ self.path[2] if k == 0 else 0)
            )
            self.path[k, 1:] = np.linalg.solve(K[1:, 1:], -known[1:])
        m = n - 1
        A = np.zeros((2 * m, 2 * m))
        A[:m, m:] = np.eye(m)
        A[m:, :m], A[m:, m:] = (-np.linalg.solve(M[1:, 1:], one[1:, 1:]) for one in (K, C))
        self.rates, self.modes = np.linalg.eig(A)
        rest = np.concatenate([self.start[1:n] - self.path[0, 1:], self.start[n + 1 :] - self.path[1, 1:]])
        self.shares = np.linalg.solve(self.modes, rest)

    def at(self, t: float, order: int = 0) -> Floats:
        """The time derivative of (q, q') of this order."""
        rest = (self.modes @ (self.shares * self.rates**order * np.exp(self.rates * t))).real
        powers = np.array([[1, t, t * t], [0, 1, 2 * t], [0, 0, 2], [0, 0, 0]]) @ self.path
        q, v = powers[order], powers[order + 1]
        q[1:] += rest[: self.n - 1]
        v[1:] += rest[self.n - 1 :]
        return np.concatenate([q, v])

    def friction(self, t: float) -> float:
        """What holds the first block: the first row of M q'' + C q' + K q = -T."""
        z, n = self.at(t), self.n
        return -float(self.M[0] @ self.at(t, 1)[n:] + self.C[0] @ z[n:] + self.K[0] @ z[:n])


@pytest.mark.parametrize("n", [1, 2, 3, 5])
@pytest.mark.parametrize(("a", "b"), [(1e-4, 0.0), (1e-7, 0.0), (-1e-5, 0.0), (1e-6, 1e-11)])
def test_a_long_stick_of_a_chain_ends_where_the_modes_say(n: int, a: float, b: float) -> None:
    held = Held(n, 0.05, a, b, seed=n)
    sign = np.sign(a)
    stiff = (held.friction(2e3) - held.friction(1e3)) / 1e3  # no faster than this for long
    late = 1.2 * NUMBERS["Fs"] / abs(stiff)
    grid = np.linspace(0, late, 2000)
    beyond = np.array([sign * held.friction(t) for t in grid]) + NUMBERS["Fs"]
    k = int(np.argmax(beyond < 0))
    expected = scipy.optimize.brentq(
        lambda t: sign * held.friction(t) + NUMBERS["Fs"], grid[k - 1], grid[k], xtol=1e-12 * late
    )
    looks = np.array([0.1, 0.5, 0.51, 0.99]) * expected
    got = held.rig.run(held.start, 1.001 * expected, t_eval=looks)
    assert got["outcome"] == _core.Outcome.finished
    assert got["steps"] < 1200
    assert got["transition_t"][0] == pytest.approx(expected, rel=1e-9)
    for t, state in zip(looks, got["state"], strict=True):
        assert state[: 2 * n] == pytest.approx(held.at(t), abs=1e-10)


def test_steady_sliding_on_two_contacts_is_crossed_whatever_it_lasts() -> None:
    K = np.array([[2.0, -0.7], [-0.7, 1.5]])
    rig = Bodies(np.diag([1.0, 0.4]), 0.1 * K, K, np.eye(2), [COULOMB, COULOMB], NUMBERS, [[(0.0, "0.7")]])
    got = rig.run([0.3, 0.2, 0.0, 0.0], 1e9, t_eval=[1e9])
    assert got["outcome"] == _core.Outcome.finished
    assert got["steps"] < 2000
    assert got["state"][-1, :2] == pytest.approx(np.linalg.solve(K, [0.6, 0.6]), abs=1e-12)
    assert got["state"][-1, 2:4] == pytest.approx([0, 0], abs=1e-12)


def test_a_swing_without_damping_keeps_its_energy_over_a_million_turns() -> None:
    rig = Bodies(np.eye(1), np.zeros((1, 1)), np.eye(1), np.eye(1), [COULOMB], NUMBERS, [[(0.0, "1.0")]])
    t_end = 2e6 * np.pi
    got = rig.run([0.6 + 0.9, 0.0], t_end, t_eval=[t_end])
    assert got["steps"] < 500
    assert got["state"][-1, :2] == pytest.approx([1.5, 0.0], abs=1e-8)


def test_derivatives_pass_through_a_long_stick() -> None:
    held = Held(3, 0.05, 1e-6, 0.0, seed=3)
    seeds = ["Fs", ("M", 4), ("K", 4), ("K", 1), ("C", 8), ("initial", 1)]
    got = held.rig.run(held.start, 3e6, t_eval=[3e6], seeds=seeds)
    assert len(got["transition_t"])
    scale = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    for i, (seed, size) in enumerate(zip(seeds, scale, strict=True)):
        h = 1e-3 * size
        t = [
            held.rig.run(held.start, 3e6, t_eval=[3e6], shifts={seed: by * h})["transition_t"][0]
            for by in (-2, -1, 1, 2)
        ]
        expected = (t[0] - 8 * t[1] + 8 * t[2] - t[3]) / (12 * h)
        assert got["transition_sensitivity"][0, 0, i] == pytest.approx(expected, rel=2e-6, abs=1e-4)


@pytest.mark.parametrize("v", [1e-3, 1e-9])
def test_a_slow_pull_of_a_block_has_a_limit_cycle(v: float) -> None:
    model = ss.Model(
        ss.BlockOnBelt(mass=0.5, stiffness=500.0), friction=ss.CoulombFriction(static=2.0, kinetic=1.2)
    )
    reach, turn = 0.8 / 500, np.sqrt(1000.0)
    period = 2 * (np.pi - np.arctan(reach * turn / v)) / turn + 2 * reach / v
    cycle = ss.limit_cycle(model, v)
    assert cycle.period == pytest.approx(period, rel=1e-10)
    assert cycle.sticks
    assert cycle.stable
    assert np.abs(cycle.multipliers).max() < 1e-4
