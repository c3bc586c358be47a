"""Where something acts that neither a name nor a curve describes, and on what: by what each place promises."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from stickslip.discovery.recurring import cost_of_line, learn_hum, strongest_lines
from stickslip.discovery.residual import by_run
from stickslip.discovery.search import Search, Trial
from stickslip.discovery.trace import MARGIN
from stickslip.discovery.unlisted import Term, gain_by_window, scores, terms
from stickslip.discovery.workers import each

REPEATS = 0.6  # of what a number for every window promises: where a line promises more, it repeats
FAR_TOO_MUCH = 0.3  # of chi-squared above 1, for nothing to be missing


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
    return search.once("promises", null, lambda: _promises(search, null))


def _promises(search: Search, null: Trial) -> Promises:
    penalty = math.log(null.fit.readings)
    curves = [(gain - len(term.knots) * penalty, term) for gain, term in scores(search, null)]
    lines = {where: line.gain for where, line in strongest_lines(search, null).items()}
    in_time = [term for term in terms(null) if term.variable == "t"]
    windows = {
        term.where: task.result() - len(null.fit.windows) * penalty
        for term, task in each(search, partial(_by_window, base=null), in_time)
    }
    return Promises(sorted(curves, key=lambda one: -one[0]), lines, windows)


def place_of(search: Search, null: Trial, best: Trial) -> tuple[str, tuple[str, ...]] | None:
    """Where an effect that nothing here describes most likely acts, and on what; None where it does not show."""
    if lines := learn_hum(search, null):
        return lines[0][0].where, ("t",)
    promised = promises(search, null)
    if promised.wandering is not None:
        return promised.wandering, ("t",)
    if best.names == ("harmonic_forcing",):  # a sharp line, and yet no force on the block
        return "angle_body", ("t",)
    most, term = promised.curves[0]
    line, where = max((promised.lines[where], where) for where in ("angle_body", "contact"))
    if line - cost_of_line(null) + MARGIN > max(most, MARGIN):
        return where, ("t",)
    return (term.where, (term.variable,)) if most > MARGIN else _noisy(null)


def _noisy(null: Trial) -> tuple[str, tuple[str, ...]] | None:
    """The reading that what is left is in, where that is far too much to be nothing though no motion is like it."""
    if null.chi2 - 1 < FAR_TOO_MUCH:
        return None
    sizes = [
        np.nanmean(np.square(np.concatenate(one)))
        for one in zip(*(r.T for r in by_run(null.fit)), strict=True)
    ]
    return f"{null.fit.engine.data[0].channels[int(np.argmax(sizes[:2]))]} channel", ("t",)


def _by_window(_: Search, term: Term, *, base: Trial) -> float:
    return gain_by_window(base, term)
