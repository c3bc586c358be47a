"""Rigs of bodies for the compiled core, from formulas as text: what the tests of `_core.simulate_bodies` share."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stickslip import _core

Floats = NDArray[np.float64]
CODE = {name: i for i, name in enumerate(_core.OPERATIONS)}
BINARY: dict[type[ast.operator], str] = {
    ast.Add: "add",
    ast.Sub: "subtract",
    ast.Mult: "multiply",
    ast.Div: "divide",
    ast.Pow: "power",
}
GROUND = -1
# what a formula reads of the rig: q0, v0 a coordinate and its speed, x0 where the first belt is
RIG = {
    f"{name}{i}": (operation, i)
    for name, operation in (("q", "coordinate"), ("v", "velocity"), ("x", "distance"))
    for i in range(4)
}


class Writer:
    """Formulas as rows of a tape; numbers join the parameters."""

    def __init__(self, parameters: dict[str, float], states: Sequence[str] = ()) -> None:
        self.parameters, self.states = parameters, list(states)
        self.rows: list[tuple[int, int, int]] = []

    def put(self, name: str, a: int = 0, b: int = 0) -> int:
        row = (CODE[name], a, b)
        if row not in self.rows:
            self.rows.append(row)
        return self.rows.index(row)

    def add(self, text: str) -> int:
        return self.node(ast.parse(text, mode="eval").body)

    def node(self, one: ast.expr) -> int:
        match one:
            case ast.Constant(value=value):
                self.parameters.setdefault(repr(float(value)), float(value))
                return self.put("parameter", list(self.parameters).index(repr(float(value))))
            case ast.Name(id=name) if name in ("u", "v", "t", "dwell"):
                return self.put(name)
            case ast.Name(id=name) if name in RIG and name not in self.parameters:
                return self.put(*RIG[name])
            case ast.Name(id=name) if name in self.states:
                return self.put("state", self.states.index(name))
            case ast.Name(id=name):
                return self.put("parameter", list(self.parameters).index(name))
            case ast.BinOp(left=a, op=op, right=b):
                return self.put(BINARY[type(op)], self.node(a), self.node(b))
            case ast.UnaryOp(op=ast.USub(), operand=a):
                return self.put("negate", self.node(a))
            case ast.Call(func=ast.Name(id=name), args=args):
                return self.put(name, *map(self.node, args))
        raise ValueError(ast.dump(one))


@dataclass
class Law:
    """Formulas for v < 0 and (where they differ) v > 0: magnitude and static limit, or a force; rates by state."""

    force: str
    limit: str | None = None
    rates: Mapping[str, str] = field(default_factory=dict)
    force_plus: str | None = None
    limit_plus: str | None = None

    def lowered(self, parameters: dict[str, float]) -> tuple[_core.Formulas, _core.Formulas]:
        pair = []
        for force, limit in (
            (self.force, self.limit),
            (self.force_plus or self.force, self.limit_plus or self.limit),
        ):
            w = Writer(parameters, list(self.rates))
            out, static = w.add(force), -1 if limit is None else w.add(limit)
            rates = [w.add(one) for one in self.rates.values()]
            pair.append(_core.Formulas(nodes=w.rows, force=out, limit=static, rates=rates))
        return pair[0], pair[1]


@dataclass
class Push:
    """A force on a direction, and rates of states of its own."""

    direction: Sequence[float]
    force: str
    rates: Mapping[str, str] = field(default_factory=dict)

    def lowered(self, parameters: dict[str, float]) -> _core.Formulas:
        w = Writer(parameters, list(self.rates))
        out = w.add(self.force)
        return _core.Formulas(nodes=w.rows, force=out, rates=[w.add(one) for one in self.rates.values()])


@dataclass
class Bodies:
    """A rig: M q'' + C q' + K q = force + pulls - D' T."""

    M: Floats
    C: Floats
    K: Floats
    D: Floats
    laws: Sequence[Law]
    numbers: Mapping[str, float]
    speeds: Sequence[Sequence[tuple[float, str]]] = ()  # pieces (from, formula)
    contact_speed: Sequence[int] | None = None
    force: Floats | None = None
    pull_x: Floats | None = None
    pull_v: Floats | None = None
    pushes: Sequence[Push] = ()

    def run(self, initial: Sequence[float], t_end: float, **options: object) -> dict[str, object]:
        """Simulate; `options`: t_eval, rtol, atol, modes, dwell, seeds (names or places to weights)."""
        n, m, s = len(self.M), len(self.D), len(self.speeds)
        parameters = dict(self.numbers)
        laws = [law.lowered(parameters) for law in self.laws]
        speeds = []
        for pieces in self.speeds:
            formulas = []
            for _, text in pieces:
                w = Writer(parameters)
                out = w.add(text)
                formulas.append(_core.Formulas(nodes=w.rows, force=out))
            speeds.append(_core.PrescribedSpeed(begins=[t for t, _ in pieces], pieces=formulas))
        pushes = [one.lowered(parameters) for one in self.pushes]
        states = sum(len(one.rates) for one in (*self.laws, *self.pushes))
        self.at = _core.bodies_layout(
            n=n, contacts=m, speeds=s, pushes=len(pushes), parameters=len(parameters), states=states
        )
        start = np.zeros(2 * n + states + s)
        start[: len(initial)] = initial
        zero = np.zeros((s, n))
        parts = [
            self.M, self.C, self.K, np.zeros(n) if self.force is None else self.force, self.D,
            np.reshape([one.direction for one in self.pushes], (-1, n)),
            zero if self.pull_x is None else self.pull_x, zero if self.pull_v is None else self.pull_v,
            list(parameters.values()), start, options.get("dwell", np.zeros(m)),
        ]  # fmt: skip
        values = np.concatenate([np.ravel(one) for one in parts]).astype(float)
        rows = []
        for seed in options.get("seeds", []):  # type: ignore[attr-defined]
            row = np.zeros(self.at["size"])
            if isinstance(seed, str):
                row[self.at["parameters"] + list(parameters).index(seed)] = 1.0
            else:
                name, place = seed
                row[self.at[name] + place] = 1.0
            rows.append(row)
        shifts = options.get("shifts", {})
        for place, by in shifts.items():  # type: ignore[attr-defined]
            name, i = ("parameters", list(parameters).index(place)) if isinstance(place, str) else place
            values[self.at[name] + i] += by
        t_eval = options.get("t_eval")
        belts = [0] * m if self.contact_speed is None else self.contact_speed
        return _core.simulate_bodies(
            n=n, laws=laws, contact_speed=np.array(belts, np.int32), speeds=speeds, pushes=pushes,
            parameters=len(parameters), values=values, modes=options.get("modes", [2] * m),
            t_start=0.0, t_end=t_end, t_eval=None if t_eval is None else np.asarray(t_eval, float),
            rtol=options.get("rtol", 1e-10), atol=options.get("atol", 1e-12),
            locator=options.get("locator", _core.Locator.henon),
            seeds=np.array(rows) if rows else np.zeros((0, self.at["size"])),
            max_transitions=options.get("max_transitions", 100000),
        )  # fmt: skip
