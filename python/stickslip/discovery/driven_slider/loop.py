"""The loop for a driven slider: fit the declared law, find what it lacks, add it, report the error before and after."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import DRIVEN, AnyEffect, effect
from stickslip.declared.effect import POSITION_RIPPLES as RIPPLES
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.scale import percent, plainly
from stickslip.discovery.driven_slider.errors import error_block, share
from stickslip.discovery.driven_slider.fit import Balance, Choice, Fit
from stickslip.discovery.driven_slider.intervals import intervals
from stickslip.discovery.driven_slider.motion import Band, band, motion
from stickslip.discovery.driven_slider.residual import describe, spectrum, views
from stickslip.discovery.driven_slider.result import DrivenFound
from stickslip.discovery.driven_slider.search import CLOSE, Search
from stickslip.discovery.result import Alternative, Evidence, FoundEffect, Interval, Rival, Verdict
from stickslip.discovery.result import Gate as FoundGate
from stickslip.errors import InputError
from stickslip.measured.case import Case, Recording
from stickslip.measured.findings import FindingKind

Floats = NDArray[np.float64]

APART = 0.05  # relative difference of two wavelengths that are not the same
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
    _check(case)
    first = max(case.train, key=len)
    assert first.drive is not None
    over = band(first.t, first.x1, first.drive, rig.mass)
    train, validate = balance(case.train, over, rig.mass), balance(case.validate, over, rig.mass)
    search = Search(train, tell, seed)
    validate.noise = train.noise
    chosen = search.run()
    tell("weighing the evidence")
    effects = found_effects(search, chosen, validate)
    before, after = model(case, search.null), model(case, chosen, search)
    gains = [step.before.chi2 - step.after.chi2 for step in search.steps] or [
        max((search.null.chi2 - one.chi2 for one in search.joined(search.null)), default=0.0)
    ]
    tell("forecasting the validate runs")
    return DrivenFound(
        title=case.title,
        verdict=verdict(chosen),
        effects=effects,
        before=before,
        after=after,
        law=_law(train, chosen),
        law_before=_law(train, search.null),
        residual_before=describe(train, search.null),
        residual_after=describe(train, chosen),
        error=error_block(case, validate, search.null, chosen, before, after),
        ranking=ranking(search, chosen),
        experiments=(),
        gate=FoundGate(
            max(gains),
            search.gate.threshold,
            float(np.mean(search.gate.draws >= max(gains))),
            search.gate.draws,
        ),
        runs=(),
        spectrum=spectrum(train, search.null, chosen),
        messages=remarks(search, chosen, over),
        seconds=time.monotonic() - began,
        views=(
            *views("train", train, search.null, chosen),
            *views("validate", validate, search.null, chosen),
        ),
        waves=waves(search, chosen),
        noise=train.noise.std,
        cutoff=over.cutoff,
    )


def balance(runs: Sequence[Recording], over: Band, mass: float) -> Balance:
    """The force balance of some recordings."""
    out = []
    for run in runs:
        assert run.drive is not None
        out.append(motion(run.name, run.t, run.x1, run.drive, over))
    if all(one.rest.all() for one in out):
        words = "no sample is beyond doubt in motion; a force balance needs a slider that slides"
        raise InputError(f"no verdict: {', '.join(one.name for one in out)}: {words}")
    return Balance(out, over, mass)


def _check(case: Case) -> None:
    if not isinstance(case.friction, CoulombFriction):
        raise InputError("the law of a driven slider is coulomb; declare kind = 'coulomb'", key="friction")
    for run in (*case.train, *case.validate):
        if run.rig != case.rig:
            words = "has another rig than the case; one model is fitted to all runs of a driven slider"
            raise InputError(f"{run.name}: {words}", key="[[run]] rig")
        for finding in run.findings:
            if finding.kind in (FindingKind.GAP, FindingKind.IRREGULAR, FindingKind.SIZE):
                raise InputError(f"no verdict: {run.name}: {finding}")


def verdict(chosen: Fit) -> Verdict:
    """What the chosen fit amounts to."""
    if any(name.startswith("tabulated") for name in chosen.names):
        return Verdict.unlisted_effect
    return Verdict.effect_found if chosen.names else Verdict.no_effect


def model(case: Case, fit: Fit, search: Search | None = None) -> Model:
    """The fitted balance as a model: friction at rest as great as at the lowest speed."""
    law = fit.law
    minus, plus = max(law.minus, 0.0), max(law.plus, 0.0)
    friction = CoulombFriction(static=minus, kinetic=minus, static_plus=plus, kinetic_plus=plus)
    assert isinstance(case.rig, DrivenSlider)
    curves = {one.name: one for one in search.curves} if search else {}
    effects: list[AnyEffect] = []
    for one, b in zip(fit.choices, fit.amplitudes, strict=True):
        if one.name in curves:
            effects.append(curves[one.name].effect(b))
        else:
            effects.append(effect(one.name, **one.term.parameters(one.inside, b, law)))
    own = case.model()
    rig = replace(case.rig, damping=max(law.damping, 0.0))
    return replace(own, rig=rig, friction=friction, effects=tuple(effects))


def _law(train: Balance, fit: Fit) -> dict[str, Interval]:
    return intervals(train, fit).law


def found_effects(search: Search, chosen: Fit, validate: Balance) -> tuple[FoundEffect, ...]:
    """The effects of the chosen fit with their evidence, in order of weight."""
    numbers = intervals(search.balance, chosen)
    curves = {one.name: one for one in search.curves}
    out = []
    for one, b in zip(chosen.choices, chosen.amplitudes, strict=True):
        less = search.without(chosen, one.name)
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
    search: Search, chosen: Fit, less: Fit, one: Choice, rivals: Sequence[Fit], validate: Balance
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
    base = _power(validate, less)
    ratio = float(np.sqrt(share(_power(validate, chosen), base)))
    explained = 100 * drop / max(search.excess, 1e-300)
    words = f"it explains {plainly(explained)} % of what the declared law leaves beyond the noise"
    if best is None and name:
        words += f"; {name} would explain {percent(control / max(search.excess, 1e-300))}"
    if best is not None:
        held = float(np.sqrt(share(_power(validate, best), base)))
        words += f"; on the validate runs the error falls to {ratio:.3f} of what it was"
        words += f", with {name} instead to {held:.3f}"
    penalty = float(np.log(len(chosen.white))) * (chosen.freedom - less.freedom)
    return Evidence(drop, drop - penalty, ratio, control, name, search.gate.threshold, words)


def elsewhere(search: Search, less: Fit, one: Choice) -> tuple[float, str]:
    """What the same wave would explain at the best wrong wavelength or frequency: harmonics and neighbours left out."""
    if not one.term.many:
        return 0.0, ""
    entries = [(i, e) for i, e in enumerate(search.dictionary.entries) if e.choice.name == one.name]
    away = np.array([abs(np.log(float(e.choice.inside[0] / one.inside[0]))) for _, e in entries])
    far = (away > APART) & (np.abs(away - np.log(2)) > APART) & (np.abs(away - np.log(4)) > APART)
    gains = search.scorer(less).gains(less.white)[[i for i, _ in entries]]
    best = int(np.argmax(np.where(far, gains, -np.inf)))
    value = entries[best][1].choice.inside[0]
    return float(gains[best]), f"{one.name} with {one.term.scanned[0]} = {value:.3g}"


def waves(search: Search, chosen: Fit) -> dict[str, Floats]:
    """What a force periodic in position would explain beside either model, wavelength by wavelength."""
    kept = [i for i, e in enumerate(search.dictionary.entries) if e.choice.name == RIPPLES[0]]
    length = np.array([float(search.dictionary.entries[i].choice.inside[0]) for i in kept])
    was = search.scorer(search.null).gains(search.null.white)[kept]
    now = search.scorer(chosen).gains(chosen.white)[kept]
    return {"wavelength": length, "before": was, "after": now}


def _power(balance: Balance, fit: Fit) -> float:
    white = balance.predicted(fit)
    return float(white @ white)


def _tied(search: Search, chosen: Fit, rival: Fit) -> bool:
    return (search.score(rival) - search.score(chosen)) / max(chosen.per_reading, 1.0) < CLOSE


def alternatives(search: Search, chosen: Fit, one: Choice, rivals: Sequence[Fit]) -> list[Alternative]:
    """Rivals in the place of an effect, everything refitted; those within reach first."""
    out = []
    if one.name in EXACT:
        name, reason = EXACT[one.name]
        out.append(Alternative(name, 1.0, 0.0, True, True, reason, {}, 1.0))
    for rival in rivals:
        delta = search.score(rival) - search.score(chosen)
        scaled = delta / max(chosen.per_reading, 1.0)
        tied = scaled < CLOSE
        gap = f"it leaves chi-squared {delta:.3g} higher, {scaled:.3g} in units of what is left per reading"
        held = {k: Interval(v, None, None) for k, v in rival.parameters()[rival.names[-1]].items()}
        out.append(
            Alternative(
                rival.names[-1], float(np.exp(-0.5 * max(scaled, 0.0))), delta, tied, False, gap, held
            )
        )
    return out


def ranking(search: Search, chosen: Fit) -> tuple[Rival, ...]:
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


def remarks(search: Search, chosen: Fit, over: Band) -> tuple[str, ...]:
    """What a person should know of the verdict."""
    out = [
        f"The force balance is weighed up to {over.cutoff:.3g} Hz, where the drive ceases to explain the acceleration.",
        f"Process noise, what the most flexible balance leaves: {search.balance.noise.std:.3g} N.",
    ]
    if chosen.per_reading > 1.1:
        left = 100 * (chosen.chi2 - len(chosen.white)) / max(search.excess, 1e-300)
        out.append(
            f"{plainly(left)} % of what the declared law left beyond the noise is still unexplained; "
            "no candidate explains more than 1 % of it"
        )
    if len(search.balance.runs) > 1:
        out.append("a force periodic in time is sought with one phase over all training runs")
    return tuple(out)
