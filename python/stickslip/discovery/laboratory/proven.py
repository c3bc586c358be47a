"""A curve that was scored, with all else fitted beside it: what it gains is proven there.

A score is of first order. Along what is all but free (a load and the level of a law) it steps far; friction that is
larger makes the same scatter a smaller share of it, and linear windows take that for a gain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.laboratory.hypothesis import Bench, Term
from stickslip.discovery.laboratory.learned import Learned
from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.fit_state import Fit

Floats = NDArray[np.float64]


def beside(bench: Bench, fit: Fit, terms: Sequence[Term], curve: Learned) -> Fit:
    """
    Return a hypothesis fitted with a curve in the model as it was scored.

    One of friction or of the belt is there as what is known of each event. The fit begins with the motions that it had:
    what the curve adds is taken out of the windows' own. Of another curve, what it adds is taken out of the readings.

    Parameters
    ----------
    bench, fit, terms : the hypothesis that it stands beside
    curve : as scored
    """
    if curve.events is None:
        windows = replace(bench, data=_less(bench, curve)).windows(terms)
        return fitted(replace(fit, windows=windows), bench.policy, bench.policy.candidate_steps, held=2)
    windows, own = bench.windows(terms), fit.own.copy()
    assert isinstance(windows, BeltWindows)
    nothing = np.zeros(windows.effects)
    windows.added = np.array([nothing if one is None else one for one in curve.events])
    own[:, windows.begins :] -= windows.added
    start = replace(fit, windows=windows, own=own)
    return fitted(start, bench.policy, bench.policy.candidate_steps, held=2)


def _less(bench: Bench, curve: Learned) -> list[Data]:
    """The runs without what a curve adds to them."""
    readings = [run.readings.copy() for run in bench.data]
    for s, columns in zip(bench.stretches, curve.columns, strict=True):
        if columns is not None:
            run = bench.data[s.run]
            weight = run.weight[s.start : s.stop]
            added = np.divide(columns @ curve.size, weight, out=np.zeros_like(weight), where=weight > 0)
            readings[s.run][s.start : s.stop] -= added
    return [replace(run, readings=one) for run, one in zip(bench.data, readings, strict=True)]
