"""What an identification of a driven slider says in sentences beside its table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.scale import percent, plainly, scales
from stickslip.declared.uncertainty import Uncertainty
from stickslip.fitted.identified import Identified
from stickslip.fitted.identify_words import EXPLAINED
from stickslip.likelihoods.driven_slider.feedback import feedback
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.driven_slider.gate import Lacking
from stickslip.likelihoods.driven_slider.held_out import HeldOut
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.driven_slider.remarks import remarks
from stickslip.likelihoods.policy import POLICY


@dataclass(frozen=True)
class Told:
    """What there is to be said: the fit, what was made of it, what the law lacks, how it does on runs not fitted."""

    balance: Balance
    fit: MotionFit
    found: Identified
    lacks: Lacking
    held: HeldOut | None
    known: Uncertainty

    @property
    def bare(self) -> bool:
        """Whether the rig has no units."""
        return any(one.unit == "1" for one in (self.found.channels or {}).values())


def messages(told: Told) -> tuple[str, ...]:
    """Say how well the law explains the readings, what it does on runs not fitted, and what is not told."""
    loop = feedback(told.balance, told.fit)
    return (
        *_explained(told),
        *remarks(told.balance, told.fit, loop, bare=told.bare),
        *_constants(told.found),
        *_held_out(told),
        *_numbers(told),
    )


def _explained(told: Told) -> list[str]:
    found, lacks = told.found, told.lacks
    share = percent(found.diagnostics["noise_of_drive"])
    out = [
        f"fitted on {told.fit.count} readings: chi-squared {plainly(found.reduced_chi2, 3)} per degree of freedom in "
        f"noise that is fitted, too; that of the force is {share} of the drive"
    ]
    words = "the intervals know nothing of what it leaves, and `stickslip discover` looks for what is missing"
    if lacks.seen:
        out.append(
            f"the declared law does not explain the readings: {lacks.name} beside it lowers -2 log likelihood by "
            f"{plainly(lacks.gain, 3)}, where noise alone passes {plainly(lacks.threshold, 3)} on "
            f"{plainly(100 * POLICY.false_alarm)} of 100 records; {words}"
        )
    elif found.reduced_chi2 > EXPLAINED:
        out.append(f"the declared law does not explain the readings; {words}")
    else:
        out.append("no single effect of the catalogue explains more of what the law leaves than noise does")
    return out


def _constants(found: Identified) -> list[str]:
    return [
        f"{name} {one.value:.4g}, or what acts like it (a gain of the drive does exactly the same), is not "
        f"{one.declared:.4g} as declared: `stickslip discover` looks for what else there is"
        for name, one in found.constants.items()
        if one.beyond
    ]


def _held_out(told: Told) -> list[str]:
    held = told.held
    if held is None:
        return []
    if held.why:
        return [f"validate runs: {held.why}"]
    force, noise = percent(held.force), percent(held.floor)
    out = f"validate runs: {force} of the drive's force is unexplained (noise as fitted: {noise})"
    if np.isfinite(held.position):
        known = scales(told.found.rig, told.found.channels)
        off, least = (known["x1"].of(one, 3) for one in (held.position, held.position_floor))
        out += f"; positions {known['t'].of(STEER.ahead)} ahead are off by {off} (noise as fitted: {least})"
    return [out]


def _numbers(told: Told) -> list[str]:
    estimates = told.found.estimates
    out = ["friction at rest is left free: the static limit is taken as great as friction in motion"]
    for name, sign in (("kinetic", "< 0"), ("kinetic_plus", "> 0")):
        one = estimates[name]
        if one.status == "unidentified":
            whose = (
                "the declared friction is kept"
                if one.declared is not None
                else "the other direction's is repeated"
            )
            out.append(f"the slider never moves with x2 {sign}: {whose} as {name}")
    low = [name for name in ("mass", "damping", "kinetic", "kinetic_plus") if name in estimates]
    below = [name for name in low if estimates[name].value < 0]
    if below:
        out.append(
            f"{_and(below)} below 0, which creates energy: 0 in the model; are drive and x1 counted the same way?"
        )
    weak = [name for name in low if estimates[name].status == "weak"]
    if weak:
        out.append(f"only weakly determined by these runs: {', '.join(weak)}")
    if "mass" in estimates and estimates["mass"].status == "unidentified":
        out.append("the mass is as declared: the readings say no more of it")
    gain = float(np.linalg.norm([told.known.gains.get(name, 0.0) for name in ("drive", "x1")]))
    if gain > 0:
        out.append(
            "friction and damping are as the drive is scaled: that the gains of drive and x1 are known to "
            f"{percent(gain)} is not in their intervals"
        )
    return out


def _and(names: Sequence[str]) -> str:
    return f"{' and '.join(names)} {'is' if len(names) == 1 else 'are'}"
