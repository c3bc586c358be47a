"""What an effect adds to the equations, in plain Python: formulas that the reference and the driven slider evaluate.

Formulas take complex numbers (for derivatives by a complex step) and arrays (for many instants, or lanes, at once).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.friction_law import Value as Value  # what formulas take, for the files of effects

Numbers = Mapping[str, float]  # the effect's parameters


NO_SIDES: Mapping[str, Value] = {}


@dataclass(slots=True)  # not frozen: one is made for every step, and freezing takes most of the time
class At:
    """Where a formula is read.

    `static_minus` is the declared static limit of T_-, `drive` the force F of a driven slider, `sides` the frozen side
    of every effect that has some, by its name.
    """

    t: Value = 0.0
    x1: Value = 0.0
    x2: Value = 0.0
    y1: Value = 0.0
    y2: Value = 0.0
    belt_speed: float = 0.0
    static_minus: float = 1.0
    drive: Value = 0.0
    sides: Mapping[str, Value] = field(default_factory=lambda: NO_SIDES)


Formula = Callable[[Numbers, At], Value]


@dataclass(frozen=True)
class Sides:
    """A law in pieces: on which side a start is, and what ends a side.

    `ends` maps the name of each switching function, negative while the side lasts, to the function and the side after.
    """

    start: Formula
    ends: Callable[[Numbers, int], Mapping[str, tuple[Callable[[At], Value], int]]]


@dataclass(frozen=True)
class Before:
    """What is known where a fit begins to simulate: v_w, the law, and what the x1 sensor reads, with its rate."""

    v: float
    belt_speed: float
    law: FrictionLaw
    read: float
    read_rate: float


@dataclass(frozen=True)
class Adds:
    """What an effect adds, each a formula of its numbers; None: nothing.

    Parameters
    ----------
    block, angle_body
        A force.
    friction
        A share of friction, static limits included: it is multiplied by 1 + share.
    peak
        By u: something on R(u); at u = 0 on the static limits.
    aging
        By the time at rest: something on the static limits.
    belt_share, belt_rate
        A share of the belt's speed, and the rate of that speed.
    drive
        A share of a driven slider's drive.
    sides
        Of a law in pieces.
    """

    block: Formula | None = None
    angle_body: Formula | None = None
    friction: Formula | None = None
    peak: Callable[[Numbers, Value], Value] | None = None
    aging: Callable[[Numbers, Value], Value] | None = None
    belt_share: Formula | None = None
    belt_rate: Formula | None = None
    drive: Formula | None = None
    sides: Sides | None = None


@dataclass(frozen=True)
class Behaves:
    """What else one may ask of an effect; None: there is nothing to say.

    Parameters
    ----------
    hidden_start
        The value of its hidden state where a fit begins to simulate, and how loosely that is held.
    period
        By numbers and belt speed: after what time it repeats; None where it does not change with time. Raises
        `InputError` where it never repeats.
    idle
        By law and all effects: why it could not act.
    drives
        By numbers, law, start and end: a sentence if friction turns negative.
    """

    hidden_start: Callable[[Numbers, Before], tuple[float, float]] | None = None
    period: Callable[[Numbers, float], float | None] | None = None
    idle: Callable[[FrictionLaw, Collection[str]], str | None] | None = None
    drives: Callable[[Numbers, FrictionLaw, float, float], str | None] | None = None


def wave_of_position(p: Numbers, at: At) -> Value:
    """A sin(2 pi x1/L + phi)."""
    return p["a"] * np.sin(2 * np.pi * at.x1 / p["L"] + p["phi"])
