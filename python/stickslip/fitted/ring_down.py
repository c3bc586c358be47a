"""Ring-down: a block that swings out on a base at rest gives the friction of its decrement.

Coulomb friction takes 2 F/k from every swing, viscous damping a share of it: turning points X about the middle follow

    |X[n+1]| = rho |X[n]| - (1 + rho) F/k,

so that a line through neighbouring ones tells both (Feeny and Liang, J. Sound Vib. 195, 1996). From there law and
damping are fitted to the readings themselves, through simulation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.declared.scale import plainly, to_digits
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.fitted.constant import Constant
from stickslip.fitted.covered_speeds import covered_speeds
from stickslip.fitted.identified import Identified, estimate
from stickslip.fitted.identify_check import explainable, misfit
from stickslip.fitted.identify_windows import law_parameters, single_noise
from stickslip.fitted.identify_words import fit_messages
from stickslip.fitted.shooting import Shot, Simulator, shoot
from stickslip.fitted.swings import FEWEST, Decrement, decrement_of, passing, zero_of
from stickslip.measured.fit_window import Array, FitWindow
from stickslip.measured.prepared import Measured

CONSTANTS = ("damping", "mass")  # fitted beside the law
NEXT_TO = 1.02  # times kinetic friction that a static limit is which is as good as that
ROOM = 1.2  # times kinetic friction that a static limit is from which a fit starts


def identify_ring_down(
    runs: Sequence[Measured],
    rig: BlockOnBelt,
    told: FrictionLaw | None,
    simulator: Simulator,
    tell: Callable[[str, float], None],
    undeclared: Sequence[str] = (),
    spring: tuple[float, float] = (0.0, 0.0),
) -> Identified:
    """
    Identify friction, and the damping of a rig that has some, from runs on a base at rest.

    Parameters
    ----------
    runs : their belt speed 0
    rig : declared
    told : the law to start from; Coulomb's by the decrement where nobody said anything
    simulator, tell, undeclared : as in `identify`
    spring : relative standard uncertainties of its stiffness, and of the force that its readings give: the swings tell
        times and lengths, and all else in proportion to these

    Raises
    ------
    InputError
        Too few swings, or a law that does not explain them.
    """
    tell("turning points", 0.2)
    zero = 0.0
    if told is None or isinstance(told, CoulombFriction):
        zero = float(np.median([zero_of(run, rig) for run in runs]))
        runs = [replace(run, readings=run.readings - zero) for run in runs]
    seen = [decrement_of(run, rig) for run in runs]
    start = _coulomb(seen, told) if told is None or isinstance(told, CoulombFriction) else told
    branches = law_parameters(start)
    names = tuple(dict.fromkeys([*branches["minus"], *branches["plus"]]))
    damping = float(np.mean([one.damping(rig) for one in seen]))
    names = (*names, "mass")  # the swings tell the frequency far better than anyone declares it
    if rig.damping > 0:
        names = (*names, "damping")
        rig_there = replace(rig, damping=damping or rig.damping)
    else:
        rig_there = rig
    model = Model(rig_there, friction=start)
    declared = np.array([model.parameters[n] for n in names])
    noise = single_noise(runs)
    tell("fitting the swings", 0.4)
    shot = _swing_by_swing(
        model, [_window(run, i, rig) for i, run in enumerate(runs)], names, noise, simulator, declared
    )
    if zero:
        shift, shot = _from_zero(model, shot, names, noise, simulator, declared)
        zero += shift
    explainable(shot, noise)
    return _concluded(rig, model, shot, seen, noise, simulator, undeclared, zero, spring)


def _coulomb(seen: Sequence[Decrement], told: CoulombFriction | None) -> CoulombFriction:
    """
    Friction by the decrement, the static limit where the resting places leave it, as declared if that is open.

    It is above kinetic friction, which a fit could not raise else.
    """
    friction = float(np.mean([one.friction for one in seen]))
    held, passed = _limits(seen, friction)
    static = 0.5 * (held + passed)
    if told is not None and held <= told.static <= passed:
        static = told.static
    return CoulombFriction(static=max(static, min(ROOM * friction, passed)), kinetic=friction)


def _limits(seen: Sequence[Decrement], friction: float) -> tuple[float, float]:
    """What the static limit is at least and at most."""
    held = max([friction, *(one.held for one in seen)])
    return held, max(min(one.passed for one in seen), held)


def _window(run: Measured, number: int, rig: BlockOnBelt) -> FitWindow:
    """The run from where it is fastest, far from any stick, on."""
    start = int(np.nanargmax(np.abs(run.track.v)))
    initial = np.array(passing(run, start, rig))
    part = slice(start, len(run.t))
    made = FitWindow(number, 0.0, run.t[part] - run.t[start], run.readings[part], (0,), initial, ("x1", "x2"))
    return replace(made, averaged=run.averaged)


def _swing_by_swing(
    model: Model,
    windows: Sequence[FitWindow],
    names: Sequence[str],
    noise: Array,
    simulator: Simulator,
    declared: Array,
) -> Shot:
    """
    Fit the first swings, then twice as many, until all are in.

    How many swings there are before the block rests depends on friction in steps, and readings of the rest say nothing
    of the way there: a fit to all of them at once ends at a wrong number of swings. A last swing that is too small to
    be seen as one bounds no static limit, so that each fit is tried with one next to kinetic friction, too.
    """
    rig = model.rig
    assert isinstance(rig, BlockOnBelt)
    span = FEWEST * math.pi * math.sqrt(rig.mass / rig.stiffness)
    longest = max(float(one.t[-1]) for one in windows)
    while True:
        part = [_until(one, span) for one in windows]
        tries = [model]
        if isinstance(model.friction, CoulombFriction):
            tries.append(model.replace({"static": NEXT_TO * model.parameters["kinetic"]}))
        shots = [
            shoot(one, part, names, noise=noise, simulator=simulator, declared=declared) for one in tries
        ]
        shot = min(shots, key=lambda one: one.reduced)
        if span >= longest:
            return shot
        model = model.replace(dict(zip(names, shot.values.tolist(), strict=True)))
        windows = [
            replace(one, initial=found.initial) for one, found in zip(windows, shot.windows, strict=True)
        ]
        span *= 2


def _from_zero(
    model: Model, shot: Shot, names: Sequence[str], noise: Array, simulator: Simulator, declared: Array
) -> tuple[float, Shot]:
    """Move what readings are counted from to where the fit to them is best: how far, and the fit there."""
    model = model.replace(dict(zip(names, shot.values.tolist(), strict=True)))

    def at(shift: float) -> Shot:
        windows = [replace(one, readings=one.readings - shift) for one in shot.windows]
        return shoot(model, windows, names, noise=noise, simulator=simulator, declared=declared)

    step = float(noise[0])
    before, after = at(-step).reduced, at(step).reduced
    bend = before - 2 * shot.reduced + after
    shift = 0.5 * step * (before - after) / bend if bend > 0 else 0.0
    moved = at(shift)
    return (shift, moved) if moved.reduced < shot.reduced else (0.0, shot)


def _until(window: FitWindow, span: float) -> FitWindow:
    """A window's first part."""
    kept = window.t <= span
    return replace(window, t=window.t[kept], readings=window.readings[kept])


def _concluded(
    rig: BlockOnBelt,
    model: Model,
    shot: Shot,
    seen: Sequence[Decrement],
    noise: Array,
    simulator: Simulator,
    undeclared: Sequence[str],
    zero: float,
    spring: tuple[float, float],
) -> Identified:
    stiffness, force = spring
    scaled = np.array(
        [v * (stiffness if n in CONSTANTS else force) for n, v in zip(shot.names, shot.values, strict=True)]
    )
    covariance = shot.covariance * max(1.0, shot.reduced) + np.outer(scaled, scaled)
    std = np.sqrt(np.diag(covariance))
    told = shot.prior_share < 0.99
    start = model.parameters
    coulomb = isinstance(model.friction, CoulombFriction)
    values = {  # a static limit is where the block rests as it did
        n: float(v) if ok or (coulomb and n == "static") else start[n]
        for n, v, ok in zip(shot.names, shot.values, told, strict=True)
    }
    if coulomb:
        values["static"] = max(values["static"], values["kinetic"])
    fitted = model.replace(values)
    rows = dict(zip(shot.names, zip(std.tolist(), shot.prior_share.tolist(), strict=True), strict=True))
    estimates = {
        n: estimate(values[n], s, share, values[n] if share >= 0.99 else start[n])
        for n, (s, share) in rows.items()
        if n not in CONSTANTS
    }
    kept = [i for i, n in enumerate(shot.names) if n not in CONSTANTS and told[i]]
    constants = {}
    for name in CONSTANTS:
        if name in rows:
            value, half = values[name], SIGMAS_95 * rows[name][0]
            constants[name] = Constant(value, value - half, value + half, getattr(rig, name), None)
    covered = covered_speeds(fitted, shot.windows, simulator)
    # of a static limit that turning points bound that is said, wherever it is put
    bounded = {
        n: e
        for n, e in estimates.items()
        if not (coulomb and n == "static" and not told[shot.names.index(n)])
    }
    return Identified(
        rig=rig,
        law=fitted.friction,
        estimates=estimates,
        names=tuple(shot.names[i] for i in kept),
        covariance=covariance[np.ix_(kept, kept)],
        covered=covered,
        noise={"x1": float(noise[0])},
        reduced_chi2=shot.reduced,
        constants=constants,
        fitted=fitted,
        diagnostics={"windows": float(len(shot.windows)), "misfit": misfit(shot, noise)},
        messages=(
            *_words(seen, rig, values.get("kinetic"), constants, zero),
            *fit_messages(bounded, covered, shot, "ring-downs", start, undeclared),
        ),
    )


def _words(
    seen: Sequence[Decrement],
    rig: BlockOnBelt,
    friction: float | None,
    constants: dict[str, Constant],
    zero: float,
) -> list[str]:
    swings = sum(one.swings for one in seen)
    lost = 2 * float(np.mean([one.friction for one in seen])) / rig.stiffness
    out = [
        f"ring-down: {swings} swings, each {plainly(lost, 3)} shorter by friction (in the rig's unit of x1)"
    ]
    if friction is not None:
        held, passed = (plainly(one, 3) for one in _limits(seen, friction))
        if any(one.held for one in seen):
            out.append(
                f"static friction lies between {held} and {passed}: the block came to rest at the one spring force and "
                "passed the other"
            )
        else:
            out.append(f"static friction is at most {passed}: the block passed that spring force")
    if zero:
        off = plainly(zero, 4)
        out.append(
            f"x1 reads {off} where the spring is slack, as the middle of the swings is there: taken off"
        )
    if (one := constants.get("damping")) is not None:
        out.append(
            f"damping {_interval(one)}, declared {plainly(one.declared, 3)}: fitted beside friction, as a share that "
            "every swing loses"
        )
    one = constants["mass"]
    out.append(
        f"mass {_interval(one)}, declared {plainly(one.declared, 4)}: of the frequency; it and friction are in "
        "proportion to the spring's stiffness"
    )
    return out


def _interval(one: Constant) -> str:
    value, low, high = (to_digits(x, 0.5 * (one.high - one.low)) for x in (one.value, one.low, one.high))
    return f"{value} ({low} .. {high})"
