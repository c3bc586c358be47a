"""From recordings to a friction law: `identify`.

The law's numbers are fitted through simulation (`stickslip.fitted.shooting`), first on windows of about one natural
period, cut in the middle of sticks, then on whole runs if the law still explains the readings there. The static
limits follow from the breakaway instants in the same fit. A real block on a belt, whose friction scatters from
slip to slip, is identified event by event instead (`stickslip.fitted.slip_levels`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Literal, get_args

import numpy as np

from stickslip.arguments import explained, must_be, one_of
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.friction_law import FrictionLaw, given_numbers
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig, on_belt
from stickslip.errors import InputError, number
from stickslip.fitted import friction_force as force
from stickslip.fitted.covered_speeds import covered_speeds
from stickslip.fitted.identified import Branch, Estimate, ForcePoints, Identified, estimate
from stickslip.fitted.identify_check import checked, explainable, misfit
from stickslip.fitted.identify_words import fit_messages, misfit_messages, plateau_messages
from stickslip.fitted.shooting import Shot, Simulator, shoot
from stickslip.measured import cutting, signals
from stickslip.measured import sticks as segments
from stickslip.measured.case import Case, Recording
from stickslip.measured.fit_window import Array, Window
from stickslip.measured.prepared import Measured, Motion
from stickslip.measured.stick_speed import why_idle, wrong_set_point
from stickslip.measured.thinning import sentences, thinned
from stickslip.simulated.simulate import simulate

BeltSpeed = Literal["set-point", "plateau"]
Progress = Callable[[str, float], None]
RESOLVED = 1e-9  # of the range of a channel: no simulation is nearer, so it counts as noise


def natural_period(rig: AnyRig) -> float:
    """Period of the free block on its springs, in the rig's unit of time."""
    rig = on_belt(rig)
    if isinstance(rig, BlockOnBelt):
        return float(2 * np.pi * np.sqrt(rig.mass / rig.stiffness))
    return 2 * np.pi


def columns(rig: AnyRig) -> tuple[int, ...]:
    """State column of each recorded channel: x1, and y1 for the rig of (2.1)."""
    return (0, 2) if isinstance(rig, Rig) else (0,)


def measured(
    recording: Recording,
    rig: AnyRig,
    *,
    noise: Mapping[str, float] | None = None,
    belt: BeltSpeed = "set-point",
    motion: Motion | None = None,
) -> Measured:
    """Readings of one run with glitches taken out, their noise, and where the block sticks.

    Raises
    ------
    InputError
        If a channel the rig needs is missing, the record is too short, or noise is given of a channel that is not used.
    """
    one_of("belt_speed", belt, get_args(BeltSpeed))
    for name, size in (noise or {}).items():
        one_of("noise", name, ("x1", "y1")[: len(columns(rig))])
        number(f"noise.{name}", size, least=0)
    channels: list[Array] = []
    stds: list[float] = []
    root = np.sqrt(recording.averaged)
    known = {name: size / root for name, size in noise.items()} if noise else recording.noise or {}
    for name in ("x1", "y1")[: len(columns(rig))]:
        x = getattr(recording, name)
        if x is None:
            raise InputError(f"{recording.name}: channel {name} is missing; the rig of (2.1) needs x1 and y1")
        x = np.array(x, dtype=float)
        there = np.isfinite(x)  # of a record that was thinned not all are
        std = float(known[name]) if name in known else signals.noise_std(x[there], t=recording.t[there])
        x[np.flatnonzero(there)[signals.find_glitches(x[there]).mask]] = np.nan
        channels.append(x)
        stds.append(std)
        stds[-1] = max(stds[-1], RESOLVED * _size(x))
    period, set_point = natural_period(rig), float(recording.belt_speed)
    t = np.asarray(recording.t, dtype=float)
    t = t - t[0]
    tolerance = segments.CREEP if isinstance(rig, BlockOnBelt) else segments.RIPPLE

    behind, size = (channels[0], stds[0]) if motion is None else motion(t, channels[0], stds[0])

    def look_at(speed: float) -> segments.Track:
        return segments.track(t, behind, belt_speed=speed, noise=size, period=period, tolerance=tolerance)

    used, look = set_point, look_at(set_point)
    speed, std = segments.plateau_speed(look, behind, size)
    for _ in range(3 if belt == "plateau" and np.isfinite(speed) else 0):
        used, look = speed, look_at(speed)
        speed, std = segments.plateau_speed(look, behind, size)
    look = look if motion is None else segments.as_read(look, t, channels[0])
    readings = np.column_stack(channels)
    return Measured(
        recording.name,
        t,
        readings,
        np.array(stds),
        used,
        set_point,
        speed,
        std,
        look,
        recording.averaged,
        motion,
    )


def single_noise(runs: Sequence[Measured]) -> Array:
    """Standard deviation of a single reading of each channel (c,), over all runs."""
    return np.asarray(np.mean([r.noise * np.sqrt(r.averaged) for r in runs], axis=0))


def _size(x: Array) -> float:
    """Range of readings, their own size where they are all the same, 1 where they are all 0."""
    return float(np.nanmax(x) - np.nanmin(x)) or float(np.nanmax(np.abs(x))) or 1.0


def law_parameters(law: FrictionLaw) -> dict[Branch, tuple[str, ...]]:
    """Names of the numbers each branch has to be identified from."""
    if isinstance(law, PaperFriction):
        return {
            "minus": ("T_s_minus", "A1", "A2", "t1", "t2", "T_min_minus"),
            "plus": ("T_s_plus", "T_min_plus"),
        }  # not the ends of the fitted ranges, v_w_min and v_w_max: the other numbers can do what they do
    names = [f.name for f in fields(law) if getattr(law, f.name) is not None]
    plus = tuple(n for n in names if n.endswith("_plus"))
    minus = tuple(n for n in names if not n.endswith("_plus"))
    return {"minus": minus, "plus": plus or minus}


@explained
def identify(
    source: Case | Recording | Sequence[Recording],
    *,
    rig: AnyRig | None = None,
    friction: FrictionLaw | None = None,
    noise: Mapping[str, float] | None = None,
    belt_speed: BeltSpeed = "set-point",
    scatter: bool | None = None,
    simulator: Simulator = simulate,
    progress: Progress | None = None,
) -> Identified:
    """Identify the friction law from recorded displacements.

    Parameters
    ----------
    source : Case, Recording or sequence of Recording
        A case's "train" runs are used.
    rig : Rig or BlockOnBelt, optional
        Required unless `source` is a case.
    friction : PaperFriction, CoulombFriction or HyperbolicFriction, optional
        The law's form and the values to start from; the case's, or Table 1, if absent.
    noise : mapping of str to float, optional
        Standard deviation of a reading per channel in the rig's units; the recording's, or estimated, if absent.
    belt_speed : "set-point" or "plateau"
        Whether v_b is what was set, or what the block was seen to ride at in its sticks.
    scatter : bool, optional
        Identify event by event, with levels that scatter. Default: for a block on a belt, unless `friction`
        is given or the case declares a law with more numbers than single slips tell.
    simulator : callable
        `stickslip.simulate` or anything with its signature.
    progress : callable, optional
        Called with what is being done and the share done.

    Returns
    -------
    Identified

    Raises
    ------
    InputError
        If a channel is missing, a record too short, or no slip is found; if the channels of a case for the rig of
        (2.1) cannot be what it says, or no law of this kind moves its rig like the readings.
    """
    if not isinstance(source, Case | Recording):
        for one in source if isinstance(source, (list, tuple)) else [source]:
            must_be("source", one, (Case, Recording), "load_case(path) gives a case")
    if scatter is not None:
        must_be("scatter", scatter, bool)
    else:
        scatter = friction is None and isinstance(
            source.rig if isinstance(source, Case) else rig, BlockOnBelt
        )
        scatter = scatter and not (
            isinstance(source, Case) and isinstance(source.declared_law, PaperFriction)
        )
    undeclared = source.undeclared if isinstance(source, Case) and friction is None else ()
    told = friction or (source.friction if isinstance(source, Case) else None)
    tell = progress or (lambda _what, _share: None)
    tell("looking at the readings", 0.0)
    own = rig
    recordings, rig, friction = _material(source, rig, friction)
    recordings, less = thinned(recordings, rig)
    notes = checked(source, recordings) if isinstance(source, Case) and own in (None, source.rig) else ()
    tell("reading modes", 0.0)
    runs = [measured(r, rig, noise=noise, belt=belt_speed) for r in recordings]
    if scatter:
        from stickslip.fitted.slip_levels import identify_events

        unit = "" if recordings[0].unit("x1") == "1" else " N"
        found = identify_events(
            runs,
            rig,
            declared=friction,
            simulator=simulator,
            tell=tell,
            unit=unit,
            undeclared=undeclared,
            why_idle=lambda i: why_idle(replace(recordings[i], rig=rig), len(runs[i].track.sticks)),
        )
    else:
        start = friction or (PaperFriction() if isinstance(rig, Rig) else CoulombFriction())
        found = _identify_by_shooting(runs, rig, start, simulator, tell, undeclared)
        doubts = ((r.name, wrong_set_point(replace(r, rig=rig))) for r in recordings)
        found = replace(found, messages=(*found.messages, *(f"{n}: {words}" for n, words in doubts if words)))
    tell("friction force", 0.95)
    rode = plateau_messages([(r.plateau, r.plateau_std, r.set_point) for r in runs], belt_speed)
    said = (*sentences(less), *notes, *found.messages, *rode, *misfit_messages(found))
    estimates = _beside_declared(found, told, undeclared)
    found = replace(found, estimates=estimates, force=_force(runs, rig), messages=said, thinned=less)
    if rig == recordings[0].rig:
        known = dict(source.noise) or None if isinstance(source, Case) else None
        found = replace(found, channels=dict(recordings[0].channels), reading_noise=known)
    tell("done", 1.0)
    return found


def _beside_declared(
    found: Identified, told: FrictionLaw | None, undeclared: Sequence[str]
) -> dict[str, Estimate]:
    """The estimates beside what was declared of the law, where that is of the kind that was identified."""
    given = {} if told is None or told.kind != found.law.kind else given_numbers(told, undeclared)
    return {name: replace(one, declared=given.get(name)) for name, one in found.estimates.items()}


def _material(
    source: Case | Recording | Sequence[Recording], rig: AnyRig | None, friction: FrictionLaw | None
) -> tuple[list[Recording], AnyRig, FrictionLaw | None]:
    if isinstance(source, Case):
        recordings = [r for r in source.runs if r.role == "train"]
        rig = rig or source.rig
        friction = friction or source.friction
    else:
        recordings = [source] if isinstance(source, Recording) else list(source)
    if rig is None:
        raise InputError("rig is missing: give identify(recording, rig=...)")
    rig = on_belt(rig)
    if not recordings:
        raise InputError("no run to identify from: the case has no run with role 'train'")
    return recordings, rig, friction


def _identify_by_shooting(
    runs: Sequence[Measured],
    rig: AnyRig,
    start: FrictionLaw,
    simulator: Simulator,
    tell: Progress,
    undeclared: Sequence[str],
) -> Identified:
    """Fit the law to windows, then to whole runs if it explains those as well."""
    branches = law_parameters(start)
    names = tuple(dict.fromkeys([*branches["minus"], *branches["plus"]]))
    model = Model(rig, friction=start)
    declared = np.array([model.parameters[n] for n in names], dtype=float)
    noise = single_noise(runs)
    period, cols = natural_period(rig), columns(rig)
    windows = [_window(r, b, i, cols) for i, r in enumerate(runs) for b in cutting.cut(r.track, period)]
    steps = iter(np.linspace(0.1, 0.9, 80))

    def fit(model: Model, windows: Sequence[Window], what: str) -> Shot:
        return shoot(
            model,
            windows,
            names,
            noise=noise,
            simulator=simulator,
            declared=declared,
            progress=lambda _: tell(what, float(next(steps, 0.9))),
        )

    short = fit(model, windows, "fitting windows")
    explainable(short, noise)
    found = model.replace(**dict(zip(names, short.values.tolist(), strict=True)))
    whole = _whole_runs(runs, short, cols)
    best, where = short, "windows"
    try:
        long = fit(found, whole, "fitting whole runs")
        if _explains(long, short):
            best, where = long, "whole runs"
    except (np.linalg.LinAlgError, ValueError):
        pass  # whole runs are a refinement; a law that cannot follow one keeps the windows' estimate
    return _conclude(runs, rig, start, names, declared, best, short, where, simulator, undeclared)


def _window(run: Measured, bounds: tuple[int, int], number: int, cols: tuple[int, ...]) -> Window:
    """A window of a run, with the state at its start."""
    made = cutting.window(run.track, run.readings, bounds, run=number, columns=cols)
    return replace(made, averaged=run.averaged)


def _whole_runs(runs: Sequence[Measured], short: Shot, cols: tuple[int, ...]) -> list[Window]:
    """One window a run, from the state its first short window was found to start in."""
    first = {w.run: w for w in reversed(short.windows)}
    return [replace(_window(r, (0, len(r.t)), i, cols), initial=first[i].initial) for i, r in enumerate(runs)]


def _explains(long: Shot, short: Shot) -> bool:
    """Whether whole runs cost no more than their fewer free states must (three standard deviations)."""
    gained = max(long.dof - short.dof, 0)
    excess = (long.chi2 - short.chi2) / max(1.0, short.reduced)
    return bool(np.isfinite(long.chi2) and excess < gained + 3 * np.sqrt(2 * gained) + 3)


def _widened(shot: Shot) -> Array:
    """Covariance that allows for what the law leaves unexplained."""
    covariance = shot.covariance * max(1.0, shot.reduced)
    if shot.reduced > 1.2 and len(shot.windows) >= 20:
        # the law is not the whole truth: let the scatter between windows speak where it is larger
        ratio = np.diag(shot.sandwich) / np.maximum(np.diag(covariance), 1e-300)
        stretch = np.sqrt(np.maximum(ratio, 1.0))
        covariance = covariance * np.outer(stretch, stretch)
    return covariance


def _conclude(
    runs: Sequence[Measured],
    rig: AnyRig,
    start: FrictionLaw,
    names: tuple[str, ...],
    declared: Array,
    best: Shot,
    short: Shot,
    where: str,
    simulator: Simulator,
    undeclared: Sequence[str],
) -> Identified:
    covariance = _widened(best)
    seen = best.prior_share < 0.99
    values = np.where(seen, best.values, declared)
    law = Model(rig, friction=start).replace(**dict(zip(names, values.tolist(), strict=True))).friction
    estimates = {
        n: estimate(v, float(np.sqrt(c)), float(share), float(d))
        for n, v, c, share, d in zip(
            names, values, np.diag(covariance), best.prior_share, declared, strict=True
        )
    }
    kept, noise = np.flatnonzero(seen), single_noise(runs)
    covered = covered_speeds(Model(rig, friction=law), best.windows, simulator)
    starts = dict(zip(names, declared.tolist(), strict=True))
    messages = fit_messages(estimates, covered, best, where, starts, undeclared)
    return Identified(
        rig=rig,
        law=law,
        estimates=estimates,
        names=tuple(names[i] for i in kept),
        covariance=covariance[np.ix_(kept, kept)],
        covered=covered,
        noise=dict(zip(("x1", "y1"), noise.tolist(), strict=False)),
        reduced_chi2=best.reduced,
        diagnostics={
            "windows": float(len(best.windows)),
            "reduced_chi2_windows": short.reduced,
            "runs": float(len(runs)),
            "whole_runs": float(where == "whole runs"),
            "misfit": misfit(best, noise),
        },
        messages=messages,
    )


def _force(runs: Sequence[Measured], rig: AnyRig) -> ForcePoints | None:
    period = natural_period(rig)
    return force.joined(
        [
            force.force_points(rig, r.track, r.readings, noise=r.noise, period=period, run=i)
            for i, r in enumerate(runs)
        ]
    )
