"""Every candidate at every number tried: what each would explain of a residual, or of drawn noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import POSITION_RIPPLES
from stickslip.likelihoods.driven_slider import terms as tm
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import Choice, MotionFit
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.driven_slider.terms import ForceTerm, Law

Floats = NDArray[np.float64]

TINY = 1e-6  # share of a column's power that is none: what rounding leaves of one that is fitted already


def mass_term(declared: float) -> ForceTerm:
    """The candidate that frees the declared mass."""

    def parameters(_: Floats, __: Floats, law: Law) -> dict[str, float]:
        return {"e": law.mass / declared - 1}

    return ForceTerm("rig_mass", (), 1, lambda run, _, __: run.a[:, None], parameters)


@dataclass(frozen=True)
class Scores:
    """Fall of chi-squared by every entry of a dictionary (e,), and the largest on each drawn residual (draws,)."""

    gains: Floats
    drawn: Floats


class Dictionary:
    """The candidates and the numbers that are tried of each; what is refitted whole, like a mass, is not among them.

    Parameters
    ----------
    balance
        Its runs say what can be told.
    """

    def __init__(self, balance: Balance) -> None:
        self.balance = balance
        self.grids = tm.grids(balance.runs)
        self.entries: list[Choice] = []
        self._chunks: list[tuple[ForceTerm, list[Floats]]] = []
        for term in tm.terms():
            if term.name in POSITION_RIPPLES[1:]:  # the same columns, another name
                continue
            insides = [np.array([v]) for v in self.grids[term.scanned[0]]] if term.scanned else [np.zeros(0)]
            width = STEER.at_once // term.amplitudes
            for start in range(0, len(insides), width):
                self._chunks.append((term, insides[start : start + width]))
            self.entries += [Choice(term, one) for one in insides]
        self.names = np.array([one.name for one in self.entries])

    def _white(self, law: Law) -> Iterator[tuple[ForceTerm, Floats]]:
        """White columns (n', m) of some entries after the other."""
        for term, insides in self._chunks:
            if term.many:
                columns = self.balance.columns(term, np.concatenate(insides), law)
            else:
                columns = np.concatenate([self.balance.columns(term, one, law) for one in insides], axis=1)
            yield term, self.balance.whitened(columns)

    def scores(self, fits: Sequence[MotionFit], draws: Floats | None = None) -> list[Scores]:
        """Score every entry beside each of some fits, which share a noise, in its white units.

        Parameters
        ----------
        fits
            What is fitted.
        draws
            More white residuals (n', draws).
        """
        beside = [self._fitted(fit, draws) for fit in fits]
        gains: list[list[Floats]] = [[] for _ in fits]
        for term, white in self._white(fits[0].law):
            power = np.einsum("ij,ij->j", white, white)
            for own, (q, residuals, lightness) in zip(gains, beside, strict=True):
                own.append(_gains(term, white, power, q.T @ white, white.T @ residuals, lightness))
        every = [np.concatenate(own) for own in gains]
        return [
            Scores(one[:, 0], one[:, 1:].max(axis=0) if one.shape[1] > 1 else np.zeros(0)) for one in every
        ]

    def _fitted(self, fit: MotionFit, draws: Floats | None) -> tuple[Floats, Floats, float]:
        """A basis of what is fitted (n', k), residuals (n', 1 + draws) beside it, and 1/mass."""
        y, X = self.balance.design(fit.choices, fit.law)
        rest = y - X @ fit.coefficients
        X = X[:, 1:] if self.balance.held(fit.choices) else X
        q, r = np.linalg.qr(X / np.maximum(np.linalg.norm(X, axis=0), 1e-300))
        q = q[: len(fit.white), np.abs(np.diag(r)) > 1e-8]
        residuals = rest[: len(fit.white), None]
        if draws is not None:
            residuals = np.column_stack([residuals, draws - q @ (q.T @ draws)])
        return q, residuals, float(fit.coefficients[0])


def _gains(
    term: ForceTerm, white: Floats, power: Floats, inside: Floats, p: Floats, lightness: float
) -> Floats:
    """Fall of chi-squared (entries, residuals) from columns (n', m), their powers, what of them is fitted already.

    `p` (m, residuals) are their products with the residuals, `lightness` is 1/mass.
    """
    own = power - np.einsum("ij,ij->j", inside, inside)
    seen = own > TINY * np.maximum(power, 1e-300)
    if term.amplitudes == 1:
        aa = np.where(seen, own, 1.0)[:, None]
        # a step of a term whose coefficient is 1 goes all the way, or not at all
        out = -2 * lightness * p - lightness**2 * aa if term.fixed else p**2 / aa
        return np.asarray(np.where(seen[:, None], out, 0.0))
    a, b = slice(0, None, 2), slice(1, None, 2)
    ab = np.einsum("ij,ij->j", white[:, a], white[:, b]) - np.einsum("ij,ij->j", inside[:, a], inside[:, b])
    aa, bb = own[a], own[b]
    det = aa * bb - ab**2
    sound = (seen[a] & seen[b] & (det > TINY * aa * bb))[:, None]
    safe = np.where(sound[:, 0], det, 1.0)[:, None]
    both = p[a] ** 2 * bb[:, None] - 2 * p[a] * p[b] * ab[:, None] + p[b] ** 2 * aa[:, None]
    return np.asarray(np.where(sound, both / safe, 0.0))


def tried(grids: dict[str, Floats], choices: Sequence[Choice]) -> bool:
    """Whether every scanned number lies within what is tried of it, not at its end: there it would have no bound."""
    for one in choices:
        for name, value in zip(one.term.scanned, one.inside, strict=True):
            if not grids[name].min() < value < grids[name].max():
                return False
    return True
