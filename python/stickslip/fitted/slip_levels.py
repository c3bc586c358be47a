"""Slip by slip: the friction of a real block on a belt, whose breakaway and sliding levels scatter.

Each slip is simulated on its own, from the stick before it into the stick after it, with its own static and
kinetic level. What all slips share (the decay of the hyperbolic law) is fitted jointly. The law reported is the
mean over slips; its intervals come from a block bootstrap over them, because neighbouring slips are on the same
patch of surface and are not independent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, BlockOnBelt
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.decay import Profile, hyperbolic, levels, merged, scores_of
from stickslip.fitted.identified import Branch, Estimate, Events, Identified
from stickslip.fitted.identify_words import event_messages, explained_messages
from stickslip.fitted.scatter import block_bootstrap, correlation_length, effective_readings, few
from stickslip.fitted.shooting import Shot, Simulator, shoot, states
from stickslip.measured.cutting import stick_position
from stickslip.measured.fit_window import Array, FitWindow
from stickslip.measured.prepared import Measured
from stickslip.measured.sticks import LEAST_SLIP, Segment

Kind = Literal["coulomb", "hyperbolic"]
MAKE: dict[Kind, type[CoulombFriction] | type[HyperbolicFriction]] = {
    "coulomb": CoulombFriction,
    "hyperbolic": HyperbolicFriction,
}
DECISIVE = 6.0  # difference of BIC from which the law with one more number is taken


@dataclass(frozen=True)
class DeclaredLaw:
    """The law of a block as declared, with the names of its numbers that are mere defaults."""

    law: FrictionLaw | None
    undeclared: frozenset[str]

    @property
    def kind(self) -> Kind | None:
        """The kind that is declared; None where it is left open, which of these two it is."""
        return next((name for name, kind in MAKE.items() if isinstance(self.law, kind)), None)

    def unseen(
        self, branch: Branch, kind: type[CoulombFriction] | type[HyperbolicFriction], names: Sequence[str]
    ) -> dict[str, float] | None:
        """Numbers declared for the direction other than `branch` (for both, without `_plus`); None unless all are."""
        law = self.law
        if not isinstance(law, kind):
            return None
        own = {
            n: f"{n}_plus" if branch == "minus" and getattr(law, f"{n}_plus") is not None else n
            for n in names
        }
        return (
            None
            if self.undeclared & set(own.values())
            else {n: float(getattr(law, m)) for n, m in own.items()}
        )


@dataclass(frozen=True)
class _Slip:
    run: int
    t: float
    amplitude: float
    speed: float
    window: FitWindow
    top: float  # against the belt's pull: where it starts,
    end: float  # and where it is caught


@dataclass(frozen=True)
class _Choice:
    """The law preferred, with what is common to all slips; `preference` is BIC(Coulomb) - BIC(hyperbolic)."""

    kind: Kind
    shot: Shot
    common: dict[str, float]
    profile: Profile | None
    preference: float


def identify_events(
    runs: Sequence[Measured],
    rig: AnyRig,
    *,
    declared: FrictionLaw | None,
    simulator: Simulator,
    tell: Callable[[str, float], None],
    unit: str = "",
    undeclared: Sequence[str] = (),
    why_idle: Callable[[int], str],
    kind: Kind | None = None,
    both: bool = False,
) -> Identified:
    """Identify Coulomb or hyperbolic friction from the slips of a block on a belt that runs one way.

    Parameters
    ----------
    runs : sequence of Measured
    rig : BlockOnBelt
    declared : law or None
        Its kind is kept; without one, or with one of another kind, the readings choose between the two. It gives the
        numbers of the direction that is not visited, where it is of the kind chosen and they are declared.
    simulator : callable
    tell : callable
        Progress.
    unit : str
        Written behind forces in sentences: " N", or nothing.
    undeclared : sequence of str
        Numbers of `declared` that are the library's defaults.
    why_idle : callable
        Says, for the number of a run, why no slip of it is used.
    kind : "coulomb" or "hyperbolic", optional
        What all runs have chosen, those of the other direction too.
    both : bool
        Whether the other direction is identified from further runs: nothing is said of it then.

    Returns
    -------
    Identified

    Raises
    ------
    InputError
        If the rig has two degrees of freedom, the belt does not run one way, or fewer than three slips are found.
    """
    if not isinstance(rig, BlockOnBelt):
        raise InputError("slips are fitted one by one only for a BlockOnBelt; use scatter=False")
    slips = [s for i, r in enumerate(runs) for s in _slips(r, i, rig)]
    branch = _branch(runs)
    noise = np.asarray(np.mean([r.noise * np.sqrt(r.averaged) for r in runs], axis=0))  # of a single reading
    seen = {s.run for s in slips}
    coulomb, slips = _one_by_one(slips, rig, noise, simulator, tell)
    used = {s.run for s in slips}
    why = {
        i: "most are not met by a slip that ends in stick; does the block only swing?"
        if i in seen
        else why_idle(i)
        for i in range(len(runs))
    }
    idle = tuple(f"{r.name}: no slip is used: {why[i]}" for i, r in enumerate(runs) if i not in used)
    if len(slips) < 3:
        count = "1 slip" if len(slips) == 1 else f"{len(slips)} slips"
        raise InputError("; ".join([f"{count} found; at least 3 are needed", *idle]))
    speed = float(np.median([s.speed for s in slips]))
    falling, decay, profile = hyperbolic(speed, coulomb, rig, noise, simulator, tell)
    # three numbers a slip in both laws; the hyperbolic one has one more for all
    readings = effective_readings(coulomb.residuals)
    gain = float(np.sum(scores_of(coulomb, coulomb) - scores_of(falling, coulomb)))
    preference = gain - float(np.log(readings))
    tell("bootstrap", 0.85)
    told = DeclaredLaw(declared, frozenset(undeclared))
    if (kind or told.kind or preferred(preference)) == "hyperbolic":
        choice = _Choice("hyperbolic", falling, {"decay": decay}, profile, preference)
    else:
        choice = _Choice("coulomb", coulomb, {}, None, preference)
    found = _conclude(runs, rig, branch, choice, slips, noise, told, unit, both=both, shared=kind is not None)
    return replace(found, messages=(*found.messages, *idle))


def preferred(preference: float) -> Kind:
    """Return the kind that BIC(Coulomb) - BIC(hyperbolic) chooses."""
    return "hyperbolic" if preference > DECISIVE else "coulomb"


def _branch(runs: Sequence[Measured]) -> Branch:
    directions = {np.sign(r.belt_speed) for r in runs}
    if len(directions) != 1 or 0.0 in directions:
        raise InputError(
            "a belt at rest has no slips to fit one by one; identify its runs alone, as ring-downs"
        )
    return "minus" if directions == {1.0} else "plus"


def _slips(run: Measured, number: int, rig: BlockOnBelt) -> list[_Slip]:
    """Slips against the belt with a stick on both sides, large enough to be told from noise."""
    track, period = run.track, 2 * np.pi * float(np.sqrt(rig.mass / rig.stiffness))
    against = -int(np.sign(run.belt_speed))
    out = []
    for before, slip, after in track.slips:
        start = max(before.middle, int(np.searchsorted(track.t, track.t[slip.start] - period / 4)))
        stop = min(after.middle, int(np.searchsorted(track.t, track.t[slip.stop] + period / 10)))
        amplitude = track.size(slip)
        if amplitude < LEAST_SLIP * run.noise[0] or stop - start < 12:
            continue
        speed = float(np.max(np.abs(track.v[slip.start : slip.stop] - run.belt_speed)))
        window = _event_window(run, number, before, start, stop)
        begin = float(track.t[slip.start])
        top = window.initial[0] + run.belt_speed * (begin - track.t[start])
        ends = (float(-against * top), float(-against * track.x[min(slip.stop, len(track.x) - 1)]))
        out.append(_Slip(number, begin, amplitude, speed, window, *ends))
    return out


def _event_window(run: Measured, number: int, before: Segment, start: int, stop: int) -> FitWindow:
    part = slice(start, stop)
    x = stick_position(run.track, run.readings[:, 0], before, start)
    return FitWindow(
        run=number,
        belt_speed=run.belt_speed,
        t=run.t[part] - run.t[start],
        readings=run.readings[part],
        columns=(0,),
        initial=np.array([x, run.belt_speed]),
        free=("x1",),
        averaged=run.averaged,
    )


def _caught(speed: Array, belt_speed: float) -> bool:
    """Does a block that has slipped stick again?"""
    stuck = np.abs(speed - belt_speed) < 1e-9 * abs(belt_speed)
    return bool(stuck[int(np.argmin(stuck)) :].any())


def _one_by_one(
    slips: Sequence[_Slip],
    rig: BlockOnBelt,
    noise: Array,
    simulator: Simulator,
    tell: Callable[[str, float], None],
) -> tuple[Shot, list[_Slip]]:
    """Coulomb levels of every slip; slips that no levels can reproduce are left out, and runs that only swing."""
    shots, kept, sticks = [], [], []
    model = Model(rig, friction=CoulombFriction())
    for i, s in enumerate(slips):
        static = rig.stiffness * s.top
        kinetic = max(rig.stiffness * 0.5 * (s.top + min(s.end, s.top - s.amplitude)), 0.0)
        window = replace(s.window, local={"static": static, "kinetic": kinetic})
        try:
            shot = shoot(model, [window], (), noise=noise, simulator=simulator, iterations=15)
            fitted = shot.windows[0]
            caught = _caught(states(model, fitted, simulator)[:, 1], fitted.belt_speed)
        except StickslipError:
            continue
        if np.isfinite(shot.chi2) and fitted.local["static"] > fitted.local["kinetic"] >= 0:
            shots.append(shot)
            kept.append(s)
            sticks.append(caught)
        tell("slips one by one", 0.1 + 0.5 * i / len(slips))
    # a swing that only touches the belt's speed is no slip: under the levels it asks for the block slides on
    swings = {
        number
        for number in {s.run for s in kept}
        if 2 * sum(stuck for s, stuck in zip(kept, sticks, strict=True) if s.run == number)
        < sum(s.run == number for s in kept)
    }
    stay = [i for i, s in enumerate(kept) if s.run not in swings]
    return merged([shots[i] for i in stay]), [kept[i] for i in stay]


def _conclude(
    runs: Sequence[Measured],
    rig: BlockOnBelt,
    branch: Branch,
    choice: _Choice,
    slips: Sequence[_Slip],
    noise: Array,
    declared: DeclaredLaw,
    unit: str,
    *,
    both: bool,
    shared: bool,
) -> Identified:
    kind, shot, preference = choice.kind, choice.shot, choice.preference
    level = levels(shot)
    local = dict(zip(shot.windows[0].local, level.T, strict=True))
    names = (*local, *choice.common)
    mean = np.array([*level.mean(axis=0), *choice.common.values()])
    resamples = block_bootstrap(level, None if choice.profile is None else choice.profile.refit)
    resamples = mean + few(len(slips)) * (resamples - mean)
    covariance = np.atleast_2d(np.cov(resamples.T))
    numbers = dict(zip(names, mean.tolist(), strict=True))
    known = declared.unseen(branch, MAKE[kind], names)
    law, estimates = _law(kind, branch, numbers, resamples, known or numbers)
    suffix = "" if branch == "minus" else "_plus"
    events = _events(choice, local, slips, noise)
    visited = (0.0, float(max(s.speed for s in slips)))
    return Identified(
        rig=rig,
        law=law,
        estimates=estimates,
        names=tuple(n + suffix for n in names),
        covariance=covariance,
        covered={
            "minus": visited if branch == "minus" else None,
            "plus": visited if branch == "plus" else None,
        },
        noise={"x1": float(noise[0])},
        reduced_chi2=shot.reduced,
        events=events,
        diagnostics=_diagnostics(runs, shot, preference, events, rig),
        messages=(
            *event_messages(
                kind,
                branch,
                preference,
                events,
                unit,
                None if both else known is not None,
                better=preferred(preference) if declared.kind else None,
                shared=shared,
            ),
            *explained_messages(
                f"{len(slips)} slips, each with levels of its own", shot.reduced, widened=False
            ),
        ),
    )


def _events(choice: _Choice, local: dict[str, Array], slips: Sequence[_Slip], noise: Array) -> Events:
    if choice.kind == "coulomb":
        static, kinetic = local["static"], local["kinetic"]
    else:
        static = local["scale"] + local["constant"]
        kinetic = _kinetic(local, slips, choice.common["decay"])
    return Events(
        t=np.array([s.t for s in slips]),
        static=static,
        kinetic=kinetic,
        amplitude=np.array([s.amplitude for s in slips]),
        rms=np.array(
            [
                float(np.sqrt(np.mean(r**2))) * noise[0] / np.sqrt(s.window.averaged)
                for r, s in zip(choice.shot.residuals, slips, strict=True)
            ]
        ),
        run=np.array([float(s.run) for s in slips]),
    )


def _kinetic(local: dict[str, Array], slips: Sequence[_Slip], decay: float) -> Array:
    """Sliding force of each slip at half its largest speed."""
    u = 0.5 * np.array([s.speed for s in slips])
    return np.asarray(local["scale"] / (1 + decay * u) + local["constant"], dtype=float)


def _law(
    kind: Kind, branch: Branch, numbers: dict[str, float], resamples: Array, unseen: dict[str, float]
) -> tuple[FrictionLaw, dict[str, Estimate]]:
    """The mean law, `unseen` being the numbers of the direction never visited."""
    own, other = ("", "_plus") if branch == "minus" else ("_plus", "")
    low, high = np.quantile(resamples, [0.025, 0.975], axis=0)
    estimates = {
        n + own: Estimate(v, float(a), float(b), float(s), "weak" if s > abs(v) / 3 else "identified")
        for (n, v), a, b, s in zip(numbers.items(), low, high, resamples.std(axis=0), strict=True)
    }
    estimates |= {n + other: Estimate(v, None, None, None, "unidentified") for n, v in unseen.items()}
    return MAKE[kind](**{n: e.value for n, e in estimates.items()}), estimates


def plateau_over_set_point(runs: Sequence[Measured]) -> float:
    """Return the mean ratio of the runs whose sticks last long enough to show a speed; nan without any."""
    seen = [run.plateau / run.set_point for run in runs if np.isfinite(run.plateau)]
    return float(np.mean(seen)) if seen else float("nan")


def _diagnostics(
    runs: Sequence[Measured], shot: Shot, preference: float, events: Events, rig: BlockOnBelt
) -> dict[str, float]:
    return {
        "events": float(len(events.t)),
        **events.levels(),
        "bic_preference_for_hyperbolic": preference,
        "level_correlation_events": correlation_length(events.static),
        "rms_residual": float(np.median(events.rms)),
        "rms_residual_of_amplitude": float(np.median(events.rms / events.amplitude)),
        "plateau_over_set_point": plateau_over_set_point(runs),
        "stiffness": rig.stiffness,
        "runs": float(len(runs)),
        "windows": float(len(shot.windows)),
    }
