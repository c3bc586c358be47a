"""Rivals of what was found, and the algebra by which some of them can never be told apart by runs of this kind."""

from __future__ import annotations

import numpy as np

from stickslip.declared.effect import CONSTANTS
from stickslip.discovery.result import Alternative, Evidence, Interval
from stickslip.discovery.slider.choose import TIED, Choice
from stickslip.discovery.slider.numbers import parameters
from stickslip.discovery.slider.weigh import PRICE, Weighed, columns_of

EXACT = 1e-6
MOST = 5


def alternatives(one: Weighed, choice: Choice) -> tuple[Alternative, ...]:
    """The nearest rivals of one effect, those that tie first."""
    out = []
    for rival in choice.rivals[one.candidate.name][:MOST]:
        delta = one.score - rival.score
        exact = _same(one, rival, choice)
        tied = exact or delta < TIED
        odds = float(np.exp(-0.5 * np.clip(delta, -60, 60)))
        values: dict[str, Interval] = {} if exact and len(choice.chosen) > 1 else parameters(rival, choice)
        name = rival.candidate.name
        out.append(
            Alternative(
                name, 1.0 if exact else odds, delta, tied, exact, _reason(one, name, exact, choice), values
            )
        )
    out += set_point(one.candidate.name)
    return tuple(sorted(out, key=lambda a: (not a.tied, a.delta)))


def _same(one: Weighed, rival: Weighed, choice: Choice) -> bool:
    """Do both, each beside the others chosen, span the same columns?"""
    others = [w.candidate for w in choice.chosen if w is not one]
    a = columns_of(choice.white, [one.candidate, *others])
    b = columns_of(choice.white, [rival.candidate, *others])
    if a.shape != b.shape:
        return False
    q, _ = np.linalg.qr(a)
    left = b - q @ (q.T @ b)
    return bool(np.all(np.linalg.norm(left, axis=0) < EXACT * np.maximum(np.linalg.norm(b, axis=0), 1e-300)))


def _reason(one: Weighed, name: str, exact: bool, choice: Choice) -> str:
    own = one.candidate.name
    pair = {own, name}
    chosen = {w.candidate.name for w in choice.chosen}
    if exact and {own, name} <= set(CONSTANTS) and len(chosen & set(CONSTANTS)) > 1:
        return (
            "one spring shows two numbers, the rise of its sticks and the frequency sqrt(k/m) of its slips, and three "
            "constants share them: weigh the block, or load the sensor with a known force"
        )
    if exact and pair == {"sensor_gain", "sensor_drift"}:
        return (
            "at one belt speed a drift of the reading raises every stick alike; a second speed separates them"
        )
    if exact and pair == {"rig_mass", "rig_stiffness"}:
        return "a recorded deflection shows k/m only: a second spring, or weighing the block, separates them"
    if exact:
        return "the two change the same number of every event in the same way"
    if pair == {"sensor_gain", "rig_stiffness"}:
        return "both raise the sticks alike; the spring also quickens the slips, as sqrt(k/m)"
    if pair == {"belt_seam", "harmonic_forcing"}:
        return (
            "along the belt or in time is the same at one speed; speeds whose runs last several periods tell"
        )
    return "found among the rivals, each fitted in the place of the winner"


def set_point(name: str) -> tuple[Alternative, ...]:
    """Return what a gain is as well, no reading being another: a belt of another multiple of its set-points."""
    if name != "sensor_gain":
        return ()
    reason = (
        "a true belt speed of (1 + e) times the set-point, in every run alike, gives the same readings to the last: "
        "measure the speed of the pull"
    )
    return (Alternative("belt speed", 1.0, 0.0, True, True, reason, {}),)


def evidence(one: Weighed, choice: Choice, held_out: float) -> Evidence:
    """Why one effect is believed."""
    rivals = [
        w
        for w in choice.rivals[one.candidate.name]
        if one.score - w.score >= TIED and not _same(one, w, choice)
    ]
    control = max(rivals, key=lambda w: w.gain, default=None)
    numbers = one.candidate.parameters
    count = choice.white.events
    gain, threshold = one.gain, choice.null.threshold + PRICE * (numbers - 1)
    against = (
        f"; the best wrong effect, {control.candidate.name}, gains {control.gain:.3g}" if control else ""
    )
    sentence = (
        f"lowers -2 log likelihood by {gain:.3g} for {numbers} number{'s' if numbers > 1 else ''}, with friction that "
        f"differs from event to event in both; process noise alone passes {threshold:.3g} in 2 % of draws{against}"
    )
    return Evidence(
        delta_chi2=gain,
        delta_bic=gain - numbers * float(np.log(count)),
        held_out_ratio=held_out,
        control=control.gain if control else None,
        control_name=control.candidate.name if control else "",
        threshold=threshold,
        sentence=sentence,
    )


__all__ = ["alternatives", "evidence"]
