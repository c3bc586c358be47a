"""The loop for a block on a belt: events, what differs between them, what is lacking, the error before and after."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.catalogue import KINDS
from stickslip.declared.effect import CONSTANTS
from stickslip.discovery.carry_over import carries_over, instead
from stickslip.discovery.result import Experiment, Found, FoundEffect, Gate, Interval, Rival, Verdict
from stickslip.discovery.slider.choose import FEWEST, Choice, choose
from stickslip.discovery.slider.gate import DRAWS
from stickslip.discovery.slider.held import constants_of, held
from stickslip.discovery.slider.model import models, phases
from stickslip.discovery.slider.numbers import parameters
from stickslip.discovery.slider.outcome import error_block, residual
from stickslip.discovery.slider.population import blocks
from stickslip.discovery.slider.remarks import remarks
from stickslip.discovery.slider.ties import alternatives, evidence
from stickslip.discovery.slider.views import spectrum, train_view, validate_view
from stickslip.discovery.slider.weigh import PRICE, Weighed
from stickslip.errors import InputError
from stickslip.fitted.block_events.table import Measured, measure, prepare
from stickslip.measured.case import Case, Recording
from stickslip.measured.constants import block_constants
from stickslip.measured.stick_speed import why_idle


def discover(
    case: Case, *, progress: Callable[[str], None] | None = None, seed: int = 0, draws: int = DRAWS
) -> Found:
    """Find what the declared model of a block on a belt lacks, where friction differs from event to event.

    Parameters
    ----------
    case
        Needs train and validate runs of a `BlockOnBelt`.
    progress
        Told what is being done, a sentence at a time.
    seed
        Of the gate's draws.
    draws
        Simulated tables of events in the gate.

    Returns
    -------
    Found

    Raises
    ------
    InputError
        Too few events, a belt that stands still, or a mass or stiffness in another unit.
    """
    began = time.monotonic()
    block_constants(case)
    tell = progress or (lambda _: None)
    tell("finding events")
    train, validate = ([measure(prepare(one)) for one in runs] for runs in (case.train, case.validate))
    silent = idle(case.train, train)
    _enough(train, silent)
    choice = choose(train, seed, tell, draws)
    (before, law_before), (after, law) = models(case, choice, train)
    tell("fitting single events under both models")
    was, now = ([held(one, constants_of(model, one)) for one in train] for model in (before, after))
    tell("forecasting the validate runs")
    error, forecasts, words = error_block(case, before, after, validate)
    tell("weighing the evidence")
    effects = tuple(_effect(one, choice, train, validate) for one in choice.chosen)
    left = residual(train, now, len(choice.chosen))
    views = [
        *(
            train_view(m, before, after, (a, b))
            for m, a, b in zip(train, was, now, strict=True)
            if len(m.events)
        ),
        *(validate_view(one, before, after, forecasts[one.run.name]) for one in validate),
    ]
    return Found(
        title=case.title,
        verdict=Verdict.effect_found if effects else Verdict.no_effect,
        effects=effects,
        before=before,
        after=after,
        law=law,
        law_before=law_before,
        residual_before=residual(train, was, 0),
        residual_after=left,
        error=error,
        ranking=_ranking(choice),
        experiments=experiments(effects),
        gate=_gate(choice),
        runs=tuple(views),
        spectrum=spectrum(train, was, now),
        messages=(*silent, *remarks(case, choice, train, effects), *words),
        seconds=time.monotonic() - began,
        constants=_constants(choice),
    )


def carried(found: Found) -> Found:
    """Return what was found, or nothing where the error of single events rises on runs never used."""
    if carries_over(found):
        return found
    error = replace(
        found.error,
        after=found.error.before,
        runs=tuple(
            replace(one, one_cycle={**one.one_cycle, "after": one.one_cycle["before"]})
            for one in found.error.runs
        ),
    )
    silent = replace(
        found,
        verdict=Verdict.no_effect,
        effects=(),
        after=found.before,
        law=found.law_before,
        residual_after=found.residual_before,
        error=error,
        experiments=(),
        ranking=tuple(replace(one, chosen=not one.names) for one in found.ranking),
    )
    return instead(found, silent)


def idle(recordings: Sequence[Recording], runs: Sequence[Measured]) -> tuple[str, ...]:
    """Every run that no slip is found in, with the reason."""
    return tuple(
        f"{recording.name}: no slip is used: {why_idle(recording, len(one.run.track.sticks))}"
        for recording, one in zip(recordings, runs, strict=True)
        if not len(one.events)
    )


def _enough(train: Sequence[Measured], idle: Sequence[str]) -> None:
    count = sum(len(one.events) for one in train)
    if count < FEWEST:
        raise InputError(
            f"{count} slips between sticks found in the train runs; {FEWEST} are needed to tell an effect from "
            "friction that differs from event to event" + "".join(f"; {one}" for one in idle)
        )


def _effect(
    one: Weighed, choice: Choice, train: Sequence[Measured], validate: Sequence[Measured]
) -> FoundEffect:
    kind = KINDS[one.candidate.name]
    return FoundEffect(
        name=kind.name,
        where=kind.where,
        depends_on=kind.depends_on,
        parameters=parameters(one, choice),
        evidence=evidence(one, choice, _held_out(one, validate)),
        alternatives=alternatives(one, choice),
        formula=kind.formula,
        phases=phases(one, train),
    )


def _held_out(one: Weighed, validate: Sequence[Measured]) -> float:
    """Error of the validate events' numbers with the effect over that without it; NaN where phases are unknown."""
    if one.candidate.per_run or not any(len(run.events) for run in validate):
        return float("nan")
    from stickslip.discovery.slider.candidates import Declared, candidates

    made = blocks(validate)
    first = validate[0].run
    same = [
        c
        for c in candidates(made, Declared(first.rig, first.force_channel))
        if c.name == one.candidate.name and (c.scale == 0 or c.scale == one.candidate.scale)
    ]
    if not same:
        return float("nan")
    without = beside = 0.0
    for block in made:
        columns = same[0].columns.get(block.name)
        if columns is None:
            continue
        weight = 1 / (block.noise + block.spread**2 + block.wander[0] ** 2 + block.wander[2] ** 2)
        without += float(weight @ block.y**2)
        beside += float(weight @ (block.y - columns @ one.theta) ** 2)
    return float(np.sqrt(beside / without)) if without > 0 else float("nan")


def _ranking(choice: Choice) -> tuple[Rival, ...]:
    """Every candidate alone, the declared model, and what was chosen in the end."""
    first = choice.steps[0]
    count = max(choice.white.events, 1)
    start = float(choice.white.y @ choice.white.y)
    total = sum(one.gain for one in choice.steps[0][:1]) + sum(
        step[0].gain for step in choice.steps[1 : max(len(choice.chosen), 1)]
    )
    rows = [Rival((), start / count, 0.0, {}, None, not choice.chosen)]
    for one in first:
        chosen = len(choice.chosen) == 1 and one.candidate.name == choice.chosen[0].candidate.name
        values = {f"{one.candidate.name}.{n}": i.value for n, i in parameters(one, choice).items()}
        rows.append(
            Rival((one.candidate.name,), (start - one.gain) / count, -one.score, values, one.gain, chosen)
        )
    if len(choice.chosen) > 1:
        names = tuple(one.candidate.name for one in choice.chosen)
        numbers = sum(one.candidate.parameters for one in choice.chosen)
        rows.append(Rival(names, (start - total) / count, PRICE * (numbers - 1) - total, {}, None, True))
    best = min(row.bic for row in rows)
    return tuple(sorted((replace(row, bic=row.bic - best) for row in rows), key=lambda row: row.bic))


def _constants(choice: Choice) -> dict[str, Interval]:
    """What the events say of each declared constant and of the gain, with everything else as declared."""
    declared, out = choice.declared, {}
    channel = "spring_force" if declared.force_channel else "x1"
    for one in choice.steps[0]:
        number = KINDS[one.candidate.name].corrects
        if number is None:
            continue
        size = 1.0 if number == "reading" else float(getattr(declared.rig, number))
        e = parameters(one, choice)["e"]
        limits = (None if limit is None else size * (1 + limit) for limit in (e.low, e.high))
        out[channel if number == "reading" else number] = Interval(size * (1 + e.value), *limits)
    return out


def _gate(choice: Choice) -> Gate:
    observed = max((one.score for one in choice.steps[0]), default=0.0)
    draws = choice.null.draws
    return Gate(
        max(observed, 0.0), choice.null.threshold, float(np.mean(draws > choice.null.threshold)), draws
    )


def experiments(effects: Sequence[FoundEffect]) -> tuple[Experiment, ...]:
    """What would break the ties that these runs cannot."""
    out = []
    tied = {(e.name, a.name) for e in effects for a in e.alternatives if a.tied}
    constants = {name for pair in tied for name in pair} & set(CONSTANTS)
    if len(constants) > 1:
        pair = (
            ("sensor_gain", "rig_stiffness") if "sensor_gain" in constants else ("rig_mass", "rig_stiffness")
        )
        out.append(
            Experiment(
                "weigh the block, and hang a known weight on the spring", None, pair, float("inf"), True
            )
        )
        out.append(
            Experiment("repeat with another spring of known stiffness", None, pair, float("inf"), True)
        )
    if ("sensor_gain", "belt speed") in tied:
        out.append(
            Experiment(
                "measure the speed of the pull", None, ("sensor_gain", "belt speed"), float("inf"), True
            )
        )
    if any({"belt_seam", "harmonic_forcing"} == set(pair) for pair in tied):
        what = "two speeds whose runs both last several periods"
        out.append(Experiment(what, None, ("belt_seam", "harmonic_forcing"), float("inf"), True))
    return tuple(out)
