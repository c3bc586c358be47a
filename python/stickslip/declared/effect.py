"""Effects beside the declared model: those of the catalogue, and a tabulated term for what has no name."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal, get_args, overload

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained, listed, must_be
from stickslip.declared.acts import Acts
from stickslip.declared.catalogue import (
    CATALOGUE,
    CONSTANTS,
    DRIVEN,
    KINDS,
    POSITION_RIPPLES,
)
from stickslip.declared.effect_kind import EffectKind, ParameterInfo
from stickslip.declared.formula_effect import FormulaEffect, formula_effect
from stickslip.declared.law_numbers import Sized, law_number
from stickslip.errors import InputError, did_you_mean, nearest, number, unknown
from stickslip.objects import Displayed, Drawn, as_call

__all__ = [
    "CATALOGUE",
    "CONSTANTS",
    "DRIVEN",
    "POSITION_RIPPLES",
    "AnyEffect",
    "Effect",
    "EffectKind",
    "FormulaEffect",
    "ParameterInfo",
    "Tabulated",
    "effect",
    "tabulated",
]

TabulatedPlace = Literal["block", "angle_body", "contact", "x1 channel", "y1 channel"]
TabulatedVariable = Literal["x1", "x2", "y1", "y2", "v_w", "t"]


def called(name: str, where: str, by: str) -> str:
    """Return what the numbers of an effect of the catalogue go by: its name, and what of its place was given."""
    place = "" if where == KINDS[name].where else f"@{where}"
    return f"{name}{place}{f'+{by}' if by else ''}"


@dataclass(frozen=True)
class Effect(Displayed):
    """One effect of the catalogue with its numbers; made by `effect`.

    Attributes
    ----------
    name
        Its name in `CATALOGUE`, as "sensor_lag".
    where
        What it acts on: a place of the catalogue, as "x1 channel", or one of a rig of bodies or matrices.
    parameters
        Its numbers by name, nondimensional for the rig of (2.1), otherwise in the rig's units; in SI those that were
        given with a unit, until it is part of a model.
    by
        Of one that couples its place to another coordinate of a rig of bodies or matrices: which; else empty.

    Examples
    --------
    >>> import stickslip as ss
    >>> lag = ss.effect("sensor_lag", tau=0.12)
    >>> lag.where, lag.parameters
    ('x1 channel', {'tau': 0.12})
    """

    __repr__ = as_call

    name: str
    where: str
    parameters: Mapping[str, float] = field(hash=False)
    by: str = ""

    @property
    def kind(self) -> EffectKind:
        """Entry of the catalogue."""
        return KINDS[self.name]

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Variables the effect adds to the model."""
        return self.kind.depends_on

    @property
    def placed(self) -> bool:
        """It acts at a place that was given, of a rig of bodies or matrices."""
        return self.where != self.kind.where

    @property
    def label(self) -> str:
        """What its numbers are called by: its name, and its place and what it couples to where these were given."""
        return called(self.name, self.where, self.by)

    @property
    def as_acts(self) -> Acts:
        """How it acts on a rig of any kind."""
        return self.kind.anywhere

    def replace(self, **parameters: float) -> Effect:
        """Return the effect with some parameters changed."""
        changed = effect(self.name, **{**self.parameters, **parameters})
        return dataclasses.replace(changed, where=self.where, by=self.by)


@overload
def effect(name: Literal["formula"], **parameters: Any) -> FormulaEffect: ...
@overload
def effect(name: str, **parameters: Any) -> Effect: ...
@explained
def effect(name: str, **parameters: Any) -> Effect | FormulaEffect:
    """Declare an effect of the catalogue, or one of your own by a formula.

    Parameters
    ----------
    name
        A name of `CATALOGUE`, `CONSTANTS` or `DRIVEN`; or "formula".
    **parameters
        Every parameter of the effect, nondimensional on the rig of (2.1), else in SI; or with a unit (`f="2 N"`), which
        a model turns into its own numbers. A phase `phi` and a creep speed `v_c` are 0 when left out.
        `where` puts it to a place of a rig of bodies or matrices: a body, a link, a contact, a channel. `by` names the
        coordinate that it couples this place to: what presses the contact, what the sensor reads beside its own.
        Of "formula": `where`; one of `force`, `factor`, `reading`; its numbers, bare in SI or with a unit ("0.1 N");
        `states` and `ranges` by name; `called`, its name in the model where there are several.

    Returns
    -------
    Effect or FormulaEffect

    Raises
    ------
    InputError
        Unknown effect or parameter (with the nearest known one), a missing parameter, or one out of bounds.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> aged = model.with_effects([ss.effect("static_aging", dT=1.0, tau=2.0)])
    >>> for one in (model, aged):
    ...     print(f"period {ss.limit_cycle(one, belt_speed=0.1).period:.3f}")
    period 10.475
    period 11.145
    """
    if name == "formula":
        return formula_effect(**parameters)
    if name not in KINDS:
        raise unknown("effect", str(name), [*KINDS, "formula"])
    kind = KINDS[name]
    where = must_be("where", parameters.pop("where", kind.where), str)
    by = must_be("by", parameters.pop("by", ""), str)
    if by and not kind.anywhere.couples:
        raise InputError(f"effect '{name}' acts at its own place alone; leave 'by' out")
    for given in parameters:
        kind.parameter(given)
    values: dict[str, float] = {}
    for info in kind.parameters:
        if info.name not in parameters:
            if not (info.per_run or info.optional):
                words = f"lacks its parameter '{info.name}' ({info.meaning}); give {info.name}="
                raise InputError(f"effect '{name}' {words}")
            values[info.name] = 0.0
            continue
        low, high = info.bounds
        bound = {"above": low} if info.open_below else {"least": low}
        key, given = f"{name}.{info.name}", parameters[info.name]
        size, unit = law_number(key, given, info.given_in)
        # what is out of bounds is said as it was given
        size = number(key, size if isinstance(given, str) else given, most=high, why=info.meaning, **bound)
        values[info.name] = size if unit is None else Sized(size, unit)
    return Effect(name, where, values, by)


@dataclass(frozen=True)
class Tabulated(Drawn):
    """A smooth curve g of one variable, for what has no name; made by `tabulated`.

    On `block` and `angle_body` it adds the force +g in the bracket's units; at the `contact` friction, static
    limits included, is multiplied by 1 + g; on `x1 channel` and `y1 channel` g is added to the reading, and the
    motion does not feel it. Between knots g is the natural cubic spline; beyond the outer knots it keeps their values.
    With a `period` it is the periodic spline, read at t + phi period/(2 pi).

    Attributes
    ----------
    where, variable
        Where it acts, and what it is a curve of.
    knots, values : (n,)
        The curve, in the model's own units.
    period, phi
        Of a curve of t that repeats: its period, in the model's unit of time, and its phase [rad].

    Examples
    --------
    >>> import stickslip as ss
    >>> curve = ss.tabulated("block", "x1", knots=[-1, 0, 1], values=[0.0, 0.1, 0.0])
    >>> print(f"{curve.curve(0.5):.4f}")
    0.0688
    """

    __repr__ = as_call

    where: str
    variable: str
    knots: tuple[float, ...]
    values: tuple[float, ...]
    period: float | None = None
    phi: float = 0.0

    @property
    def name(self) -> str:
        """`tabulated_<where>_<variable>`; of a channel `learned_<channel>_<variable>`."""
        if self.of_reading:
            return f"learned_{self.where[:2]}_{self.variable}"
        return f"tabulated_{self.where}_{self.variable}"

    @property
    def of_reading(self) -> bool:
        """Is the curve one of a sensor, added to its readings?"""
        return self.where.endswith(" channel")

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The one variable the curve depends on."""
        return (self.variable,)

    @property
    def parameters(self) -> Mapping[str, float]:
        """The values at the knots, value_0, value_1, ...; with a period, whose last value is the first, the angular
        frequency w and the phase phi.
        """
        out = {f"value_{i}": value for i, value in enumerate(self.values)}
        if self.period is None:
            return out
        out.popitem()
        return out | {"w": 2 * np.pi / self.period, "phi": self.phi}

    def replace(self, **parameters: float) -> Tabulated:
        """Return the term with some of its parameters changed; another w stretches the knots."""
        known = dict(self.parameters)
        for name in parameters:
            if name not in known:
                raise InputError(f"'{self.name}' has no parameter '{name}'; {did_you_mean(name, known)}")
        known.update(parameters)
        if self.period is None:
            return tabulated(self.where, self.variable, self.knots, tuple(known.values()))
        phi, w, knots, period = known.pop("phi"), known.pop("w"), self.knots, self.period
        if "w" in parameters:
            period = 2 * np.pi / number("w", w, above=1e-300)
            knots = (*(period * (one / self.knots[-1]) for one in self.knots[:-1]), period)
        values = (*known.values(), known["value_0"])
        return tabulated(self.where, self.variable, knots, values, period=period, phi=phi)

    def curve(self, variable: ArrayLike, derivative: int = 0) -> NDArray[np.float64]:
        """Return g, or a derivative of it, at `variable`, any shape."""
        given = np.asarray(variable, dtype=np.float64)
        knots = np.array(self.knots)
        if self.period is None:
            at = np.clip(given, knots[0], knots[-1])
        else:
            at = np.mod(given + self.phi * self.period / (2 * np.pi), self.period)
        ends: Literal["natural", "periodic"] = "natural" if self.period is None else "periodic"
        spline = scipy.interpolate.CubicSpline(knots, np.array(self.values), bc_type=ends)
        out = np.asarray(spline(at, derivative), dtype=np.float64)
        return out if derivative == 0 or self.period is not None else np.where(at == given, out, 0.0)


@explained
def tabulated(
    where: str,
    depends_on: str,
    knots: Iterable[float],
    values: Iterable[float],
    *,
    period: float | None = None,
    phi: float = 0.0,
) -> Tabulated:
    """Declare a tabulated term: a smooth curve in one variable, where no name of the catalogue fits.

    Parameters
    ----------
    where
        "block", "angle_body" (adds a force), "contact" (friction times 1 + g), "x1 channel" or "y1 channel" (adds
        to the reading).
    depends_on
        "x1", "x2", "y1", "y2", "v_w" or "t".
    knots
        Increasing, 2 to 24 of them (n,).
    values
        The curve at the knots (n,).
    period
        For `depends_on="t"`: the curve repeats with this period. Knots then run from 0 to `period`
        and the last value equals the first.
    phi
        Of a curve that repeats: its phase at the start of the run, in radians; the curve is read at
        t + phi period/(2 pi).

    Returns
    -------
    Tabulated
        For the `effects` of a `Model`.

    Raises
    ------
    InputError
        Unknown place or variable, knots that do not increase, lengths that differ, a number not finite.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> bump = ss.tabulated("contact", "x1", knots=[-1, 0, 1], values=[0.0, 0.1, 0.0])  # 10 % at x1 = 0
    >>> run = ss.simulate(model.with_effects([bump]), belt_speed=0.1, t_end=40)
    >>> len(run.transitions)
    8
    """
    place = _member("where", where, get_args(TabulatedPlace))
    variable = _member("depends_on", depends_on, get_args(TabulatedVariable))
    if place.endswith("channel") and variable == "v_w":
        words = "a curve of a reading depends on x1, x2, y1, y2 or t"
        raise InputError(words, key="where", value=where)
    at = tuple(number(f"knots[{i}]", x) for i, x in enumerate(listed("knots", knots, "numbers")))
    curve = tuple(number(f"values[{i}]", x) for i, x in enumerate(listed("values", values, "numbers")))
    if len(at) != len(curve):
        raise InputError(f"{len(at)} knots but {len(curve)} values; give one value a knot", key="values")
    if not 2 <= len(at) <= 24:
        raise InputError(f"{len(at)} given; a tabulated term has 2 to 24", key="knots")
    if any(b <= a for a, b in pairwise(at)):
        raise InputError("must increase from knot to knot", key="knots")
    phi = number("phi", phi)
    if period is None and phi != 0:
        raise InputError("only a curve that repeats has a phase; give its period", key="phi", value=phi)
    if period is not None:
        period = number("period", period, above=0)
        if variable != "t":
            raise InputError(f"only a curve in t repeats, this one depends on {variable}", key="period")
        if at[0] != 0 or at[-1] != period or curve[0] != curve[-1] or len(at) < 3:
            words = "needs knots from 0 to the period (at least 3) and equal first and last values"
            raise InputError(words, key="period")
    return Tabulated(place, variable, at, curve, period, phi)


def _member(key: str, value: str, known: tuple[str, ...]) -> str:
    for name in known:
        if value == name:
            return name
    guess = nearest(str(value), known)
    tail = f"; did you mean '{guess}'?" if guess else ""
    raise InputError(f"must be one of {', '.join(known)}{tail}", key=key, value=value)


AnyEffect = Effect | Tabulated | FormulaEffect


def with_numbers(one: AnyEffect, numbers: Mapping[str, float]) -> AnyEffect:
    """Return an effect with those of some numbers that are its own, by full name."""
    if isinstance(one, Tabulated):
        return one
    own = {name: f"{one.label}.{name}" for name in one.parameters}
    return one.replace(**{name: numbers[full] for name, full in own.items() if full in numbers})
