"""From recordings to a friction law that every event shares: `identify` of `stickslip.likelihoods` without scatter.

The law's numbers are fitted through simulation (`stickslip.fitted.shooting`), first on windows of about one natural
period, cut in the middle of sticks, then on whole runs if the law still explains the readings there. The static
limits follow from the breakaway instants in the same fit. A block on a belt is identified slip by slip instead
(`stickslip.fitted.slip_levels`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal, get_args

import numpy as np

from stickslip.arguments import must_be, one_of
from stickslip.declared.bodies_model import check_closed_form
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.friction_law import FrictionLaw, given_numbers
from stickslip.declared.law_dimensions import in_model
from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig, on_belt
from stickslip.declared.uncertainty import Uncertainty
from stickslip.errors import InputError, number
from stickslip.fitted import friction_force as force
from stickslip.fitted.identified import Estimate, ForcePoints, Identified
from stickslip.fitted.identify_check import checked
from stickslip.fitted.identify_windows import columns, identify_by_windows, natural_period
from stickslip.fitted.identify_words import EXPLAINED, misfit_messages, plateau_messages
from stickslip.fitted.shooting import Simulator
from stickslip.measured import signals
from stickslip.measured import sticks as segments
from stickslip.measured.case import Case, Recording
from stickslip.measured.fit_window import Array
from stickslip.measured.prepared import Measured, Motion
from stickslip.measured.stick_speed import why_idle, wrong_set_point
from stickslip.measured.thinning import sentences, thinned
from stickslip.simulated.simulate import simulate

BeltSpeed = Literal["set-point", "plateau"]
Progress = Callable[[str, float], None]
RESOLVED = 1e-9  # of the range of a channel: no simulation is nearer, so it counts as noise


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


def _size(x: Array) -> float:
    """Range of readings, their own size where they are all the same, 1 where they are all 0."""
    return float(np.nanmax(x) - np.nanmin(x)) or float(np.nanmax(np.abs(x))) or 1.0


@dataclass(frozen=True)
class Material:
    """
    What is identified from.

    Parameters
    ----------
    recordings, runs : as they are fitted, read and with their sticks
    rig : declared
    friction : the law to start from, None where nobody said anything
    undeclared : its numbers that are mere defaults
    idle : says, for the number of a run, why no slip of it is used
    known : how well the rig's constants and gains are; None: they are exact
    """

    recordings: Sequence[Recording]
    runs: Sequence[Measured]
    rig: AnyRig
    friction: FrictionLaw | None
    undeclared: Sequence[str]
    idle: Callable[[int], str]
    known: Uncertainty | None = None

    @property
    def told(self) -> FrictionLaw | None:
        """The law whose kind is kept: the one to start from, unless it is wholly a default."""
        law = self.friction
        silent = isinstance(law, PaperFriction) and set(law.numbers) <= set(self.undeclared)
        return None if silent else law

    @property
    def unit(self) -> str:
        """Written behind forces."""
        return "" if self.recordings[0].unit("x1") == "1" else " N"


# the law where every slip has levels of its own, fitted when first asked for
Alone = Callable[[], Identified]
Scattering = Callable[[Material, Progress, Alone | None], Identified | None]


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
    scattering: Scattering | None = None,
) -> Identified:
    """Identify the law that every event shares; all but `scattering` is as `stickslip.identify` has it.

    Parameters
    ----------
    source, rig, friction, noise, belt_speed, scatter, simulator, progress
        See `stickslip.likelihoods.identify`.
    scattering : callable, optional
        Identifies where friction differs from event to event, None where it does not: asked first for a block on a
        belt, and for a rig of (2.1) where the law alone does not explain the readings, or with `scatter`.
    """
    if not isinstance(source, Case | Recording):
        for one in source if isinstance(source, (list, tuple)) else [source]:
            must_be("source", one, (Case, Recording), "load_case(path) gives a case")
    slips = _by_slips(source, rig, friction, scatter)
    undeclared = source.undeclared if isinstance(source, Case) and friction is None else ()
    tell = progress or (lambda _what, _share: None)
    tell("looking at the readings", 0.0)
    own = rig
    recordings, rig, friction = _material(source, rig, friction)
    told = friction
    recordings, less = thinned(recordings, rig)
    notes = checked(source, recordings) if isinstance(source, Case) and own in (None, source.rig) else ()
    tell("reading modes", 0.0)
    runs = [measured(r, rig, noise=noise, belt=belt_speed) for r in recordings]
    material = Material(
        recordings,
        runs,
        rig,
        friction,
        undeclared,
        lambda i: why_idle(replace(recordings[i], rig=rig), len(runs[i].track.sticks)),
        source.uncertainty if isinstance(source, Case) and own in (None, source.rig) else None,
    )
    found = _found(material, simulator, tell, slips, scatter, scattering)
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


def _by_slips(
    source: Case | Recording | Sequence[Recording],
    rig: AnyRig | None,
    friction: FrictionLaw | None,
    scatter: bool | None,
) -> bool:
    """Whether a law without scatter in common is fitted slip by slip."""
    if scatter is not None:
        must_be("scatter", scatter, bool)
        return scatter
    block = isinstance(source.rig if isinstance(source, Case) else rig, BlockOnBelt)
    many = isinstance(source, Case) and isinstance(source.declared_law, PaperFriction)
    return friction is None and block and not many


def _found(
    material: Material,
    simulator: Simulator,
    tell: Progress,
    slips: bool,
    scatter: bool | None,
    scattering: Scattering | None,
) -> Identified:
    """The law with scatter where there is some, else without; a block's slips have levels of their own then, too."""
    block = isinstance(material.rig, BlockOnBelt)
    if isinstance(material.rig, BlockOnBelt) and all(run.belt_speed == 0 for run in material.runs):
        from stickslip.fitted.ring_down import identify_ring_down

        return identify_ring_down(
            material.runs,
            material.rig,
            material.told,
            simulator,
            tell,
            material.undeclared,
            _of_spring(material),
        )

    @cache
    def alone() -> Identified:
        from stickslip.fitted.both_ways import identify_slips

        return identify_slips(
            material.runs,
            material.rig,
            declared=material.friction,
            simulator=simulator,
            tell=tell,
            unit=material.unit,
            undeclared=material.undeclared,
            why_idle=material.idle,
        )

    slips = slips and (block or scattering is None)
    if block and scattering is not None:
        found = scattering(material, tell, alone if slips else None)
        if found is not None:
            return found
    if slips:
        return alone()
    start = material.friction or (PaperFriction() if isinstance(material.rig, Rig) else CoulombFriction())
    found = identify_by_windows(material.runs, material.rig, start, simulator, tell, material.undeclared)
    if not block and scattering is not None and (scatter or found.reduced_chi2 > EXPLAINED):
        found = scattering(material, tell, None) or found
    doubts = ((r.name, wrong_set_point(replace(r, rig=material.rig))) for r in material.recordings)
    return replace(found, messages=(*found.messages, *(f"{n}: {words}" for n, words in doubts if words)))


def _beside_declared(
    found: Identified, told: FrictionLaw | None, undeclared: Sequence[str]
) -> dict[str, Estimate]:
    """The estimates beside what was declared of the law, where that is of the kind that was identified."""
    given = {} if told is None or told.kind != found.law.kind else given_numbers(told, undeclared)
    return {name: replace(one, declared=given.get(name)) for name, one in found.estimates.items()}


def _of_spring(material: Material) -> tuple[float, float]:
    """Relative standard uncertainties of the stiffness, and of the force that readings of the spring give."""
    if material.known is None:
        return 0.0, 0.0
    channel = material.recordings[0].channel("x1")
    stiffness, gain = (material.known.relative(name) for name in ("stiffness", channel))
    return stiffness, gain if channel == "spring_force" else math.hypot(stiffness, gain)


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
    if friction is not None:
        check_closed_form(rig, friction)
        friction = in_model(friction, rig)
    return recordings, rig, friction


def _force(runs: Sequence[Measured], rig: AnyRig) -> ForcePoints | None:
    period = natural_period(rig)
    return force.joined(
        [
            force.force_points(rig, r.track, r.readings, noise=r.noise, period=period, run=i)
            for i, r in enumerate(runs)
        ]
    )
