"""What the declared law lacks: candidates join one at a time, each with everything refitted, as long as they pay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import DRIVEN
from stickslip.declared.effect import POSITION_RIPPLES as RIPPLES
from stickslip.discovery.driven_slider.curves import CurveTerm, curves
from stickslip.discovery.driven_slider.dictionary import Dictionary, Scorer
from stickslip.discovery.driven_slider.fit import Balance, Choice, Fit
from stickslip.discovery.driven_slider.reference import process_noise

Floats = NDArray[np.float64]

MOST = 10  # effects at most
TRIED = 4  # candidates fitted whole at every step, of those that the score puts first
SHARE = 0.01  # of the excess over the noise: what explains less is left alone
DRAWS = 400
LEVEL = 0.99  # of the gate
MARGIN = 1.3  # on the gate, for what the bootstrap does not know
BLOCK = 0.1  # s, over which noise keeps its shape in the bootstrap
FAITHFUL = 0.5  # share of what a curve gains that a name must gain to be preferred to it
CLOSE = 12.0  # fall of chi-squared by which a rival must lose to be ruled out, in units of what is left per reading


@dataclass(frozen=True)
class Gate:
    """The largest gain of any candidate on noise alone: `draws`, and the limit that 1 % of them pass."""

    threshold: float
    draws: Floats


@dataclass(frozen=True)
class Step:
    """One candidate that joined: the fit before and after, and what its rivals would have gained (name: fit)."""

    before: Fit
    after: Fit
    rivals: tuple[Fit, ...]


@dataclass
class Search:
    """A balance with its noise known, ready to be searched.

    Parameters
    ----------
    balance
        Training runs.
    tell
        Told what is being tried.
    seed
        Of the bootstrap.
    """

    balance: Balance
    tell: Callable[[str], None]
    seed: int = 0
    dictionary: Dictionary = field(init=False)
    noise: Floats = field(init=False)
    null: Fit = field(init=False)
    gate: Gate = field(init=False)
    steps: list[Step] = field(init=False, default_factory=list)
    curves: tuple[CurveTerm, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.tell("fitting the declared law")
        first = self.balance.fit()
        self.tell("laying out the candidates")
        self.dictionary = Dictionary(self.balance, first.law)
        self.tell("estimating the process noise")
        self.noise = process_noise(self.balance, self.dictionary)
        self.null = self.balance.fit()
        self.gate = self._gate()
        self.curves = curves(self.balance.runs)

    def scorer(self, fit: Fit) -> Scorer:
        """Score candidates beside those of a fit."""
        balance = self.balance
        parts = [balance.base[:, 0 if "rig_mass" in fit.names else 1 :], balance.free]
        for one in fit.choices:
            if one.name != "rig_mass" and not one.term.fixed:
                parts.append(balance.columns(one.term, one.inside, fit.law))
        return self.dictionary.scorer(balance.whitened(np.column_stack(parts)))

    def _gate(self) -> Gate:
        """Largest gains on the noise itself, its sign drawn block by block: where it is large, it stays large."""
        generator = np.random.default_rng(self.seed)
        white = self.balance.whitened(self.noise)
        block = max(int(BLOCK / (self.balance.runs[0].dt * self.balance.band.step)), 1)
        count = -(-len(white) // block)
        signs = np.repeat(generator.choice([-1.0, 1.0], (count, DRAWS)), block, axis=0)[: len(white)]
        shift = generator.integers(0, block, DRAWS)
        signs = np.stack([np.roll(signs[:, i], shift[i]) for i in range(DRAWS)], axis=1)
        draws = self.scorer(self.null).gains(white[:, None] * signs).max(axis=0)
        return Gate(MARGIN * float(np.quantile(draws, LEVEL)), draws)

    @property
    def excess(self) -> float:
        """chi-squared of the declared law beyond what noise leaves."""
        return max(self.null.chi2 - (len(self.null.white) - self.null.freedom), 0.0)

    def gain(self, before: Fit, after: Fit) -> float:
        """Fall of chi-squared in units of what is left per reading: while much is left, little counts for little."""
        return (before.chi2 - after.chi2) / max(after.per_reading, 1.0)

    def pays(self, before: Fit, after: Fit) -> bool:
        """Does the fall pass the gate, the price of its numbers, and the least share of the excess?"""
        price = np.log(len(after.white)) * (after.freedom - before.freedom)
        enough = before.chi2 - after.chi2 > SHARE * self.excess
        return enough and self.gain(before, after) > max(self.gate.threshold, price)

    def joined(self, fit: Fit, taken: Sequence[str] = ()) -> tuple[Fit, ...]:
        """Fits with one more candidate each, best first; names `taken` stay out."""
        scorer = self.scorer(fit)
        gains = scorer.gains(fit.white)
        size = np.array([one.choice.term.size for one in self.dictionary.entries])
        worth = gains - np.log(len(fit.white)) * size
        later = [b for a, b in pairwise(RIPPLES) if a not in fit.names]
        for name in {*taken, *fit.names, *later}:
            if name in self.dictionary.families:
                worth[self.dictionary.family == self.dictionary.families.index(name)] = -np.inf
        order, seen = [], set()
        for i in np.argsort(-worth):
            name = self.dictionary.entries[i].choice.name
            if np.isfinite(worth[i]) and name not in seen:
                seen.add(name)
                order.append(int(i))
        out = []
        for i in order[:TRIED]:
            choice = self.dictionary.entries[i].choice
            self.tell(f"trying {' + '.join((*fit.names, choice.name))}")
            out.append(self.balance.sharpen((*fit.choices, choice), fit.law, last=True))
        return tuple(sorted(filter(possible, out), key=self.score))

    def score(self, fit: Fit) -> float:
        """-2 log likelihood with the price of the numbers."""
        return fit.chi2 + float(np.log(len(fit.white))) * fit.freedom

    def run(self) -> Fit:
        """Let candidates join while they pay, then learned curves; then drop those that no longer do."""
        fit = self.null
        while len(fit.choices) < MOST:
            rivals = self.joined(fit)
            learned = self.learned(fit)
            if learned and (not rivals or self.clearly(fit, learned[0], rivals[0])):
                rivals = (learned[0], *rivals)
            if not rivals or not self.pays(fit, rivals[0]):
                break
            sharper = self.balance.sharpen(rivals[0].choices, rivals[0].law)
            after = sharper if possible(sharper) else rivals[0]
            self.steps.append(Step(fit, after, rivals[1:]))
            fit = after
        return self._thinned(self._exchanged(fit))

    def _exchanged(self, fit: Fit) -> Fit:
        """Give every place to the candidate that fills it best, now that the others are there."""
        for one in list(fit.choices):
            if one.name in RIPPLES:
                continue
            less = self.without(fit, one.name)
            rivals = self.joined(less, taken=(one.name, *RIPPLES))
            if rivals and self.score(rivals[0]) < self.score(fit):
                other = self.balance.sharpen(rivals[0].choices, rivals[0].law)
                if possible(other) and self.score(other) < self.score(fit):
                    fit = other
        return fit

    def learned(self, fit: Fit) -> tuple[Fit, ...]:
        """Fits with one more learned curve each, best first."""
        fresh = [one for one in self.curves if one.name not in fit.names]
        self.tell(f"learning a curve beside {' + '.join(fit.names) or 'the declared law'}")
        none = np.zeros(0)
        fits = [self.balance.fit((*fit.choices, Choice(one.term(), none)), fit.law) for one in fresh]
        return tuple(sorted(fits, key=self.score))

    def clearly(self, fit: Fit, curve: Fit, named: Fit) -> bool:
        """Does a curve do so much better than the best name that the name would only be the nearest word for it?"""
        drop, best = fit.chi2 - curve.chi2, fit.chi2 - named.chi2
        return self.score(curve) < self.score(named) and best < FAITHFUL * drop

    def without(self, fit: Fit, name: str) -> Fit:
        """The fit without one of its candidates, the others sharpened."""
        rest = tuple(one for one in fit.choices if one.name != name)
        return self.balance.fit(rest, fit.law) if rest else self.null

    def _thinned(self, fit: Fit) -> Fit:
        for one in list(fit.choices):
            less = self.without(fit, one.name)
            if possible(less) and not self.pays(less, fit):
                fit = less
        return fit


def possible(fit: Fit) -> bool:
    """Whether every named effect of a fit has numbers within the bounds that the catalogue sets them."""
    numbers = fit.parameters()
    return all(
        info.allows(numbers[name].get(info.name, 0.0))
        for name in numbers.keys() & DRIVEN.keys()
        for info in DRIVEN[name].parameters
    )


__all__ = ["Choice", "Gate", "Search", "Step"]
