"""What has no name and comes again and again: a curve in time that repeats, each run at a phase of its own."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated
from stickslip.discovery.hum import humming
from stickslip.discovery.periodic import HIGHEST, TABLE_KNOTS, Line, strongest_line
from stickslip.discovery.rivals import LOGARITHMIC, hypothesis, sought
from stickslip.discovery.search import CLEAN, Search, Trial
from stickslip.discovery.trace import MARGIN, OUTRUN
from stickslip.discovery.unlisted import SPREAD, Term, repeating
from stickslip.discovery.workers import each
from stickslip.fitted.readings import Learned
from stickslip.fitted.unknowns import Unknown

Floats = NDArray[np.float64]
PLACES = ("block", "angle_body", "contact")
FINE = 2 * TABLE_KNOTS
OFF = 1.5  # times that the frequency of a reading's own line may move
NEXT = 0.3  # of the gain of the strongest line: one elsewhere that promises less is not tried


def learn_recurring(search: Search, base: Trial, beat: Trial | None = None) -> list[tuple[Term, Trial]]:
    """Curves that repeat in time, added to `base` where a line shows; closely fitted, best first.

    Where there is a name to `beat` they begin with its law and windows, and are given up where they stall far above it.
    """
    lines = strongest_lines(search, base)
    least = max(cost_of_line(base), NEXT * max(line.gain for line in lines.values()))
    shown = sorted((one for one in lines.items() if one[1].gain > least), key=lambda one: -one[1].gain)
    say_where = lambda one: f"learning what repeats in time: {one[0]}"  # noqa: E731
    learned = [
        task.result() for _, task in each(search, partial(_learned, base=base, beat=beat), shown, say_where)
    ]
    return sorted((one for one in learned if one is not None), key=lambda one: one[1].bic)


def learn_hum(search: Search, base: Trial) -> list[tuple[Term, Trial]]:
    """The same of a reading, where its own line is nearly all that `base` leaves, beside what a force at such a line
    does, best first; none where no reading has one.
    """
    hum = humming(base)
    if hum is None:
        return []
    search.progress(f"learning what repeats in time: {hum[0]}")
    learned = _learned(search, hum, base=base)
    forces = learn_recurring(search, base) if hum[1].w < HIGHEST else []
    return sorted([*([learned] if learned else []), *forces], key=lambda one: one[1].bic)


def cost_of_line(base: Trial) -> float:
    """What a line must gain: the penalty for its frequency and for an amplitude and a phase in each run, and more."""
    return (2 * len(base.fit.engine.data) + 1) * math.log(base.fit.readings) + MARGIN


def strongest_lines(search: Search, base: Trial) -> dict[str, Line]:
    """The strongest line at each place."""
    say = lambda where: f"looking for what repeats in time: {where}"  # noqa: E731
    tasks = partial(each, search, partial(_line_at, base=base), PLACES, say)
    return search.once("lines", base, lambda: {where: task.result() for where, task in tasks()})


def _line_at(_: Search, where: str, *, base: Trial) -> Line:
    return strongest_line(base.fit, where)


def _learned(
    search: Search, one: tuple[str, Line], *, base: Trial, beat: Trial | None = None
) -> tuple[Term, Trial] | None:
    """The sine first, on more knots if that leaves something."""
    where, line = one
    turns = np.linspace(0.0, 1.0, TABLE_KNOTS + 1)
    size = min(float(np.median(np.hypot(*line.amplitudes.T))), 0.5 * SPREAD.get(where, 0.5))
    phases = tuple(float(np.arctan2(b, a)) for a, b in line.amplitudes)
    if beat is not None:
        base = _without(search, base, beat)
    worst = math.inf if beat is None else OUTRUN * beat.fit.cost
    term, trial = _fitted(search, base, where, line.w, size * np.sin(2 * np.pi * turns), phases, worst)
    if trial is None:
        return None
    if trial.fit.cost > worst:
        return term, trial
    trial = search.polish(trial, turns=1)
    if trial.excess < CLEAN or trial.fit.cost > 0.7 * base.fit.cost:
        return term, trial
    curve = trial.model.effects[-1]
    assert isinstance(curve, Tabulated)
    assert curve.period is not None
    values = curve.replace(phi=0.0).curve(np.linspace(0.0, curve.period, FINE + 1))
    phases = trial.hypothesis.phases[f"{term.prefix}.phi"]
    fine, more = _fitted(search, base, where, curve.parameters["w"], values, phases, worst)
    if more is not None:
        more = search.polish(more, turns=1)
    return (term, trial) if more is None or more.bic > trial.bic else (fine, more)


def _without(search: Search, base: Trial, beat: Trial) -> Trial:
    """The base where a name has its law and windows; as it is if that cannot be simulated."""
    law = hypothesis(beat.hypothesis.model, [], search.model)
    return search.run(law, windows_of=beat, iterations=0, rounds=0, anyway=True) or base


def _fitted(
    search: Search, base: Trial, where: str, w: float, values: Floats, phases: tuple[float, ...], worst: float
) -> tuple[Term, Trial | None]:
    """A trial from these values over a turn. The first stays 0: else all phases and the curve could turn together."""
    knots = np.linspace(0.0, 2 * np.pi / w, len(values))
    term = Term(where, "t", tuple(knots.tolist()), recurs=True)
    values = values - values[0]
    values[-1] = values[0]
    h, learned = base.hypothesis, base.fit.engine.learned
    model, of_reading = h.model, where.endswith("channel")
    if of_reading:
        at = tuple(np.linspace(0.0, 1.0, len(values)).tolist())
        learned = (*learned, Learned(where[:2], "t", at, recurs=True))
    else:
        model = model.with_effects([*model.effects, repeating(term, values)])
    bounds = (w / OFF, w * OFF) if of_reading else sought("harmonic_forcing.w")
    unknowns = [
        Unknown(f"{term.prefix}.value_{i}", float(values[i]), False, 0.0, SPREAD.get(where, 0.5))
        for i in range(1, len(values) - 1)
    ]
    unknowns += [
        Unknown(f"{term.prefix}.w", w, True, math.log(w), LOGARITHMIC, bounds=bounds),
        Unknown(f"{term.prefix}.phi", phases[0], False, phases[0], 30.0, per_run=True),
    ]
    h = replace(
        h,
        model=model,
        unknowns=(*h.unknowns, *unknowns),
        phases={**h.phases, f"{term.prefix}.phi": phases},
    )
    return term, search.run(h, windows_of=base, learned=learned, iterations=60, worst=worst)
