"""Every candidate at every number tried, ready to be scored against a residual, or against drawn noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import POSITION_RIPPLES
from stickslip.discovery.driven_slider import terms as tm
from stickslip.discovery.driven_slider.fit import Balance, Choice
from stickslip.discovery.driven_slider.terms import Law, Term

Floats = NDArray[np.float64]
Single = NDArray[np.float32]

CHUNK = 128  # candidates computed at once
TINY = 1e-6  # share of a column's power that must be new beside what is fitted


@dataclass(frozen=True)
class Entry:
    """A candidate at some scanned numbers, and its first column in the dictionary."""

    choice: Choice
    first: int
    width: int


def mass_term(declared: float) -> Term:
    """The candidate that frees the declared mass."""

    def parameters(_: Floats, __: Floats, law: Law) -> dict[str, float]:
        return {"e": law.mass / declared - 1}

    return Term("rig_mass", (), 1, lambda run, _, __: run.a[:, None], parameters)


class Dictionary:
    """Columns of all candidates, filtered.

    Parameters
    ----------
    balance
        Its runs and band.
    law
        The friction with which candidates that scale with it are computed.
    """

    def __init__(self, balance: Balance, law: Law) -> None:
        self.balance = balance
        self.low_passes = [balance.band.matrix(len(run.t)) for run in balance.runs]
        grids = tm.grids(balance.runs, balance.band.cutoff)
        self.entries: list[Entry] = []
        blocks: list[Single] = []
        at = 0
        for term in (mass_term(balance.mass), *tm.terms()):
            if term.name in POSITION_RIPPLES[1:]:
                continue
            insides = [np.zeros(0)] if not term.scanned else [np.array([v]) for v in grids[term.scanned[0]]]
            for start in range(0, len(insides), CHUNK):
                part = insides[start : start + CHUNK]
                blocks.append(self._block(term, part, law))
                for inside in part:
                    self.entries.append(Entry(Choice(term, inside), at, term.amplitudes))
                    at += term.amplitudes
        for again in (
            one for one in tm.terms() if one.name in POSITION_RIPPLES[1:]
        ):  # the same columns, another name
            same = [one for one in self.entries if one.choice.name == POSITION_RIPPLES[0]]
            self.entries += [Entry(Choice(again, one.choice.inside), one.first, one.width) for one in same]
        self.filtered: Single = np.concatenate(blocks, axis=1)
        self.white: Single = self.filtered
        first = np.array([one.first for one in self.entries], dtype=np.intp)
        self.one = np.array([one.width == 1 for one in self.entries])
        self.fixed = np.array([one.choice.term.fixed for one in self.entries])
        self.a: NDArray[np.intp] = first
        self.b: NDArray[np.intp] = first + ~self.one
        self.families = sorted({one.choice.name for one in self.entries})
        self.family = np.array([self.families.index(one.choice.name) for one in self.entries])

    def _block(self, term: Term, insides: Sequence[Floats], law: Law) -> Single:
        rows = []
        for run, low_pass in zip(self.balance.runs, self.low_passes, strict=True):
            if term.many:
                columns = term.columns(run, np.concatenate(insides), law)
            else:
                columns = np.concatenate([term.columns(run, one, law) for one in insides], axis=1)
            rows.append(low_pass @ columns.astype(np.float32))
        return np.asarray(np.concatenate(rows), dtype=np.float32)

    def whiten(self) -> None:
        """Take the colour of the balance's noise out of every column."""
        self.white = self.balance.noise.matrix(self.balance.lengths).astype(np.float32) @ self.filtered

    def scorer(self, fitted: Floats) -> Scorer:
        """Prepare to score residuals of a fit whose whitened columns are `fitted` (n', k)."""
        q, r = np.linalg.qr(fitted / np.maximum(np.linalg.norm(fitted, axis=0), 1e-300))
        q = q[:, np.abs(np.diag(r)) > 1e-8]
        return Scorer(self, q.astype(np.float32))


class Scorer:
    """How much each entry would lower chi-squared beside what is fitted already."""

    def __init__(self, dictionary: Dictionary, q: Single) -> None:
        self.of = dictionary
        d, c = dictionary, dictionary.white
        self.power = np.einsum("ij,ij->j", c, c).astype(np.float64)
        self.own = self.power.copy()
        cross = np.einsum("ij,ij->j", c[:, d.a], c[:, d.b]).astype(np.float64)
        self.cross = np.where(d.one, 0.0, cross)
        self.q = q[:, :0]
        self._take_out(q)

    def add(self, columns: Floats) -> None:
        """Count whitened columns (n', k) among what is fitted."""
        new = columns - self.q @ (self.q.T @ columns)
        new /= np.maximum(np.linalg.norm(new, axis=0), 1e-300)
        self._take_out(np.linalg.qr(new)[0].astype(np.float32))

    def _take_out(self, q: Single) -> None:
        d = self.of
        inside = (q.T @ d.white).astype(np.float64)
        self.own -= np.einsum("ij,ij->j", inside, inside)
        self.cross -= np.where(d.one, 0.0, np.einsum("ij,ij->j", inside[:, d.a], inside[:, d.b]))
        self.q = np.concatenate([self.q, q], axis=1)
        self.seen = self.own > TINY * np.maximum(self.power, 1e-300)

    def gains(self, white: Floats) -> Floats:
        """Fall of chi-squared by every entry (e,), or (e, draws) for several residuals (n', draws)."""
        d = self.of
        w = white.astype(np.float32)
        w = w - self.q @ (self.q.T @ w)
        p = (d.white.T @ w).astype(np.float64)
        shape = (-1,) + (1,) * (p.ndim - 1)
        aa, bb = self.own[d.a].reshape(shape), self.own[d.b].reshape(shape)
        ab, pa, pb = self.cross.reshape(shape), p[d.a], p[d.b]
        ok_a, ok_b = self.seen[d.a].reshape(shape), self.seen[d.b].reshape(shape)
        single = np.where(ok_a, pa**2 / np.maximum(aa, 1e-30), 0.0)
        det = aa * bb - ab**2
        sound = ok_a & ok_b & (det > 1e-6 * aa * bb)
        double = np.where(
            sound, (pa**2 * bb - 2 * pa * pb * ab + pb**2 * aa) / np.where(sound, det, 1.0), single
        )
        whole = 2 * pa - aa
        one, fixed = d.one.reshape(shape), d.fixed.reshape(shape)
        return np.asarray(np.where(fixed, np.where(ok_a, whole, 0.0), np.where(one, single, double)))
