"""Where something acts that neither a name nor a curve describes, and on what: by what each place promises."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from stickslip.discovery.recurring import PLACES, cost_of_line, line_at
from stickslip.discovery.search import Search, Trial
from stickslip.discovery.trace import MARGIN
from stickslip.discovery.unlisted import Term, scored, sensitivity, terms
from stickslip.discovery.workers import each

REPEATS = 0.6  # of what a number for every window promises: where a line promises more, it repeats


@dataclass(frozen=True)
class Promises:
    """Fall of chi-squared promised to first order, less the price of the numbers: by curves (greatest first), by lines
    (their price not taken off), and by a number for every window.
    """

    curves: list[tuple[float, Term]]
    lines: dict[str, float]
    windows: dict[str, float]

    @property
    def wandering(self) -> str | None:
        """Where something acts that differs from window to window rather than with the state or a phase, if it does.

        A number for every window, at one place, promises more than any curve, and clearly more than any line.
        """
        where = max(self.windows, key=lambda place: self.windows[place])
        most = self.windows[where]
        surpassed = most < max(MARGIN, self.curves[0][0]) or REPEATS * most < max(self.lines.values())
        return None if surpassed else where


def promises(search: Search, null: Trial) -> Promises:
    """What each place promises beside the declared law."""
    penalty = math.log(null.fit.readings)
    every = list(terms(null))
    curves = [
        (task.result() - len(term.knots) * penalty, term)
        for term, task in each(search, partial(scored, base=null), every)
    ]
    lines = {where: task.result().gain for where, task in each(search, partial(line_at, base=null), PLACES)}
    in_time = [term for term in every if term.variable == "t"]
    windows = {
        term.where: task.result() - len(null.fit.windows) * penalty
        for term, task in each(search, partial(_loosened, base=null), in_time)
    }
    return Promises(sorted(curves, key=lambda one: -one[0]), lines, windows)


def place_of(search: Search, null: Trial, best: Trial) -> tuple[str, tuple[str, ...]] | None:
    """Where an effect that nothing here describes most likely acts, and on what; None where it does not show."""
    promised = promises(search, null)
    if promised.wandering is not None:
        return promised.wandering, ("t",)
    if best.names == ("harmonic_forcing",):  # a sharp line, and yet no force on the block
        return "angle_body", ("t",)
    most, term = promised.curves[0]
    line, where = max((promised.lines[where], where) for where in ("angle_body", "contact"))
    if line - cost_of_line(null) + MARGIN > max(most, MARGIN):
        return where, ("t",)
    return (term.where, (term.variable,)) if most > MARGIN else None


def _loosened(_: Search, term: Term, *, base: Trial) -> float:
    """Fall of chi-squared that a constant of each window's own promises where the term acts, the base refitted."""
    fit, p = base.fit, len(base.fit.vector)
    A, g, left = np.stack([np.diag(fit.engine.precision)] * 2), np.zeros((2, p)), np.zeros(2)
    for w, b, knots in zip(fit.windows, fit.blocks, sensitivity(base, term), strict=True):
        if knots is None:
            continue
        J = np.zeros((len(b.r), p))
        J[:, fit.engine.columns[w.run]] = b.J
        size = 0.0
        # a curve's knots together are a constant
        for i, own in enumerate((b.K, np.column_stack([b.K, knots.sum(axis=1)]))):
            q = np.linalg.qr(own)[0]
            D, r = J - q @ (q.T @ J), b.r - q @ (q.T @ b.r)
            size = size or max(1.0, float(r @ r) / len(r))  # bad windows are held back
            A[i] += D.T @ D / size
            g[i] += D.T @ r / size
            left[i] += float(r @ r) / size
    before, after = (left[i] - g[i] @ np.linalg.lstsq(A[i], g[i], rcond=1e-12)[0] for i in range(2))
    return float(before - after)
