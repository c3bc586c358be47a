"""How much of a drawn effect survives when the declared law is refitted: can it be seen at all?

The readings are predicted in windows of about one cycle from the true states, with and without the effect;
from the difference everything is projected out that the declared law's eight numbers and each window's
initial state can follow (linearised). What is left, in units of the noise, is the gain in log-likelihood any
method could hope for.
"""

from __future__ import annotations

import numpy as np
import rigsim
from draw import TABLE_1, Case, Run, without
from readings import Array, pack, simulate

WINDOW = 300  # samples at most
STEP = 0.02


def _windows(case: Case, run: Run) -> list[tuple[slice, Array, float]]:
    """Window, true state at its start and the beginning of its stick."""
    numbers = pack(case.values | run.phases | {"vb": run.belt_speed})
    times = np.concatenate([[run.since], run.t])
    states, modes, _ = rigsim.run(times, run.start, run.since, STEP, numbers, run.wander)
    changes = np.flatnonzero(np.diff(modes) != 0) + 1
    found = []
    for first in range(0, run.t.size - 50, WINDOW):
        before = changes[changes <= first + 1]
        since = times[before[-1]] if before.size else run.since
        found.append((slice(first, min(first + WINDOW, run.t.size)), states[first + 1].copy(), float(since)))
    return found


def _predict(values: dict[str, float], run: Run, start: Array, cut: slice, since: float) -> Array:
    x, y, _, _ = simulate(
        values | run.phases | {"vb": run.belt_speed}, run.t[cut], start, since=since, h_max=STEP,
        wander=run.wander,
        extrapolate=True,
    )  # fmt: skip
    return np.concatenate([x, y])


def surviving(case: Case) -> tuple[float, float]:
    """Gain ``delta chi-squared`` over the training runs, and the refitted declared model's chi-squared per
    sample.
    """
    plain = without(case.values, [e["name"] for e in case.effects])
    rows, columns = [], []
    for run in case.runs:
        if run.role != "train":
            continue
        for cut, start, since in _windows(case, run):
            nominal = _predict(plain, run, start, cut, since)
            gap = _predict(case.values, run, start, cut, since) - nominal
            local = []
            for i, h in enumerate((1e-5, 1e-5, 1e-5, 1e-5)):
                moved = start.copy()
                moved[i] += h
                local.append((_predict(plain, run, moved, cut, since) - nominal) / h)
            shared = []
            for name in TABLE_1:
                h = 1e-4 * plain[name]
                shared.append(
                    (_predict(plain | {name: plain[name] + h}, run, start, cut, since) - nominal) / h
                )
            weights = 1.0 / (1.0 + 0.3 * np.max(np.abs(gap)) / 0.02)  # far beyond linear: count it less
            nuisance, rest = np.array(local).T, np.column_stack([gap, np.array(shared).T])
            if not (np.all(np.isfinite(nuisance)) and np.all(np.isfinite(rest))):
                continue  # a neighbour of this window's start runs away
            q, _ = np.linalg.qr(nuisance)
            rest = (rest - q @ (q.T @ rest)) * weights / case.noise
            rows.append(rest[:, 0])
            columns.append(rest[:, 1:])
    gap, basis = np.concatenate(rows), np.concatenate(columns)
    left = gap - basis @ np.linalg.lstsq(basis, gap, rcond=None)[0]
    return float(left @ left), 1.0 + float(left @ left) / gap.size
