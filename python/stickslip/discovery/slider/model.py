"""From what was chosen to complete models: the law of the mean event, the effects with their numbers and intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import CONSTANTS, Effect, effect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.discovery.result import Interval
from stickslip.discovery.slider.choose import Choice
from stickslip.discovery.slider.held import constants_of
from stickslip.discovery.slider.population import Block
from stickslip.discovery.slider.weigh import Weighed, columns_of, weigh
from stickslip.errors import InputError
from stickslip.fitted.block_events.cycle import S
from stickslip.fitted.block_events.levels import carried, number_of, sliding
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.block_events.table import Measured
from stickslip.fitted.identify import identify
from stickslip.fitted.scatter import block_bootstrap
from stickslip.measured.case import Case

Floats = NDArray[np.float64]
Law = Mapping[str, Interval]
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
    from stickslip.discovery.slider.candidates import waves

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


def phases(one: Weighed, runs: Sequence[Measured]) -> dict[str, float]:
    """Phase at the start of each train run, for effects that have one."""
    if not one.candidate.per_run:
        return {}
    pairs = one.theta.reshape(-1, 2)
    numbered = _numbers(one, runs)
    return {
        runs[i].run.name: float(np.arctan2(c, s) % (2 * np.pi))
        for i, (s, c) in zip(numbered, pairs, strict=True)
    }


def _numbers(one: Weighed, runs: Sequence[Measured]) -> list[int]:
    if "level" in one.candidate.columns:
        return [i for i, run in enumerate(runs) if len(run.events)]
    return [i for i, run in enumerate(runs) if np.any(run.sticks.rate > 0.3)]


def models(
    case: Case, choice: Choice, runs: Sequence[Measured]
) -> tuple[tuple[Model, Law], tuple[Model, Law]]:
    """The declared model with the law of the mean event, and the same with what was found; each law's intervals."""
    own = case.model()
    rig = choice.declared.rig
    terms = []
    for one in choice.chosen:
        values = {name: interval.value for name, interval in parameters(one, choice).items()}
        terms.append(effect(one.candidate.name, **values))
    before: FrictionLaw
    after: FrictionLaw
    if isinstance(case.declared_law, CoulombFriction | None):
        before, law_before = _law(Model(rig, friction=CoulombFriction()), choice.declared.force_channel, runs)
        with_terms = Model(rig, friction=before, effects=tuple(terms))
        after, law = _law(with_terms, choice.declared.force_channel, runs)
    else:
        before, law_before = after, law = _fitted_law(case)

    def whole(friction: FrictionLaw, effects: Sequence[Effect]) -> Model:
        return Model(rig, friction=friction, effects=tuple(effects), channels=own.channels, noise=own.noise)

    return (whole(before, ()), law_before), (whole(after, terms), law)


def _fitted_law(case: Case) -> tuple[FrictionLaw, Law]:
    """A declared law that is no Coulomb law, by simulation: the closed form of the events knows constant levels only.

    Raises
    ------
    InputError
        The slips cannot tell the law, or a run is of another rig, which the fit does not know.
    """
    other = next((run for run in case.train if run.rig != case.rig), None)
    if other is not None:
        words = f"run '{other.name}' is on a rig of its own, which only a Coulomb law is identified with"
        raise InputError(words, key="friction")
    found = identify(case)
    law = {
        name: Interval(one.value, one.low, one.high)
        for name, one in found.estimates.items()
        if one.low is not None
    }
    return found.law, law


def _law(
    model: Model, force_channel: bool, runs: Sequence[Measured]
) -> tuple[CoulombFriction, Mapping[str, Interval]]:
    """Mean static and kinetic force, every run counting alike; intervals from blocks of neighbouring events."""
    reading = reading_of(model, force_channel)
    growth, tau = (number_of(model, "static_aging", key) for key in ("dT", "tau"))
    means, variances = [], []
    for one in (run for run in runs if len(run.events)):
        e, speed = one.events, one.run.belt_speed
        top, bottom = (reading.undone(x, e.t) for x in (e.p[:, S], e.arrest))
        grown = growth * (1 - np.exp(-e.dwell / tau)) if growth else 0.0
        slid = sliding(model, top, bottom, speed, constants_of(model, one).log_w2)
        levels = np.column_stack([carried(model, top, speed) - grown, slid])
        means.append(levels.mean(axis=0))
        variances.append(block_bootstrap(levels).var(axis=0))
    mean = np.mean(means, axis=0)
    between = np.var(means, axis=0, ddof=1) if len(means) > 1 else np.zeros(2)
    std = np.sqrt((between + np.mean(variances, axis=0)) / len(means))
    static, kinetic = float(mean[0]), float(min(mean[1], mean[0]))
    names = ("static", "kinetic") if runs[0].run.sign > 0 else ("static_plus", "kinetic_plus")
    law = {
        name: _interval(value, float(s)) for name, value, s in zip(names, (static, kinetic), std, strict=True)
    }
    return CoulombFriction(static=static, kinetic=max(kinetic, 0.0)), law


def block_of(choice: Choice, name: str) -> Block:
    """A block by its name."""
    return next(one for one in choice.blocks if one.name == name)
