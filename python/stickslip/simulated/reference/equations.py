"""(2.1)-(4.3) and the catalogue of effects as `reference` integrates them, in plain Python.

Between switchings every side (of a kink, of a gap, of the contact) is frozen, so the field is analytic:

    M x2' = -Q + F,   F = -T = force of the belt on the block,   v = x2 - V(t),   v' = (1/M + k/tau)(F - q)
    Rig          M = alpha1, Q = alpha1 x1 + eta1 (x2 + y2) + s y1 - B,   s = +1 reciprocal, -1 as printed
                 alpha2 y2' = -beta3 y1 - eta12 y2 - x1 - eta1 x2 + A
    BlockOnBelt  M = mass, Q = stiffness x1 + damping x2 - B

with B, A the effects' forces on block and angle body, V = v_b (1 + a sin(w t + phi)) + b the belt's speed
(ripple, droop), and q the force that would keep the block on the belt (x2 = V, x2' = V'):

    q = [Q(x2 = V) + M (r' - b/tau)] / (1 + M k/tau),   r' = v_b a w cos(w t + phi),   tau b' = -k F - b

Stick: F = q while -L_plus <= q <= L_minus. Slip: T = sgn(v) N R(u), u = |v|, or |w| with friction_memory
(tau w' = v - w, w = 0 in stick). N, the product of the "friction times" effects, multiplies the limits too.
Compliance: T = k z + c v, z' = v - k |v| z / (N R), never stick. Every function takes complex numbers (for
derivatives by a complex step) and arrays of them (for a look at many instants at once).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, cast

import numpy as np
from scipy.interpolate import CubicSpline

from stickslip.declared.catalogue import KINDS
from stickslip.declared.effect import Effect, Tabulated
from stickslip.declared.effect_terms import At, Value
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider, Rig
from stickslip.errors import InputError

Guard = Callable[[Value, Value], Value]  # a switching function S(t, z), negative while the side lasts

REST = 1e-12  # |v| below this at the start is rest on the belt


@dataclass(frozen=True)
class Side:
    """What is frozen while a switching function lands: one value per piecewise-smooth law."""

    contact: int  # -1, 1 slip with that sign of v; 0 stick
    since: float = 0.0  # time of the last arrival on the belt (static_aging)
    clamped: bool = False  # beyond the fitted range of the branch
    memory: int = 1  # sign of w (friction_memory)
    pivot: int = 0  # sign of y2, 0 stuck (pivot_dry_friction)
    cell: tuple[
        int, ...
    ] = ()  # of each tabulated term: 0 before the first knot, i after knot i, counted from 1
    cycle: tuple[int, ...] = ()  # periods behind (tabulated in t)
    of: Mapping[str, int] = field(default_factory=dict)  # of effects that are laws in pieces, by name


def _with(row: tuple[int, ...], k: int, value: int) -> tuple[int, ...]:
    """The row with another value at place k."""
    return (*row[:k], value, *row[k + 1 :])


def _cells(curve: Tabulated) -> list[tuple[float, Value]]:
    """Start and cubic of every cell: constant outside the knots, the natural (periodic) spline between."""
    x, y = np.array(curve.knots), np.array(curve.values)
    spline = CubicSpline(x, y, bc_type="periodic" if curve.period else "natural")
    inner = [(float(a), spline.c[:, i]) for i, a in enumerate(x[:-1])]
    return [(0.0, y[:1]), *inner, (0.0, y[-1:])]


class System:
    """The field, the loads and the switching functions of one model at one belt speed."""

    def __init__(self, model: Model, belt_speed: float) -> None:
        if isinstance(model.rig, DrivenSlider):
            raise InputError("a driven slider has no belt; closed_loop and forecast move it", key="rig")
        self.model, self.v_b = model, float(belt_speed)
        self.two = isinstance(model.rig, Rig)
        self.e: dict[str, Mapping[str, float]] = {x.name: x.parameters for x in model.effects}
        self.rig = cast(Any, model.rig)  # either of the two, told apart by `two`
        self.stiffer = 1.0  # of (2.1), what the block's springs are over alpha1
        ranks = {name: i for i, name in enumerate(KINDS)}
        own = sorted((x for x in model.effects if isinstance(x, Effect)), key=lambda x: ranks[x.name])
        for one in own:
            number = one.kind.corrects
            if self.two and number:  # alpha1 is the mass, too
                self.stiffer = 1 + one.parameters["e"]
            elif number and number != "reading":  # the true number is (1 + e) times the declared one
                true = getattr(self.rig, number) * (1 + one.parameters["e"])
                self.rig = replace(self.rig, **{number: true})
        self.adds = [(one.kind.adds, one.parameters) for one in own]
        self.sided = {one.name: (s, one.parameters) for one in own if (s := one.kind.adds.sides)}
        self.branches = {s: model.friction.branch(s) for s in (-1, 1)}
        names = list(self.rig.state_names)
        hidden = (("w", "friction_memory"), ("z", "contact_compliance"), ("b", "belt_load_droop"))
        self.names = names + [h for h, effect in hidden if effect in self.e]
        self.d = len(names)
        self.curves = [x for x in model.effects if isinstance(x, Tabulated) and not x.of_reading]
        self.cells = [_cells(one) for one in self.curves]
        self.compliant = "contact_compliance" in self.e
        self.mass = self.rig.alpha1 if self.two else self.rig.mass

    # -- the field, sides frozen ---------------------------------------------------------------------------

    def get(self, z: Value, name: str) -> Value:
        """Component `name` of z, zero where the system has none."""
        return z[self.names.index(name)] if name in self.names else 0.0 * z[0]

    def at(self, t: Value, z: Value, x2: Value, side: Side) -> At:
        """Where the effects' formulas are read."""
        y1, y2 = self.get(z, "y1"), self.get(z, "y2")
        return At(t, z[0], x2, y1, y2, self.v_b, self.branches[-1].static, sides=side.of)

    def belt(self, t: Value, z: Value) -> tuple[Value, Value]:
        """V and the ripple's part of V'."""
        at, share, rate = At(t=t, belt_speed=self.v_b), 0.0 * t, 0.0 * t
        for adds, p in self.adds:
            if adds.belt_share and adds.belt_rate:
                share, rate = share + adds.belt_share(p, at), rate + adds.belt_rate(p, at)
        return self.v_b * (1 + share) + self.get(z, "b"), rate

    def block_load(self, t: Value, z: Value, x2: Value, side: Side) -> Value:
        """Q: what the belt would have to balance, accelerations apart."""
        rig, x1, y1, y2 = self.rig, z[0], self.get(z, "y1"), self.get(z, "y2")
        if self.two:
            coupling = 1.0 if rig.coupling == "reciprocal" else -1.0
            load = self.stiffer * rig.alpha1 * x1 + rig.eta1 * (x2 + y2) + coupling * y1
        else:
            load = rig.stiffness * x1 + rig.damping * x2
        at = self.at(t, z, x2, side)
        for adds, p in self.adds:
            if adds.block:
                load = load - adds.block(p, at)
        return load - sum(self.tabulated("block", t, z, x2, side))

    def angle_force(self, t: Value, z: Value, side: Side) -> Value:
        """alpha2 y2' without the pivot's dry friction."""
        rig, (x1, x2, y1, y2) = self.rig, z[:4]
        force = -rig.beta3 * y1 - rig.eta12 * y2 - x1 - rig.eta1 * x2
        at = self.at(t, z, x2, side)
        for adds, p in self.adds:
            if adds.angle_body:
                force = force + adds.angle_body(p, at)
        return force + sum(self.tabulated("angle_body", t, z, x2, side))

    def table_variable(self, k: int, t: Value, z: Value, x2: Value, side: Side) -> Value:
        """Return what tabulated term k depends on, the periods behind taken off."""
        one = self.curves[k]
        name, period = one.variable, one.period
        if name == "t":
            return t + (one.phi / (2 * np.pi) - side.cycle[k]) * period if period else t
        return x2 - self.belt(t, z)[0] if name == "v_w" else x2 if name == "x2" else self.get(z, name)

    def tabulated(self, where: str, t: Value, z: Value, x2: Value, side: Side) -> Iterator[Value]:
        """G of each tabulated term there, on the cubic of its frozen cell."""
        for k, one in enumerate(self.curves):
            if one.where == where:
                start, cubic = self.cells[k][side.cell[k]]
                yield np.polyval(cubic, self.table_variable(k, t, z, x2, side) - start)

    def normal(self, t: Value, z: Value, side: Side) -> Value:
        """N: what friction is multiplied by."""
        factor, at = 1.0 + 0.0 * z[0], self.at(t, z, z[1], side)
        for g in self.tabulated("contact", t, z, z[1], side):
            factor = factor * (1.0 + g)
        for adds, p in self.adds:
            if adds.friction:
                factor = factor * (1 + adds.friction(p, at))
        return factor

    def slip_speed(self, t: Value, z: Value, side: Side) -> Value:
        """Return the u of R(u): |v|, or |w| with friction_memory."""
        if "friction_memory" in self.e:
            return side.memory * self.get(z, "w")
        return side.contact * (z[1] - self.belt(t, z)[0])

    def kinetic(self, t: Value, z: Value, side: Side) -> Value:
        """N R(u) on the frozen branch."""
        law, u = self.branches[side.contact], self.slip_speed(t, z, side)
        magnitude = law.above + 0 * u if side.clamped else law.below(u)
        for adds, p in self.adds:
            if adds.peak:
                magnitude = magnitude + adds.peak(p, u)
        return self.normal(t, z, side) * magnitude

    def limit(self, direction: int, t: Value, z: Value, side: Side) -> Value:
        """Return the static limit L against slip with the sign `direction`."""
        magnitude = self.branches[direction].static
        for adds, p in self.adds:
            if adds.peak:
                magnitude = magnitude + adds.peak(p, 0.0)
            if adds.aging:
                magnitude = magnitude + adds.aging(p, t - side.since)
        return self.normal(t, z, side) * magnitude

    def demand(self, t: Value, z: Value, side: Side) -> Value:
        """q: the force that would keep the block on the belt."""
        speed, ripple = self.belt(t, z)
        load = self.block_load(t, z, speed, side) + self.mass * ripple
        if p := self.e.get("belt_load_droop"):
            load = (load - self.mass * self.get(z, "b") / p["tau"]) / (1 + self.mass * p["k"] / p["tau"])
        return load

    def field(self, t: Value, z: Value, side: Side) -> Value:
        """dz/dt with every side frozen."""
        speed, ripple = self.belt(t, z)
        v, out = z[1] - speed, dict.fromkeys(self.names, 0.0 * z[0])
        if side.contact == 0:
            force = self.demand(t, z, side)
        elif self.compliant:
            bristle, contact = self.get(z, "z"), self.e["contact_compliance"]
            out["z"] = v - contact["k"] * side.contact * v * bristle / self.kinetic(t, z, side)
            force = -contact["k"] * bristle - contact["c"] * v
        else:
            force = -side.contact * self.kinetic(t, z, side)
        if p := self.e.get("belt_load_droop"):
            out["b"] = (-p["k"] * force - self.get(z, "b")) / p["tau"]
        if (p := self.e.get("friction_memory")) and side.contact:
            out["w"] = (v - self.get(z, "w")) / p["tau"]
        out["x1"] = z[1]
        out["x2"] = (force - self.block_load(t, z, z[1], side)) / self.mass
        if side.contact == 0:
            out["x2"] = ripple + out.get("b", 0.0)
        if self.two:
            torque = self.angle_force(t, z, side)
            if p := self.e.get("pivot_dry_friction"):
                if p["v_c"] > 0:
                    torque = torque - p["f"] * np.tanh(z[3] / p["v_c"])
                else:
                    torque = 0.0 * torque if side.pivot == 0 else torque - side.pivot * p["f"]
            out["y1"], out["y2"] = z[3], torque / self.rig.alpha2
        return np.array([out[n] for n in self.names])

    # -- the switching functions, and what follows a switching ----------------------------------------------

    def guards(self, side: Side) -> dict[str, Guard]:
        """Return what can end `side`; "rest", "slip-" and "slip+" change the contact."""
        e, s = self.e, side.contact
        out: dict[str, Guard] = {}
        if s:
            out["rest"] = lambda t, z: -s * (z[1] - self.belt(t, z)[0])
            if (kink := self.branches[s].kink) is not None:
                sign = -1.0 if side.clamped else 1.0
                out["clamp"] = lambda t, z: sign * (self.slip_speed(t, z, side) - kink)
            if "friction_memory" in e:
                out["memory"] = lambda _, z: -side.memory * self.get(z, "w")
        else:
            out["slip-"] = lambda t, z: self.demand(t, z, side) - self.limit(-1, t, z, side)
            out["slip+"] = lambda t, z: -self.limit(1, t, z, side) - self.demand(t, z, side)
        return out | self._effect_guards(side) | self._pivot_guards(side) | self._knot_guards(side)

    def _effect_guards(self, side: Side) -> dict[str, Guard]:
        """Return what ends the sides of effects, each by its formula."""

        def read(end: Callable[[At], Value]) -> Guard:
            return lambda t, z: end(self.at(t, z, z[1], side))

        sided = [(sides.ends(p, side.of[name])) for name, (sides, p) in self.sided.items()]
        return {key: read(end) for ends in sided for key, (end, _) in ends.items()}

    def _pivot_guards(self, side: Side) -> dict[str, Guard]:
        if "pivot_dry_friction" not in self.e or self.e["pivot_dry_friction"]["v_c"] > 0:
            return {}
        f = self.e["pivot_dry_friction"]["f"]
        if side.pivot:
            return {"pivot": lambda _, z: -side.pivot * z[3]}
        return {
            "pivot+": lambda t, z: self.angle_force(t, z, side) - f,
            "pivot-": lambda t, z: -self.angle_force(t, z, side) - f,
        }

    def _knot_guards(self, side: Side) -> dict[str, Guard]:
        out: dict[str, Guard] = {}
        for k, one in enumerate(self.curves):
            if (cell := side.cell[k]) < len(one.knots):
                out[f"knot{k}+"] = partial(self._past_knot, k, one.knots[cell], 1.0, side)
            if cell > 0:
                out[f"knot{k}-"] = partial(self._past_knot, k, one.knots[cell - 1], -1.0, side)
        return out

    def _past_knot(self, k: int, knot: float, sign: float, side: Side, t: Value, z: Value) -> Value:
        return sign * (self.table_variable(k, t, z, z[1], side) - knot)

    def _at_knot(self, name: str, side: Side) -> Side:
        """The side after a knot of a tabulated term: `knot0+` is the next of the first."""
        k, up = int(name[4:-1]), name[-1] == "+"
        cell, cycle = side.cell[k] + (1 if up else -1), side.cycle[k]
        if up and self.curves[k].period and side.cell[k] == len(self.curves[k].knots) - 1:
            cell, cycle = 1, cycle + 1
        return replace(side, cell=_with(side.cell, k, cell), cycle=_with(side.cycle, k, cycle))

    def switch(self, name: str, t: float, z: Value, side: Side) -> tuple[Value, Side]:
        """State and sides after the switching `name` at t, z."""
        z = z.copy()
        if name == "rest":
            z[1] = self.belt(t, z)[0]
            return self.enter(-side.contact, z, side, t) if self.compliant else self.arrive(t, z, side)
        if name in ("slip-", "slip+"):
            z[1] = self.belt(t, z)[0]
            return self.enter(-1 if name == "slip-" else 1, z, side, t)
        if name.startswith("pivot"):
            z[3] = 0.0
            return z, replace(side, pivot=self.pivot(t, z, side))
        if name.startswith("knot"):
            return z, self._at_knot(name, side)
        for owner, (sides, p) in self.sided.items():
            if name in (ends := sides.ends(p, side.of[owner])):
                return z, replace(side, of={**side.of, owner: ends[name][1]})
        changes: dict[str, dict[str, Any]] = {
            "clamp": {"clamped": not side.clamped},
            "memory": {"memory": -side.memory},
        }
        return z, replace(side, **changes[name])

    def pivot(self, t: float, z: Value, side: Side) -> int:
        """Side of the pivot's dry friction at y2 = 0."""
        f, load = self.e["pivot_dry_friction"]["f"], self.angle_force(t, z, side)
        return 1 if load >= f else -1 if load <= -f else 0

    def arrive(self, t: float, z: Value, side: Side, dwell: float = 0.0) -> tuple[Value, Side]:
        """Decide at v = 0: stick if the belt can supply q, else slip to the side it cannot hold."""
        rest = replace(side, contact=0, since=t - dwell)
        q = self.demand(t, z, rest)
        contact = -1 if q > self.limit(-1, t, z, rest) else 1 if q < -self.limit(1, t, z, rest) else 0
        if "friction_memory" in self.e and contact in (0, side.contact):
            z[self.names.index("w")] = 0.0  # it has come to rest, were it for an instant
        return self.enter(contact, z, rest, t)

    def enter(self, contact: int, z: Value, side: Side, t: float) -> tuple[Value, Side]:
        """Set the sides of the contact when it begins to be `contact`."""
        w = self.get(z, "w")
        side = replace(side, contact=contact, memory=int(np.sign(w)) or contact, clamped=False)
        kink = self.branches[contact].kink if contact else None
        if kink is not None and self.slip_speed(t, z, side) > kink:
            side = replace(side, clamped=True)
        return z, side

    def start(self, z: Value, dwell: float = 0.0) -> tuple[Value, Side]:
        """State and sides at t = 0; within `REST` of V is at rest on the belt, since `dwell` if it sticks."""
        z, t = z.copy(), 0.0
        phases = [one.phi / (2 * np.pi) if one.period else 0.0 for one in self.curves]
        side = Side(0, cell=(0,) * len(phases), cycle=tuple(int(np.floor(phase)) for phase in phases))
        cells = [self._cell(k, t, z, side) for k in range(len(phases))]
        side = replace(side, cell=tuple(cells))
        at = self.at(t, z, z[1], side)
        side = replace(side, of={name: int(sides.start(p, at)) for name, (sides, p) in self.sided.items()})
        v = z[1] - self.belt(t, z)[0]
        if abs(v) > REST:
            z, side = self.enter(int(np.sign(v)), z, side, t)
        else:
            z[1] = self.belt(t, z)[0]
            z, side = self.arrive(t, z, side, dwell)
            if self.compliant:  # it goes the way the bristle and the springs push it
                z, side = self.enter(1, z, side, t)
                rise = -self.rate(self.guards(side)["rest"], t, z, side)
                z, side = self.enter(1 if rise >= 0 else -1, z, side, t)
        if "pivot_dry_friction" in self.e:
            side = replace(side, pivot=int(np.sign(z[3])) or self.pivot(t, z, side))
        return z, side

    def _cell(self, k: int, t: Value, z: Value, side: Side) -> int:
        """Where a tabulated term stands at a start."""
        return int(
            np.searchsorted(self.curves[k].knots, self.table_variable(k, t, z, z[1], side), side="right")
        )

    def rate(self, guard: Guard, t: Value, z: Value, side: Side) -> Value:
        """f_S, the rate of a switching function along the flow, by a complex step (exact to rounding)."""
        h = 1e-30
        return guard(t + 1j * h, z + 1j * h * self.field(t, z, side)).imag / h
