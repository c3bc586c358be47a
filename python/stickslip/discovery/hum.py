"""A line in a reading itself: what a sensor picks up beside the motion, as from the mains."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.discovery.periodic import Line
from stickslip.discovery.residual import by_run
from stickslip.discovery.search import CLEAN, Trial

Floats = NDArray[np.float64]
NEARLY_ALL = 0.8  # of chi-squared above the noise, that a line in one reading takes up where it is that
FINE = 4.0  # frequencies to the width of a line
CLOSER = 8  # grid of times, finer than the sampling, that uneven samples are put on
LOWEST = 2.0  # turns in the longest run


def humming(null: Trial) -> tuple[str, Line] | None:
    """The channel in whose residual one frequency, at an amplitude and a phase of its own in each run, is nearly all
    that is left above the noise, and its line; None if there is none. Up to half the sampling rate, far above what
    moves the rig: the residual itself is looked at, not what the model makes of a force.
    """
    if null.excess < CLEAN:
        return None
    residuals, channels = by_run(null.fit), null.fit.engine.data[0].channels[:2]
    lines = [_line(null, residuals, c) for c in range(len(channels))]
    line, channel = max(zip(lines, channels, strict=True), key=lambda one: one[0].gain)
    over = null.fit.cost - null.fit.readings
    return (f"{channel} channel", line) if line.gain > NEARLY_ALL * over else None


def _line(null: Trial, residuals: list[Floats], channel: int) -> Line:
    """The strongest line of a channel; its amplitudes are in units of its reading."""
    data = null.fit.engine.data
    step = float(np.median([np.median(np.diff(run.t)) for run in data])) / CLOSER
    longest = max(float(run.t[-1]) for run in data)
    size = scipy.fft.next_fast_len(int(FINE * longest / step), real=True)
    waves = np.zeros((len(data), size // 2 + 1), dtype=np.complex128)
    used = np.ones(len(data))
    for k, (run, r) in enumerate(zip(data, residuals, strict=True)):
        good = np.isfinite(r[:, channel])
        comb = np.bincount(np.round(run.t[good] / step).astype(np.int64), r[good, channel])
        used[k] = max(int(good.sum()), 1)
        waves[k] = scipy.fft.rfft(comb, size)
    gain = (2 * np.abs(waves) ** 2 / used[:, None]).sum(axis=0)
    turns = np.arange(len(gain)) / (size * step)
    gain[(turns < LOWEST / longest) | (turns > 0.5 / (CLOSER * step))] = 0.0
    best = int(np.argmax(gain))
    wave = 2 * waves[:, best] / used * np.array([run.noise[channel] for run in data])
    return Line(float(gain[best]), float(2 * np.pi * turns[best]), np.stack([-wave.imag, wave.real], 1))
