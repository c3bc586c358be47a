"""What of a rig of any kind moves with the drive, what moves freely, and when what moves it repeats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, names, substituted
from stickslip.declared.formula.value import value
from stickslip.declared.places import coordinate, distance
from stickslip.errors import InputError
from stickslip.simulated.general import General
from stickslip.simulated.orbits.general_field import Field
from stickslip.simulated.orbits.period import common_multiple, periods_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Frame:
    """What the drive carries along (n,), columns (n, f) that nothing holds, and the row (n,) the section is of."""

    carried: Floats
    free: Floats
    row: Floats


def frame_of(field: Field) -> Frame:
    """Find what moves with the drive: K carried = drive_stiffness, K free = 0, and no formula sees a difference.

    Raises
    ------
    InputError
        There is no such motion with the drive, or no contact moves anything that is held.
    """
    eq = field.own.equations
    n = len(eq.names)
    carried: Floats = np.asarray(np.linalg.lstsq(eq.K, eq.drive_stiffness, rcond=1e-12)[0], dtype=np.float64)
    if np.abs(eq.K @ carried - eq.drive_stiffness).max() > 1e-9 * np.abs(eq.drive_stiffness).max():
        raise InputError("the drive pulls at what no spring holds back; no motion repeats", key="drive_speed")
    slopes = _slopes(field)
    for key, row in slopes:
        seen = row * np.append(carried, 1.0)
        if eq.driven and field.own.drive.constant is None and abs(seen.sum()) > 1e-9 * np.abs(seen).sum():
            words = "reads a coordinate that the drive carries away, and its speed is a formula; give it as a number"
            raise InputError(words, key=key)
    held = [eq.K / (np.abs(eq.K).max() or 1.0)]
    held += [row[None, :n] / np.abs(row[:n]).max() for _, row in slopes if row[:n].any()]
    free = _null_space(np.vstack(held))
    for one in eq.contacts:
        row = one.direction - free @ (free.T @ one.direction)
        if np.abs(row).max() > 1e-9 * np.abs(one.direction).max():
            return Frame(carried, free, row)
    raise InputError("no contact moves anything that a spring holds: there is no cycle to cut", key="rig")


def _slopes(field: Field) -> list[tuple[str, Floats]]:
    """How formulas change with the coordinates and the drive's way (n + 1,), at a few places drawn once."""
    own = field.own
    n, rng = len(own.equations.names), np.random.default_rng(0)
    by = [*(coordinate(i).name for i in range(n)), distance("drive_speed").name]
    out = list[tuple[str, Floats]]()
    for key, trees in field.trees().items():
        for tree, numbers in trees:
            if not names(tree) & set(by):
                continue
            each = [derivative(tree, one) for one in by]
            for _ in range(3):
                of = {name: float(rng.uniform(0.1, 1.0)) for name in sorted(names(tree))} | dict(numbers)
                out.append((key, np.array([float(value(one, of)) for one in each])))
    return out


def _null_space(rows: Floats) -> Floats:
    _, s, right = np.linalg.svd(rows)
    rank = int((s > 1e-12 * s.max(initial=0.0)).sum())
    return np.asarray(right[rank:].T)


def forcing_period(own: General, field: Field, carried: Floats) -> float | None:
    """Period common to everything in the model that depends on time; None if nothing does.

    Raises
    ------
    InputError
        Something depends on time without a period, or the periods have no common multiple.
    """
    belt, found = own.belt.constant, dict[str, float]()

    def add(key: str, periods: list[float]) -> None:
        found.update({f"{key}{' ' * k}": one for k, one in enumerate(periods)})

    for key, speed, used in (
        ("belt_speed", own.belt, own.equations.on_belt),
        ("drive_speed", own.drive, own.equations.driven),
    ):
        if not used:
            continue
        if len(speed.pieces) > 1:
            raise InputError("changes in steps; no motion repeats", key=key, value=speed.text)
        add(key, periods_of(speed.pieces[0], {}, key))
    way = distance("belt_speed").name
    drive = own.drive.constant if own.equations.driven else 0.0
    along = {way: _by_time(belt or 0.0), distance("drive_speed").name: _by_time(drive or 0.0)}
    for i, share in enumerate(carried.tolist()):  # seen from the drive
        if share and drive:
            place = coordinate(i)
            along[place.name] = Apply("add", (place, _by_time(share * drive)))
    for key, trees in field.trees().items():
        for tree, numbers in trees:
            if way in names(tree) and belt is None:
                words = "reads how far the belt has come, and its speed is a formula; no period is known"
                raise InputError(words, key=key)
            add(key, periods_of(substituted(tree, along), numbers, key))
    return common_multiple(found)


def _by_time(speed: float) -> Tree:
    return Apply("multiply", (Number(speed), Name("t"))) if speed else Number(0.0)
