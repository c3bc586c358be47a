"""Starts for a ripple of the belt, read where the block rides on it: a periodogram over the sticks.

In a stick x1 = c_j + v_b t - (v_b a/w) cos(w t + phi), with a constant c_j for each stick, and a slope and a curvature,
for drifts and bent sensors would outshine a ripple in the low frequencies; a recorded belt reads
v_b (1 + a sin(w t + phi)) itself. The amplitudes are fitted at every frequency at once, these projected out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import effect
from stickslip.discovery.rivals import Start
from stickslip.fitted.data import Data, read_again
from stickslip.fitted.solve import Fit
from stickslip.measured.sticks import rides

Floats = NDArray[np.float64]
AT_ONCE = 4_000_000  # sines of samples and frequencies at once: 32 MB


def ripple_starts(
    data: Sequence[Data], *, peaks: int = 2, lowest: float = 0.6, highest: float = 16.0
) -> list[Start]:
    """The `peaks` strongest ripples, each with its phases by run; none where no stick is long enough."""
    span = max(float(run.t[-1]) for run in data)
    w = np.arange(lowest, highest, 0.7 / span)
    parts = [_belt_lines(run, w) if "belt" in run.channels else _stick_lines(run, w) for run in data]
    gain = np.sum([p[0] for p in parts], axis=0)
    starts: list[Start] = []
    used: list[float] = []
    for i in np.argsort(-gain):
        if len(starts) == peaks or gain[i] <= 0:
            break
        if any(abs(w[i] - other) < 0.3 for other in used):
            continue
        used.append(float(w[i]))
        amplitudes = [
            p[1][:, i] / run.belt_speed for p, run in zip(parts, data, strict=True) if run.belt_speed
        ]
        size = float(np.median([np.hypot(*a) for a in amplitudes]))
        phases = tuple(float(np.arctan2(p[1][1, i] * s, p[1][0, i] * s)) for p, s in _signs(parts, data))
        starts.append(Start(effect("belt_speed_ripple", a=min(size, 0.5), w=float(w[i]), phi=0.0), phases))
    return starts


def freed_of_sensor(fit: Fit) -> list[Data]:
    """The runs with what the fit's sensor does to x1 taken out of its readings; without weight outside the windows."""
    engine = fit.engine
    done = engine.simulate(fit.vector, fit.windows)
    readings = [run.readings.copy() for run in engine.data]
    weights = [np.zeros_like(run.weight) for run in engine.data]
    for i, (w, b) in enumerate(zip(fit.windows, fit.blocks, strict=True)):
        rows, weight = slice(w.start, w.stop), engine.data[w.run].weight[w.start : w.stop]
        if not done.ok[i]:
            continue
        off = b.r.reshape(weight.shape)[:, 0] / np.where(weight[:, 0] > 0, weight[:, 0], np.inf)
        readings[w.run][rows, 0] = done.state[done.of(i), 0] + off
        weights[w.run][rows] = weight
    return [
        replace(read_again(run, one), weight=weight)
        for run, one, weight in zip(engine.data, readings, weights, strict=True)
    ]


def _signs(
    parts: list[tuple[Floats, Floats]], data: Sequence[Data]
) -> list[tuple[tuple[Floats, Floats], float]]:
    return [(p, float(np.sign(run.belt_speed)) or 1.0) for p, run in zip(parts, data, strict=True)]


def _belt_lines(run: Data, w: Floats) -> tuple[Floats, Floats]:
    """Gain (k,) and amplitudes (2, k) of sin and cos in the recorded belt speed."""
    value = run.readings[:, 2] - run.belt_speed
    good = run.weight[:, 2] > 0
    label = np.zeros(int(good.sum()), dtype=np.int64)
    return _lines(
        run.t[good], value[good] / run.noise[2], label, w, run.noise[2], np.ones_like(w), swap=False
    )


def _stick_lines(run: Data, w: Floats) -> tuple[Floats, Floats]:
    """The same from the displacement in sticks; amplitudes are turned into those of the speed."""
    stick = rides(run.v, run.belt_speed)
    stick &= run.weight[:, 0] > 0
    label = np.cumsum(np.diff(stick.astype(np.int8), prepend=0) == 1)
    keep = stick.copy()
    for k in np.unique(label[stick]):
        at = np.flatnonzero(stick & (label == k))
        edge = max(2, int(0.25 / float(np.median(np.diff(run.t)))))
        keep[at[:edge]] = keep[at[-edge:]] = False
    if keep.sum() < 30:
        return np.zeros_like(w), np.zeros((2, len(w)))
    value = (run.readings[keep, 0] - run.belt_speed * run.t[keep]) / run.noise[0]
    return _lines(run.t[keep], value, label[keep], w, run.noise[0], w, swap=True)


def _lines(
    t: Floats,
    value: Floats,
    label: NDArray[np.int64],
    w: Floats,
    noise: float,
    rate: Floats,
    *,
    swap: bool,
) -> tuple[Floats, Floats]:
    slow = []  # what is projected out of each stick
    for k in np.unique(label):
        part = np.flatnonzero(label == k)
        slow.append((part, np.linalg.qr(np.vander(t[part] - t[part].mean(), 3 if swap else 1))[0]))
        value[part] -= slow[-1][1] @ (slow[-1][1].T @ value[part])
    gain, amplitudes = np.empty(len(w)), np.empty((2, len(w)))
    wide = max(AT_ONCE // max(len(t), 1), 1)
    for first in range(
        0, len(w), wide
    ):  # sines of all frequencies at once would be as many as samples squared
        some = slice(first, first + wide)
        gain[some], amplitudes[:, some] = _fitted(t, value, slow, w[some], swap)
    return gain, amplitudes * noise * rate


def _fitted(
    t: Floats, value: Floats, slow: Sequence[tuple[NDArray[np.intp], Floats]], w: Floats, swap: bool
) -> tuple[Floats, Floats]:
    """Gain and amplitudes at some frequencies, what is slow projected out."""
    sine, cosine = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    for part, q in slow:
        for x in (sine, cosine):
            x[part] -= q @ (q.T @ x[part])
    ss, cc, sc = (sine**2).sum(0), (cosine**2).sum(0), (sine * cosine).sum(0)
    bs, bc = value @ sine, value @ cosine
    det = ss * cc - sc**2 + 1e-6 * (ss + cc) ** 2 + 1e-12
    s, c = (cc * bs - sc * bc) / det, (ss * bc - sc * bs) / det
    # displacement -(V/w) cos(w t + phi) to speed V sin(w t + phi)
    amplitudes = np.stack([-c, s]) if swap else np.stack([s, c])
    return s * bs + c * bc, amplitudes
