"""What speaks for an effect: gain, gain on windows held out, a wrong effect of equal flexibility, and ties."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from stickslip.discovery.intervals import of_effect
from stickslip.discovery.result import Alternative, Evidence
from stickslip.discovery.search import Search, Trial
from stickslip.discovery.unlisted import called, is_tabulated
from stickslip.fitted.relax import relaxed
from stickslip.fitted.solve import fit

TIED = 8.0  # difference in -2 log likelihood below which two rivals are not told apart

ALGEBRA: Mapping[frozenset[str], str] = {
    frozenset({"sensor_lag", "sensor_delay"}): (
        "without a driven run only the relative lag exists: x1 late by tau reads like y1 early by tau to first order "
        "in tau, so that the shape of a first-order lag alone separates them"
    ),
}


def held_out(null: Trial, trial: Trial) -> float:
    """Root-mean-square residual with the effect over that without, on windows left out of both fits in turn."""
    scores = {id(null): 0.0, id(trial): 0.0}
    for fold in range(2):
        for one in (null, trial):
            scores[id(one)] += _left_out(one, fold)
    return math.sqrt(scores[id(trial)] / max(scores[id(null)], 1e-300))


def _left_out(trial: Trial, fold: int) -> float:
    engine = trial.fit.engine
    windows = trial.fit.windows
    kept = [w for i, w in enumerate(windows) if i % 2 != fold]
    out = [w for i, w in enumerate(windows) if i % 2 == fold]
    found = fit(engine, trial.fit.vector, kept, iterations=6, rounds=0)
    vector = trial.fit.vector if found is None else found.vector
    left = engine.residuals(vector, relaxed(engine, vector, out, 4))
    return sum(
        100.0 * (w.stop - w.start) if r is None else float(r @ r) for w, r in zip(out, left, strict=True)
    )


def evidence(
    search: Search,
    null: Trial,
    trial: Trial,
    name: str,
    tried: Sequence[Trial],
    threshold: float,
    held: float,
) -> Evidence:
    """Evidence for `name` in the chosen trial, against the trial without it."""
    rest = tuple(sorted(n for n in trial.names if n != name))
    without = search.tried.get(rest, null)
    if without.fit.cost > null.fit.cost:  # ended worse than the law that is nested in it
        without = null
    gain, bic = without.fit.cost - trial.fit.cost, without.bic - trial.bic
    done = {t.names for t in tried}
    swapped = [  # another effect in the place of this one, beside the same others
        t
        for t in (*tried, *(t for t in search.screened if t.names not in done))
        if name not in t.names and len(t.names) == len(trial.names) and set(rest) <= set(t.names)
    ]
    readings = trial.fit.readings
    control = min(swapped, key=lambda t: t.cost_of(readings), default=None)
    fall = None if control is None else max(without.fit.cost - control.cost_of(readings), 0.0)
    label = "" if control is None else next((n for n in control.names if n not in rest), "")
    words = f"lowers chi-squared by {gain:.4g} (the gate is {threshold:.3g})"
    if fall is not None:
        words += f"; the best wrong effect, {label}, by {fall:.4g}"
    words += f"; error on windows held out falls to {held:.3g} of what it was"
    return Evidence(gain, bic, held, fall, label, threshold, words)


def alternatives(trial: Trial, tried: Sequence[Trial], name: str) -> tuple[Alternative, ...]:
    """Rivals of `name`, effects or learned curves: all that are tied with it or nearly, with their odds."""
    others = set(trial.names) - {name}
    best: dict[str, Trial] = {}
    for rival in tried:
        new = set(rival.names) - others
        if rival.partial:  # of other readings
            continue
        if (
            len(rival.names) != len(trial.names)
            or not others <= set(rival.names)
            or len(new) != 1
            or name in new
        ):
            continue
        label = next(iter(new))
        if label not in best or rival.bic < best[label].bic:
            best[label] = rival
    near = [(label, one) for label, one in best.items() if one.bic - trial.bic <= 3 * TIED]
    return tuple(
        sorted((_alternative(trial, one, label, name) for label, one in near), key=lambda a: a.delta)
    )


def _alternative(trial: Trial, rival: Trial, label: str, name: str) -> Alternative:
    delta = rival.bic - trial.bic
    algebra = ALGEBRA.get(frozenset({label, name}))
    tied = delta < TIED
    reason = algebra or (
        "fits these runs as well as the winner" if tied else "fits almost as well; the odds are against it"
    )
    odds = math.exp(-0.5 * max(min(delta, 700.0), -700.0))
    curve = is_tabulated(label)
    return Alternative(
        called(label) if curve else label,
        odds,
        delta,
        tied,
        False,
        reason,
        {} if curve else of_effect(rival.fit, label),
        correlation(trial, rival),
    )


def correlation(one: Trial, other: Trial) -> float | None:
    """Between what the two rivals predict differently from the readings' noise: cosine of their residuals."""
    a = np.concatenate([b.r for b in one.fit.blocks])
    b = np.concatenate([c.r for c in other.fit.blocks])
    if len(a) != len(b):
        return None
    return float(a @ b / max(math.sqrt(float(a @ a) * float(b @ b)), 1e-300))
