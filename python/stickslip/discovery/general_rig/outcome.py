"""What a search on a rig of bodies or matrices says, in the words that every report has."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import AnyEffect, effect
from stickslip.declared.model import Model
from stickslip.declared.rigs.general import ContactRow, GeneralRig
from stickslip.discovery.general_rig.bench import GeneralBench
from stickslip.discovery.general_rig.curve_kinds import CurveKind
from stickslip.discovery.general_rig.curve_told import standing, told_as_curves
from stickslip.discovery.laboratory import left as windows_left
from stickslip.discovery.laboratory import outcome
from stickslip.discovery.laboratory.constants import Freed
from stickslip.discovery.laboratory.rival_kind import RivalKind, within
from stickslip.discovery.laboratory.said_of_constants import said_of_constants
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.laboratory.wrong_constant import evidence_of, rivals_of
from stickslip.discovery.result import FoundEffect, Rival
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_identify import scatter as sizes_of_scatter
from stickslip.likelihoods.fit_state import Fit, unexplained
from stickslip.likelihoods.interval import Interval

Floats = NDArray[np.float64]


def said(name: str) -> str:
    """Return what an effect at a place is called: by its name, and of what."""
    return name.replace("@", " of ")


def model(bench: GeneralBench, trial: Trial, declared: Model) -> Model:
    """Return the model of a hypothesis: law, constants and effects as fitted, channels and noise as declared."""
    values = trial.fit.values()
    effects: list[AnyEffect] = []
    own = {one.name: one for one in bench.candidates}
    for one in trial.terms:
        e = one.effect
        if isinstance(one.kind, CurveKind):
            effects.append(replace(one.kind.declared.replace(**e.parameters), ranges={}))
            continue
        if isinstance(one.kind, RivalKind):  # as it was declared, its ranges and units kept
            found = {k: within(one.kind, k, Interval(v, None, None)).value for k, v in e.parameters.items()}
            effects.append(own[e.name].replace(**found))
            continue
        if one.phases:
            turned = math.pi if e.parameters["a"] < 0 else 0.0
            phi = float(np.mod(one.phases[0] + turned, 2 * math.pi))
            e = e.replace(a=abs(e.parameters["a"]), phi=phi)
        effects.append(e)
    if trial.freed is not None and _in_model(bench, trial.freed):
        effects.append(replace(effect("sensor_gain", e=trial.freed.off), where=trial.freed.name))
    plain = bench.model
    numbers = {}
    for name in plain.parameters:
        if name in values:
            numbers[name] = values[name]
    made = plain.replace(numbers)
    return Model(
        made.rig,
        friction=made.friction,
        effects=tuple(effects),
        channels=declared.channels,
        noise=declared.noise,
    )


def sensors(bench: GeneralBench, trial: Trial) -> dict[str, float]:
    """Return the gains, less 1, and the offsets of a hypothesis, as its fit names them; not one that is an effect."""
    values, freed = trial.fit.values(), trial.freed
    wrong = freed.name if freed is not None and _in_model(bench, freed) else ""
    names = [f"gain.{one}" for one in bench.data[0].channels if one != wrong]
    names += [f"offset.{one}" for one in bench.data[0].channels]
    return {name: values[name] for name in names if name in values}


def effects(bench: GeneralBench, found: Searched) -> tuple[FoundEffect, ...]:
    """Return the effects of the verdict, in order of weight."""
    named = list(outcome.effects(bench, replace(found, chosen=replace(found.chosen, freed=None))))
    if found.chosen.freed is not None:
        named.append(_wrong_constant(bench, found, found.chosen.freed))
    out = []
    for one in told_as_curves(bench, found, named):
        if one.curve is not None:
            out.append(one)
            continue
        rivals = tuple(replace(a, name=said(a.name)) for a in one.alternatives)
        proof = replace(
            one.evidence, control_name=said(one.evidence.control_name), sentence=said(one.evidence.sentence)
        )
        out.append(replace(one, alternatives=rivals, evidence=proof))
    return standing(sorted(out, key=lambda one: -one.evidence.weight))


def _gain(bench: GeneralBench, one: Freed) -> bool:
    return f"gain.{one.name}" in bench.declared.names


def _in_model(bench: GeneralBench, one: Freed) -> bool:
    """Whether it is a gain that a model has: those of accelerations and forces are their sensors' alone."""
    assert isinstance(bench.model.rig, GeneralRig)
    return _gain(bench, one) and one.name in bench.model.rig.state_names


def _wrong_constant(bench: GeneralBench, found: Searched, wrong: Freed) -> FoundEffect:
    """A declared constant or gain that is off by more than three of its standard uncertainties."""
    assert isinstance(bench.model.rig, GeneralRig)
    known = bench.model.rig.numbers

    def named(one: Freed) -> tuple[str, Mapping[str, Interval]] | None:
        if _gain(bench, one):
            return f"sensor_gain of {one.name} channel", {"e": _error(one)}
        return f"rig_{one.name}", {one.name: one.interval(known[one.name])}

    proof, rivals = evidence_of(found, wrong), rivals_of(wrong, named)
    if _gain(bench, wrong):
        words = f"{wrong.name} channel reads {1 + wrong.off:.4g} times what it should"
        where = f"{wrong.name} channel"
        return FoundEffect("sensor_gain", where, (), {"e": _error(wrong)}, proof, rivals, words)
    value = known[wrong.name]
    words = (
        f"{wrong.name} is {value * (1 + wrong.off):.4g} rather than {value:.4g} ({100 * wrong.off:+.3g} %)"
    )
    where = wrong.name.rpartition(".")[0] or wrong.name.partition("_")[0]
    numbers = {wrong.name: wrong.interval(value)}
    return FoundEffect(f"rig_{wrong.name}", where, (), numbers, proof, rivals, words, of_rig=True)


def _error(one: Freed) -> Interval:
    """Relative error, true over declared less 1."""
    at = one.interval()
    return Interval(*(None if x is None else x - 1 for x in (at.value, at.low, at.high)))  # type: ignore[arg-type]


def ranking(found: Searched) -> tuple[Rival, ...]:
    """Return all that was fitted or scored, best first."""
    return tuple(replace(one, names=tuple(map(said, one.names))) for one in outcome.ranking(found))


def constants(bench: GeneralBench, fit: Fit) -> dict[str, Interval]:
    """Return what the runs say of every declared constant and gain; a gain as 1 + e."""
    known, out = bench.model.parameters, {}
    for name, one in said_of_constants(bench, fit).items():
        size = known.get(name, 1.0)
        out[name] = Interval(*(None if x is None else x * size for x in (one.value, one.low, one.high)))  # type: ignore[arg-type]
    return out


def scatter(fit: Fit) -> dict[str, Interval]:
    """Return the relative standard deviations of what differs from event to event; of several laws each by its name."""
    out: dict[str, Interval] = {}
    found = sizes_of_scatter(fit)
    alone = sum(name.endswith(".kinetic") for name in found) == 1
    for name, one in found.items():
        law, _, kind = name.rpartition(".")
        sizes = (one.value, one.low, one.high)
        if kind == "static":  # a static limit has what it shares with kinetic friction, too
            shared = found[f"{law}.kinetic"]
            both = (shared.value, shared.low, shared.high)
            sizes = tuple(math.hypot(a, b) for a, b in zip(sizes, both, strict=True))  # type: ignore[assignment]
        out[kind if alone or not law else name] = Interval(*sizes)
    return out


def left(bench: GeneralBench, fit: Fit) -> windows_left.Left:
    """Return what a fit leaves; of several contacts in stick where all are, else in slip as the first that does."""
    made = windows_left.left(bench, fit)
    motions = fit.windows.motions(fit.at, fit.own)
    kept = [m for m, block in zip(motions, fit.blocks, strict=True) if m is not None and block is not None]
    blocks = [replace(b, mode=_one_mode(m.mode)) for b, m in zip(made.blocks, kept, strict=True)]
    return replace(made, blocks=blocks)


def _one_mode(mode: NDArray[np.int8]) -> NDArray[np.int8]:
    if not mode.shape[1]:
        return np.zeros(len(mode), dtype=np.int8)
    first = (mode != 0).argmax(axis=1)
    return np.asarray(mode[np.arange(len(mode)), first], dtype=np.int8)


def readings(bench: GeneralBench, fit: Fit) -> list[Floats]:
    """Return what a fit makes of each run, (n, channels); NaN where no window is."""
    out = [np.full(run.readings.shape, np.nan) for run in bench.data]
    for s, motion in zip(bench.stretches, fit.windows.motions(fit.at, fit.own), strict=True):
        if motion is not None:
            out[s.run][s.start : s.stop] = motion.readings
    return out


def _percent(one: Interval) -> str:
    low, high = (None if x is None else f"{100 * x:.2g}" for x in (one.low, one.high))
    return f"{100 * one.value:.2g} %" + ("" if low is None or high is None else f" ({low} to {high})")


def remarks(bench: GeneralBench, trial: Trial) -> tuple[str, ...]:
    """Return what a person should read beside the verdict."""
    sizes = ", ".join(f"{name} by {_percent(one)}" for name, one in scatter(trial.fit).items())
    out = [
        f"friction differs from event to event: {sizes} (standard deviations, 95 % intervals); the law is that of the "
        "mean event"
    ]
    if bench.one_way:
        out.append("a constant load is absorbed by the friction laws: every contact slips one way only")
    unread = sorted({one.name for run in bench.data for one, told in _seen(bench, run) if not told})
    if unread:
        out.append(f"the motion at {', '.join(unread)} is not read: it is found from the other coordinates")
    if (over := unexplained(trial.fit)) > bench.policy.noise_left:
        out.append(f"{over:.3g} times the noise's variance is left: something acts that no name says")
    return tuple(out)


def _seen(bench: GeneralBench, run: BodiesData) -> Sequence[tuple[ContactRow, bool]]:
    return list(zip(bench.contacts, run.seen.tolist(), strict=True))
