"""The loop for a driven slider: fit the declared law, find what it lacks, add it, report the error before and after."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import DRIVEN, AnyEffect, effect
from stickslip.declared.effect import POSITION_RIPPLES as RIPPLES
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.scale import percent, plainly
from stickslip.discovery.driven_slider.errors import error_block
from stickslip.discovery.driven_slider.residual import describe, spectrum, views
from stickslip.discovery.driven_slider.result import DrivenFound
from stickslip.discovery.driven_slider.search import DrivenSearch
from stickslip.discovery.result import TIED, Alternative, Evidence, FoundEffect, Rival, Verdict
from stickslip.discovery.result import Gate as FoundGate
from stickslip.errors import InputError
from stickslip.likelihoods.driven_slider.banded import BandedBalance
from stickslip.likelihoods.driven_slider.feedback import feedback
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import Choice, MotionFit
from stickslip.likelihoods.driven_slider.held_out import share
from stickslip.likelihoods.driven_slider.intervals import intervals
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.driven_slider.prepared import (
    balance,
    check,
    check_samples,
    declared_mass,
    fitted_model,
    shown_band,
)
from stickslip.likelihoods.driven_slider.remarks import remarks
from stickslip.likelihoods.interval import Interval
from stickslip.measured.case import Case

Floats = NDArray[np.float64]

EXACT = {
    "rig_mass": (
        "drive_gain",
        "a wrong mass and a wrong gain of the drive do the same to the motion, friction being free; "
        "only a known added mass tells them apart",
    ),
}


def discover(case: Case, *, tell: Callable[[str], None], seed: int = 0) -> DrivenFound:
    """Find what the declared model of a driven slider lacks.

    Parameters
    ----------
    case
        From `stickslip.load_case`; its rig is a `DrivenSlider`.
    tell
        Told what is being tried.
    seed
        Of the bootstrap.

    Raises
    ------
    InputError
        The runs are too short, irregularly sampled or contradict the declared mass.
    """
    began = time.monotonic()
    rig = case.rig
    assert isinstance(rig, DrivenSlider)
    check(case.friction, rig, (*case.train, *case.validate))
    declared = declared_mass(rig, case.uncertainty)
    with no_verdict():
        check_samples((*case.train, *case.validate))
        over = shown_band(case.train, rig)
        trained = balance(case.train, declared)
    search = DrivenSearch(trained, tell, seed)
    with no_verdict():
        validate = balance(case.validate, declared)
    validate.like(search.balance)
    chosen = carried(search, search.run(), validate)
    tell("weighing the evidence")
    bare = search.bare(chosen)  # the declared law in the noise that is left
    effects = found_effects(search, chosen, validate)
    before, after = model(case, search.null), model(case, chosen, search)
    observed = largest_gain(search)
    tell("forecasting the validate runs")
    train_shown, shown = BandedBalance(search.balance, over), BandedBalance(validate, over)
    own = intervals(search.balance, chosen).law
    return DrivenFound(
        title=case.title,
        verdict=verdict(chosen),
        effects=effects,
        before=before,
        after=after,
        law=_law(own),
        law_before=_law(intervals(search.balance, search.null).law),
        residual_before=describe(search.balance, bare),
        residual_after=describe(search.balance, chosen),
        error=error_block(case, shown, search.null, chosen, before, after),
        ranking=ranking(search, chosen),
        experiments=(),
        gate=FoundGate(
            observed,
            search.gate.threshold,
            float(np.mean(search.gate.draws >= observed)),
            search.gate.draws,
        ),
        runs=(),
        spectrum=spectrum(search.balance, bare.white, chosen.white),
        messages=_said(search, chosen),
        seconds=time.monotonic() - began,
        constants={"mass": own["mass"]},
        views=(
            *views("train", train_shown, search.null, chosen),
            *views("validate", shown, search.null, chosen),
        ),
        waves=waves(search, chosen),
        noise=chosen.noise.std * chosen.law.mass,
        cutoff=over.cutoff,
    )


@contextmanager
def no_verdict() -> Iterator[None]:
    """Let what is wrong with a record say that there is no verdict of it."""
    try:
        yield
    except InputError as error:
        raise InputError(f"no verdict: {error.what}", key=error.key) from None


def carried(search: DrivenSearch, chosen: MotionFit, validate: Balance) -> MotionFit:
    """The chosen fit without effects that have no bound, or that raise the error of the validate runs."""
    fit = chosen
    while fit.choices:
        numbers = intervals(search.balance, fit).effects
        worst, least = "", 0.0
        for one in fit.choices:
            if one.name == "rig_mass":  # the runs say as much of it without the name
                continue
            less = search.without(fit, one.name)
            validate.take(fit.noise)
            rise = _power(validate, less) - _power(validate, fit)
            if search.unbounded(one, numbers[one.name]):
                rise = -np.inf
            if rise <= least:
                worst, least = one.name, rise
        if not worst:
            break
        fit = search.renoised(search.without(fit, worst))
    return fit


def largest_gain(search: DrivenSearch) -> float:
    """The largest gain of a candidate that joined; where none did, of those that were tried."""
    joined = [search.gain(step.before, step.after) for step in search.steps]
    return max(joined or [search.gain(search.null, one) for one in search.joined(search.null)], default=0.0)


def verdict(chosen: MotionFit) -> Verdict:
    """What the chosen fit amounts to."""
    if any(name.startswith("tabulated") for name in chosen.names):
        return Verdict.unlisted_effect
    return Verdict.effect_found if chosen.names else Verdict.no_effect


def model(case: Case, fit: MotionFit, search: DrivenSearch | None = None) -> Model:
    """The fitted balance as a model; with its effects where a search has found them."""
    curves = {one.name: one for one in search.curves} if search else {}
    effects: list[AnyEffect] = []
    for one, b in zip(fit.choices, fit.amplitudes, strict=True):
        if one.name in curves:
            effects.append(curves[one.name].effect(b))
        else:
            effects.append(effect(one.name, **one.term.parameters(one.inside, b, fit.law)))
    made = fitted_model(case.model(), fit)
    assert isinstance(case.rig, DrivenSlider)
    assert isinstance(made.rig, DrivenSlider)
    rig = replace(made.rig, mass=case.rig.mass) if "rig_mass" in fit.names else made.rig
    return replace(made, rig=rig, effects=tuple(effects))


def _law(numbers: dict[str, Interval]) -> dict[str, Interval]:
    return {name: one for name, one in numbers.items() if name != "mass"}


def found_effects(search: DrivenSearch, chosen: MotionFit, validate: Balance) -> tuple[FoundEffect, ...]:
    """The effects of the chosen fit with their evidence, in order of weight."""
    numbers = intervals(search.balance, chosen)
    curves = {one.name: one for one in search.curves}
    out = []
    lesser = [search.without(chosen, one.name) for one in chosen.choices]
    if lesser:
        search.score_all([*lesser, chosen])
    for one, b, less in zip(chosen.choices, chosen.amplitudes, lesser, strict=True):
        rivals = search.joined(less, taken=RIPPLES if one.name in RIPPLES else (one.name,))
        proof = evidence(search, chosen, less, one, rivals, validate)
        others = tuple(alternatives(search, chosen, one, rivals))
        if one.name in curves:
            curve = curves[one.name]
            learned = curve.curve(b, numbers.deviations[one.name])
            out.append(
                FoundEffect(
                    "unlisted", curve.where, (curve.variable,), {}, proof, others,
                    f"{learned.term}: a curve in {curve.variable}", learned,
                )
            )  # fmt: skip
            continue
        kind = DRIVEN[one.name]
        own = numbers.effects[one.name]
        phases = {run.name: own["phi"].value for run in search.balance.runs if "phi" in own}
        shown = {name: i for name, i in own.items() if name != "phi"}
        out.append(
            FoundEffect(
                one.name, kind.where, kind.depends_on, shown, proof, others, kind.formula, None, phases
            )
        )
    return tuple(sorted(out, key=lambda e: -e.evidence.weight))


def evidence(
    search: DrivenSearch,
    chosen: MotionFit,
    less: MotionFit,
    one: Choice,
    rivals: Sequence[MotionFit],
    validate: Balance,
) -> Evidence:
    """What the effect explains, what the best wrong one in its place would; what both are worth when validated."""
    drop = less.chi2 - chosen.chi2
    size = one.term.size
    wrong = [r for r in rivals if r.choices[-1].term.size >= size and not _tied(search, chosen, r)]
    best = min(wrong, key=lambda r: r.chi2, default=None)
    control, name = (less.chi2 - best.chi2, best.names[-1]) if best is not None else (0.0, "")
    other, where = elsewhere(search, less, one)
    if other > control:
        control, name, best = other, where, None
    validate.take(chosen.noise)
    base = _power(validate, less)
    ratio = float(np.sqrt(share(_power(validate, chosen), base)))
    excess = search.excess(chosen)
    explained = 100 * drop / excess
    words = f"it explains {plainly(explained)} % of what the declared law leaves beyond the noise"
    if best is None and name:
        words += f"; {name} would explain {percent(control / excess)}"
    if best is not None:
        held = float(np.sqrt(share(_power(validate, best), base)))
        words += f"; on the validate runs the error falls to {ratio:.3f} of what it was"
        words += f", with {name} instead to {held:.3f}"
    penalty = chosen.price * (chosen.freedom - less.freedom)
    return Evidence(drop, drop - penalty, ratio, control, name, search.gate.threshold, words)


def elsewhere(search: DrivenSearch, less: MotionFit, one: Choice) -> tuple[float, str]:
    """What the same wave would explain at the best wrong wavelength or frequency: harmonics and neighbours left out."""
    if not one.term.many:
        return 0.0, ""
    own = RIPPLES[0] if one.name in RIPPLES else one.name
    entries = [(i, e) for i, e in enumerate(search.dictionary.entries) if e.name == own]
    away = np.array([abs(np.log(float(e.inside[0] / one.inside[0]))) for _, e in entries])
    same = STEER.same_wave
    far = (away > same) & (np.abs(away - np.log(2)) > same) & (np.abs(away - np.log(4)) > same)
    gains = search.scores(less)[[i for i, _ in entries]]
    best = int(np.argmax(np.where(far, gains, -np.inf)))
    value = entries[best][1].inside[0]
    return float(gains[best]), f"{one.name} with {one.term.scanned[0]} = {value:.3g}"


def waves(search: DrivenSearch, chosen: MotionFit) -> dict[str, Floats]:
    """What a force periodic in position would explain beside either model, wavelength by wavelength."""
    kept = np.flatnonzero(search.dictionary.names == RIPPLES[0])
    length = np.array([float(search.dictionary.entries[i].inside[0]) for i in kept])
    return {
        "wavelength": length,
        "before": search.scores(search.null)[kept],
        "after": search.scores(chosen)[kept],
    }


def _power(balance: Balance, fit: MotionFit) -> float:
    white = balance.predicted(fit)
    return float(white @ white)


def _tied(search: DrivenSearch, chosen: MotionFit, rival: MotionFit) -> bool:
    return search.score(rival) - search.score(chosen) < TIED


def alternatives(
    search: DrivenSearch, chosen: MotionFit, one: Choice, rivals: Sequence[MotionFit]
) -> list[Alternative]:
    """Rivals in the place of an effect, everything refitted; those within reach first."""
    out = []
    if one.name in EXACT:
        name, reason = EXACT[one.name]
        out.append(Alternative(name, 1.0, 0.0, True, True, reason, {}, 1.0))
    for rival in rivals:
        delta = search.score(rival) - search.score(chosen)
        tied = delta < TIED
        gap = f"it leaves -2 log likelihood {delta:.3g} higher, its numbers priced"
        held = {k: Interval(v, None, None) for k, v in rival.parameters()[rival.names[-1]].items()}
        out.append(
            Alternative(rival.names[-1], float(np.exp(-0.5 * max(delta, 0.0))), delta, tied, False, gap, held)
        )
    return out


def ranking(search: DrivenSearch, chosen: MotionFit) -> tuple[Rival, ...]:
    """Every fit that was tried on the way, best first."""
    fits = [search.null, chosen]
    for step in search.steps:
        fits += [step.after, *step.rivals]
    unique = {tuple(sorted(one.names)): one for one in reversed(fits)}
    ordered = sorted(unique.values(), key=search.score)
    least = search.score(ordered[0])
    out = []
    for one in ordered:
        numbers = {
            f"{name}.{p}": v
            for name, values in one.parameters().items()
            for p, v in values.items()
            if not name.startswith("tabulated")
        }
        out.append(Rival(one.names, one.per_reading, search.score(one) - least, numbers, None, one is chosen))
    return tuple(out)


def _said(search: DrivenSearch, chosen: MotionFit) -> tuple[str, ...]:
    """What a person should know of the verdict."""
    out = remarks(search.balance, chosen, feedback(search.balance, search.null))
    if len(search.balance.runs) > 1:
        out = (*out, "a force periodic in time is sought with one phase over all training runs")
    return out
