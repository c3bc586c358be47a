"""Ring-down: a block that swings out on a base at rest gives the friction of its decrement.

Coulomb friction takes 2 F/k from every swing, viscous damping a share of it: turning points X about the middle follow

    |X[n+1]| = rho |X[n]| - (1 + rho) F/k,

so that a line through neighbouring ones tells both (Feeny and Liang, J. Sound Vib. 195, 1996). From there law and
damping are fitted to the readings themselves, through simulation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.declared.scale import plainly
from stickslip.errors import InputError
from stickslip.fitted.covered_speeds import covered_speeds
from stickslip.fitted.identified import Constant, Identified, estimate
from stickslip.fitted.identify_check import explainable, misfit
from stickslip.fitted.identify_windows import law_parameters, single_noise
from stickslip.fitted.identify_words import fit_messages
from stickslip.fitted.shooting import Shot, Simulator, shoot
from stickslip.measured.cutting import local_state
from stickslip.measured.fit_window import Array, Window
from stickslip.measured.prepared import Measured

FEWEST = 3  # swings
CLEAR = 8.0  # times the noise: a swing that is one
ENOUGH = 6  # swings from which damping is told beside friction


@dataclass(frozen=True)
class Decrement:
    """
    What turning points say.

    Parameters
    ----------
    friction : Coulomb's, a force
    ratio : of neighbouring amplitudes that viscous damping alone would leave, at most 1
    swings : how many half periods
    held, passed : force of the spring where the block came to rest, 0 where it did not, and at the turn before: the
        static limit lies between them
    """

    friction: float
    ratio: float
    swings: int
    held: float = 0.0
    passed: float = math.inf

    def damping(self, rig: BlockOnBelt) -> float:
        """Return the damping that leaves this ratio."""
        log = -math.log(self.ratio) / math.pi
        return 2 * math.sqrt(rig.stiffness * rig.mass) * log / math.sqrt(1 + log**2)


def decrement(turns: Array, stiffness: float) -> Decrement:
    """
    Return the friction of turning points.

    Parameters
    ----------
    turns : (n,) displacements of successive turning points, of alternating sides, the resting place at 0
    stiffness : of the spring

    Raises
    ------
    InputError
        Fewer than three swings, or amplitudes that do not fall.
    """
    size = np.abs(np.asarray(turns, dtype=float))
    if len(size) < FEWEST + 1:
        raise InputError(
            f"{max(len(size) - 1, 0)} swings of a ring-down are seen; at least {FEWEST} are needed"
        )
    if len(size) > ENOUGH:
        slope, level = np.polyfit(size[:-1], size[1:], 1)
        ratio = float(np.clip(slope, 0.05, 1.0))
    else:
        ratio = 1.0
    level = float(np.mean(size[1:] - ratio * size[:-1]))
    friction = -level * stiffness / (1 + ratio)
    if friction <= 0:
        raise InputError(
            "the swings of a ring-down do not fall as friction makes them: nothing is told of it"
        )
    return Decrement(friction, ratio, len(size) - 1)


def turning_points(run: Measured) -> tuple[Array, Array]:
    """Return samples and displacements of the turning points of a run, (n,) each, while its swings are clear."""
    v, t, x = run.track.v, run.t, run.readings[:, 0]
    fastest = int(np.nanargmax(np.abs(v)))
    crossings = fastest + np.flatnonzero(np.sign(v[fastest:-1]) * np.sign(v[fastest + 1 :]) < 0)
    at: list[int] = []
    places: list[float] = []
    for i in crossings.tolist():
        place, _ = local_state(t, x, i, max(run.track.width, 3))
        if places and (place - places[-1]) * (-1) ** len(places) * np.sign(v[fastest]) < CLEAR * run.noise[0]:
            break
        at.append(i)
        places.append(place)
    return np.array(at, dtype=int), np.array(places)


def identify_ring_down(
    runs: Sequence[Measured],
    rig: BlockOnBelt,
    told: FrictionLaw | None,
    simulator: Simulator,
    tell: Callable[[str, float], None],
    undeclared: Sequence[str] = (),
) -> Identified:
    """
    Identify friction, and the damping of a rig that has some, from runs on a base at rest.

    Parameters
    ----------
    runs : their belt speed 0
    rig : declared
    told : the law to start from; Coulomb's by the decrement where nobody said anything
    simulator, tell, undeclared : as in `identify`

    Raises
    ------
    InputError
        Too few swings, or a law that does not explain them.
    """
    tell("turning points", 0.2)
    seen = [_decrement(run, rig) for run in runs]
    start = _coulomb(seen) if told is None or isinstance(told, CoulombFriction) else told
    branches = law_parameters(start)
    names = tuple(dict.fromkeys([*branches["minus"], *branches["plus"]]))
    damping = float(np.mean([one.damping(rig) for one in seen]))
    if rig.damping > 0:
        names = (*names, "damping")
        rig_there = replace(rig, damping=damping or rig.damping)
    else:
        rig_there = rig
    model = Model(rig_there, friction=start)
    declared = np.array([model.parameters[n] for n in names])
    noise = single_noise(runs)
    tell("fitting the swings", 0.4)
    shot = shoot(
        model, [_window(run, i) for i, run in enumerate(runs)], names, noise=noise, simulator=simulator,
        declared=declared,
    )  # fmt: skip
    explainable(shot, noise)
    return _concluded(rig, model, shot, seen, noise, simulator, undeclared)


def _coulomb(seen: Sequence[Decrement]) -> CoulombFriction:
    """Friction by the decrement, the static limit in the middle of what the resting places leave open."""
    friction = float(np.mean([one.friction for one in seen]))
    held, passed = _limits(seen, friction)
    return CoulombFriction(static=0.5 * (held + passed) if passed < math.inf else held, kinetic=friction)


def _limits(seen: Sequence[Decrement], friction: float) -> tuple[float, float]:
    """What the static limit is at least and at most."""
    held = max([friction, *(one.held for one in seen)])
    return held, max(min(one.passed for one in seen), held)


def _decrement(run: Measured, rig: BlockOnBelt) -> Decrement:
    at, places = turning_points(run)
    try:
        found = decrement(places, rig.stiffness)
    except InputError as error:
        raise InputError(f"{run.name}: {error}") from None
    after = run.readings[at[-1] :, 0]
    rests = float(np.nanmax(np.abs(after - places[-1]))) < CLEAR * run.noise[0]
    if not rests:
        return found
    held, passed = (rig.stiffness * abs(float(places[i])) for i in (-1, -2))
    return replace(found, held=held, passed=passed)


def _window(run: Measured, number: int) -> Window:
    """The run from where it is fastest, far from any stick, on."""
    start = int(np.nanargmax(np.abs(run.track.v)))
    initial = np.array(local_state(run.t, run.readings[:, 0], start, max(run.track.width, 3)))
    part = slice(start, len(run.t))
    made = Window(number, 0.0, run.t[part] - run.t[start], run.readings[part], (0,), initial, ("x1", "x2"))
    return replace(made, averaged=run.averaged)


def _concluded(
    rig: BlockOnBelt,
    model: Model,
    shot: Shot,
    seen: Sequence[Decrement],
    noise: Array,
    simulator: Simulator,
    undeclared: Sequence[str],
) -> Identified:
    covariance = shot.covariance * max(1.0, shot.reduced)
    std = np.sqrt(np.diag(covariance))
    told = shot.prior_share < 0.99
    start = model.parameters
    values = {n: float(v) if ok else start[n] for n, v, ok in zip(shot.names, shot.values, told, strict=True)}
    if isinstance(model.friction, CoulombFriction):
        values["static"] = max(values["static"], values["kinetic"])
    fitted = model.replace(values)
    rows = dict(zip(shot.names, zip(std.tolist(), shot.prior_share.tolist(), strict=True), strict=True))
    estimates = {
        n: estimate(values[n], s, share, values[n] if share >= 0.99 else start[n])
        for n, (s, share) in rows.items()
        if n != "damping"
    }
    kept = [i for i, n in enumerate(shot.names) if n != "damping" and told[i]]
    constants = {}
    if "damping" in rows:
        c, s = values["damping"], 1.96 * rows["damping"][0]
        constants["damping"] = Constant(c, c - s, c + s, rig.damping, None)
    covered = covered_speeds(fitted, shot.windows, simulator)
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
            *_words(seen, rig, values.get("kinetic"), constants),
            *fit_messages(estimates, covered, shot, "ring-downs", start, undeclared),
        ),
    )


def _words(
    seen: Sequence[Decrement], rig: BlockOnBelt, friction: float | None, constants: dict[str, Constant]
) -> list[str]:
    swings = sum(one.swings for one in seen)
    lost = 2 * float(np.mean([one.friction for one in seen])) / rig.stiffness
    out = [
        f"ring-down: {swings} swings, each {plainly(lost, 3)} shorter by friction (in the rig's unit of x1)"
    ]
    if friction is not None and any(one.held for one in seen):
        held, passed = _limits(seen, friction)
        out.append(
            f"static friction lies between {plainly(held, 3)} and {plainly(passed, 3)}: the block came to rest at the "
            "one spring force and passed the other"
        )
    for one in constants.values():
        out.append(
            f"damping {plainly(one.value, 3)} ({plainly(one.low, 3)} .. {plainly(one.high, 3)}), declared "
            f"{plainly(one.declared, 3)}: fitted beside friction, as a share that every swing loses"
        )
    return out
