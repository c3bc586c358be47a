"""The next experiment: for rivals that are tied, how far apart further runs would set them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.result import Experiment, FoundEffect
from stickslip.errors import StickslipError
from stickslip.fitted.data import Data
from stickslip.fitted.readings import Chain, read
from stickslip.simulated.simulate import simulate
from stickslip.simulated.states import HIDDEN, VISIBLE
from stickslip.simulated.trajectory import Trajectory

Floats = NDArray[np.float64]
SUFFICIENT = 15.0
LENGTH, SAMPLES = 60.0, 1200
CHANNELS = 2


def next_experiments(
    fitted: Mapping[frozenset[str], Model],
    chosen: frozenset[str],
    data: Sequence[Data],
    effects: Sequence[FoundEffect],
    free: Sequence[str] = (),
) -> tuple[Experiment, ...]:
    """
    Return a menu of runs ranked by the expected difference in chi-squared between the tied rivals.

    Parameters
    ----------
    fitted : models of the hypotheses that were fitted, by the names of their effects
    chosen : names of the one that was chosen
    data : the train runs
    effects : what was found, with its rivals
    free : numbers of the model that differ from run to run and are fitted anew in each, beside the start
    """
    pairs = [(one.name, other.name) for one in effects for other in one.alternatives if other.tied]
    out: list[Experiment] = []
    for name, other in pairs[:3]:
        rival = fitted.get(frozenset({*chosen - {name}, other}))
        if rival is None:
            continue
        for what, speed, initial in _menu(data):
            gain = _separation(fitted[chosen], rival, data[0].noise[:2], speed, initial, free)
            out.append(Experiment(what, speed, (name, other), gain, gain > SUFFICIENT))
    return tuple(sorted(out, key=lambda one: -one.separability))


def _menu(data: Sequence[Data]) -> list[tuple[str, float, tuple[float, ...]]]:
    speeds = np.abs([run.belt_speed for run in data])
    top, low = float(speeds.max()), float(speeds.min())
    used = {float(np.sign(run.belt_speed)) for run in data}
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
    model: Model,
    rival: Model,
    noise: Floats,
    speed: float,
    initial: tuple[float, ...],
    free: Sequence[str],
) -> float:
    """Squared distance of what sensors would read under the rivals over the noise; start and `free` refitted."""
    t = np.linspace(0.0, LENGTH, SAMPLES)
    names = ("initial.x1", "initial.x2", "initial.y1", "initial.y2", *free)

    def run(of: Model, sensitivity: Sequence[str] = ()) -> Trajectory:
        return simulate(
            of,
            belt_speed=speed,
            initial=initial,
            t_end=LENGTH,
            t_eval=t,
            rtol=1e-7,
            atol=1e-8,
            sensitivity=sensitivity,
        )

    try:
        a, b = run(model, names), run(rival)
    except StickslipError:
        return 0.0
    if not (a.status.ok and b.status.ok):
        return 0.0
    there, here = _readings(b, rival, speed), _readings(a, model, speed)
    d = ((there.values - here.values) / noise).ravel()
    q = np.linalg.qr((here.slopes / noise[:, None]).reshape(len(d), -1))[0]
    d = d - q @ (q.T @ d)
    return float(d @ d)


def _readings(run: Trajectory, model: Model, speed: float) -> Chain:
    """What the sensors of x1 and y1 say of a run, with the slopes that it has."""
    p = model.parameters
    state = np.column_stack([run.state, *(run.hidden[name] for name in HIDDEN)])
    columns = [run.sensitivity[:, i] for i in range(len(VISIBLE))]
    columns += [run.hidden_sensitivity[name] for name in HIDDEN]
    slopes = dict(enumerate(columns))
    return read(run.t, state, slopes, run.sensitivity_names, p, speed, CHANNELS)
