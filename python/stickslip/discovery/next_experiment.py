"""The next experiment: for rivals that are tied, how far apart further runs would set them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.result import Experiment, FoundEffect
from stickslip.discovery.search import Search, Trial
from stickslip.errors import StickslipError
from stickslip.simulated.simulate import simulate

Floats = NDArray[np.float64]
SUFFICIENT = 15.0
LENGTH, SAMPLES = 60.0, 1200


def next_experiments(search: Search, trial: Trial, effects: Sequence[FoundEffect]) -> tuple[Experiment, ...]:
    """A menu of runs ranked by the expected difference in chi-squared between the tied rivals."""
    pairs = [(one.name, other.name) for one in effects for other in one.alternatives if other.tied]
    out: list[Experiment] = []
    for name, other in pairs[:3]:
        rest = [n for n in trial.names if n != name]
        rival = next((t for key, t in search.tried.items() if set(key) == {*rest, other}), None)
        if rival is None:
            continue
        for what, speed, initial in _menu(search):
            gain = _separation(search, trial, rival, speed, initial)
            out.append(Experiment(what, speed, (name, other), gain, gain > SUFFICIENT))
    return tuple(sorted(out, key=lambda one: -one.separability))


def _menu(search: Search) -> list[tuple[str, float, tuple[float, ...]]]:
    speeds = np.abs([run.belt_speed for run in search.data])
    top, low = float(speeds.max()), float(speeds.min())
    used = {float(np.sign(run.belt_speed)) for run in search.data}
    rest = (0.1, 0.0, 0.0, 0.0)
    menu: list[tuple[str, float, tuple[float, ...]]] = [
        ("a faster belt", 1.6 * top, rest),
        ("a slower belt", 0.5 * low, rest),
        ("free decay on a belt at rest, from a pull of 0.6", 0.0, (0.6, 0.0, 0.1, 0.0)),
        ("the middle speed from a pull against the belt", 0.5 * (top + low), (-0.4, 0.0, 0.2, 0.0)),
        ("slide-hold-slide: the slowest belt, so that rests are long", 0.25 * low, rest),
    ]
    if len(used) == 1:
        sign = -next(iter(used))
        menu.append(("the belt reversed", sign * float(np.median(speeds)), rest))
    return menu


def _separation(
    search: Search, trial: Trial, rival: Trial, speed: float, initial: tuple[float, ...]
) -> float:
    """Squared distance of the rivals' predicted states over the noise, the start refitted (to first order)."""
    t = np.linspace(0.0, LENGTH, SAMPLES)
    names = ("initial.x1", "initial.x2", "initial.y1", "initial.y2")
    try:
        a = simulate(
            trial.hypothesis.model, belt_speed=speed, initial=initial, t_end=LENGTH, t_eval=t, rtol=1e-7,
            atol=1e-8, sensitivity=names,
        )  # fmt: skip
        b = simulate(
            rival.hypothesis.model,
            belt_speed=speed,
            initial=initial,
            t_end=LENGTH,
            t_eval=t,
            rtol=1e-7,
            atol=1e-8,
        )
    except StickslipError:
        return 0.0
    if not (a.status.ok and b.status.ok):
        return 0.0
    noise = search.data[0].noise[:2]
    d = ((b.state - a.state)[:, [0, 2]] / noise).ravel()
    K = (a.sensitivity[:, [0, 2]] / noise[:, None]).reshape(-1, len(names))
    q = np.linalg.qr(K)[0]
    d = d - q @ (q.T @ d)
    return float(d @ d)
