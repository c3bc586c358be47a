"""The law of a driven slider from its recordings, in the force noise that `discover` knows, too."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw, given_numbers
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, DrivenSlider
from stickslip.declared.uncertainty import Uncertainty
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.constant import Constant
from stickslip.fitted.identified import BRANCHES, Branch, Estimate, ForcePoints, Identified, Status
from stickslip.likelihoods.driven_slider.banded import BandedBalance
from stickslip.likelihoods.driven_slider.dictionary import Dictionary
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.driven_slider.gate import Lacking, lacking
from stickslip.likelihoods.driven_slider.held_out import HeldOut, held_out
from stickslip.likelihoods.driven_slider.identify_words import Told, messages
from stickslip.likelihoods.driven_slider.intervals import LAW, intervals, law_covariance
from stickslip.likelihoods.driven_slider.motion import stacked
from stickslip.likelihoods.driven_slider.prepared import (
    balance,
    check,
    check_samples,
    coulomb,
    declared_mass,
    fitted_model,
    shown_band,
)
from stickslip.measured.case import Case
from stickslip.measured.recording import Recording
from stickslip.measured.thinning import MOST_SEARCHED, Thinned, sentences, thinned

Floats = NDArray[np.float64]
Tell = Callable[[str, float], None]

SILENT, LEANS = 0.99, 0.1  # shares of the declared in what is known of a number, as of an `Estimate`
WIDE = 1 / 3  # of a number, above which its standard deviation leaves it weak
SIDES: Mapping[Branch, tuple[str, str, float]] = {
    "minus": ("kinetic", "static", -1.0),
    "plus": ("kinetic_plus", "static_plus", 1.0),
}


@dataclass(frozen=True)
class DrivenMaterial:
    """What is identified from: a declared model, its runs, what was given of its law, how well constants are known."""

    model: Model
    train: Sequence[Recording]
    validate: Sequence[Recording]
    given: Mapping[str, float]
    known: Uncertainty
    thinned: tuple[Thinned, ...]

    @property
    def rig(self) -> DrivenSlider:
        """The declared rig."""
        assert isinstance(self.model.rig, DrivenSlider)
        return self.model.rig


def identify_driven(
    source: Case | Recording | Sequence[Recording],
    *,
    rig: AnyRig | None = None,
    friction: FrictionLaw | Mapping[str, FrictionLaw] | None = None,
    progress: Tell | None = None,
) -> Identified:
    """Identify friction and damping of a driven slider, and its mass as far as it is in doubt.

    Every reading is predicted from those before it, in reading noise and coloured force noise whose sizes and memory
    are fitted, too (`stickslip.likelihoods.driven_slider.noise`): a drive that answers to the readings biases nothing.

    Parameters
    ----------
    source
        A case, of which the "train" runs are fitted and the "validate" runs, if any, are forecast; or recordings.
    rig
        That of the source, or None.
    friction
        The declared law, Coulomb's; nothing is held at its numbers.
    progress
        Called with what is being done and the share done.

    Raises
    ------
    InputError
        Another law or rig, a record that is too short, irregular or never moves, or that contradicts the mass.
    StickslipError
        No mass moves as the record does.
    """
    tell = progress or (lambda _what, _share: None)
    tell("looking at the readings", 0.0)
    material = _material(source, rig, None if friction is None else coulomb(friction))
    check(material.model.friction, material.rig, (*material.train, *material.validate))
    check_samples(material.train)
    band = shown_band(material.train, material.rig)
    fitted = balance(material.train, declared_mass(material.rig, material.known))
    tell("fitting the law and the noise", 0.1)
    fit = fitted.settle()
    if not math.isfinite(fit.law.mass):
        words = "the slider does not move as a drive moves a mass: is the drive's sign or column wrong?"
        raise StickslipError(words)
    tell("looking for what the law lacks", 0.5)
    lacks = lacking(Dictionary(fitted), fit)
    fitted.at(fit)
    shown = BandedBalance(fitted, band)
    found = _found(material, shown, fit, lacks)
    tell("forecasting the validate runs", 0.9)
    held = held_out(material.validate, shown, fit, found.model)
    told = Told(fitted, fit, found, lacks, held, material.known)
    said = (*sentences(material.thinned), *messages(told))
    tell("done", 1.0)
    return replace(found, messages=said, diagnostics={**found.diagnostics, **_of_runs(held)})


def _material(
    source: Case | Recording | Sequence[Recording], rig: AnyRig | None, friction: FrictionLaw | None
) -> DrivenMaterial:
    if isinstance(source, Case):
        model = source.model(friction=friction)
        train, validate = ([r for r in source.runs if r.role == role] for role in ("train", "validate"))
        undeclared = source.undeclared if friction is None else ()
        known = source.uncertainty
    else:
        train, validate = [source] if isinstance(source, Recording) else list(source), []
        undeclared = () if friction is not None else tuple(vars(CoulombFriction()))
        known = None
    if not train:
        raise InputError("no run to identify from: the case has no run with role 'train'")
    own = train[0].rig if known is None else source.rig  # type: ignore[union-attr]
    if rig not in (None, own):
        raise InputError("a driven slider is declared with its recordings; leave it out", key="rig")
    if known is None:
        channels = dict(train[0].channels)
        model = Model(own, friction=friction or CoulombFriction(), channels=channels)
        known = Uncertainty.usual(own, channels=channels)
    train, less = thinned(train, own, MOST_SEARCHED)
    validate, more = thinned(validate, own, MOST_SEARCHED) if validate else (validate, ())
    given = given_numbers(model.friction, undeclared)
    return DrivenMaterial(model, train, validate, given, known, (*less, *more))


def _found(material: DrivenMaterial, shown: BandedBalance, fit: MotionFit, lacks: Lacking) -> Identified:
    """What a fit says, but for sentences."""
    fitted, force = shown.balance, fit.noise.std * fit.law.mass
    covariance = law_covariance(fitted, fit)
    law, estimates = _law(material, fitted, fit, covariance)
    made = replace(fitted_model(material.model, fit), friction=law)
    kept = [name for name in LAW if name in estimates and estimates[name].std and estimates[name].value > 0]
    places = [list(LAW).index(name) for name in kept]
    drive = np.concatenate([run.command for run in fitted.runs])
    channels, noise = material.model.channels, material.model.noise
    return Identified(
        rig=material.rig,
        law=law,
        estimates=estimates,
        names=tuple(kept),
        covariance=covariance[np.ix_(places, places)],
        covered=_covered(fitted),
        noise={"x1": fit.noise.reading, "drive": force},
        reduced_chi2=fit.per_reading,
        force=_points(shown, fit),
        constants=_constants(estimates, fitted.declared.uncertainty),
        fitted=made,
        diagnostics={
            "runs": float(len(material.train)),
            "readings": float(fit.count),
            "noise_of_drive": force / math.sqrt(float(np.mean(drive**2))),
            "gain_of_best_effect": lacks.gain,
            "gain_of_noise": lacks.threshold,
        },
        thinned=material.thinned,
        channels=None if channels is None else dict(channels),
        reading_noise=None if noise is None else dict(noise),
    )


def _law(
    material: DrivenMaterial, fitted: Balance, fit: MotionFit, covariance: Floats
) -> tuple[CoulombFriction, dict[str, Estimate]]:
    """The law, and estimates of its numbers, of the damping, and of a mass that is not exact."""
    numbers, known = intervals(fitted, fit).law, fitted.declared.uncertainty
    seen = [name for name, one in numbers.items() if one.low is not None and (known > 0 or name != "mass")]
    unseen = [name for name, _, _ in SIDES.values() if name not in seen]
    law = _unseen(fitted_model(material.model, fit).friction.numbers, unseen, material.given)
    declared = {"mass": material.rig.mass, "damping": material.rig.damping, **material.given}
    order = [name for kinetic, static, _ in SIDES.values() for name in (static, kinetic)]
    estimates = {
        name: Estimate(law[name], None, None, None, "unidentified", declared.get(name)) for name in order
    }
    for name in seen:
        one, i = numbers[name], list(LAW).index(name)
        std = math.sqrt(max(float(covariance[i, i]), 0.0))
        share = (std / (one.value * known)) ** 2 if name == "mass" else 0.0
        status = _status(one.value, std, share)
        estimates[name] = Estimate(one.value, one.low, one.high, std, status, declared.get(name))
    return CoulombFriction(**law), estimates


def _unseen(law: Mapping[str, float], unseen: Sequence[str], given: Mapping[str, float]) -> dict[str, float]:
    """The law's numbers; friction of a direction never taken as declared, or as in the other one."""
    out = dict(law)
    for name, other in (("kinetic", "kinetic_plus"), ("kinetic_plus", "kinetic")):
        if name in unseen:
            out[name] = given.get(name, law[other])
            static = name.replace("kinetic", "static")
            out[static] = max(given.get(static, out[name]), out[name])
    return out


def _status(value: float, std: float, share: float) -> Status:
    if share >= SILENT:
        return "unidentified"
    return "weak" if share > LEANS or std > WIDE * abs(value) else "identified"


def _constants(estimates: Mapping[str, Estimate], known: float) -> dict[str, Constant]:
    """Mass and damping beside what is declared; a damping of 0 is none that was declared."""
    out = {}
    for name, uncertainty in (("mass", known), ("damping", None)):
        one = estimates.get(name)
        if one is None or one.low is None or one.high is None or not one.declared:
            continue
        out[name] = Constant(one.value, one.low, one.high, one.declared, uncertainty)
    return out


def _covered(fitted: Balance) -> dict[Branch, tuple[float, float] | None]:
    """Range of the speed in either direction, where it is beyond doubt."""
    v = np.concatenate([run.v[~run.rest] for run in fitted.runs])
    covered: dict[Branch, tuple[float, float] | None] = {}
    for branch in BRANCHES:
        u = SIDES[branch][2] * v
        u = u[u > 0]
        covered[branch] = (float(u.min()), float(u.max())) if u.size else None
    return covered


def _points(shown: BandedBalance, fit: MotionFit) -> ForcePoints:
    """What the drive leaves beside inertia and damping, within the band, over the velocity."""
    v = stacked(shown.balance.runs, shown.band, lambda run: run.v)
    T = shown.force - fit.law.mass * shown.inertia - fit.law.damping * v
    rest = np.concatenate([run.rest[shown.band.kept(len(run.t))] for run in shown.balance.runs])
    run = np.repeat(np.arange(len(shown.lengths), dtype=np.float64), shown.lengths)
    std = np.full(len(T), shown.floor(fit, at_rest=False))
    return ForcePoints(v, T, std, np.where(rest, 0.0, np.sign(v)), run)


def _of_runs(held: HeldOut | None) -> dict[str, float]:
    if held is None:
        return {}
    return {
        "held_out_force": held.force,
        "held_out_force_of_noise": held.floor,
        "held_out_position": held.position,
        "held_out_position_of_noise": held.position_floor,
    }
