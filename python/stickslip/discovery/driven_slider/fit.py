"""Weighted least squares of the force balance: the declared law and some candidates, in white units of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.discovery.driven_slider import terms as tm
from stickslip.discovery.driven_slider.motion import Band, Motion, stacked
from stickslip.discovery.driven_slider.noise import Noise
from stickslip.discovery.driven_slider.terms import Law, Term

Floats = NDArray[np.float64]

REMEMBERED = 400  # candidates whose columns are kept at hand
LAW_ROUNDS = 2  # candidates that scale with friction are computed with the friction of the round before


@dataclass(frozen=True)
class Choice:
    """A candidate with its scanned numbers (k,)."""

    term: Term
    inside: Floats

    @property
    def name(self) -> str:
        """The candidate's name."""
        return self.term.name


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted balance.

    `choices` are the candidates in it, `amplitudes` their coefficients, `law` the declared law's numbers,
    `coefficients` those of all columns (law, candidates, free friction, extra), `white` (n',) the residual in white
    units, `chi2` its sum of squares, `freedom` how many numbers were fitted.
    """

    choices: tuple[Choice, ...]
    law: Law
    amplitudes: tuple[Floats, ...]
    coefficients: Floats
    white: Floats
    chi2: float
    freedom: int

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the candidates in it."""
        return tuple(one.name for one in self.choices)

    @property
    def per_reading(self) -> float:
        """chi2 over its degrees of freedom."""
        return self.chi2 / max(len(self.white) - self.freedom, 1)

    def parameters(self) -> dict[str, dict[str, float]]:
        """Every candidate's numbers under its catalogue names."""
        return {
            one.name: one.term.parameters(one.inside, b, self.law)
            for one, b in zip(self.choices, self.amplitudes, strict=True)
        }


class Balance:
    """The force balance of some runs within a band: F = mass a + damping v + T + candidates + noise.

    Parameters
    ----------
    runs
        What was measured.
    over
        The band.
    mass
        Declared mass [kg]; it is fitted only where `rig_mass` is among the candidates.
    """

    def __init__(self, runs: Sequence[Motion], over: Band, mass: float) -> None:
        self.runs, self.band, self.mass = tuple(runs), over, mass
        self.force = stacked(runs, over, lambda run: run.drive)
        self.base = stacked(runs, over, tm.base)
        self.free = _beside([over(tm.free(run, over.step)) for run in self.runs])
        self.lengths = [len(over.kept(len(run.t))) for run in self.runs]
        self._low_passes = [over.matrix(len(run.t), np.float64) for run in self.runs]
        self._kept: dict[tuple[object, ...], Floats] = {}
        self._white_base = self._white_force = np.zeros(0)
        self._noise = self.noise = Noise(np.ones(1), 1.0)

    @property
    def noise(self) -> Noise:
        """Noise in whose white units is fitted."""
        return self._noise

    @noise.setter
    def noise(self, noise: Noise) -> None:
        self._noise = noise
        self._whiten = noise.matrix(self.lengths)
        self._white_base = self.whitened(np.column_stack([self.base, self.free]))
        self._white_force = self.whitened(self.force)
        self._kept.clear()

    def columns(self, term: Term, inside: Floats, law: Law) -> Floats:
        """A candidate's columns (n, m), filtered."""
        return np.concatenate(
            [m @ term.columns(run, inside, law) for m, run in zip(self._low_passes, self.runs, strict=True)]
        )

    def white_columns(self, term: Term, inside: Floats, law: Law) -> Floats:
        """The same in white units; the last ones are remembered."""
        key = (term.name, inside.tobytes(), law if term.scaled else None)
        if key not in self._kept:
            if len(self._kept) > REMEMBERED:
                self._kept.pop(next(iter(self._kept)))
            self._kept[key] = self.whitened(self.columns(term, inside, law))
        return self._kept[key]

    def whitened(self, rows: Floats) -> Floats:
        """Rows in white units."""
        return np.asarray(self._whiten @ rows, dtype=np.float64)

    def fit(
        self, choices: Sequence[Choice] = (), law: Law | None = None, *, extra: Floats | None = None
    ) -> Fit:
        """Fit the law's numbers and the candidates' amplitudes, their scanned numbers held.

        Parameters
        ----------
        choices
            Candidates; one named `rig_mass` frees the mass.
        law
            Friction with which candidates that scale with it are computed at first; None: from a fit without them.
        extra
            More columns (n, m), filtered, that may take any amplitude.
        """
        if law is None:
            law = self.fit((), Law(self.mass, 0.0, 0.0, 0.0)).law
        for _ in range(LAW_ROUNDS if choices else 1):
            out = self._once(choices, law, extra)
            law = out.law
        return out

    def _once(self, choices: Sequence[Choice], law: Law, extra: Floats | None) -> Fit:
        heavy = any(one.name == "rig_mass" for one in choices)
        wy = self._white_force - (0.0 if heavy else self.mass) * self._white_base[:, 0]
        first, last = self._white_base[:, 0 if heavy else 1 : 4], self._white_base[:, 4:]
        parts, widths = [first], []
        for one in choices:
            w = np.zeros((len(wy), 0))
            if one.name != "rig_mass":
                w = self.white_columns(one.term, one.inside, law)
            if one.term.fixed:
                wy, w = wy - w[:, 0], w[:, :0]
            parts.append(w)
            widths.append(w.shape[1])
        parts += [last] if extra is None else [last, self.whitened(extra)]
        X = np.column_stack(parts)
        scale = lengths(X)
        b, rank = _solved(X / scale, wy)
        b /= scale
        numbers = b[: first.shape[1]]
        fitted = Law(float(numbers[0]) if heavy else self.mass, *(float(one) for one in numbers[-3:]))
        amplitudes = (
            np.split(b[len(numbers) : len(numbers) + sum(widths)], np.cumsum(widths)[:-1]) if widths else []
        )
        white = wy - X @ b
        inside = sum(len(one.inside) for one in choices)
        return Fit(
            tuple(choices), fitted, tuple(amplitudes), b, white, float(white @ white), int(rank) + inside
        )

    def residual(self, fit: Fit, extra: Floats | None = None) -> Floats:
        """What a fit leaves of the force (n,) in N, before whitening; `extra` as it was fitted with."""
        heavy = "rig_mass" in fit.names
        y = self.force - (0.0 if heavy else fit.law.mass) * self.base[:, 0]
        parts = [self.base[:, 0 if heavy else 1 :]]
        for one in fit.choices:
            c = np.zeros((len(y), 0))
            if one.name != "rig_mass":
                c = self.columns(one.term, one.inside, fit.law)
            if one.term.fixed:
                y, c = y - c[:, 0], c[:, :0]
            parts.append(c)
        parts += [self.free] if extra is None else [self.free, extra]
        return np.asarray(y - np.column_stack(parts) @ fit.coefficients, dtype=np.float64)

    def predicted(self, fit: Fit) -> Floats:
        """Residual (n',) in white units of a fit to other runs: nothing is fitted here but friction at rest."""
        w = self._white_force - fit.law.mass * self._white_base[:, 0]
        numbers = np.array([fit.law.damping, fit.law.minus, fit.law.plus])
        w = w - self._white_base[:, 1:4] @ numbers
        for one, b in zip(fit.choices, fit.amplitudes, strict=True):
            if one.name != "rig_mass":
                c = self.white_columns(one.term, one.inside, fit.law)
                w = w - (c[:, 0] if one.term.fixed else c @ b)
        free = self._white_base[:, 4:]
        return np.asarray(w - free @ np.linalg.lstsq(free, w, rcond=None)[0], dtype=np.float64)

    def unexplained(self, fit: Fit) -> Floats:
        """The same in N, not whitened (n,)."""
        y = self.force - fit.law.mass * self.base[:, 0]
        y = y - self.base[:, 1:4] @ np.array([fit.law.damping, fit.law.minus, fit.law.plus])
        for one, b in zip(fit.choices, fit.amplitudes, strict=True):
            if one.name != "rig_mass":
                c = self.columns(one.term, one.inside, fit.law)
                y = y - (c[:, 0] if one.term.fixed else c @ b)
        return np.asarray(y - self.free @ np.linalg.lstsq(self.free, y, rcond=None)[0], dtype=np.float64)

    def design(self, fit: Fit) -> tuple[Floats, Floats]:
        """Whitened columns of everything fitted: law, amplitudes, friction at rest, then the scanned numbers'.

        Also the step of the logarithm of each scanned number to which its column belongs.
        """
        heavy = "rig_mass" in fit.names
        parts, last, steps = [self._white_base[:, 0 if heavy else 1 : 4]], [], []
        for one, b in zip(fit.choices, fit.amplitudes, strict=True):
            if one.name == "rig_mass":
                continue
            c = self.white_columns(one.term, one.inside, fit.law)
            weight = np.ones(1) if one.term.fixed else b
            if not one.term.fixed:
                parts.append(c)
            for i in range(len(one.inside)):
                step = 0.01 * self._step(one)
                moved = one.inside.copy()
                moved[i] *= np.exp(step)
                last.append((self.white_columns(one.term, moved, fit.law) - c) @ weight / 0.01)
                steps.append(100 * step)
        parts.append(self._white_base[:, 4:])
        return np.column_stack([*parts, *last]), np.array(steps)

    def law_names(self, fit: Fit) -> tuple[str, ...]:
        """Names of the law's numbers in the order of the columns."""
        law = ("damping", "kinetic", "kinetic_plus")
        return ("mass", *law) if "rig_mass" in fit.names else law

    def sharpen(self, choices: Sequence[Choice], law: Law, *, last: bool = False) -> Fit:
        """Fit the scanned numbers too, from where they are: all of them, or those of the last candidate alone."""
        moved = choices[-1:] if last else choices
        held = tuple(choices[: len(choices) - len(moved)])
        start = np.concatenate([np.zeros(0), *(np.log(np.abs(one.inside)) for one in moved)])
        if not start.size:
            return self.fit(choices, law)
        steps = np.concatenate([[self._step(one)] * len(one.inside) for one in moved])

        def at(z: Floats) -> tuple[Choice, ...]:
            out, k = list(held), 0
            for one in moved:
                part = slice(k, k + len(one.inside))
                inside = np.sign(one.inside) * np.exp(start[part] + steps[part] * z[part])
                out.append(Choice(one.term, inside))
                k = part.stop
            return tuple(out)

        def white(z: Floats) -> Floats:
            return self._once(at(z), law, None).white

        still, small = np.zeros(len(start)), np.full(len(start), 1e-2)
        solved = scipy.optimize.least_squares(
            white, still, diff_step=small, bounds=(-6, 6), max_nfev=8, ftol=1e-5, xtol=1e-3
        )
        return self.fit(at(solved.x), law)

    def _step(self, one: Choice) -> float:
        """Natural step of the logarithm of a scanned number: a wave's is that which slips a radian over the record."""
        if one.term.scanned == ("L",):
            return float(one.inside[0] / (2 * np.pi * max(np.ptp(run.x) for run in self.runs)))
        if one.term.scanned == ("w",):
            span = self.runs[-1].t[-1] - self.runs[0].t[0]
            return float(1 / (one.inside[0] * span))
        return 0.3


def lengths(columns: Floats) -> Floats:
    """Lengths (m,) of columns to divide them by: 1 of one that is zero."""
    out = np.linalg.norm(columns, axis=0)
    return np.where(out > 0, out, 1.0)


def _solved(X: Floats, y: Floats) -> tuple[Floats, int]:
    """Least squares (m,) and the rank of columns of length 1: by normal equations where they lose few digits."""
    sizes, vectors = scipy.linalg.eigh(X.T @ X)
    if sizes[0] > 1e-7 * sizes[-1]:  # some 2e-9 of the answer
        return np.asarray(vectors @ ((vectors.T @ (X.T @ y)) / sizes), dtype=np.float64), X.shape[1]
    b, _, rank, _ = scipy.linalg.lstsq(X, y, cond=1e-10)
    return np.asarray(b, dtype=np.float64), int(rank)


def _beside(blocks: Sequence[Floats]) -> Floats:
    """Columns that belong to one run each: a block-diagonal matrix."""
    return np.asarray(scipy.linalg.block_diag(*blocks), dtype=np.float64)
