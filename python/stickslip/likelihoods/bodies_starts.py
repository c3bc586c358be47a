"""Where windows of a rig of bodies begin: how far and how fast a run moves, and what sticks there leaves free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.policy import Policy

Floats = NDArray[np.float64]
# of the integration, in the shortest natural period; motions take 65 at most
STEPS_A_PERIOD, LEAST_STEPS = 300, 1000


@dataclass(frozen=True)
class BodiesStart:
    """v = held + scale_v * (free @ numbers): what sticks moves with what it rubs on."""

    scale_q: Floats
    scale_v: Floats
    free: Floats  # (n, n); a column of zeros for what sticks
    held: Floats  # (n,)


def start_of(D: Floats, speeds: Floats, scales: tuple[Floats, Floats]) -> BodiesStart:
    """
    Return how the velocities follow from a window's own numbers.

    Parameters
    ----------
    D : (sticking, n) directions of the contacts that stick
    speeds : (sticking,) of what each of them rubs on
    scales : as of `scales_of`
    """
    scale_q, scale_v = scales
    n = len(scale_q)
    if not len(D):
        return BodiesStart(scale_q, scale_v, np.eye(n), np.zeros(n))
    scaled = D * scale_v
    _, _, turned = np.linalg.svd(scaled)
    free = np.zeros((n, n))
    free[:, : n - len(D)] = turned[len(D) :].T
    return BodiesStart(scale_q, scale_v, free, scale_v * (np.linalg.pinv(scaled) @ speeds))


def scales_of(run: BodiesData) -> tuple[Floats, Floats]:
    """How far each coordinate moves in a radian of the natural period, and how fast."""
    v = np.std(run.v, axis=0)
    v = np.maximum(v, 1e-3 * max(float(v.max()), 1e-300))
    return v * run.periods[0] / (2 * np.pi), v


def resolved(scales: tuple[Floats, Floats], policy: Policy) -> float:
    """Return the absolute tolerance of a run's simulations: states may be of micrometres, in SI."""
    smallest = min(float(one.min()) for one in scales)
    return 0.01 * policy.tolerance * min(smallest, 1.0)


def most_steps(lasts: float, run: BodiesData, policy: Policy, hidden: bool) -> int:
    """Return steps of a window, some times as many as motions take; of fast hidden states as many as any."""
    usual = max(STEPS_A_PERIOD * lasts / run.periods[1], LEAST_STEPS)
    return int(policy.most_integration_steps if hidden else min(usual, policy.most_integration_steps))
