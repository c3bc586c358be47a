"""A belt whose speed drifts in time: what looks like a droop under the load, but for the load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import effect
from stickslip.discovery.result import Curve
from stickslip.discovery.rivals import Start, hypothesis, sought
from stickslip.discovery.search import CLEAN, Search, Trial
from stickslip.discovery.unlisted import guess, knots_for
from stickslip.fitted.readings import Learned
from stickslip.fitted.unknowns import without
from stickslip.simulated.states import BELT

Floats = NDArray[np.float64]
DROOP, WAVE = "belt_load_droop", "belt_speed_ripple"
UNLOADED = 0.02  # of what the droop gains: the most that it gains by the load where its speed only drifts
TURNED = 0.5, 1.5  # radians that a slow wave turns in the longest record, to start from
SLOW = 0.1, 10.0  # and the fewest and most that it may
STEEP = 0.9  # of the belt's speed: the most that a wave starts with
KNOTS = 4
STEADY = 0.25  # of the mean: what a share varies by that is one and the same


def drift_of(search: Search) -> tuple[Trial, Curve] | None:
    """A slow wave of the belt's speed, and its drift as a curve; None where no droop was fitted, or it needs the load.

    A droop whose load is taken away leaves each window a belt speed of its own. Where that does as well, the speed
    depends on time. A wave much longer than the record stands for it in the model: unlike the droop it can be forecast.
    """
    droop = search.tried.get((DROOP,))
    free = None if droop is None else _unloaded(search, droop)
    if free is None:
        return None
    search.progress("letting the belt's speed drift")
    t, share = _shares(free)
    waves = [one for turned in TURNED if (one := _wave(search, free, t, share, turned)) is not None]
    if not waves:
        return None
    return min(waves, key=lambda one: one.fit.cost), _curve(t, share)


def steady(curve: Curve, after: Trial) -> bool:
    """Is it the same share of the set-point throughout, and no drift?"""
    middle = float(np.mean(curve.value))
    return after.excess < CLEAN and float(np.ptp(curve.value)) < STEADY * abs(middle)


def told(curve: Curve, after: Trial) -> tuple[str, str]:
    """Why it is a drift, or another speed throughout, and its formula."""
    free = (
        "a belt that droops under its load does no better than one whose speed is free in every window: the load has "
        "no say"
    )
    left = f"a slow wave stands for that in the model, and leaves {after.chi2:.3g}"
    if steady(curve, after):
        share = 1 + float(np.mean(curve.value))
        words = (
            f"{free}, and all windows choose {share:.4g} times the set-points: check the scale of belt_speed, "
            f"or that of x1 and y1 both; {left}"
        )
        return words, f"{share:.4g} v_b throughout"
    formula = "v_b (1 + g): a slow curve in t" + (f", {curve.guess}" if curve.guess else "")
    return f"{free}, and the speed drifts in time; {left}", formula


def _unloaded(search: Search, droop: Trial) -> Trial | None:
    """The droop without the load, its time constant the longest; None where it then loses what it had gained."""
    longest = {f"{DROOP}.k": sought(f"{DROOP}.k")[0], f"{DROOP}.tau": sought(f"{DROOP}.tau")[1]}
    h = droop.hypothesis
    free = replace(h, model=h.model.replace(longest), unknowns=without(h.unknowns, [DROOP]))
    trial = search.run(free, windows_of=droop, tolerance=1e-3, anyway=True)
    gained = search.tried[()].fit.cost - droop.fit.cost
    lost = trial is None or trial.fit.cost - droop.fit.cost > UNLOADED * gained
    return None if lost else trial


def _shares(free: Trial) -> tuple[Floats, Floats]:
    """Time and belt speed over the set-point, less 1, in the middle of each window of an unloaded droop."""
    fit, tau = free.fit, sought(f"{DROOP}.tau")[1]
    at, off = [], []
    for w in fit.windows:
        run = fit.engine.data[w.run]
        half = 0.5 * float(run.t[w.stop - 1] - run.t[w.start])
        at.append(float(run.t[w.start]) + half)
        off.append(float(w.state[BELT]) * np.exp(-half / tau) / run.belt_speed)
    return np.array(at), np.array(off)


def _wave(search: Search, free: Trial, t: Floats, share: Floats, turned: float) -> Trial | None:
    runs = free.fit.engine.data
    longest = max(float(run.t[-1]) for run in runs)
    w = turned / longest
    a = float(np.clip((t @ share) / (t @ t) / w, -STEEP, STEEP))
    start = Start(effect(WAVE, a=a, w=w, phi=0.0), (0.0,) * len(runs))
    h = hypothesis(free.hypothesis.model, [start], search.model)
    low, high = (turns / longest for turns in SLOW)
    slow = tuple(replace(u, bounds=(low, high)) if u.name == f"{WAVE}.w" else u for u in h.unknowns)
    trial = search.run(replace(h, unknowns=slow), windows_of=free, anyway=True)
    return None if trial is None else search.close(trial)


def _curve(t: Floats, share: Floats) -> Curve:
    """The drift through all windows' shares, with its 95 % band from their scatter."""
    shape = Learned("belt", "t", knots_for(t, KNOTS))
    basis = shape.basis(t)
    values, *_ = np.linalg.lstsq(basis, share, rcond=None)
    scatter = float(np.sum((share - basis @ values) ** 2)) / max(len(t) - basis.shape[1], 1)
    x = np.linspace(t.min(), t.max(), 101)
    at = shape.basis(x)
    covariance = scatter * np.linalg.pinv(basis.T @ basis)
    half = 1.96 * np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", at, covariance, at), 0.0))
    middle = at @ values
    words = guess(x, middle, np.maximum(half, 1e-12), "t")
    return Curve(
        "belt", "t", "belt speed over its set-point, less 1", x, middle, middle - half, middle + half,
        np.array(shape.knots), words,
    )  # fmt: skip
