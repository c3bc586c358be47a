"""What effects bring into a window of a rig of bodies: where their states begin, and what sensors read through them.

No reading shows an effect's state at the start of a window. It begins there as if the motion had gone on as it goes
there: what follows the motion is as far behind as its rate of change leaves it. That of a lagged reading is read: where
the body slips at the start, what lags still goes as the body went before. How far a belt or a drive has come follows
from its speed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, names
from stickslip.declared.formula.value import Value, value
from stickslip.declared.placed import PlacedState
from stickslip.declared.places import coordinate, distance, velocity
from stickslip.declared.speeds import Speed
from stickslip.fitted.bodies_data import SHARE, BodiesData, smoothed
from stickslip.likelihoods.bodies_own_friction import OFF
from stickslip.simulated.bodies_lowering import LoweredBodies

Floats = NDArray[np.float64]
NOTHING = Number(0.0)
DRIVE = "drive_speed"
_Come = tuple[Floats, Floats, dict[str, Floats]]  # times, way, and its slopes by number


def steady(state: PlacedState, n: int, goes: Tree | None = None) -> Tree:
    """
    Return what a state is where its rate is known: (z - s) slope = rate - rate(s), s its start.

    Parameters
    ----------
    state : of an effect
    n : coordinates of the rig
    goes : its rate, as it is read; None: that of what it follows, s'
    """
    start = state.start
    slope = derivative(state.rate, state.name)
    if state.name not in names(state.rate) or slope == NOTHING:
        return start
    if goes is None:
        moves = [(derivative(start, coordinate(i).name), velocity(i)) for i in range(n)]
        parts: list[Tree] = [derivative(start, "t")]
        parts += [Apply("multiply", one) for one in moves if one[0] != NOTHING]
        goes = reduce(lambda a, b: Apply("add", (a, b)), parts)
    at_start = Apply("subtract", (goes, _put(state.rate, state.name, start)))
    return Apply("add", (start, Apply("divide", (at_start, _put(slope, state.name, start)))))


def _rate_of(channel: int) -> str:
    """Return what names the rate of a reading."""
    return f"rate of channel {channel}"


def _put(tree: Tree, name: str, by: Tree) -> Tree:
    if isinstance(tree, Name):
        return by if tree.name == name else tree
    if isinstance(tree, Number):
        return tree
    return Apply(tree.operation, tuple(_put(one, name, by) for one in tree.operands))


@dataclass(frozen=True)
class _Entry:
    """A value that follows from others: a tree of them, and its slopes by name."""

    place: int
    tree: Tree
    slopes: Mapping[str, Tree]


class Beginnings:
    """What of a window's start follows from its other numbers, for the windows of one run."""

    def __init__(self, lowered: LoweredBodies, run: BodiesData) -> None:
        own, layout = lowered.own, lowered.layout
        self.n, self.run, self.lowered = len(own.equations.names), run, lowered
        self.ways: dict[tuple[str, float], float] = {}
        self.last: dict[str, tuple[tuple[float, ...], _Come]] = {}  # integrals, by what they were made with
        begin, parameters = layout["initial"], layout["parameters"]
        self.places = {coordinate(i).name: begin + i for i in range(self.n)}
        self.places |= {velocity(i).name: begin + self.n + i for i in range(self.n)}
        self.places |= {name: parameters + place for name, place in lowered.places.items()}
        of_laws = sum(len(law.states) for law in own.laws)
        first = begin + 2 * self.n + of_laws
        states = [state for push in own.effects.pushes for state in push.states]
        self.entries = [
            self._entry(first + k, steady(one, self.n, self._read_rate(one))) for k, one in enumerate(states)
        ]
        behind = begin + 2 * self.n + len(own.hidden)
        self.rails = {key: behind + k for k, key in enumerate(_rails(lowered))}

    def _read_rate(self, state: PlacedState) -> Tree | None:
        """The rate of a state that a channel shows, by that of the channel; None where none does."""
        for c, name in enumerate(self.run.channels):
            reading = self.lowered.own.effects.readings.get(name)
            if reading is None or state.name not in names(reading):
                continue
            slope = _put(derivative(reading, state.name), state.name, state.start)
            return Apply("divide", (Name(_rate_of(c)), slope))
        return None

    @cached_property
    def rates(self) -> dict[str, Floats]:
        """Rates of the channels that show a state, (n,), by what trees call them."""
        run, longest = self.run, self.run.periods[1] / SHARE
        asked = {name for one in self.entries for name in names(one.tree)}
        return {
            _rate_of(c): smoothed(run.t, run.readings[:, c], float(run.noise[c]), longest)[1]
            for c in range(len(run.channels))
            if _rate_of(c) in asked
        }

    def _entry(self, place: int, tree: Tree) -> _Entry:
        by = [name for name in sorted(names(tree)) if name in self.places]
        return _Entry(place, tree, {name: derivative(tree, name) for name in by})

    @cached_property
    def read(self) -> Mapping[str, int]:
        """Places of all that is read here: next to nothing where no effect has a state, or makes a speed another."""
        if self.entries or self.rippled:
            return self.places
        return {key: place for key, place in self.places.items() if key in self.rails}

    @cached_property
    def rippled(self) -> dict[str, tuple[Tree, list[str]]]:
        """What effects multiply prescribed speeds by, and the numbers that this reads."""
        out = {}
        for key in self.rails:
            tree = self.lowered.own.effects.factor(key)
            if tree is not None:
                out[key] = (tree, [name for name in sorted(names(tree)) if name in self.places])
        return out

    def rippling(self, key: str, of: Mapping[str, float | Floats]) -> tuple[Value, dict[str, Value]]:
        """Return what effects multiply a prescribed speed by at times, and its slopes by their numbers."""
        if key not in self.rippled:
            return 1.0, {}
        tree, by = self.rippled[key]
        return value(tree, of), {name: value(derivative(tree, name), of) for name in by}

    def put(self, values: Floats, rows: Floats, t: float) -> None:
        """Put into the values, and into rows of seeds, what follows from the others at time `t`."""
        of = {name: float(values[place]) for name, place in self.read.items()} | {"t": t}
        for key, place in self.rails.items():
            come, slopes = self._come(key, of, t)
            values[place] = come + (self.run.drawn if key == DRIVE else 0.0)
            self._chain(rows, place, slopes)
            of[distance(key).name] = float(values[place])
        of |= {name: float(np.interp(t, self.run.t, rate)) for name, rate in self.rates.items()}
        for one in self.entries:
            values[one.place] = float(value(one.tree, of))
            self._chain(rows, one.place, {name: float(value(tree, of)) for name, tree in one.slopes.items()})

    def _chain(self, rows: Floats, place: int, slopes: Mapping[str, float]) -> None:
        rows[:, place] = sum((size * rows[:, self.places[name]] for name, size in slopes.items()), 0.0)

    def _come(self, key: str, of: Mapping[str, float], t: float) -> tuple[float, dict[str, float]]:
        """How far a belt or a drive has come, and its slopes by numbers of effects."""
        speed = self.run.belt if key == "belt_speed" else self.run.drive
        if key == DRIVE and speed.constant is not None:  # a number of the run, which may be fitted
            return self._driven(of, t)
        if key not in self.rippled:
            return self._gone(key, speed, t), {}
        tree, by = self.rippled[key]
        if by == [OFF]:
            gone = self._gone(key, speed, t)
            return (1.0 + of[OFF]) * gone, {OFF: gone}
        numbers = tuple(of[name] for name in by)
        if key not in self.last or self.last[key][0] != numbers:
            self.last[key] = numbers, self._integrals(speed, tree, by, of)
        grid, come, slopes = self.last[key][1]
        return float(np.interp(t, grid, come)), {
            name: float(np.interp(t, grid, one)) for name, one in slopes.items()
        }

    def _gone(self, key: str, speed: Speed, t: float) -> float:
        """How far a speed goes by itself."""
        if (key, t) not in self.ways:
            self.ways[key, t] = float(speed.way(t))
        return self.ways[key, t]

    def _driven(self, of: Mapping[str, float], t: float) -> tuple[float, dict[str, float]]:
        """How far a drive of constant speed has come, and its slopes by that speed and by numbers of effects."""
        if DRIVE not in self.rippled:
            return of[DRIVE] * t, {DRIVE: t}
        tree, by = self.rippled[DRIVE]
        numbers = tuple(of[name] for name in by)
        if DRIVE not in self.last or self.last[DRIVE][0] != numbers:
            self.last[DRIVE] = numbers, self._integrals(Speed.of(1.0), tree, by, of)
        grid, come, slopes = self.last[DRIVE][1]
        share = float(np.interp(t, grid, come))
        each = {name: of[DRIVE] * float(np.interp(t, grid, one)) for name, one in slopes.items()}
        return of[DRIVE] * share, {DRIVE: share, **each}

    def _integrals(self, speed: Speed, tree: Tree, by: Sequence[str], of: Mapping[str, float]) -> _Come:
        """Way over time on a grid of half the samples' step, and its slopes by numbers of effects."""
        dt, end = float(np.median(np.diff(self.run.t))), float(self.run.t[-1])
        grid = np.linspace(0.0, end, 2 * max(round(end / dt), 1) + 1)
        rate, every = np.asarray(speed(grid)) * np.ones(len(grid)), {**of, "t": grid}

        def along(one: Tree) -> Floats:
            made = rate * np.broadcast_to(value(one, every), grid.shape)
            return np.asarray(scipy.integrate.cumulative_simpson(made, x=grid, initial=0.0))

        return grid, along(tree), {name: along(derivative(tree, name)) for name in by}


class Reads:
    """What the channels of one run read of the core's states."""

    def __init__(self, lowered: LoweredBodies, channels: Sequence[str]) -> None:
        own = lowered.own
        n = len(own.equations.names)
        self.names = [coordinate(i).name for i in range(n)] + [velocity(i).name for i in range(n)]
        self.names += [*own.hidden, *(distance(key).name for key in _rails(lowered))]
        self.trees = {
            c: own.effects.readings[name] for c, name in enumerate(channels) if name in own.effects.readings
        }
        self.numbers = lowered.own.effects.numbers

    def read(
        self, c: int, t: Floats, state: Floats, slopes: Floats, of: Mapping[str, float]
    ) -> tuple[Floats, Floats, dict[str, Floats]]:
        """
        Return the readings of a channel (n,), their slopes through the states (n, k), and by numbers of effects.

        Parameters
        ----------
        c, t, state, slopes : the channel; times (n,), states (n, d) and their slopes (n, d, k)
        of : numbers by name
        """
        tree = self.trees[c]
        every = {**of, "t": t, **dict(zip(self.names, state.T, strict=False))}
        shape = t.shape
        out = np.broadcast_to(value(tree, every), shape).copy()
        by = np.zeros((len(t), slopes.shape[2]))
        own = {}
        for name in names(tree):
            if name in self.names:
                slope = np.broadcast_to(value(derivative(tree, name), every), shape)
                by += slope[:, None] * slopes[:, self.names.index(name)]
            elif name in self.numbers:
                own[name] = np.broadcast_to(value(derivative(tree, name), every), shape).copy()
        return out, by, own


def _rails(lowered: LoweredBodies) -> list[str]:
    eq = lowered.own.equations
    used = zip(lowered.own.effects.keys, (eq.on_belt, eq.driven), strict=True)
    return [key for key, moves in used if moves]
