"""What the declared law lacks: candidates join one at a time, each with everything refitted, as long as they pay."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import DRIVEN
from stickslip.declared.effect import POSITION_RIPPLES as RIPPLES
from stickslip.discovery.driven_slider.curves import CurveTerm, curves
from stickslip.likelihoods.driven_slider import terms as tm
from stickslip.likelihoods.driven_slider.dictionary import Dictionary, mass_term, tried
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import Choice, MotionFit
from stickslip.likelihoods.driven_slider.gate import DrivenGate, drawn_gate
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.interval import Interval
from stickslip.likelihoods.policy import POLICY
from stickslip.progress import trying

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class DrivenStep:
    """One candidate that joined: the fit before and after, and its rivals' fits."""

    before: MotionFit
    after: MotionFit
    rivals: tuple[MotionFit, ...]


@dataclass
class DrivenSearch:
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
    null: MotionFit = field(init=False)
    gate: DrivenGate = field(init=False)
    steps: list[DrivenStep] = field(init=False, default_factory=list)
    curves: tuple[CurveTerm, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.tell("fitting the declared law and the noise")
        self.null = self.balance.settle()
        self.dictionary = Dictionary(self.balance)
        self.tell("drawing the gate")
        gains, self.gate = drawn_gate(self.dictionary, self.null, self.seed)
        self._scored: list[tuple[MotionFit, Floats]] = [(self.null, gains)]
        self.curves = curves(self.balance.runs)

    def scores(self, fit: MotionFit) -> Floats:
        """What every entry of the dictionary would gain beside a fit, to first order."""
        if not any(one is fit for one, _ in self._scored):
            self.score_all([fit])
        return next(gains for one, gains in self._scored if one is fit)

    def score_all(self, fits: Sequence[MotionFit]) -> None:
        """Score beside fits that share a noise, at the cost of one."""
        self.balance.at(fits[0])
        scored = [one.gains for one in self.dictionary.scores(fits)]
        self._scored = [self._scored[0], *zip(fits, scored, strict=True)]

    def gain(self, before: MotionFit, after: MotionFit) -> float:
        """Fall of -2 log likelihood, the noise refitted on either side."""
        return before.deviance - after.deviance

    def pays(self, before: MotionFit, after: MotionFit) -> bool:
        """Does the fall pass the gate and the price of its numbers?

        A declared constant is one number that is asked for by name: it is held against its own uncertainty.
        """
        joined = set(after.names) - set(before.names)
        price = after.price * (after.freedom - before.freedom)
        least = max(self.gate.threshold, price)
        known = self.balance.declared.uncertainty
        if joined == {"rig_mass"} and known > 0:
            if abs(after.parameters()["rig_mass"]["e"]) <= STEER.far * known:
                return False
            least = STEER.far**2
        return self.gain(before, after) > least

    def joined(self, fit: MotionFit, taken: Sequence[str] = ()) -> tuple[MotionFit, ...]:
        """Fits with one more candidate each in the noise of `fit`, best first; names `taken` stay out."""
        return self.fitted(fit, self.first(fit, taken))

    def first(self, fit: MotionFit, taken: Sequence[str], *, every: bool = False) -> list[Choice]:
        """The candidates that the score puts first beside a fit, and the mass."""
        gains, names = self.scores(fit), self.dictionary.names
        size = np.array([one.term.size for one in self.dictionary.entries])
        worth = gains - fit.price * size
        out = {*taken, *fit.names}
        ripple = next((one for one in RIPPLES if one not in out), None)
        worth[np.isin(names, [one for one in out if one not in RIPPLES])] = -np.inf
        if ripple is None or (set(taken) & set(RIPPLES)):
            worth[names == RIPPLES[0]] = -np.inf
        order = [int(i) for i in np.argsort(-worth) if np.isfinite(worth[i])]
        best = {names[i]: i for i in reversed(order)}  # the best entry of each name
        # a wave is told by its score; what is smooth in time may be taken for noise as long as that is not refitted
        smooth = {one.name for one in self.dictionary.entries if one.term.scanned not in (("L",), ("w",))}
        ranked = sorted(best.values(), key=lambda i: -worth[i])
        first = [
            i for rank, i in enumerate(ranked) if rank < POLICY.fullest or (every and names[i] in smooth)
        ]
        choices = [self.dictionary.entries[i] for i in first]
        choices = [
            replace(one, term=_term(ripple)) if ripple and one.name == RIPPLES[0] else one for one in choices
        ]
        if "rig_mass" not in out:
            choices.append(Choice(mass_term(self.balance.declared.mass), np.zeros(0)))
        return choices

    def fitted(self, fit: MotionFit, choices: Sequence[Choice]) -> tuple[MotionFit, ...]:
        """The possible fits with each of some candidates, in the noise of `fit`, best first."""
        self.balance.at(fit)
        found = []
        for choice in choices:
            self.tell(trying(fit.names, choice.name))
            found.append(self.balance.sharpen((*fit.choices, choice), fit.law, last=True))
        return tuple(sorted(filter(self.possible, found), key=self.score))

    def possible(self, fit: MotionFit) -> bool:
        """Whether every number of a fit is one that may be, and was not carried to the end of what is tried."""
        return possible(fit) and tried(self.dictionary.grids, fit.choices)

    def score(self, fit: MotionFit) -> float:
        """-2 log likelihood with the price of the numbers."""
        return fit.deviance + fit.price * fit.freedom

    def renoised(self, fit: MotionFit) -> MotionFit:
        """The fit, its scanned numbers and its noise fitted too."""
        self.balance.at(fit)
        sharper = self.balance.sharpen(fit.choices, fit.law)
        return self.balance.shorter(self.balance.renoised(sharper if self.possible(sharper) else fit))

    def quickly(self, fit: MotionFit) -> MotionFit:
        """The fit in a noise of its own, its scanned numbers held."""
        self.balance.take(fit.noise)
        return self.balance.renoised(fit, rounds=1)

    def run(self) -> MotionFit:
        """Let candidates join while they pay, then learned curves; then drop those that no longer do."""
        fit = self.null
        while len(fit.choices) < STEER.most:
            self.balance.at(fit)
            tried = self.fitted(fit, self.first(fit, (), every=True))
            rivals = tuple(sorted((self.quickly(one) for one in tried), key=self.score))
            learned = self.learned(fit)
            if learned and (not rivals or self.clearly(fit, learned[0], rivals[0])):
                rivals = (learned[0], *rivals)
            ranked = sorted((self.renoised(one) for one in rivals[: POLICY.fullest]), key=self.score)
            # a curve stays ahead of the name that it was put before
            if ranked and rivals[0].names[-1].startswith("tabulated"):
                ranked.sort(key=lambda one: not one.names[-1].startswith("tabulated"))
            paying = [one for one in ranked if self.pays(fit, one)]
            if not paying:
                break
            self.steps.append(
                DrivenStep(fit, paying[0], tuple(one for one in rivals if one.names != paying[0].names))
            )
            fit = paying[0]
        return self._thinned(fit)

    def learned(self, fit: MotionFit) -> tuple[MotionFit, ...]:
        """Fits with one more learned curve each, best first."""
        fresh = [one for one in self.curves if one.name not in fit.names]
        self.tell(f"learning a curve beside {' + '.join(fit.names) or 'the declared law'}")
        none = np.zeros(0)
        self.balance.at(fit)
        fits = [self.balance.fit((*fit.choices, Choice(one.term(), none)), fit.law) for one in fresh]
        fits = [self.balance.shorter(self.quickly(one)) for one in fits]
        return tuple(sorted(fits, key=self.score))

    def clearly(self, fit: MotionFit, curve: MotionFit, named: MotionFit) -> bool:
        """Does a curve do so much better than the best name that the name would only be the nearest word for it?"""
        drop, best = self.gain(fit, curve), self.gain(fit, named)
        return self.score(curve) < self.score(named) and best < STEER.faithful * drop

    def bare(self, fit: MotionFit) -> MotionFit:
        """The declared law alone, in the noise of a fit."""
        self.balance.at(fit)
        return self.balance.fit((), self.null.law)

    def excess(self, chosen: MotionFit) -> float:
        """chi-squared of the declared law beyond what the noise leaves, in the noise of a fit."""
        return max(self.bare(chosen).chi2 - chosen.chi2, 1e-300)

    def unbounded(self, one: Choice, numbers: Mapping[str, Interval]) -> bool:
        """Whether a number of an effect has no bound: it reaches the end of what is tried, or a size may be 0."""
        for name, value in zip(one.term.scanned, one.inside, strict=True):
            own = numbers.get(name)
            grid = self.dictionary.grids[name]
            if own is not None and not (grid.min() < _low(own) and _high(own) < grid.max() and value):
                return True
        sizes = [own for name, own in numbers.items() if name not in one.term.scanned and name != "phi"]
        return one.term.size <= 2 and any(_low(own) * _high(own) <= 0 for own in sizes if own.value)

    def without(self, fit: MotionFit, name: str) -> MotionFit:
        """The fit without one of its candidates, in its own noise."""
        rest = tuple(one for one in fit.choices if one.name != name)
        self.balance.at(fit)
        return self.balance.fit(rest, fit.law)

    def _thinned(self, fit: MotionFit) -> MotionFit:
        for one in list(fit.choices):
            less = self.balance.renoised(self.without(fit, one.name))
            if self.possible(less) and not self.pays(less, fit):
                fit = less
        return fit


def _low(one: Interval) -> float:
    return -np.inf if one.low is None else one.low


def _high(one: Interval) -> float:
    return np.inf if one.high is None else one.high


def _term(name: str) -> tm.ForceTerm:
    return next(one for one in tm.terms() if one.name == name)


def possible(fit: MotionFit) -> bool:
    """Whether every named effect of a fit has numbers within the bounds that the catalogue sets them."""
    numbers = fit.parameters()
    return np.isfinite(fit.law.mass) and all(
        info.allows(numbers[name].get(info.name, 0.0))
        for name in numbers.keys() & DRIVEN.keys()
        for info in DRIVEN[name].parameters
    )


__all__ = ["DrivenSearch", "DrivenStep"]
