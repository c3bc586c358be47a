"""A line in a reading itself: what a sensor picks up beside the motion, as from the mains."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.left import Left
from stickslip.discovery.residual import LIMIT, by_run, left_over

Floats = NDArray[np.float64]
NEARLY_ALL = 0.8  # of chi-squared above the noise, that a line in one reading takes up where it is that
FINE = 4.0  # frequencies to the width of a line
CLOSER = 8  # grid of times, finer than the sampling, that uneven samples are put on
LOWEST = 2.0  # turns in the longest run
KNOTS = 17  # of a turn, as it is told


@dataclass(frozen=True)
class Line:
    """
    A sine in a channel.

    Parameters
    ----------
    gain : fall of chi-squared
    w : angular frequency
    amplitudes : (runs, 2) of sine and cosine, in the unit of the reading
    """

    gain: float
    w: float
    amplitudes: Floats


def humming(left: Left) -> ScoredCurve | None:
    """
    Return the hum of a channel: one frequency, at an amplitude and a phase of its own in each run.

    None where that is not nearly all that is left above the noise. It is sought up to half the sampling rate, far above
    what moves the rig: the residual itself is looked at, not what the model makes of a force.

    Parameters
    ----------
    left : what a fit leaves
    """
    if left_over(left) < LIMIT:
        return None
    residuals, channels = by_run(left), left.engine.data[0].channels[:2]
    lines = [_line(left, residuals, c) for c in range(len(channels))]
    c = int(np.argmax([one.gain for one in lines]))
    line, over = lines[c], left.chi2 - (left.readings - left.dof)
    if line.gain < NEARLY_ALL * over:
        return None
    own = np.concatenate([r[:, c] for r in residuals])
    power, count = float(np.nansum(own**2)), int(np.isfinite(own).sum())
    gain = count * math.log(power / max(power - line.gain, 1e-9 * power))  # of a noise that is estimated
    size = float(np.median(np.hypot(*line.amplitudes.T)))
    std = float(np.median([run.noise[c] for run in left.engine.data])) * math.sqrt(2 / count)
    x = np.linspace(0.0, 2 * math.pi / line.w, KNOTS)
    numbers = 2 * len(left.engine.data) + 1
    value, spread = size * np.sin(line.w * x), np.full(KNOTS, std)
    return ScoredCurve(
        f"{channels[c]} channel", "t", gain, x, value, spread, numbers, (), period=float(x[-1])
    )


def _line(left: Left, residuals: list[Floats], channel: int) -> Line:
    """The strongest line of a channel."""
    data = left.engine.data
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
