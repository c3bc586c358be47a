"""What every candidate would gain beside the declared law, and what noise alone seldom passes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.driven_slider.dictionary import Dictionary, tried
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class DrivenGate:
    """The largest gain of any candidate on noise drawn from the fitted null, and what the false ones seldom pass."""

    threshold: float
    draws: Floats


def drawn_gate(dictionary: Dictionary, null: MotionFit, seed: int = 0) -> tuple[Floats, DrivenGate]:
    """Gains (e,) of every entry of a dictionary beside the declared law, to first order, and their gate."""
    (first,) = dictionary.scores([null], dictionary.balance.read_again(POLICY.draws, seed))
    return first.gains, DrivenGate(extreme(first.drawn, 1 - POLICY.false_alarm), first.drawn)


@dataclass(frozen=True)
class Lacking:
    """The effect that would explain most beside the declared law, its gain in -2 log likelihood, and the gate."""

    name: str
    gain: float
    threshold: float

    @property
    def seen(self) -> bool:
        """Whether noise alone seldom gains so much."""
        return self.gain > self.threshold


def lacking(dictionary: Dictionary, null: MotionFit) -> Lacking:
    """Ask whether a single effect explains more than noise would: to first order, then fitted with the noise."""
    gains, gate = drawn_gate(dictionary, null)
    best = int(np.argmax(gains))
    choice, gain = dictionary.entries[best], float(gains[best])
    balance = dictionary.balance
    if gain > gate.threshold:
        balance.at(null)
        fit = balance.sharpen((choice,), null.law)
        if not tried(dictionary.grids, fit.choices):
            fit = balance.fit((choice,), null.law)
        gain = null.deviance - balance.shorter(balance.renoised(fit)).deviance
        balance.at(null)
    return Lacking(choice.name, gain, gate.threshold)


def extreme(drawn: Floats, level: float) -> float:
    """Quantile of largest values, from the Gumbel law with their mean and variance: they are few."""
    scale = float(np.std(drawn)) * np.sqrt(6) / np.pi
    return float(np.mean(drawn) + scale * (-np.log(-np.log(level)) - np.euler_gamma))
