"""Does the drive answer to the readings? In a loop their noise comes back as force, which biases a force balance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.driven_slider.policy import STEER

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Feedback:
    """`share` of what is new in the drive that goes with the latest readings; `chance` of so much in an open loop.

    `mass` [kg] is what least squares of the force balance would give.
    """

    share: float
    chance: float
    mass: float

    @property
    def closed(self) -> bool:
        """Whether the drive answers to the readings."""
        return self.chance < STEER.chance


def feedback(balance: Balance, fit: MotionFit) -> Feedback:
    """Ask the first run, by the test of Caines and Chan (IEEE Trans. Automatic Control 20, 1975, 498).

    What its own past does not say of the drive is independent of what is new in the readings so far, unless the drive
    is made from them.
    """
    run, order, answers = balance.runs[0], STEER.order, STEER.answers
    new = fit.white[: len(run.t) - 3 - order]  # row r is of reading r + order + 3
    first = order + 3 + answers
    past = np.column_stack([run.command[first - j : len(run.command) - j] for j in range(1, order + 1)])
    own = run.command[first:]
    past = np.column_stack([past, np.ones(len(past))])
    own = own - past @ np.linalg.lstsq(past, own, rcond=None)[0]
    X = np.column_stack([new[answers - i : len(new) - i] for i in range(answers)])
    left = own - X @ np.linalg.lstsq(X, own, rcond=None)[0]
    total = float(own @ own)
    share = 1 - float(left @ left) / total if total > 0 else 0.0
    chance = float(scipy.stats.chi2.sf(len(own) * share, answers))
    return Feedback(share, chance, plain_mass(balance))


def plain_mass(balance: Balance) -> float:
    """The mass by least squares of the force balance at the full rate."""
    X = np.column_stack([balance.response, balance.base])
    moving = X[:, 2:4].any(axis=1)
    return float(np.linalg.lstsq(X[moving], balance.drive[moving], rcond=None)[0][0])
