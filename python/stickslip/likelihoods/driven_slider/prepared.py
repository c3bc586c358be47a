"""From recordings of a driven slider to what is fitted, and from a fit to its model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, DrivenSlider
from stickslip.declared.uncertainty import Uncertainty
from stickslip.errors import InputError
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import DeclaredMass, MotionFit
from stickslip.likelihoods.driven_slider.motion import Band, band, motion
from stickslip.measured.findings import FindingKind
from stickslip.measured.recording import Recording

SPOILT = (FindingKind.GAP, FindingKind.IRREGULAR, FindingKind.SIZE)  # findings that no fit can do with


def coulomb(law: object) -> CoulombFriction:
    """The law, if it is Coulomb's; or raise `InputError`."""
    if not isinstance(law, CoulombFriction):
        raise InputError("the law of a driven slider is coulomb; declare kind = 'coulomb'", key="friction")
    return law


def check(law: FrictionLaw, rig: AnyRig, runs: Sequence[Recording]) -> None:
    """Raise `InputError` for a law that is not Coulomb's, and for a run of another rig."""
    coulomb(law)
    for run in runs:
        if run.rig != rig:
            words = "has another rig than the case; one model is fitted to all runs of a driven slider"
            raise InputError(f"{run.name}: {words}", key="[[run]] rig")


def check_samples(runs: Sequence[Recording]) -> None:
    """Raise `InputError` for runs that are irregularly sampled, or contradict the declared mass."""
    for run in runs:
        for finding in run.findings:
            if finding.kind in SPOILT:
                raise InputError(f"{run.name}: {finding}")


def declared_mass(rig: DrivenSlider, known: Uncertainty) -> DeclaredMass:
    """The mass, as nearly known as a motion shows it in the units of the drive and of the way."""
    gains = [known.gains.get(name, 0.0) for name in ("drive", "x1")]
    return DeclaredMass(rig.mass, float(np.hypot(known.relative("mass"), np.linalg.norm(gains))))


def shown_band(runs: Sequence[Recording], rig: DrivenSlider) -> Band:
    """The band in which the drive of the longest run explains its acceleration."""
    first = max(runs, key=len)
    assert first.drive is not None
    return band(first.t, first.x1, first.drive, rig.mass)


def balance(runs: Sequence[Recording], declared: DeclaredMass) -> Balance:
    """The motion of some recordings."""
    out = []
    for run in runs:
        assert run.drive is not None
        out.append(motion(run.name, run.t, run.x1, run.drive, declared.mass))
    if all(one.rest.all() for one in out):
        words = "no sample is beyond doubt in motion; a force balance needs a slider that slides"
        raise InputError(f"{', '.join(one.name for one in out)}: {words}")
    return Balance(out, declared)


def fitted_model(declared: Model, fit: MotionFit) -> Model:
    """The declared model with the law and the mass of a fit: friction at rest as great as at the lowest speed."""
    law = fit.law
    minus, plus = max(law.minus, 0.0), max(law.plus, 0.0)
    friction = CoulombFriction(static=minus, kinetic=minus, static_plus=plus, kinetic_plus=plus)
    assert isinstance(declared.rig, DrivenSlider)
    rig = replace(declared.rig, mass=law.mass, damping=max(law.damping, 0.0))
    return replace(declared, rig=rig, friction=friction)
