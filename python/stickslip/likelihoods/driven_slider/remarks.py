"""What a person should know of a driven slider's fit."""

from __future__ import annotations

from stickslip.declared.scale import percent
from stickslip.likelihoods.driven_slider.feedback import Feedback
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit


def remarks(balance: Balance, chosen: MotionFit, loop: Feedback, *, bare: bool = False) -> tuple[str, ...]:
    """Say how large the noise is, whether the drive answers to it, and where the mass ended; `bare` of no units."""
    noise, mass = chosen.noise, chosen.law.mass
    force, way, inertia = ("", "", "") if bare else (" N", " m", " kg")
    out = [
        f"Noise: {noise.std * mass:.3g}{force} of force, {noise.reading:.3g}{way} of the readings.",
    ]
    if loop.closed:
        out.append(
            f"The drive answers to noise of the readings: {percent(loop.share)} of what is new in it goes with theirs. "
            f"A force balance by least squares would give a mass of {loop.mass:.3g}{inertia}; the fit is of each "
            "reading from those before it, which that does not bias."
        )
    off = chosen.law.mass / balance.declared.mass - 1
    known = balance.declared.uncertainty
    if "rig_mass" not in chosen.names and abs(off) > known > 0:
        out.append(
            f"The mass is fitted {percent(abs(off))} from the declared one, "
            f"{abs(off) / known:.2g} of its standard uncertainties."
        )
    return tuple(out)
