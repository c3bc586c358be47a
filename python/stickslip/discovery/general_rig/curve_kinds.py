"""Curves that no name explains, at every place of a rig of bodies or matrices.

Each is an effect by a formula whose sizes are sought together, as a user's own rival is. It stands against the names in
one search: a name that says the same with fewer numbers is cheaper. Its shapes are powers of z/sqrt(1 + z^2), z the
variable over what is as good as its largest value: beyond what the runs reach they grow no more, so that a motion that
goes there is not driven off.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import FormulaEffect
from stickslip.declared.formula_effect import formula_effect
from stickslip.declared.model import Model
from stickslip.declared.places import CHANNEL
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.discovery.general_rig.kinds import Sizes, along, largest, rival_at, slip
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.fitted.bodies_data import BodiesData

Floats = NDArray[np.float64]
DRAWN = 61  # places that a curve is told at
HALF = 0.5  # of a contact's friction
LARGE = 10.0  # times what there is: a size that no curve has
TERMS = {
    "force": "force on {}",
    "factor": "friction factor minus 1 of {}",
    "reading": "added to the {} reading",
}


@dataclass(frozen=True)
class CurveKind(RivalKind):
    """
    Facts of a curve.

    Parameters
    ----------
    variable : what it is a curve of, as formulas call it
    reach : (2,) least and largest value of it in the runs
    unit : what the variable is divided by
    powers : of its shapes, one for each size
    """

    variable: str = field(kw_only=True)
    reach: tuple[float, float] = field(kw_only=True)
    unit: float = field(kw_only=True)
    powers: tuple[int, ...] = field(kw_only=True)

    @property
    def nameless(self) -> bool:
        """No one declared it."""
        return True

    @property
    def term(self) -> str:
        """What the curve is, in words."""
        return TERMS[self.declared.acts].format(self.where.removesuffix(CHANNEL))

    def shapes(self) -> tuple[Floats, Floats]:
        """Return places over its reach, (n,), and its shapes there, (n, k)."""
        x = np.linspace(*self.reach, DRAWN)
        sign, z = -1.0 if self.declared.acts == "force" else 1.0, x / self.unit
        return x, sign * (z / np.sqrt(1 + z**2))[:, None] ** np.array(self.powers)


def curve_kinds(model: Model, data: Sequence[BodiesData]) -> list[CurveKind]:
    """
    Return curves at every place that has what they are of.

    A straight line of a spring or of a gain is a constant of the rig, and friction as a whole is the law's: they are
    no shapes of these.

    Parameters
    ----------
    model, data : the declared model, and its runs
    """
    sizes = Sizes(model, data)
    return [*_forces(sizes), *_contacts(sizes), *_readings(sizes)]


def _forces(sizes: Sizes) -> Iterator[CurveKind]:
    """
    Of links by their deflection and its rate, of coordinates by theirs where no link has them alone.

    Where a contact alone rubs on one a force by its rate is friction.
    """
    rig, own = sizes.rig, sizes.own
    rows: list[Floats] = []
    if isinstance(rig, BodiesRig):
        for i in range(len(rig.link)):
            row, of_drive = rig.deflection(i)
            rows.append(row)
            every = [
                run.q @ row + of_drive * sizes.driven(run) - float(rig.link[i].rest) for run in sizes.data
            ]
            force = sizes.link(i).k2 * sizes.link(i).length
            yield _kind(sizes, f"link_{i + 1}", "force", "deflection", every, (2, 3, 4, 5), force)
            if not of_drive:
                rates = [run.v @ row for run in sizes.data]
                yield _kind(sizes, f"link_{i + 1}", "force", "deflection_rate", rates, (1, 2, 3, 4), force)
    for i, name in enumerate(own.names):
        unit = sizes.coordinate(i)
        force = unit.k2 * unit.length
        if not any(along(row, i) for row in rows):
            places = [run.q[:, i] for run in sizes.data]
            if not isinstance(rig, BodiesRig):
                yield _kind(sizes, name, "force", "deflection", places, (2, 3, 4, 5), force)
            if not any(along(one.direction, i) for one in own.contacts):
                rates = [run.v[:, i] for run in sizes.data]
                yield _kind(sizes, name, "force", "deflection_rate", rates, (1, 2, 3, 4), force)


def _contacts(sizes: Sizes) -> Iterator[CurveKind]:
    for one in sizes.own.contacts:
        speeds = [np.abs(slip(run, one)) for run in sizes.data]
        yield _kind(sizes, one.name, "factor", "u", speeds, (1, 2, 3, 4), HALF)


def _readings(sizes: Sizes) -> Iterator[CurveKind]:
    for c, name in enumerate(sizes.data[0].channels):
        if name in sizes.rig.state_names:
            read = [run.readings[:, c] for run in sizes.data]
            yield _kind(sizes, name, "reading", "reading", read, (2, 3, 4), largest(np.concatenate(read)))


def _kind(
    sizes: Sizes,
    where: str,
    acts: str,
    variable: str,
    every: Sequence[Floats],
    powers: tuple[int, ...],
    size: float,
) -> CurveKind:
    """
    A curve of a variable that is `every` in the runs.

    Its sizes have a prior as wide as all that is there, so that a fit does not run off where the law or a spring does
    the same.
    """
    x = np.concatenate(every)
    unit = largest(x)
    low, high = (float(one) for one in np.quantile(x, [0.002, 0.998]))
    names = [f"b{p}" for p in powers]
    z = f"{variable}/{unit!r}"
    shapes = " + ".join(
        f"{name}*({z}/sqrt(1 + ({z})**2))**{p}" for name, p in zip(names, powers, strict=True)
    )
    text = {"force": f"-({shapes})", "factor": f"1 + {shapes}", "reading": f"reading + {shapes}"}[acts]
    bounds = dict.fromkeys(names, (-LARGE * size, LARGE * size))
    called = f"curve_of_{variable}_at_{where}".replace(".", "_")
    given: dict[str, Any] = {acts: text, **dict.fromkeys(names, 0.0)}
    made: FormulaEffect = formula_effect(called=called, where=where, ranges=bounds, **given)
    plain = rival_at(made, sizes.rig)
    facts = {one.name: getattr(plain, one.name) for one in fields(plain)}
    facts["parameters"] = tuple(replace(one, spread=size) for one in plain.parameters)
    return CurveKind(**facts, variable=variable, reach=(low, high), unit=unit, powers=powers)
