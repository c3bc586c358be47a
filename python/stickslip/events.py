"""Slip by slip: the friction of a real block on a belt, whose breakaway and sliding levels scatter.

Each slip is simulated on its own, from the stick before it into the stick after it, with its own static and
kinetic level. What all slips share (the decay of the hyperbolic law) is fitted jointly. The law reported is the
mean over slips; its intervals come from a block bootstrap over them, because neighbouring slips are on the same
patch of surface and are not independent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from stickslip.errors import InputError, StickslipError
from stickslip.friction import CoulombFriction, FrictionLaw, HyperbolicFriction
from stickslip.identified import Branch, Estimate, Events, Identified
from stickslip.model import Model
from stickslip.rig import AnyRig, BlockOnBelt
from stickslip.segments import Segment, stick_position
from stickslip.shooting import Array, Shot, Simulator, Window, shoot

if TYPE_CHECKING:
    from stickslip.identify import Measured

Kind = Literal["coulomb", "hyperbolic"]
LEAST_SLIP = 10.0  # amplitude in standard deviations of the noise
RESAMPLES = 2000


@dataclass(frozen=True)
class _Slip:
    run: int
    t: float
    amplitude: float
    speed: float
    window: Window


def identify_events(
    runs: Sequence[Measured], rig: AnyRig, *, simulator: Simulator, tell: Callable[[str, float], None]
) -> Identified:
    """Identify Coulomb or hyperbolic friction from the slips of a block on a belt.

    Parameters
    ----------
    runs : sequence of Measured
    rig : BlockOnBelt
    simulator : callable
    tell : callable
        Progress.

    Returns
    -------
    Identified

    Raises
    ------
    InputError
        If the rig has two degrees of freedom, or fewer than three slips are found.
    """
    if not isinstance(rig, BlockOnBelt):
        raise InputError("slips are fitted one by one only for a BlockOnBelt; use scatter=False")
    slips = [s for i, r in enumerate(runs) for s in _slips(r, i, rig)]
    branch = _branch(runs)
    noise = np.mean([r.noise for r in runs], axis=0)
    coulomb, slips = _one_by_one(slips, rig, noise, simulator, tell)
    if len(slips) < 3:
        raise InputError(
            f"{len(slips)} slips found; at least 3 are needed (is the belt speed right, does the block stick?)"
        )
    tell("hyperbolic law", 0.6)
    hyperbolic = _hyperbolic(slips, coulomb, rig, noise, simulator)
    tell("bootstrap", 0.85)
    chosen, preference = _choose(coulomb, hyperbolic, slips)
    return _conclude(runs, rig, branch, chosen, preference, slips, noise)


def _branch(runs: Sequence[Measured]) -> Branch:
    directions = {np.sign(r.belt_speed) for r in runs}
    if len(directions) != 1 or 0.0 in directions:
        raise InputError("slips are fitted one by one for one belt direction; identify each direction separately")
    return "minus" if directions == {1.0} else "plus"


def _slips(run: Measured, number: int, rig: BlockOnBelt) -> list[_Slip]:
    """Slips against the belt with a stick on both sides, large enough to be told from noise."""
    track, period = run.track, 2 * np.pi * float(np.sqrt(rig.mass / rig.stiffness))
    against = -int(np.sign(run.belt_speed))
    out = []
    trio = zip(track.segments[:-2], track.segments[1:-1], track.segments[2:], strict=True)
    for before, slip, after in trio:
        if before.mode or after.mode or slip.mode != against:
            continue
        start = max((before.start + before.stop) // 2, int(np.searchsorted(track.t, track.t[slip.start] - period / 4)))
        stop = min((after.start + after.stop) // 2, int(np.searchsorted(track.t, track.t[slip.stop] + period / 10)))
        part = track.x[slip.start : slip.stop]
        amplitude = float(part.max() - part.min())
        if amplitude < LEAST_SLIP * run.noise[0] or stop - start < 12:
            continue
        speed = float(np.max(np.abs(track.v[slip.start : slip.stop] - run.belt_speed)))
        window = _event_window(run, number, before, start, stop)
        out.append(_Slip(number, float(track.t[slip.start]), amplitude, speed, window))
    return out


def _event_window(run: Measured, number: int, before: Segment, start: int, stop: int) -> Window:
    part = slice(start, stop)
    x = stick_position(run.track, run.readings[:, 0], before, start)
    return Window(
        run=number,
        belt_speed=run.belt_speed,
        t=run.t[part] - run.t[start],
        readings=run.readings[part],
        columns=(0,),
        initial=np.array([x, run.belt_speed]),
        free=("x1",),
    )


def _one_by_one(
    slips: Sequence[_Slip],
    rig: BlockOnBelt,
    noise: Array,
    simulator: Simulator,
    tell: Callable[[str, float], None],
) -> tuple[Shot, list[_Slip]]:
    """Coulomb levels of every slip; slips that no level can reproduce are left out."""
    shots, kept = [], []
    model = Model(rig, friction=CoulombFriction())
    for i, s in enumerate(slips):
        x = s.window.readings[:, 0]
        direction = float(np.sign(s.window.belt_speed))
        top, end = float(np.nanmax(direction * x)), float(direction * x[np.isfinite(x)][-1])
        static = rig.stiffness * top
        kinetic = max(rig.stiffness * 0.5 * (top + min(end, top - s.amplitude)), 0.0)
        window = replace(s.window, local={"static": static, "kinetic": kinetic})
        try:
            shot = shoot(model, [window], (), noise=noise, simulator=simulator, iterations=15)
        except StickslipError:
            continue
        own = shot.windows[0].local
        if np.isfinite(shot.chi2) and own["static"] > own["kinetic"] >= 0:
            shots.append(shot)
            kept.append(s)
        tell("slips one by one", 0.1 + 0.5 * i / len(slips))
    return _merged(shots), kept


def _merged(shots: Sequence[Shot]) -> Shot:
    empty = np.zeros((0, 0))
    return Shot(
        names=(),
        values=np.zeros(0),
        covariance=empty,
        sandwich=empty,
        windows=[w for s in shots for w in s.windows],
        local_std=[d for s in shots for d in s.local_std],
        residuals=[r for s in shots for r in s.residuals],
        chi2=float(sum(s.chi2 for s in shots)),
        dof=sum(s.dof for s in shots),
        prior_share=np.zeros(0),
    )


def _hyperbolic(
    slips: Sequence[_Slip], coulomb: Shot, rig: BlockOnBelt, noise: Array, simulator: Simulator
) -> Shot | None:
    """Joint fit with a common decay, each slip with its own R(0) and its own level at speed."""
    decay = 1.0 / (0.3 * float(np.median([s.speed for s in slips])))
    windows = []
    for w in coulomb.windows:
        static, kinetic = w.local["static"], w.local["kinetic"]
        # same mean over the slip: 1/(1 + decay u) averages about 0.4 over it
        drop = (static - kinetic) / 0.6
        windows.append(replace(w, local={"scale": drop, "constant": static - drop}))
    model = Model(rig, friction=HyperbolicFriction(scale=1.0, decay=decay))
    try:
        return shoot(model, windows, ("decay",), noise=noise, simulator=simulator, iterations=25)
    except (StickslipError, np.linalg.LinAlgError):
        return None


def _effective(residuals: Sequence[Array]) -> float:
    """Number of independent readings: misfit is correlated from sample to sample, noise is not."""
    total = 0.0
    for r in residuals:
        x = r[:, 0] - r[:, 0].mean()
        power = float(x @ x)
        rho = float(np.clip(x[1:] @ x[:-1] / power, 0.0, 0.999)) if power > 0 else 0.0
        total += max(len(x) * (1 - rho) / (1 + rho), 1.0)
    return total


def _choose(coulomb: Shot, hyperbolic: Shot | None, slips: Sequence[_Slip]) -> tuple[Shot, float]:
    """The law with the lower Bayesian information criterion, and by how much the hyperbolic one is preferred."""
    if hyperbolic is None or not np.isfinite(hyperbolic.chi2):
        return coulomb, -np.inf
    n = _effective(coulomb.residuals)
    # both have three numbers a slip; the hyperbolic law has one more for all
    preference = n * float(np.log(coulomb.chi2 / hyperbolic.chi2)) - float(np.log(n))
    del slips
    return (hyperbolic if preference > 2 else coulomb), preference


def _conclude(
    runs: Sequence[Measured],
    rig: BlockOnBelt,
    branch: Branch,
    shot: Shot,
    preference: float,
    slips: Sequence[_Slip],
    noise: Array,
) -> Identified:
    kind: Kind = "hyperbolic" if shot.names else "coulomb"
    local = {n: np.array([w.local[n] for w in shot.windows]) for n in shot.windows[0].local}
    names = (*local, *shot.names)
    level = np.column_stack([*local.values(), *(np.full(len(slips), v) for v in shot.values)])
    mean = level.mean(axis=0)
    covariance = _block_bootstrap(level)
    for i, n in enumerate(shot.names):
        k = names.index(n)
        covariance[k, k] = max(float(shot.sandwich[i, i]), float(shot.covariance[i, i]))
    law, estimates = _law(kind, branch, names, mean, np.sqrt(np.diag(covariance)))
    suffix = "" if branch == "minus" else "_plus"
    static = local["static"] if kind == "coulomb" else local["scale"] + local["constant"]
    kinetic = local["kinetic"] if kind == "coulomb" else _kinetic(law, local, slips, float(shot.values[0]))
    rms = np.array([float(np.sqrt(np.mean(r**2))) * noise[0] for r in shot.residuals])
    events = Events(
        t=np.array([s.t for s in slips]),
        static=static,
        kinetic=kinetic,
        amplitude=np.array([s.amplitude for s in slips]),
        rms=rms,
        run=np.array([float(s.run) for s in slips]),
    )
    visited = (0.0, float(max(s.speed for s in slips)))
    return Identified(
        rig=rig,
        law=law,
        estimates=estimates,
        names=tuple(n + suffix for n in names),
        covariance=covariance,
        covered={"minus": visited if branch == "minus" else None, "plus": visited if branch == "plus" else None},
        noise={"x1": float(noise[0])},
        reduced_chi2=shot.reduced,
        events=events,
        diagnostics=_diagnostics(runs, shot, preference, events, rig),
        messages=_messages(kind, branch, preference, events, noise, rig),
    )


def _kinetic(law: FrictionLaw, local: dict[str, Array], slips: Sequence[_Slip], decay: float) -> Array:
    """Sliding force of each slip at half its largest speed."""
    del law
    u = 0.5 * np.array([s.speed for s in slips])
    return np.asarray(local["scale"] / (1 + decay * u) + local["constant"], dtype=float)


def _law(
    kind: Kind, branch: Branch, names: Sequence[str], mean: Array, std: Array
) -> tuple[FrictionLaw, dict[str, Estimate]]:
    """The mean law; the direction never visited keeps the same numbers and is marked unidentified."""
    make = CoulombFriction if kind == "coulomb" else HyperbolicFriction
    numbers = dict(zip(names, mean.tolist(), strict=True))
    own, other = ("", "_plus") if branch == "minus" else ("_plus", "")
    both = {n + own: v for n, v in numbers.items()} | {n + other: v for n, v in numbers.items()}
    estimates = {
        n + own: Estimate(v, v - 1.96 * s, v + 1.96 * s, s, "weak" if s > abs(v) / 3 else "identified", v)
        for (n, v), s in zip(numbers.items(), std.tolist(), strict=True)
    }
    estimates |= {n + other: Estimate(v, None, None, None, "unidentified", v) for n, v in numbers.items()}
    return make(**both), estimates


def _block_bootstrap(level: Array) -> Array:
    """Covariance of the mean over slips when neighbours are correlated (circular blocks)."""
    n = len(level)
    size = int(min(max(np.ceil(2 * _correlation_length(level[:, 0])), 1), max(n // 4, 1)))
    rng = np.random.default_rng(0)
    starts = rng.integers(0, n, size=(RESAMPLES, -(-n // size)))
    index = (starts[:, :, None] + np.arange(size)) % n
    means = level[index.reshape(RESAMPLES, -1)[:, :n]].mean(axis=1)
    return np.atleast_2d(np.cov(means.T))


def _correlation_length(x: Array) -> float:
    """Integrated autocorrelation of a sequence, in events, summed to the first negative lag."""
    d = x - x.mean()
    power = float(d @ d)
    total = 0.5
    for k in range(1, len(d) // 2):
        rho = float(d[k:] @ d[:-k]) / power if power > 0 else 0.0
        if rho <= 0:
            break
        total += rho
    return total


def _diagnostics(
    runs: Sequence[Measured], shot: Shot, preference: float, events: Events, rig: BlockOnBelt
) -> dict[str, float]:
    drop = events.static - events.kinetic
    return {
        "events": float(len(events.t)),
        "bic_preference_for_hyperbolic": preference,
        "static_std_between_events": float(np.std(events.static, ddof=1)),
        "kinetic_std_between_events": float(np.std(events.kinetic, ddof=1)),
        "drop_mean": float(drop.mean()),
        "drop_std_between_events": float(np.std(drop, ddof=1)),
        "level_correlation_events": _correlation_length(events.static),
        "rms_residual": float(np.median(events.rms)),
        "rms_residual_of_amplitude": float(np.median(events.rms / events.amplitude)),
        "plateau_over_set_point": float(np.nanmean([r.plateau / r.set_point for r in runs])),
        "stiffness": rig.stiffness,
        "runs": float(len(runs)),
        "windows": float(len(shot.windows)),
    }


def _messages(
    kind: Kind, branch: Branch, preference: float, events: Events, noise: Array, rig: BlockOnBelt
) -> tuple[str, ...]:
    del noise, rig
    drop = events.static - events.kinetic
    other = "plus" if branch == "minus" else "minus"
    why = {
        "coulomb": "a decay with speed is not called for",
        "hyperbolic": "friction falls with speed rather than at once",
    }[kind]
    q = np.quantile(events.static, [0.05, 0.5, 0.95])
    return (
        f"{len(events.t)} slips fitted one by one; {kind} law chosen by BIC, difference {abs(preference):.1f} ({why})",
        f"breakaway force: median {q[1]:.4g}, 90 % of slips between {q[0]:.4g} and {q[2]:.4g}",
        f"drop at breakaway: {drop.mean():.4g} +- {drop.std(ddof=1):.2g} between slips",
        f"a single slip is reproduced to {100 * float(np.median(events.rms / events.amplitude)):.0f} % of its "
        "amplitude (median)",
        f"branch T_{other} was never visited: its numbers repeat T_{branch}'s and are unidentified",
    )
