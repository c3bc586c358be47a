"""A laboratory's imperfections: friction that scatters, a belt that wobbles, constants and gains that are nearly right.

None of them is an effect. Friction is a random field along the belt: smooth, or with steps that stay for one event
and a little longer, so that static and kinetic level change together from event to event.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP = 0.02  # of the field's samples, in the displacement of (2.1)
BEFORE = 60.0  # way along the belt before a record begins
STATED = ("alpha1", "alpha2", "beta3")  # masses and stiffnesses; the dampings are eta1, eta12


@dataclass(frozen=True)
class Imperfections:
    """
    What one case has.

    Attributes
    ----------
    scatter : relative standard deviation of friction
    smooth : whether the field is smooth, with `length`; else it has steps that long
    length : correlation length along the belt
    belt : relative standard deviation of the belt's speed
    constants : declared over true number of the rig
    time : declared over true omega of a rig in SI, whose mass and springs say what it is
    gains : of the two sensors
    bits : of the converter over 1.5 times the range
    glitches : share of readings that are elsewhere
    """

    scatter: float
    smooth: bool
    length: float
    belt: float
    constants: Mapping[str, float]
    time: float
    gains: tuple[float, float]
    bits: int
    glitches: float

    def told(self) -> dict[str, Any]:
        """Return it for answers.json."""
        return asdict(self)


def draw(rng: np.random.Generator, size: float) -> Imperfections:
    """Return imperfections of the usual sizes, times `size`."""
    masses, dampings = rng.uniform(0.003, 0.015) * size, rng.uniform(0.05, 0.15) * size
    constants = {name: float(1 + masses * rng.standard_normal()) for name in STATED}
    constants |= {name: float(1 + dampings * rng.standard_normal()) for name in ("eta1", "eta12")}
    # of numbers that are drawn already, so that a seed's cases stay what they were
    own = np.random.default_rng([int(1e9 * one) for one in constants.values()])
    time = float(1 + 0.7 * masses * own.standard_normal())  # omega^2 = (k1 + k2)/m
    gain = rng.uniform(0.002, 0.005) * size
    smooth = bool(rng.random() < 0.5)
    return Imperfections(
        scatter=float(rng.uniform(0.01, 0.04) * size),
        smooth=smooth,
        length=float(np.exp(rng.uniform(*np.log((0.1, 1.0) if smooth else (0.5, 1.5))))),
        belt=float(rng.uniform(0.002, 0.008) * size),
        constants=constants,
        time=time,
        gains=(float(1 + gain * rng.standard_normal()), float(1 + gain * rng.standard_normal())),
        bits=int(rng.choice([12, 14, 16])),
        glitches=float(rng.choice([0.0, 0.0005])),
    )


def field(rng: np.random.Generator, way: float, what: Imperfections) -> Array:
    """Return friction's relative change along the belt, a number every `STEP`, of unit variance."""
    count = int((way + 2 * BEFORE) / STEP) + 8
    if not what.smooth:
        ends = np.cumsum(rng.uniform(0.6, 1.4, 4 + int(count * STEP / (0.6 * what.length))) * what.length)
        levels = rng.standard_normal(len(ends) + 1)
        for i in range(1, len(levels)):  # one event tells a little of the next
            levels[i] = 0.4 * levels[i - 1] + 0.917 * levels[i]
        return np.asarray(levels[np.searchsorted(ends, np.arange(count) * STEP)])
    x = np.arange(-4 * what.length, 4 * what.length + STEP, STEP)
    kernel = np.exp(-((x / what.length) ** 2))
    made = np.convolve(rng.standard_normal(count + len(kernel) - 1), kernel, mode="valid")
    return np.asarray(made / np.sqrt(np.sum(kernel**2)))


def numbers(rng: np.random.Generator, what: Imperfections) -> dict[str, float]:
    """Return the simulator's numbers of one run."""
    return {
        "field_a": what.scatter,
        "wobble_a": what.belt * np.sqrt(2.0 / 3.0),
        "wobble_w": float(rng.uniform(0.2, 0.7)),
        "wobble_phi": float(rng.uniform(0, 2 * np.pi)),
    }


def as_read(
    rng: np.random.Generator, readings: Array, gain: float, noise: float, what: Imperfections
) -> Array:
    """Return noisy readings as the sensor's gain, its glitches and the converter make them."""
    out = gain * readings
    hit = rng.random(out.size) < what.glitches
    out[hit] += rng.choice([-1, 1], hit.sum()) * rng.uniform(10, 60, hit.sum()) * noise
    step = 1.5 * float(np.ptp(readings)) / 2**what.bits
    return np.asarray(step * np.round(out / step))
