"""Plain words for a verdict: what each effect is, where it sits, how sure one can be.

One file, as a report is read from top to bottom: what one sentence says the next need not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from stickslip.declared.catalogue import CONSTANTS, KINDS
from stickslip.declared.rig import BlockOnBelt
from stickslip.declared.scale import percent
from stickslip.declared.si import OF_VARIABLES
from stickslip.discovery.errors import DRAWS
from stickslip.discovery.general_rig.result import GeneralFound
from stickslip.discovery.residual import LIMIT
from stickslip.discovery.result import (
    TIED,
    Alternative,
    Found,
    FoundEffect,
    Part,
    Residual,
    Verdict,
)
from stickslip.likelihoods.interval import Interval
from stickslip.likelihoods.policy import POLICY
from stickslip.shown.report.units import Axes, Axis

PLAIN: Mapping[str, str] = {
    **{kind.name: kind.words for kind in KINDS.values()},
    "unlisted": "something that has no name in the catalogue",
}
PLACE: Mapping[str, str] = {
    "block": "on the block",
    "angle_body": "on the angle body",
    "both": "between block and angle body",
    "contact": "in the contact",
    "belt": "in the belt drive",
    "drive": "in the drive",
    "x1 channel": "in the x1 channel",
    "y1 channel": "in the y1 channel",
}

FAR = 50.0  # chi-squared per reading that no verdict should rest on
FEW = 3  # effects that a sentence can hold without numbers

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def plain(name: str) -> str:
    """An effect in plain words; a name that has none is given back."""
    return PLAIN.get(name, name.replace("_", " "))


def kind(effect: FoundEffect) -> str:
    """What is found, in plain words."""
    return "a declared number of the rig that is wrong" if effect.of_rig else plain(effect.name)


def called(effect: FoundEffect) -> str:
    """An effect in plain words; one at a place of a rig of bodies or matrices by its name and that place."""
    if (effect.where, effect.name) == ("drive", "belt_speed_ripple"):
        return "a ripple of the drive's speed"
    if effect.of_rig or effect.where in PLACE:
        return kind(effect)
    return f"{effect.name.replace('_', ' ')} of {effect.where}"


def guessed(effect: FoundEffect) -> bool:
    """Whether nothing describes the effect, so that its place is the likeliest, and its evidence holds no numbers."""
    return effect.name == "unlisted" and effect.curve is None and not effect.of_rig and not effect.parameters


def joined(words: Sequence[str]) -> str:
    """Words as prose: a, b and c."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1] if words else ""


def sentence(text: str) -> str:
    """A remark as a sentence: capital, full stop, ±; the name of a run or of an effect stays as it is."""
    first = text.partition(" ")[0].rstrip(",")
    head = text[:1].upper() if first.replace("-", "").isalpha() else text[:1]
    return f"{head}{text[1:].rstrip('.')}.".replace("+-", "±")


def ties(effect: FoundEffect) -> list[Alternative]:
    """The rivals that the readings cannot tell from the effect."""
    return [one for one in effect.alternatives if one.tied]


def hopeless(found: Found) -> bool:
    """Whether the best of all that was tried is still far from the readings and forecasts no better than nothing."""
    if found.verdict is Verdict.no_effect:
        return False
    return found.residual_after.chi2 > FAR and found.error.after > 0.9 * found.error.before


def headline(found: Found) -> str:
    """The verdict as one sentence; a tie is part of it, and that it does not carry over is another."""
    said, error = _verdict(found), found.error
    if not found.effects or hopeless(found) or (error.carries and not error.rises):
        return said
    rise = f"rises from {error.before:.3g} to {error.after:.3g}"
    if error.carries:
        alone = "noise" if isinstance(found, GeneralFound) else "friction of events to come"
        floor = f"{alone} alone makes {error.floor:.3g}"
        return (
            f"{said} The error on runs that were not used {rise} ({floor}), but they do not speak against it."
        )
    why = f"the error on them {rise}" if error.rises else "they are less likely with it"
    return f"{said} It does not carry over to runs that were not used: {why}."


def _verdict(found: Found) -> str:
    """The verdict alone."""
    if hopeless(found):
        times = short(math.sqrt(found.residual_after.chi2), 2)
        return (
            f"No explanation found: the best of all that was tried is still off by {times} times the noise and "
            "forecasts no better. Check the rig's declared numbers, the units and the belt speeds first."
        )
    if found.unclaimed:
        names = joined([called(one) for one in found.unclaimed])
        them = "it" if len(found.unclaimed) == 1 else "them"
        return f"Nothing is claimed: the train runs name {names}, but runs not used speak against {them}."
    if (
        found.verdict is Verdict.no_effect
        and not found.scatter
        and (there := found.after.scatter) is not None
    ):
        differs = max(there.kinetic, there.static)
        if differs > POLICY.repeats:  # all events share what the model lacks, and no cause was found
            return (
                "Nothing can be named: the declared model explains the readings only with friction that is "
                f"{percent(differs)} off in every event, and no cause of that was found."
            )
    if (
        found.verdict is Verdict.no_effect
        and isinstance(found.before.rig, BlockOnBelt)
        and (found.scatter or not found.residual_after.clean or _above(found.residual_after))
    ):
        return "Nothing can be named: no cause stands out from friction that differs from event to event."
    if found.verdict is Verdict.no_effect and (
        not found.residual_after.clean or _above(found.residual_after)
    ):
        return (
            "Nothing can be named: a little is left above the noise, but no effect and no curve takes it up."
        )
    if found.verdict is Verdict.no_effect and found.residual_after.correlated:
        return "Nothing can be named: what is left is no larger than the noise, but it is no white noise."
    if found.verdict is Verdict.no_effect and found.never:
        never = f"the block never {found.never} in these runs"
        return f"Nothing shows as missing, but {never}: little of the friction law is tested."
    if found.verdict is Verdict.no_effect:
        return "Nothing is missing: the declared model explains the readings down to their noise."
    if found.verdict is Verdict.unlisted_effect:
        effect = next((e for e in found.effects if e.name == "unlisted"), found.effects[0])
        on = joined([v for v in effect.depends_on if v != "memory"])
        variables = f", as a function of {on}" if on else ""
        memory = " with a memory" if "memory" in effect.depends_on else ""
        others = [plain(e.name) for e in found.effects if e is not effect]
        beside = f", beside {joined(others)}" if others else ""
        place = PLACE.get(effect.where, f"at {effect.where}")
        acts = "acts, most likely" if guessed(effect) else "acts"
        return f"Something that is not in the catalogue {acts} {place}{variables}{memory}{beside}."
    if found.residual_after.chi2 > FAR:
        best = f"of all that was tried {joined([called(one) for one in found.effects])} comes nearest"
        return f"Not explained: {best}, and leaves {short(math.sqrt(found.residual_after.chi2), 2)} times the noise."
    if all(e.of_rig for e in found.effects):
        return f"A declared number of the rig is wrong: {'; '.join(e.formula for e in found.effects)}."
    lacking = [
        f"what mends the rig ({e.formula})"
        if e.of_rig
        else " or ".join((called(e), *(plain(a.name) for a in ties(e))))
        for e in found.effects
    ]
    tied = any(ties(e) for e in found.effects)
    if len(lacking) == 1 or (
        len(lacking) <= FEW and not tied
    ):  # "and" and "or" in one sentence may be read either way
        return (
            f"The declared model lacks {joined(lacking)}{': these runs cannot tell which' if tied else ''}."
        )
    listed = "; ".join(f"({i}) {one}" for i, one in enumerate(lacking, 1))
    settled = '; where it says "or" these runs cannot tell which' if tied else ""
    return f"The declared model lacks {len(lacking)} things: {listed}{settled}."


def sureness(found: Found) -> list[str]:
    """How sure: of there being something, then of each name."""
    g, count = found.gate, len(found.gate.draws)
    if found.verdict is Verdict.no_effect:
        if math.isinf(g.threshold):
            return ["No effect was tried."]
        chance = (
            f"; noise alone does that in {_share(found)} of {count} simulated records like these"
            if count
            else ""
        )
        if g.observed > g.threshold:
            believed = "It is not believed: its own size is not told, or scatter may pass for it."
        else:
            believed = f"To be believed it must lower it by {short(g.threshold, 3)}."
        lines = [f"The best candidate lowers chi-squared by {short(g.observed, 3)}{chance}. {believed}"]
        if found.residual_after.clean:
            lines.append("An effect too small to show above the noise of these runs is not excluded.")
        return lines
    lines = [_something(found)]
    if not found.residual_after.clean and found.verdict is Verdict.effect_found:
        names = joined([effect.name for effect in found.effects])
        lines.append(
            f"But no name tried explains the readings down to their noise; {names} is the best of them."
        )
    return lines + [_of_the_name(found, effect) for effect in found.effects]


def _something(found: Found) -> str:
    """Whether there is something at all: sure only where no simulated record reaches what the readings show."""
    g = found.gate
    if g.observed <= g.threshold:
        for one in found.effects:
            if one.name in CONSTANTS:
                return f"A number of the rig is not as declared: {one.name} is {one.evidence.sentence}."
        return "Something is missing, though no effect of the list lowers chi-squared by more than noise may."
    best = f"the best single candidate lowers chi-squared by {short(g.observed, 3)}"
    if any(one >= g.observed for one in g.draws):
        share, count = _share(found), len(g.draws)
        return f"Something is missing, in all likelihood: {best}; noise alone does that in {share} of {count} records."
    return f"Something is missing, that is sure: {best}; {alarms(found)}."


def alarms(found: Found) -> str:
    """What noise alone does to chi-squared."""
    g, count = found.gate, len(found.gate.draws)
    if not count:
        return f"at least {short(g.threshold, 3)} is asked for"
    most = short(float(max(g.draws)), 3)
    return f"in {count} simulated records with noise alone the best did so by at most {most}"


def _share(found: Found) -> str:
    share = sum(float(one) >= found.gate.observed for one in found.gate.draws) / len(found.gate.draws)
    return percent(share) if share else "none"


def _of_the_name(found: Found, effect: FoundEffect) -> str:
    equal = ties(effect)
    curve = effect.name == "unlisted"
    if hopeless(found):
        name = "A learned curve" if curve else effect.name
        return f"{name} came nearest. That is no finding: what it leaves is far too much, and it does not forecast."
    if guessed(effect):
        on = " and on what" if effect.depends_on else ""
        return f"Where it acts{on} is the likeliest guess: no name and no curve explains the readings."
    if not curve and found.residual_after.chi2 > FAR:
        return f"The name {effect.name} does not stand: with so much left it may stand in for something else."
    who = "Where it acts and on what" if curve else f"The name {effect.name}"
    if effect.of_rig:
        who = f"That it is {joined(list(effect.parameters))}"
    if equal:
        odds = joined([f"{one.name} ({_tie(one)})" for one in equal])
        exact = " The tie is exact: no run of this kind can break it." if any(a.exact for a in equal) else ""
        return f"{who} is NOT settled: these runs cannot tell it from {odds}.{exact}"
    if effect.alternatives:
        nearest = max(effect.alternatives, key=lambda one: one.odds)
        against = f"{short(1 / nearest.odds, 2)} to 1" if nearest.odds > 1e-12 else "beyond 10¹² to 1"
        return f"{who} stands: the odds against the nearest rival, {nearest.name}, are {against}."
    return (
        f"{who} stands: no rival comes near."
        if effect.evidence.control_name
        else f"{who} {_beside_the_rest(found)}"
    )


def _beside_the_rest(found: Found) -> str:
    """How far the next best lies where nothing was tried in the very place of what was chosen."""
    others = [one for one in found.ranking if one.names and not one.chosen and math.isfinite(one.bic)]
    best = next((one.bic for one in found.ranking if one.chosen), 0.0)
    if not others:
        return "was held against no rival."
    nearest = min(others, key=lambda one: one.bic)
    above = nearest.bic - best
    if above <= 0:
        return f"is NOT settled: the evidence for {' + '.join(nearest.names)} is no worse."
    return (
        f"was held against no rival of its kind; of all that was tried {' + '.join(nearest.names)} comes nearest, its "
        f"-2 log evidence higher by {short(above, 3)}."
    )


def _tie(one: Alternative) -> str:
    """How a rival stands that cannot be told from a name; odds for one that scatter may have made are no odds."""
    return "it fits better, but as scatter might" if one.delta < -TIED else _odds(one.odds)


def _odds(odds: float) -> str:
    return f"odds {short(odds, 2)} to 1"


def spanned(one: Interval) -> tuple[str, str]:
    """A value and its 95 % interval, with as many digits as the interval has two of."""
    if one.low is None or one.high is None:
        return short(one.value), "–"
    width, size = abs(one.high - one.low), max(abs(one.low), abs(one.high), abs(one.value))
    digits = 4 if width <= 0 or size <= 0 else max(3, min(9, 2 + math.floor(math.log10(size / width) + 1)))
    return short(one.value, digits), f"{short(one.low, digits)} … {short(one.high, digits)}"


def short(value: float | None, digits: int = 4) -> str:
    """A number for a person: plain up to a million, then with a power of ten; a dash where there is none."""
    if value is None or not math.isfinite(value):
        return "–"
    rounded = float(f"{value:.{digits}g}")  # 99.7 is 100 in two digits
    size = abs(rounded)
    if size == 0 or 1e-3 <= size < 10**digits:
        text = f"{rounded:.{digits}g}"
    elif 1 <= size < 1e7:
        text = f"{rounded:,.0f}".replace(",", "\u202f")
    else:
        mantissa, _, power = f"{value:.{max(digits - 1, 0)}e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        text = f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPT)}"
    return text.replace("-", "−")


def _above(left: Residual) -> list[Part]:
    """Channels in which more than noise is left: a noise taken too large in one must not hide another."""
    return [p for p in left.parts if p.what == "channel" and p.chi2 > 1 + LIMIT * p.error]


def clean_sentence(found: Found) -> str:
    """Whether anything is left after the cure."""
    before, after = found.residual_before, found.residual_after
    error = f"± {short(after.error, 1)}"
    if after.clean and (above := _above(after)):
        names = " and ".join(f"{p.name} ({short(p.chi2)})" for p in above)
        return (
            f"Not all is noise: chi-squared per reading is {short(after.chi2)} {error} in all, but more than noise "
            f"leaves in channel {names}."
        )
    if after.clean and after.correlated:
        return (
            f"Not all is white noise: chi-squared per reading is {short(after.chi2)} {error}, but what is left in "
            f"{joined(after.correlated)} goes on from reading to reading. The noise was taken too large and hides an "
            "effect, or it is a filter's."
        )
    if after.clean:
        return f"What is left is noise: chi-squared per reading is {short(after.chi2)} {error}."
    if found.effects and after.chi2 > before.chi2 + 2 * math.hypot(before.error, after.error):
        return (
            f"Reading by reading more is left than before: chi-squared per reading is {short(after.chi2)} {error}, "
            f"{short(before.chi2)} without what was found, and noise alone leaves 1.{_other_measure(found)}"
        )
    return (
        f"Not all is explained: chi-squared per reading is still {short(after.chi2)} {error} "
        "where noise alone leaves 1."
    )


def _other_measure(found: Found) -> str:
    """What was fitted instead, where that is not the readings."""
    if not isinstance(found.before.rig, BlockOnBelt):
        return ""
    return (
        " That is not what was fitted: what was found explains how events differ from each other (their levels of "
        "friction, stick rates, slip frequencies), not the course of the readings within one."
    )


def floor(found: Found, *, single: bool) -> str:
    """How the floor of the error was estimated."""
    if single:
        return (
            "is the noise of the readings over their standard deviation in an event; the few numbers fitted to each "
            "event take up a little of the noise. It is the same for both models."
        )
    if found.scatter:
        return (
            "is what a model that is right leaves: the noise of the readings, and the friction of the events to come, "
            "which nobody can know. Both models have it in their error."
        )
    which = "with what was found" if found.effects else "declared"
    return (
        f"is the error of the model {which} on records that it simulated itself, with fresh noise, forecast in "
        f"the same way: the mean of {DRAWS} draws, so that an error, with the one draw that was measured, can lie "
        "below it. Grey: before and after differ by less than the floor, so that the difference says nothing."
    )


def caveats(found: Found, axes: Axes | None = None) -> list[str]:
    """What this verdict does not say; numbers in the units of the axes, else the model's own."""
    out = [sentence(one) for one in found.messages]
    loose = [name for name, one in found.law.items() if one.low is None or one.high is None]
    if loose:
        out.append(f"Not identified by these runs, kept near the declared values: {', '.join(loose)}.")
    for effect in found.effects:
        open_ended = [n for n, one in effect.parameters.items() if one.low is None or one.high is None]
        if open_ended:
            out.append(f"{effect.name}: the runs set no interval for {', '.join(open_ended)}.")
        if effect.curve is not None and effect.curve.period is None:
            variable = effect.curve.variable
            named = variable in OF_VARIABLES  # of other rigs it is in SI, and flattens beyond
            axis = axes.variable(variable) if axes is not None and named else None
            reach = _from_to(effect.curve.x.min(), effect.curve.x.max(), axis)
            beyond = "it is held constant and " if named else ""
            out.append(f"The learned curve holds for {variable} {reach}; beyond, {beyond}nothing is known.")
    if found.effects and not found.residual_after.clean:
        out.append(
            "Intervals take the model to be complete; while something is left over they are too narrow."
        )
    speeds = [abs(run.belt_speed) for run in found.runs if run.role == "train"]
    if speeds:
        axis = None if axes is None else replace(axes.x2, size=abs(axes.x2.size))
        reach = _from_to(min(speeds), max(speeds), axis)
        out.append(f"Trained at |belt speed| {reach}; forecasts at other speeds extrapolate.")
    return list(dict.fromkeys(out))


def _from_to(low: float, high: float, axis: Axis | None) -> str:
    """A range in the unit of an axis; one number where both ends are written alike."""
    size, unit = (axis.size, f" {axis.unit}") if axis and axis.unit != "1" else (1.0, " (model units)")
    ends = [short(end, 3) for end in sorted((size * float(low), size * float(high)))]
    return f"{ends[0]}{unit} only" if ends[0] == ends[1] else f"from {ends[0]} to {ends[1]}{unit}"
