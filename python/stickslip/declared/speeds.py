"""A speed that is prescribed, of a belt or a drive: a number, a formula of t, steps, or what was measured."""

from __future__ import annotations

import hashlib
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained, vector
from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.range import check_range
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, substituted, switches
from stickslip.declared.formula.value import Value, value
from stickslip.errors import InputError, number
from stickslip.objects import Drawn

_T = Name("t")
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_EXACT, _PARTS = 1e-11, 1_000_000  # how nearly a way is told, and the parts that it is found in at most


@explained
@dataclass(frozen=True, repr=False)
class Speed(Drawn):
    """A speed over time, in pieces that are formulas of t; `of`, `steps` and `measured` make one.

    Attributes
    ----------
    begins
        Times from which the pieces hold, increasing (k,); the first holds before its own too.
    pieces
        Formulas of t, trees (k,).
    text
        As a person would write it.

    Examples
    --------
    >>> import stickslip as ss
    >>> speed = ss.Speed.of("0.1*sin(2*t)")
    >>> print(f"{speed(0.5):.4f}")
    0.0841
    """

    begins: tuple[float, ...]
    pieces: tuple[Tree, ...]
    text: str = ""

    @classmethod
    def of(cls, given: object, key: str = "belt_speed") -> Speed:
        """Return a speed of a number, a formula ("0.5*sin(1.7*t)") or a `Speed`.

        Raises
        ------
        InputError
            None of these, or a formula that is not defined at every time.
        """
        if isinstance(given, Speed):
            return given
        if not isinstance(given, str):
            size = number(key, given)  # type: ignore[arg-type]  # `number` looks
            return cls((0.0,), (Number(size),), f"{size:g}")
        try:
            tree = parse(given, ["t"])
        except InputError as error:
            raise InputError(error.what, key=key, value=error.value) from None
        check_range(key, tree, "t", {})
        _check_roots(tree, 0.0, key, given)
        if found := switches(tree):
            words = f"'{found[0].operation}' has a kink in time; give the speed in steps, with a formula each"
            raise InputError(words, key=key, value=given)
        return cls((0.0,), (tree,), given)

    @classmethod
    def steps(cls, begins: ArrayLike, values: Sequence[object], key: str = "belt_speed") -> Self:
        """Return a speed that changes at given times.

        Parameters
        ----------
        begins
            Times from which each value holds, increasing; the first holds before it too.
        values
            Numbers, or formulas of t.
        """
        times = vector("from", begins, "times")
        if len(times) == 0 or len(times) != len(values):
            raise InputError(f"has {len(values)} values for {len(times)} times", key=key)
        _check_times(times, key)
        pieces = tuple(cls.of(one, key).pieces[0] for one in values)
        for at, tree, one in zip(times.tolist(), pieces, values, strict=True):
            _check_roots(tree, at, key, one)
        told = ", ".join(f"{one} from {t:g}" for t, one in zip(times, values, strict=True))
        return cls(tuple(times.tolist()), pieces, told)

    @classmethod
    def measured(cls, t: ArrayLike, values: ArrayLike, key: str = "belt_speed") -> Self:
        """Return what was measured: straight between the samples, constant before the first and after the last."""
        times, speeds = _samples(t, values, key, 2)
        begins, pieces = [float(times[0])], list[Tree]()
        slopes = np.diff(speeds) / np.diff(times)
        for start, first, slope in zip(times, speeds, slopes, strict=False):
            line = Apply("multiply", (Number(float(slope)), Apply("subtract", (_T, Number(float(start))))))
            pieces.append(Apply("add", (Number(float(first)), line)) if slope else Number(float(first)))
        begins += times[1:].tolist()
        pieces.append(Number(float(speeds[-1])))
        before: list[Tree] = [Number(float(speeds[0]))]
        text = f"measured, {len(times)} samples"
        return cls((float(times[0]) - 1.0, *begins), (*before, *pieces), text)

    @classmethod
    def held(cls, t: ArrayLike, values: ArrayLike, key: str = "belt_speed") -> Self:
        """Return what holds from each sample to the next, the first before all and the last after."""
        times, sizes = _samples(t, values, key, 1)
        new = np.concatenate([[True], sizes[1:] != sizes[:-1]])
        pieces = tuple(Number(float(one)) for one in sizes[new])
        return cls(tuple(times[new].tolist()), pieces, f"{len(times)} samples, each held until the next")

    @property
    def digest(self) -> str:
        """What tells it from every other: its pieces in full, where `text` is short."""
        return hashlib.sha256(repr((self.begins, self.pieces)).encode()).hexdigest()

    @property
    def constant(self) -> float | None:
        """The number that it is at every time, or None."""
        first = self.pieces[0]
        return first.value if len(self.pieces) == 1 and isinstance(first, Number) else None

    def piece(self, t: float) -> int:
        """Return which piece holds from the time t on."""
        return max(0, bisect_right(self.begins, t) - 1)

    def at(self, t: Value, piece: int) -> tuple[Value, Value]:
        """Value and rate of a piece at t."""
        tree = self.pieces[piece]
        return value(tree, {"t": t}), value(derivative(tree, "t"), {"t": t})

    def __call__(self, t: ArrayLike) -> NDArray[np.float64]:
        """Return the speed at the times t, any shape."""
        times = np.asarray(t, dtype=np.float64)
        flat, out = times.ravel(), np.empty(times.size)
        held = np.maximum(np.searchsorted(self.begins, flat, side="right") - 1, 0)
        order = np.argsort(held, kind="stable")
        for same in np.split(order, np.flatnonzero(np.diff(held[order])) + 1):
            if len(same):
                out[same] = value(self.pieces[held[same[0]]], {"t": flat[same]})
        return out.reshape(times.shape)

    def within(self, start: float, end: float) -> Speed:
        """Return what is the same between two times, with the pieces that are needed there alone."""
        kept = slice(self.piece(start), self.piece(end) + 1)
        return Speed(self.begins[kept], self.pieces[kept], self.text)

    def delayed(self, by: float) -> Speed:
        """Return what comes so much later."""
        late: Mapping[str, Tree] = {"t": Apply("subtract", (_T, Number(by)))}
        pieces = tuple(one if isinstance(one, Number) else substituted(one, late) for one in self.pieces)
        return Speed(tuple(one + by for one in self.begins), pieces, f"{self.text}, {by:g} later")

    def since(self, start: float) -> Speed:
        """Return the same speed by a clock that begins at `start`."""
        if start == 0 or self.constant is not None:
            return self
        return replace(self.delayed(-start), text=f"{self.text}, from {start:g} on")

    def followed(self, later: Speed, begin: float) -> Speed:
        """Return the speed until a time, and another from there on."""
        kept = [i for i, at in enumerate(self.begins) if at < begin]
        new = [i for i, at in enumerate(later.begins) if at > begin]
        begins = (*(self.begins[i] for i in kept), begin, *(later.begins[i] for i in new))
        first = later.pieces[later.piece(begin)]
        pieces = (*(self.pieces[i] for i in kept), first, *(later.pieces[i] for i in new))
        return Speed(begins, pieces, later.text)

    def way(self, t: ArrayLike) -> NDArray[np.float64]:
        """Return how far it goes from the time 0 to the times t >= 0, any shape."""
        times = np.asarray(t, dtype=np.float64)
        if self.constant is not None:
            return self.constant * times
        last = float(times.max(initial=0.0))
        inner = [one for one in self.begins if 0 < one < last]
        edges = np.unique(np.concatenate([[0.0], inner, times.ravel()]))
        come, parts = self._come(edges, 1), 1
        while parts * len(edges) < _PARTS:
            parts *= 2
            finer = self._come(edges, parts)
            done = np.abs(finer - come).max() <= _EXACT * max(float(np.abs(finer).max()), 1e-300)
            come = finer
            if done:
                break
        return np.asarray(come[np.searchsorted(edges, times)])

    def _come(self, edges: NDArray[np.float64], parts: int) -> NDArray[np.float64]:
        """The way at edges, the first of which is 0: by Gauss in so many parts between two."""
        share = (np.arange(parts)[:, None] + 0.5 * (1 + _NODES)).ravel() / parts
        width = np.diff(edges)
        rate = self(edges[:-1, None] + width[:, None] * share)
        each = width * (rate @ np.tile(_WEIGHTS, parts)) / (2 * parts)
        return np.concatenate([[0.0], np.cumsum(each)])

    def scaled(self, time: float, size: float) -> Speed:
        """Return the speed in other units: of t/time and value * size."""
        if time == 1 and size == 1:
            return self
        by: Mapping[str, Tree] = {"t": Apply("multiply", (_T, Number(time)))}
        pieces = tuple(
            Number(one.value * size)
            if isinstance(one, Number)
            else Apply("multiply", (Number(size), substituted(one, by)))
            for one in self.pieces
        )
        return Speed(tuple(one / time for one in self.begins), pieces, self.text)


def _check_roots(tree: Tree, at: float, key: str, given: object) -> None:
    """Refuse a root, or a power that is not whole, of what is 0 where a formula begins: it has no series there."""
    if not isinstance(tree, Apply):
        return
    for one in tree.operands:
        _check_roots(one, at, key, given)
    exponent = tree.operands[1] if tree.operation == "power" else None
    whole = isinstance(exponent, Number) and exponent.value >= 0 and exponent.value == int(exponent.value)
    if (tree.operation == "sqrt" or (exponent is not None and not whole)) and value(
        tree.operands[0], {"t": at}
    ) == 0:
        words = (
            f"takes a root, or a power that is not whole, of what is 0 at t = {at:g}; begin a little above 0"
        )
        raise InputError(words, key=key, value=given)


def _samples(
    t: ArrayLike, values: ArrayLike, key: str, fewest: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times that increase and as many values, all finite."""
    times, sizes = vector("t", t, "times"), vector(key, values, "values")
    if len(times) != len(sizes) or len(times) < fewest:
        words = f"has {len(sizes)} samples at {len(times)} times; give one for each, {fewest} at least"
        raise InputError(words, key=key)
    if not (np.isfinite(times).all() and np.isfinite(sizes).all()):
        raise InputError("has samples that are not finite", key=key)
    _check_times(times, key)
    return times, sizes


def _check_times(times: NDArray[np.float64], key: str) -> None:
    if np.any(np.diff(times) <= 0):
        i = int(np.argmax(np.diff(times) <= 0)) + 1
        raise InputError(
            f"its times must increase; entry {i} is {times[i]:g} after {times[i - 1]:g}", key=key
        )
