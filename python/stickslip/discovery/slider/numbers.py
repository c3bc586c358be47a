"""From a chosen candidate to the numbers of its effect, in the effect's own terms, with intervals."""

from __future__ import annotations

import numpy as np

from stickslip.declared.effect import CONSTANTS
from stickslip.discovery.result import Interval
from stickslip.discovery.slider.candidates import waves
from stickslip.discovery.slider.choose import Choice
from stickslip.discovery.slider.weigh import Weighed, columns_of, weigh

Z = 1.96
LATE = 0.1  # of 1/w: the delay given to a belt that droops, too short to matter


def parameters(one: Weighed, choice: Choice) -> dict[str, Interval]:
    """Numbers of a chosen effect in its own terms, with 95 % intervals.

    Intervals of wavelengths and time constants are those over which the likelihood falls by 2; amplitudes are
    common to the runs, their root mean square weighed by what each run says.
    """
    candidate, rig = one.candidate, choice.declared.rig
    theta, std = float(one.theta[0]), float(np.sqrt(one.covariance[0, 0]))
    if candidate.name in CONSTANTS:
        low, value, high = (float(np.expm1(theta + z * std)) for z in (-Z, 0, Z))
        return {"e": Interval(value, low, high)}
    if candidate.per_run:
        return _wave(one, choice)
    level = next(block for block in choice.blocks if block.name == "level")
    force = rig.stiffness * float(np.mean(level.load))
    if candidate.name == "static_aging":
        return {"dT": _interval(force * theta, force * std), "tau": Interval(candidate.scale, None, None)}
    if candidate.name == "contact_compliance":
        soft = [rig.stiffness / np.expm1(max(theta + z * std, 1e-9)) for z in (Z, 0, -Z)]
        return {"k": Interval(float(soft[1]), float(soft[0]), float(soft[2])), "c": Interval(0.0, None, None)}
    if candidate.name == "belt_load_droop":
        late = LATE * float(np.sqrt(rig.mass / rig.stiffness))
        return {"k": _interval(theta, std), "tau": Interval(late, None, None)}
    names = {"sensor_nonlinearity": "q", "sensor_drift": "r", "friction_drift": "r", "spring_cubic_k1": "k"}
    return {names.get(candidate.name, "c"): _interval(theta, std)}


def _interval(value: float, std: float) -> Interval:
    return Interval(value, value - Z * std, value + Z * std)


def _wave(one: Weighed, choice: Choice) -> dict[str, Interval]:
    pairs = one.theta.reshape(-1, 2)
    variance = np.diag(one.covariance).reshape(-1, 2).sum(axis=1)
    seen = variance > 0
    weight = 1 / variance[seen]
    # the square of an amplitude is too large by the variance of its parts
    squares = np.sum(pairs[seen] ** 2, axis=1) - variance[seen]
    a = float(np.sqrt(max(float(weight @ squares / weight.sum()), 0.0)))
    a = a or float(np.sqrt(weight @ np.sum(pairs[seen] ** 2, axis=1) / weight.sum()))
    std = float(np.sqrt(0.5 / weight.sum()))
    force = choice.declared.rig.stiffness if one.candidate.name == "harmonic_forcing" else 1.0
    low, high = _width(one, choice)
    key = "L" if one.candidate.name == "belt_seam" else "w"
    a, std = min(force * a, 0.99 if force == 1.0 else np.inf), force * std
    return {"a": _interval(a, std), key: Interval(one.candidate.scale, low, high)}


def _width(one: Weighed, choice: Choice) -> tuple[float, float]:
    """Where the gain of a wave falls by 4 on either side of its best wavelength."""
    others = columns_of(choice.white, [w.candidate for w in choice.chosen if w is not one])
    best = weigh(choice.white, one.candidate, others)
    limits = []
    for side in (-1, 1):
        at = one.candidate.scale
        for step in np.geomspace(0.002, 0.3, 24):
            at = one.candidate.scale * (1 + side * step)
            trial = weigh(choice.white, waves(choice.blocks, one.candidate.name, at), others)
            if trial is None or best is None or trial.gain < best.gain - 4:
                break
        limits.append(float(at))
    return limits[0], limits[1]
