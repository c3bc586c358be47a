"""A rig by its matrices, as a model reduction gives them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, get_args

import numpy as np

from stickslip.arguments import explained, one_of
from stickslip.declared.rigs.general import (
    Against,
    ContactRow,
    Equations,
    GeneralRig,
    RigError,
    Trait,
    Unit,
    check_equations,
    check_names,
)
from stickslip.errors import InputError, number

Rows = Sequence[Sequence[float]]


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class MatricesRig(GeneralRig):
    """M q'' + C q' + K (q - rest) = -sum of d_j T_j(v_j) + drive_stiffness x_drive + drive_damping x_drive'.

    Parameters
    ----------
    M, C, K
        (n, n), in SI; M symmetric and positive definite; C absent: no damping.
    contact
        A direction (n,), or a list of them (m, n).
    names
        Of the coordinates; q1, q2, ... if absent.
    unit
        "m", "rad" or "1" of all coordinates, or a list of them.
    rest
        Coordinates at which the springs are slack (n,); 0 if absent.
    against
        What every contact rubs on, "belt" or "ground", or a list of them.
    law
        Names of the contacts' laws; one for all, or a list; "" for the only one.
    drive_stiffness, drive_damping
        Force on the coordinates by displacement and speed of a drive (n,); K and C hold their share already.

    Raises
    ------
    InputError
        A size is wrong, a number not finite, M not positive definite, or two contacts act on one direction.

    Warns
    -----
    ModelWarning
        Without friction the motion would grow without bound.

    Examples
    --------
    >>> import stickslip as ss
    >>> pin = ss.MatricesRig(M=[[0.5]], C=[[0.4]], K=[[800]], contact=[1], names=["x"])  # kg, N s/m, N/m
    >>> model = ss.Model(pin, friction=ss.CoulombFriction(static=4.0, kinetic=2.0))  # N
    >>> run = ss.simulate(model, belt_speed=0.05, t_end=1)
    >>> print(f"{1e3 * run.x.max():.3f} mm")
    4.975 mm
    """

    kind: ClassVar[str] = "matrices"

    M: Rows
    K: Rows
    C: Rows | None = None
    contact: Rows | Sequence[float] = ()
    names: Sequence[str] | None = None
    unit: str | Sequence[str] = "m"
    rest: Sequence[float] | None = None
    against: str | Sequence[str] = "belt"
    law: str | Sequence[str] = ""
    drive_stiffness: Sequence[float] | None = None
    drive_damping: Sequence[float] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "M", _rows("M", self.M))
        n = len(self.M)
        for name in ("M", "K", "C"):
            given = getattr(self, name)
            if given is None:
                continue
            rows = _rows(name, given)
            if len(rows) != n or any(len(row) != n for row in rows):
                raise RigError(f"is {_shape(rows)}; it must be {n} x {n}, as M has rows", name)
            object.__setattr__(self, name, rows)
        for name in ("rest", "drive_stiffness", "drive_damping"):
            if (given := getattr(self, name)) is not None:
                object.__setattr__(self, name, _row(name, given, n))
        alone = len(self.contact) > 0 and np.isscalar(self.contact[0])
        directions: Sequence[object] = (self.contact,) if alone else self.contact
        object.__setattr__(self, "contact", tuple(_row("contact", one, n) for one in directions))
        names = tuple(f"q{i + 1}" for i in range(n)) if self.names is None else tuple(self.names)
        if len(names) != n:
            raise RigError(f"has {len(names)} names for {n} coordinates", "names")
        check_names(names, "names")
        object.__setattr__(self, "names", names)
        for name, count in (("unit", n), ("against", len(self.contact)), ("law", len(self.contact))):
            given = getattr(self, name)
            if not isinstance(given, str):
                if len(given) != count:
                    raise RigError(f"has {len(given)} entries; {count} are needed", name)
                object.__setattr__(self, name, tuple(given))
        check_equations(self.equations)

    @cached_property
    def equations(self) -> Equations:
        """The equations of motion."""
        M, K = np.array(self.M), np.array(self.K)
        n = len(M)
        units: list[Unit] = [one_of("unit", one, get_args(Unit)) for one in _each(self.unit, n)]  # type: ignore[misc]
        rows = []
        count = len(self.contact)
        for i, (row, against, law) in enumerate(
            zip(self.contact, _each(self.against, count), _each(self.law, count), strict=True)
        ):
            kept: Against = one_of("against", against, get_args(Against))  # type: ignore[assignment]
            direction = np.array(row)
            touched = {units[k] for k in np.flatnonzero(direction)}
            rows.append(ContactRow(f"contact_{i + 1}", direction, kept, law, touched == {"rad"}))
        zero = np.zeros(n)
        return Equations(
            tuple(self.names or ()),
            tuple(units),
            M,
            np.zeros((n, n)) if self.C is None else np.array(self.C),
            K,
            zero if self.rest is None else K @ np.array(self.rest),
            zero if self.drive_stiffness is None else np.array(self.drive_stiffness),
            zero if self.drive_damping is None else np.array(self.drive_damping),
            tuple(rows),
        )

    @property
    def numbers(self) -> dict[str, float]:
        """Every number by name: "M_11", "K_12", "contact_11", "rest_1"."""
        out: dict[str, float] = {}
        for name in ("M", "C", "K", "contact"):
            for i, row in enumerate(getattr(self, name) or ()):
                out |= {f"{name}_{i + 1}{_gap(len(row))}{k + 1}": one for k, one in enumerate(row)}
        for name in ("rest", "drive_stiffness", "drive_damping"):
            out |= {f"{name}_{i + 1}": one for i, one in enumerate(getattr(self, name) or ())}
        return out

    @property
    def uncertain(self) -> Mapping[str, Trait]:
        """Entries of M, K and C that are not 0; of two that mirror each other the upper one."""
        groups: tuple[tuple[str, Trait], ...] = (("M", "inertia"), ("K", "stiffness"), ("C", "damping"))
        out: dict[str, Trait] = {}
        for name, trait in groups:
            rows = getattr(self, name) or ()
            for i, row in enumerate(rows):
                for k, size in enumerate(row):
                    if size != 0 and (k >= i or rows[k][i] != size):
                        out[f"{name}_{i + 1}{_gap(len(row))}{k + 1}"] = trait
        return out

    def tied(self, name: str) -> tuple[str, ...]:
        """Return an entry and its mirror, where the two are equal."""
        group, _, place = name.partition("_")
        rows, gap = getattr(self, group), _gap(len(self.M))
        i, k = (int(one) - 1 for one in (place.split(gap) if gap else place))
        return (name,) if i == k or rows[i][k] != rows[k][i] else (name, f"{group}_{k + 1}{gap}{i + 1}")

    def _changed(self, values: Mapping[str, float]) -> dict[str, Any]:
        changed: dict[str, Any] = {}
        all_ = {**self.numbers, **values}
        for name in ("M", "C", "K", "contact"):
            rows = getattr(self, name) or ()
            kept = [
                [all_[f"{name}_{i + 1}{_gap(len(row))}{k + 1}"] for k in range(len(row))]
                for i, row in enumerate(rows)
            ]
            changed[name] = kept if rows else getattr(self, name)
        for name in ("rest", "drive_stiffness", "drive_damping"):
            if (given := getattr(self, name)) is not None:
                changed[name] = [all_[f"{name}_{i + 1}"] for i in range(len(given))]
        return changed

    def table(self) -> dict[str, object]:
        """Return a file's table [rig]."""
        out: dict[str, object] = {"kind": self.kind}
        for name in ("M", "C", "K", "contact"):
            if rows := getattr(self, name):
                out[name] = [list(row) for row in rows]
        for name in ("names", "unit", "rest", "against", "law", "drive_stiffness", "drive_damping"):
            given = getattr(self, name)
            if given is not None and given != "":
                out[name] = given if isinstance(given, str) else list(given)
        return out


def _gap(count: int) -> str:
    return "" if count < 10 else "_"


def _each(given: str | Sequence[str], count: int) -> Sequence[str]:
    return [given] * count if isinstance(given, str) else given


def _rows(name: str, given: object) -> tuple[tuple[float, ...], ...]:
    if isinstance(given, (str, bytes)) or not isinstance(given, (Sequence, np.ndarray)) or len(given) == 0:
        raise RigError("must be a matrix, a list of rows", name)
    if any(isinstance(one, str) or not isinstance(one, (Sequence, np.ndarray)) for one in given):
        raise RigError("must be a matrix, a list of rows like [[1, 0], [0, 1]]", name)
    return tuple(_row(name, one, None) for one in given)


def _row(name: str, given: object, count: int | None) -> tuple[float, ...]:
    if isinstance(given, (str, bytes)) or not isinstance(given, (Sequence, np.ndarray)):
        raise RigError("must be a list of numbers", name)
    if count is not None and len(given) != count:
        raise RigError(f"has {len(given)} numbers for {count} coordinates", name)
    try:
        return tuple(number(name, one) for one in given)
    except InputError as error:
        raise RigError(error.what, name, value=error.value) from None


def _shape(rows: Rows) -> str:
    widths = {len(row) for row in rows}
    return f"{len(rows)} x {widths.pop()}" if len(widths) == 1 else "of rows of different length"
