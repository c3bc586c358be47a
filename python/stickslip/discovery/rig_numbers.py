"""Is a number of the declared rig wrong? Fitted beside the law it is one number; a curve in its place is many."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stickslip.declared.effect import Tabulated, tabulated
from stickslip.declared.rig import AnyRig, Rig
from stickslip.declared.uncertainty import Uncertainty
from stickslip.declared.uncertainty import numbers as every_number
from stickslip.discovery.intervals import combined, intervals
from stickslip.discovery.result import Curve, Interval
from stickslip.discovery.rivals import hypothesis
from stickslip.discovery.search import CLEAN, Search, Trial
from stickslip.discovery.workers import each
from stickslip.fitted.unknowns import RIG, Unknown
from stickslip.progress import StageStep

BEYOND = 3.0  # standard uncertainties within which a constant is as declared (the format of a case says so)
FACTOR = 10.0  # by which a declared number may be wrong
EDGE = 1e-6  # of a number: nearer to its bound it is at it
ROUNDING = 1e-9  # of a number: so far its search stays inside of what a rig may have
APART = 3  # times that the bound between two numbers is moved
WORSE = 1.5  # of the cost of what was chosen: a number that leaves more after a few steps will not come near
REACH = 4.0  # times the readings of x1 that a straight line reaches: the motion stays within
NEARLY_TWICE = 0.1  # how near 2 a slope must be to be the coupling's
STRAIGHT = (
    0.9  # share of a learned curve's variance in a straight line, which a wrong number of the rig leaves
)
STEEP = 20.0  # width of the weak Gaussian on the ends of that line


@dataclass(frozen=True)
class Kind:
    """What may be wrong together: the numbers that are freed, with a line in x1 on the block or not; where, on what."""

    free: tuple[str, ...]
    where: str
    depends_on: tuple[str, ...]
    line: bool = False


PLACES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    **dict.fromkeys(("alpha1", "m", "k1"), ("block", ("x1",))),
    **dict.fromkeys(("alpha2", "J", "r", "beta3", "k3"), ("angle_body", ("y1",))),
    **dict.fromkeys(("eta12", "c2"), ("angle_body", ("y2",))),
    **dict.fromkeys(("eta1", "c1"), ("both", ("x2", "y2"))),
    "k2": ("both", ("x1", "y1")),
    "x1": ("x1 channel", ("x1",)),
    "y1": ("y1 channel", ("y1",)),
}
"""Where a declared constant, or the gain of a channel, acts, and on what."""
KINDS: Mapping[tuple[str, ...], Kind] = {  # by what the trials of them are called
    **{(name,): Kind((name,), *PLACES[name]) for name in ("alpha1", "alpha2", "beta3", "eta12")},
    ("eta1", "eta12"): Kind(("eta1", "eta12"), *PLACES["eta1"]),  # c1 is in both
    ("block stiffness",): Kind((), *PLACES["k1"], line=True),  # alpha1 x1 alone
    ("block inertia",): Kind(("alpha1",), *PLACES["m"], line=True),  # alpha1 x1'' too, and not alike
}


def freed(search: Search, chosen: Trial, closely: bool = False) -> list[Trial]:
    """The declared law with numbers of the rig free, from where `chosen` has the law and the windows; best first.

    Their names are those of the numbers. `closely`: the best is fitted in earnest if it does better than `chosen`.
    """
    rig = search.model.rig
    assert isinstance(rig, Rig)
    kinds = [names for names, kind in KINDS.items() if all(getattr(rig, name) > 0 for name in kind.free)]
    tasks = each(search, partial(_freed, chosen=chosen), kinds, _freeing)
    found = [replace(one, names=names) for names, task in tasks if (one := task.result()) is not None]
    found.sort(key=lambda one: one.bic)
    if closely and found and found[0].excess > CLEAN and found[0].bic < chosen.bic:
        found[0] = replace(search.polish(found[0], turns=1), names=found[0].names)
    search.freed += found
    return found


def _freeing(names: tuple[str, ...]) -> StageStep:
    return StageStep(f"freeing {called(names)} of the rig", "freeing each number of the rig")


def _freed(search: Search, names: tuple[str, ...], *, chosen: Trial) -> Trial | None:
    kind, rig = KINDS[names], search.model.rig
    assert isinstance(rig, Rig)
    between = math.sqrt(rig.eta1 * rig.eta12)
    for _ in range(APART):
        own = [unknown(rig, name, between if len(kind.free) > 1 else None) for name in kind.free]
        trial = _fitted(search, kind, own, chosen)
        if trial is None:
            return None
        found = trial.hypothesis.model.parameters
        stopped = [
            u for u in own if min(abs(math.log(found[u.name] / end)) for end in u.bounds if end > 0) < EDGE
        ]
        if not stopped:
            return trial
        if len(kind.free) < 2:
            break
        between = math.sqrt(found["eta1"] * found["eta12"])  # one of them has come to the other's side
    return None  # what is at its bound is not found


def _fitted(search: Search, kind: Kind, own: Sequence[Unknown], chosen: Trial) -> Trial | None:
    h, own = hypothesis(chosen.hypothesis.model, [], search.model), list(own)
    if kind.line:
        far = REACH * max(float(np.max(np.abs(run.readings[:, 0]))) for run in search.data)
        line = tabulated("block", "x1", [-far, far], [0.0, 0.0])
        h = replace(h, model=h.model.with_effects([line]))
        own += [Unknown(f"{line.name}.value_{i}", 0.0, False, 0.0, STEEP) for i in range(2)]
    return search.run(
        replace(h, unknowns=(*h.unknowns, *own)),
        windows_of=chosen, tolerance=1e-4, worst=WORSE * chosen.fit.cost, anyway=True,
    )  # fmt: skip


def unknown(rig: Rig, name: str, between: float | None = None) -> Unknown:
    """A number of the rig as one to estimate, within what a rig may have while the others are as declared.

    Of two dampings that move together eta1 stays below `between`, eta12 above.
    """
    value = float(getattr(rig, name))
    least = {"alpha1": 1.0, "beta3": 1.0, "eta12": rig.eta1}.get(name, 0.0)
    most = rig.eta12 if name == "eta1" else math.inf
    if between is not None:
        least, most = (between, math.inf) if name == "eta12" else (0.0, between)
    # within what the rig takes after rounding in the logarithm too
    low, high = max(least * (1 + ROUNDING), value / FACTOR), min(most * (1 - ROUNDING), value * FACTOR)
    start = min(max(value, low), high)
    return Unknown(name, start, True, math.log(value), 1.0, bounds=(low, high))


def numbers(trial: Trial) -> Mapping[str, Interval]:
    """The numbers of the rig that a trial has free, with their intervals.

    Where the block's x1'' and x1 have no longer the same number, `inertia` and `stiffness` stand for alpha1.
    """
    fit, model = trial.fit, trial.hypothesis.model
    lines = [term for term in model.effects if isinstance(term, Tabulated)]
    if not lines:
        return {name: one for name, one in intervals(fit).items() if name in RIG}
    line, rig = lines[0], model.rig
    assert isinstance(rig, Rig)
    span = line.knots[-1] - line.knots[0]
    slopes = {f"{line.name}.value_0": 1 / span, f"{line.name}.value_1": -1 / span, "alpha1": rig.alpha1}
    stiffness = rig.alpha1 - (line.values[-1] - line.values[0]) / span
    out = {"stiffness": combined(fit, stiffness, slopes)}
    if "alpha1" in {u.name for u in fit.engine.hypothesis.shared}:
        out = {"inertia": combined(fit, rig.alpha1, {"alpha1": rig.alpha1}), **out}
    return out


def each_alone(tried: Sequence[Trial]) -> dict[str, Interval]:
    """What the readings say of each number of the rig that was freed with all others as declared."""
    alone = (one for one in sorted(tried, key=lambda one: one.bic) if len(one.names) == 1)
    out: dict[str, Interval] = {}
    for one in alone:
        own = numbers(one)
        if len(own) == 1:
            out = {**own, **out}
    return out


def formula(rig: AnyRig, found: Mapping[str, Interval]) -> str:
    """What is declared, what is found, and what that says of the SI constants."""
    assert isinstance(rig, Rig)
    words = [
        f"{_WORDS.get(name, name)} is {one.value:.4g} rather than {declared(rig, name):.4g}"
        f"{_share(rig, name, found)}"
        for name, one in found.items()
    ]
    return " and ".join(words)


_WORDS = {"inertia": "alpha1 before x1''", "stiffness": "alpha1 before x1"}


def declared(rig: AnyRig, name: str) -> float:
    """A number or a constant as declared; `inertia` and `stiffness` are alpha1."""
    return every_number(rig)["alpha1" if name in _WORDS else name]


def wrong(rig: AnyRig, found: Mapping[str, Interval]) -> tuple[str, float]:
    """The declared constant that wrong numbers stand for, and the logarithm of found over declared.

    Of a rig in SI that is a constant of its own; where two numbers are wrong together, the first of them.
    """
    names = list(found)
    if {"inertia", "stiffness"} <= set(names):  # x1'' and x1 have no longer the same number
        apart = {n: abs(math.log(found[n].value / declared(rig, n))) for n in ("inertia", "stiffness")}
        names = [max(apart, key=lambda n: apart[n])]
    name = names[0]
    behind = constant(rig, name, found)
    if behind is None:
        own = "alpha1" if name in _WORDS else name
        return own, math.log(found[name].value / declared(rig, own))
    return behind.name, math.log(behind.of(found[name].value) / behind.of(declared(rig, name)))


def beyond(known: Uncertainty, found: Mapping[str, Interval]) -> bool:
    """Whether wrong numbers are further off than three standard uncertainties of the constant behind them."""
    name, off = wrong(known.rig, found)
    own = known.constants.get(name)
    return abs(off) > BEYOND * (known.relative(name) if own is None and name in known.names else own or 0.0)


@dataclass(frozen=True)
class Constant:
    """The SI constant behind a number of the rig, everything else as declared: (number - least) size."""

    name: str
    size: float
    least: float = 0.0

    @property
    def unit(self) -> str:
        """Its unit."""
        return Rig.dimensions[self.name].unit

    def of(self, value: float) -> float:
        """Its value for one of the number."""
        return (value - self.least) * self.size


def constant(rig: AnyRig, name: str, found: Mapping[str, Interval]) -> Constant | None:
    """What a wrong number says of the SI constants by (2.1), with r, k2 and the units as declared.

    c2 is in eta12 - eta1, with the eta1 `found` if it was. alpha1 in both places is none: a mass and a spring k1 that
    are both wrong.
    """
    if not isinstance(rig, Rig) or rig.scales is None:
        return None
    omega, k2, r = rig.scales.omega, rig.scales.k2, rig.scales.r
    eta1 = found["eta1"].value if "eta1" in found else rig.eta1
    known = {
        "alpha2": Constant("J", r * r * k2 / omega**2),
        "beta3": Constant("k3", k2, 1.0),
        "eta1": Constant("c1", k2 / omega),
        "eta12": Constant("c2", k2 / omega, eta1),
        "inertia": Constant("m", k2 / omega**2),
        "stiffness": Constant("k1", k2, 1.0),
    }
    return known.get(name)


def _share(rig: Rig, name: str, found: Mapping[str, Interval]) -> str:
    """The SI constant behind a number, as a share of what is declared."""
    now, was = constant(rig, name, found), constant(rig, name, {})
    if now is None or was is None or was.of(declared(rig, name)) <= 0:
        return ""
    return f" ({now.name} {now.of(found[name].value) / was.of(declared(rig, name)):.3g} times the declared)"


def called(names: Sequence[str]) -> str:
    """What a trial of numbers of the rig, or of one effect, is called among its rivals."""
    return " and ".join(names)


def remark(
    rig: AnyRig, names: tuple[str, ...], after: Trial, tied: Sequence[Trial], curve: Curve | None
) -> str | None:
    """What to know of wrong numbers of the rig beside what was found: `names` in the trial `after`, a learned curve."""
    if tied:
        return (
            "a wrong number of the declared rig would explain the readings as well: "
            f"{'; or '.join(formula(rig, numbers(one)) for one in tied)}: check it"
        )
    if names in KINDS and KINDS[names].line:
        return (
            "alpha1 sets the unit of time and where the declared law has its ends: these stay as declared, so that "
            f"what is found is near and not yet exact; {_instead(rig, numbers(after))} and search again"
        )
    looks = None if curve is None else _LOOKS.get((curve.where, curve.variable))
    if curve is None or looks is None or not np.corrcoef(curve.x, curve.value)[0, 1] ** 2 > STRAIGHT:
        return None
    if looks == COUPLING:
        return _turned(rig, curve)
    return (
        f"the learned curve is nearly straight, as a wrong {looks} of the declared rig leaves it: check these"
    )


def _turned(rig: AnyRig, curve: Curve) -> str | None:
    """The coupling of the other sign, where the curve is what that adds to the block: twice the force of y1."""
    if not isinstance(rig, Rig):
        return None
    sign, other = (1.0, "as_printed") if rig.coupling == "reciprocal" else (-1.0, "reciprocal")
    slope = float(np.polyfit(curve.x, curve.value, 1)[0])
    if abs(slope - 2 * sign) > NEARLY_TWICE:
        return None
    return (
        f"the learned curve is {slope:+.3g} y1, what the coupling of the other sign adds: write coupling = '{other}' "
        f"in [rig] instead of '{rig.coupling}', and search again"
    )


COUPLING = "coupling"
_LOOKS = {
    ("block", "y1"): COUPLING,
    ("block", "x1"): "m, k1 or k2",
    ("angle_body", "y1"): "J, k2 or k3",
    ("angle_body", "y2"): "J, c1 or c2",
}


def _instead(rig: AnyRig, found: Mapping[str, Interval]) -> str:
    """What to write in [rig]."""
    known = ((constant(rig, name, found), one) for name, one in found.items())
    words = [f"{what.name} = {what.of(one.value):.4g} {what.unit}" for what, one in known if what is not None]
    return f"write {called(words)} in [rig]" if words else "correct the rig's constants"
