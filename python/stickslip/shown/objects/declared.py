"""Rigs, laws, effects, models and their parts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields

import numpy as np
from matplotlib.axes import Axes

from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.dimensions import LENGTH, RATE, STIFFNESS
from stickslip.declared.effect import Effect, Tabulated
from stickslip.declared.formula_laws.tabulated import TabulatedFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, DrivenSlider, Rig, Scales
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.rigs.number_unit import PER, number_unit
from stickslip.declared.rigs.parts import RigPart
from stickslip.declared.scatter import EventScatter
from stickslip.declared.si import dimension_in, si_of
from stickslip.declared.speeds import Speed
from stickslip.shown.objects.description import Cell, Description, describe
from stickslip.shown.plot.curves import GREY, LIMIT, SIMULATED

Row = tuple[Cell, ...]
SI_HEADS = ("quantity", "value", "in SI", "unit")
POINTS = 200  # of a curve
OF_RIG = {"length": LENGTH.unit, "omega": RATE.unit, "k2": STIFFNESS.unit, "r": LENGTH.unit}


@describe.register
def _rig(one: Rig) -> Description:
    si = {} if one.scales is None else one.to_si()
    units = {name: Rig.dimensions[name].unit for name in si}
    rows: list[Row] = [
        (name, getattr(one, name), None, "") for name in ("alpha1", "alpha2", "beta3", "eta1", "eta12")
    ]
    rows += [(name, None, value, units[name]) for name, value in si.items()]
    notes = [] if one.coupling == "reciprocal" else [f"coupling: {one.coupling}"]
    title = f"Rig of (2.1){'' if si else ', nondimensional'}"
    return Description(title=title, heads=SI_HEADS, rows=rows, notes=notes)


@describe.register(BlockOnBelt)
@describe.register(DrivenSlider)
def _one_body(one: BlockOnBelt | DrivenSlider) -> Description:
    rows: list[Row] = [
        (field.name, getattr(one, field.name), type(one).dimensions[field.name].unit) for field in fields(one)
    ]
    what = "Block on a belt" if isinstance(one, BlockOnBelt) else "Driven slider"
    return Description(title=what, heads=("quantity", "value", "unit, if in SI"), rows=rows)


@describe.register
def _general(one: GeneralRig) -> Description:
    own = one.equations
    rubs = ", ".join(f"{contact.name} on {contact.against}" for contact in own.contacts) or "nothing rubs"
    coordinates = ", ".join(
        name if unit == "1" else f"{name} [{unit}]" for name, unit in zip(own.names, own.units, strict=True)
    )
    rows: list[Row] = [(name, size, number_unit(one, name)) for name, size in one.numbers.items()]
    what = "bodies" if isinstance(one, BodiesRig) else "matrices"
    return Description(title=f"Rig by its {what}: {coordinates}; {rubs}", rows=rows)


@describe.register
def _part(one: RigPart) -> Description:
    rows: list[Row] = []
    for field in fields(one):
        value = getattr(one, field.name)
        if value not in (None, "", 0.0):
            text = " – ".join(value) if isinstance(value, tuple) else value
            rows.append((field.name, text, PER.get(field.name, "") if isinstance(value, float) else ""))
    return Description(title=f"{type(one).__name__} of a rig", rows=rows)


@describe.register
def _scales(one: Scales) -> Description:
    rows: list[Row] = [(field.name, getattr(one, field.name), OF_RIG[field.name]) for field in fields(one)]
    rows += [("time", one.time, "s"), ("velocity", one.velocity, "m/s"), ("force", one.force, "N")]
    return Description(title="What is 1 in (2.1)", rows=rows)


@describe.register
def _scatter(one: EventScatter) -> Description:
    rows: list[Row] = [(field.name, getattr(one, field.name)) for field in fields(one)]
    return Description(
        title="What differs from event to event", heads=("share of itself", "value"), rows=rows
    )


@describe.register
def _law(one: FrictionLaw) -> Description:
    units = one.declared_units
    rows: list[Row] = [(name, value, units.get(name, "")) for name, value in one.numbers.items()]
    draw = None if isinstance(one, ContactLaws) else characteristic(one)
    texts = {name: getattr(one, f"{name}_text", None) for name in ("kinetic", "static", "force")}
    notes = [f"{name} = {text}" for name, text in texts.items() if text]
    return Description(title=f"{one.kind} friction", rows=rows, notes=notes, draw=draw)


@describe.register
def _by_points(one: TabulatedFriction) -> Description:
    points = list(zip(one.speeds, one.forces, strict=True))
    rows: list[Row] = [*points]
    heads = ("speed", "force")
    if one.forces_plus is not None:
        speeds = one.speeds_plus or one.speeds
        heads, rows = (
            ("v_w", "magnitude"),
            [
                *((-u, R) for u, R in reversed(points)),
                *zip(speeds, one.forces_plus, strict=True),
            ],
        )
    return Description(title="friction by points", heads=heads, rows=rows, draw=characteristic(one))


def _speeds(law: FrictionLaw, most: float | None = None) -> np.ndarray:
    """Speeds (n,) over which a law is drawn: up to twice its own, of either sign."""
    own = [abs(value) for name, value in law.numbers.items() if name.startswith(("v_", "speed"))]
    own += [kink for kink in law.kinks if kink]
    reach = most or 2 * max(own, default=0.5)
    u = reach * np.linspace(1e-4, 1, POINTS) ** 2
    return np.concatenate([-u[::-1], u])


def characteristic(
    law: FrictionLaw, unit: Mapping[str, tuple[float, str]] | None = None, most: float | None = None
) -> Callable[[Axes], None]:
    """What draws T over v_w up to a speed, with the static limits at 0."""
    speed, force = (unit or {}).get("v_w", (1.0, "")), (unit or {}).get("T", (1.0, ""))

    def draw(ax: Axes) -> None:
        v = _speeds(law, most)
        T = np.asarray(law.force(v))
        for side in (v < 0, v > 0):
            ax.plot(speed[0] * v[side], force[0] * T[side], color=SIMULATED, lw=1.4)
        minus, plus = law.static_limits
        ax.plot(
            [0, 0], [-force[0] * minus, force[0] * plus], color=LIMIT, lw=1.4, marker="_", label="at rest"
        )
        ax.axhline(0, color=GREY, lw=0.4, zorder=0)
        ax.set_xlabel("$v_w$" + (f" [{speed[1]}]" if speed[1] else ""))
        ax.set_ylabel("friction $T$" + (f" [{force[1]}]" if force[1] else ""))

    return draw


@describe.register
def _effect(one: Effect) -> Description:
    infos = {info.name: info for info in one.kind.parameters}
    rows: list[Row] = [
        (name, value, infos[name].dimension.unit, infos[name].meaning)
        for name, value in one.parameters.items()
    ]
    on = f"; depends on {', '.join(one.depends_on)}" if one.depends_on else ""
    return Description(
        title=f"Effect {one.name}, {one.where}{on}",
        heads=("parameter", "value", "unit, if in SI", "meaning"),
        rows=rows,
    )


@describe.register
def _tabulated(one: Tabulated) -> Description:
    rows: list[Row] = list(zip(one.knots, one.values, strict=True))

    def draw(ax: Axes) -> None:
        x = np.linspace(one.knots[0], one.knots[-1], POINTS)
        ax.plot(x, one.curve(x), color=SIMULATED, lw=1.4)
        ax.plot(one.knots, one.values, "o", color=LIMIT, ms=3)
        ax.set_xlabel(one.variable)
        ax.set_ylabel("g")

    title = f"Curve at {one.where} over {one.variable}"
    return Description(title=title, heads=(one.variable, "g"), rows=rows, draw=draw)


@describe.register
def _model(one: Model) -> Description:
    rig = one.rig
    rows: list[Row] = []
    for name, value in one.parameters.items():
        if isinstance(rig, GeneralRig):
            rows.append((name, value, None, number_unit(rig, name)))
            continue
        measured = dimension_in(one.friction, name)
        known = None if measured is None else si_of(measured, rig, one.channels)
        if known is None:
            rows.append((name, value, None, ""))
        else:
            rows.append((name, value, known.of(value), known.unit))
    effects = f", {', '.join(effect.name for effect in one.effects)}" if one.effects else ""
    notes = [f"noise of {name}: {size:g} {_unit_of(one, name)}" for name, size in (one.noise or {}).items()]
    return Description(
        title=f"{type(rig).__name__}, {one.friction.kind} friction{effects}",
        heads=SI_HEADS,
        rows=rows,
        notes=notes,
        draw=None if isinstance(one.friction, ContactLaws) else characteristic(one.friction),
    )


def _unit_of(model: Model, channel: str) -> str:
    unit = (model.channels or {})[channel].unit if channel in (model.channels or {}) else ""
    return "" if unit == "1" else unit


@describe.register
def _speed(one: Speed) -> Description:
    rows: list[Row] = [("speed", one.text)]
    begins = one.begins
    span = (begins[0], begins[-1] + max(begins[-1] - begins[0], 10.0) * 0.1 + 10.0 * (len(begins) == 1))

    def draw(ax: Axes) -> None:
        t = np.linspace(*span, 2 * POINTS)
        ax.plot(t, one(t), color=SIMULATED, lw=1.2)
        ax.set_xlabel("t")
        ax.set_ylabel("speed")

    return Description(
        title=one.text or f"{len(one.pieces)} pieces", heads=("what", "as written"), rows=rows, draw=draw
    )
