"""Is a declared constant wrong by more than its uncertainty? One is freed at a time, all others as well as declared.

A constant within three of its standard uncertainties is no finding, whatever it gains. Constants of an SI rig are in
several numbers of (2.1) at once, its unit of time among them: what tells them apart is how those are off together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.uncertainty import SIGMAS_95, Uncertainty
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.rig_numbers import BEYOND
from stickslip.likelihoods.declared_numbers import sizes
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.interval import Interval
from stickslip.likelihoods.shared import Declared

Floats = NDArray[np.float64]
# Two of them add up to a third, of which a large error of one is a share: to first order by what they are, not by their
# logarithms.
SUMMED = frozenset({"c1", "c2", "eta1", "eta12"})


@dataclass(frozen=True)
class Freed:
    """
    One constant freed from what is declared of it.

    Parameters
    ----------
    name : as declared; of a gain, its channel
    off : relative error found, true over declared less 1
    sd : its standard deviation, of the logarithm
    known : its standard uncertainty as declared
    gain : fall of -2 log evidence, the width of what it may be paid for
    declared : what is known of all constants once this one is free
    rivals : other constants that would explain it
    """

    name: str
    off: float
    sd: float
    known: float
    gain: float
    declared: Declared
    rivals: tuple[Freed, ...] = ()

    @property
    def far(self) -> float:
        """How many standard uncertainties it is off."""
        return abs(math.log1p(self.off)) / self.known

    @property
    def beyond(self) -> bool:
        """Whether the whole 95 % interval lies beyond three standard uncertainties."""
        return self.gain > 0 and self.far - SIGMAS_95 * self.sd / self.known > BEYOND

    def interval(self, value: float = 1.0) -> Interval:
        """Return the constant with its 95 % interval, from its declared value."""
        at = math.log1p(self.off)
        return Interval(*(value * math.exp(at + k * SIGMAS_95 * self.sd) for k in (0, -1, 1)))


def freed(bench: Bench, fit: Fit, known: Uncertainty) -> list[Freed]:
    """
    Return every constant and gain freed alone, the likeliest first.

    Parameters
    ----------
    bench, fit : a fitted hypothesis
    known : the declared constants
    """
    declared, wide = bench.declared, bench.policy.law_spread**2
    plain = [declared.gains.get(name, name) for name in declared.names]
    size = np.append(sizes(bench.model, declared.names), 1.0)
    information, pull = _told(fit, declared.names)
    none = _evidence(declared.covariance, information, pull)
    out = []
    for name, own in {**known.constants, **known.gains}.items():
        if own == 0:
            continue
        joint = known.on_time([*plain, name], name, wide) * np.outer(size, size)
        covariance, along = joint[:-1, :-1], joint[-1, :-1]
        if np.abs(along).max(initial=0.0) == 0:
            continue  # in none of the numbers that are fitted
        inner = np.linalg.inv(np.eye(len(pull)) + information @ covariance)
        at = float(along @ inner @ pull)
        left = float(joint[-1, -1] - along @ (inner @ (information @ along)))
        gain = 2 * (_evidence(covariance, information, pull) - none)
        free = replace(declared, covariance=covariance)
        sd = math.sqrt(max(left, 0.0))
        if name in SUMMED:  # what is none, or less by an error, is known to be no more than that error
            at = max(at, min(sd, 1.0) - 1.0)
        if name in known.gains or name in SUMMED:  # as it is, not by its logarithm
            out.append(Freed(name, at, sd / (1 + at), own, gain, free))
        else:
            out.append(Freed(name, math.expm1(at), sd, own, gain, free))
    return sorted(out, key=lambda one: -one.gain)


def _told(fit: Fit, names: Sequence[str]) -> tuple[Floats, Floats]:
    """
    What the readings alone say of the constants: information (n, n), and information times estimate (n,).

    Of dampings that is their relative change, of other numbers of a rig the logarithm of it.
    """
    assert fit.solution is not None
    place = {n.name: i for i, n in enumerate(fit.windows.numbers)}
    at = [place[name] for name in names]
    away, prior = fit.windows.prior.at(fit.at)
    precision = np.linalg.inv(fit.solution.covariance[np.ix_(at, at)])
    information = precision - prior[np.ix_(at, at)]
    size, turn = np.linalg.eigh(0.5 * (information + information.T))
    information, off = (turn * np.maximum(size, 0.0)) @ turn.T, -away[at]
    pull = precision @ off
    added = np.array(
        [name in SUMMED and fit.windows.numbers[i].logarithmic for name, i in zip(names, at, strict=True)]
    )
    slope = np.where(added, np.exp(-off), 1.0)
    relative = np.where(added, np.expm1(off), off)
    return slope[:, None] * information * slope, slope * (pull + information @ (slope * relative - off))


def _evidence(covariance: Floats, information: Floats, pull: Floats) -> float:
    """Log marginal likelihood of what the readings say, under a covariance of the constants."""
    inner = np.eye(len(pull)) + covariance @ information
    _, volume = np.linalg.slogdet(inner)
    return float(0.5 * pull @ np.linalg.solve(inner, covariance @ pull) - 0.5 * volume)
