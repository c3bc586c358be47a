"""What the laws that are formulas share: numbers with units, branches, magnitudes, steady sliding."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy

from stickslip.declared.dimensions import Dimension
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import Apply, Name, Number, Operation, Tree, substituted
from stickslip.declared.formula.value import Value, value
from stickslip.declared.friction_law import Direction, Floats, FrictionLaw, LawBranch
from stickslip.declared.law_form import BranchForm, LawForm, StateForm
from stickslip.errors import InputError

NO_RISE = 1e-150  # square of a slope that is none: its own square is a number still


@dataclass(frozen=True, repr=False)
class LawByFormula(FrictionLaw):
    """A law whose magnitudes, force and rates are formulas.

    A subclass gives their texts: `kinetic` and `static` of a rigid law or `force` of a compliant one, and of every
    state its rate, its start and what it measures.
    """

    kinetic_text: ClassVar[str | None] = None
    static_text: ClassVar[str | None] = None
    force_text: ClassVar[str | None] = None
    state_texts: ClassVar[Mapping[str, tuple[str, str, Dimension]]] = {}

    def form(self) -> LawForm:
        """Return the law as it is simulated."""
        kept: LawForm | None = self.__dict__.get("_form")
        if kept is None:
            object.__setattr__(self, "_form", kept := self._make_form())
        return kept

    def __getstate__(self) -> dict[str, object]:
        return {name: one for name, one in self.__dict__.items() if name != "_form"}

    def _texts(self) -> tuple[str | None, str | None, str | None, Mapping[str, tuple[str, str, Dimension]]]:
        return self.kinetic_text, self.static_text, self.force_text, self.state_texts

    def _make_form(self) -> LawForm:
        kinetic, static, force, states = self._texts()
        rates = {f"{name}_rate": parse(rate) for name, (rate, _, _) in states.items()}
        minus = BranchForm(
            None if kinetic is None else parse(kinetic),
            None if static is None else parse(static),
            None if force is None else substituted(parse(force), rates),
            tuple(rates.values()),
        )
        kept = tuple(StateForm(name, parse(start), what) for name, (_, start, what) in states.items())
        twins = {name: f"{name}_plus" for name in self.each_way if getattr(self, f"{name}_plus") is not None}
        return LawForm(minus, minus.renamed(twins), self.numbers, kept)

    # -- what every law can be asked ---------------------------------------------------------------------------

    @property
    def static_limits(self) -> tuple[float, float]:
        """Static limits (minus, plus) at the beginning of a stick; of a compliant law its steady force near rest."""
        return self._limit(-1), self._limit(1)

    def _limit(self, direction: Direction) -> float:
        form = self.form()
        static = form.branch(direction).static
        if static is None:
            return float(self._steady(direction, np.array([1e-12]))[0])
        return float(value(static, {**form.numbers, **self._started(direction, 0.0), "dwell": 0.0, "t": 0.0}))

    @property
    def kinks(self) -> tuple[None, None]:
        """None: where a formula saturates, its own min, max and abs say so."""
        return None, None

    def _minus(self, u: Floats) -> Floats:
        return self._steady(-1, u)

    def _plus(self, u: Floats) -> Floats:
        return self._steady(1, u)

    def _steady(self, direction: Direction, u: Floats) -> Floats:
        """Return the magnitude in steady sliding at the speeds u."""
        form = self.form()
        branch = form.branch(direction)
        shape = np.shape(u)
        out = np.empty(shape)
        for place, speed in np.ndenumerate(np.asarray(u, dtype=np.float64)):
            of = {**form.numbers, "u": speed, "v": direction * speed, "t": 0.0, "dwell": 0.0}
            of |= steady_states(form, direction, float(speed))
            tree = branch.kinetic if branch.force is None else branch.force
            assert tree is not None
            size = float(np.real(value(tree, of)))
            out[place] = size if branch.force is None else direction * size
        return out

    def _started(self, direction: Direction, speed: float) -> dict[str, float]:
        form = self.form()
        of: dict[str, Value] = {**form.numbers, "u": abs(speed), "v": direction * abs(speed)}
        return {one.name: float(np.real(value(one.start, of))) for one in form.states}

    def branch(self, direction: Direction) -> LawBranch:
        """Return the branch for slip with the sign `direction`, of a law without states.

        Raises
        ------
        InputError
            The law has states, or no stick.
        """
        form = self.form()
        kinetic = form.branch(direction).kinetic
        if form.states or kinetic is None:
            raise InputError(f"the law '{self.kind}' has a state of its own; simulate the rig instead")
        return LawBranch(self._limit(direction), lambda u: value(kinetic, {**form.numbers, "u": u, "t": 0.0}))


def steady_states(form: LawForm, direction: Direction, speed: float) -> dict[str, float]:
    """Return the states of a law in steady sliding, found from where they start.

    Raises
    ------
    InputError
        They settle nowhere.
    """
    if not form.states:
        return {}
    of: dict[str, Value] = {**form.numbers, "u": speed, "v": direction * speed, "t": 0.0, "dwell": 0.0}
    names, rates = [one.name for one in form.states], form.branch(direction).rates
    guess = np.array([float(np.real(value(one.start, of))) for one in form.states])
    if not np.isfinite(guess).all():
        return dict(zip(names, guess, strict=True))
    slope = np.array([[_slope(rate, of, names, guess, k) for k in range(len(names))] for rate in rates])
    start = np.array([float(value(rate, {**of, **dict(zip(names, guess, strict=True))})) for rate in rates])
    if np.all(np.abs(start) <= 1e-14 * np.abs(slope) @ np.abs(guess)):
        return dict(zip(names, guess, strict=True))
    scale = np.where(guess != 0, np.abs(guess), 1.0)
    if np.linalg.matrix_rank(slope) == len(names):  # a step of Newton's sets the scale of what starts at 0
        step = np.linalg.solve(slope, -start)
        scale = np.where(guess != 0, np.abs(guess), np.where(step != 0, np.abs(step), 1.0))

    def residual(shares: Floats) -> Floats:
        at = {**of, **dict(zip(names, guess + shares * scale, strict=True))}
        return np.array([float(np.real(value(rate, at))) for rate in rates])

    found = scipy.optimize.root(residual, np.zeros(len(names)), tol=1e-14)
    if not found.success and not np.all(np.abs(found.fun) < 1e-9):
        raise InputError(
            f"the state {', '.join(names)} has no steady value at a speed of {speed:g}; give its start"
        )
    return dict(zip(names, guess + found.x * scale, strict=True))


def _slope(rate: Tree, of: Mapping[str, Value], names: Sequence[str], at: Floats, k: int) -> float:
    h = 1e-30
    states = {name: complex(at[i], h * (i == k)) for i, name in enumerate(names)}
    return float(np.imag(value(rate, {**of, **states})) / h)


def _of(operation: Operation, *operands: Tree | float) -> Tree:
    return Apply(
        operation, tuple(Number(float(one)) if isinstance(one, int | float) else one for one in operands)
    )


def monotone_cubic(name: str, knots: Sequence[float], values: Sequence[Tree]) -> Tree:
    """Return the tree of the curve of Fritsch and Butland (1984) through points, constant outside, without new humps.

    Its slopes are those of `scipy.interpolate.PchipInterpolator`, as formulas of the values: the values may be numbers
    of a law, of which there are derivatives.
    """
    h = [float(b - a) for a, b in itertools.pairwise(knots)]
    rises = [
        _of("divide", _of("subtract", b, a), w)
        for (a, b), w in zip(itertools.pairwise(values), h, strict=True)
    ]
    inner = [_between(*one) for one in zip(h[:-1], h[1:], rises[:-1], rises[1:], strict=True)]
    if len(h) > 1:
        first, last = _at_end(h[0], h[1], rises[0], rises[1]), _at_end(h[-1], h[-2], rises[-1], rises[-2])
    else:
        first = last = rises[0]
    slopes, parts = [first, *inner, last], []
    for (d, e), m, w in zip(itertools.pairwise(slopes), rises, h, strict=True):
        cubic = _of("divide", _of("subtract", _of("add", d, e), _of("multiply", 2, m)), w * w)
        square = _of(
            "divide", _of("subtract", _of("multiply", 3, m), _of("add", _of("multiply", 2, d), e)), w
        )
        parts.append((cubic, square, d))
    return _piecewise(name, knots, values[0], parts)


def _between(h: float, w: float, m: Tree, n: Tree) -> Tree:
    """The slope between two rises: their weighted harmonic mean, 0 where they differ in sign."""
    one, two = 2 * w + h, w + 2 * h
    both = _of("max", _of("multiply", m, n), 0)
    weighted = _of("add", _of("multiply", one, n), _of("multiply", two, m))
    # 0 over 0 where both rises are 0
    beside = _of("divide", weighted, _of("add", _of("multiply", weighted, weighted), NO_RISE))
    return _of("multiply", one + two, _of("multiply", both, beside))


def _at_end(h: float, w: float, m: Tree, n: Tree) -> Tree:
    """The slope at an end: of the parabola through three points, as far as it makes no hump."""
    by = _of("divide", _of("subtract", _of("multiply", 2 * h + w, m), _of("multiply", h, n)), h + w)
    most = _of("multiply", 3, m)
    return _of("max", _of("min", by, _of("max", most, 0)), _of("min", most, 0))


def _piecewise(name: str, knots: Sequence[float], start: Tree, parts: Sequence[Sequence[Tree]]) -> Tree:
    """
    The curve that is a cubic between knots and constant outside.

    Each part adds what it does between two knots, of a distance clamped to its width: nothing cancels.
    """
    terms = [start]
    for left, right, coefficients in zip(knots[:-1], knots[1:], parts, strict=True):
        clamped = _of("min", _of("max", _of("subtract", Name(name), left), 0), right - left)
        sum_ = coefficients[0]
        for one in coefficients[1:]:
            sum_ = _of("add", _of("multiply", sum_, clamped), one)
        terms.append(_of("multiply", sum_, clamped))
    while len(terms) > 1:  # added in pairs: the tree stays flat, however many knots there are
        pairs = [_of("add", a, b) for a, b in zip(terms[::2], terms[1::2], strict=False)]
        terms = [*pairs, *terms[2 * len(pairs) :]]
    return terms[0]
