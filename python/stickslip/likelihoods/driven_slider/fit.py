"""Weighted least squares of the motion: the declared law and some candidates, in white units of the noise.

What is fitted is an acceleration, `x2' = F/mass - damping/mass x2 - T/mass - candidates/mass + noise` with `noise` of
`noise.py`: linear in 1/mass and in everything else over the mass. Unlike the force balance, which has the measured
acceleration on its right side, it is not biased by noise of the readings, in a loop or not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.likelihoods.driven_slider.fitted_motion import Choice, DeclaredMass, MotionFit
from stickslip.likelihoods.driven_slider.motion import DrivenRun, moved, rounded, spread
from stickslip.likelihoods.driven_slider.noise import POLES, Noise, Rows, Sampling, Whitener, fitted
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.driven_slider.terms import ForceTerm, Law
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]

STEP = 0.01  # of a derivative by differences, in natural steps of a scanned number


class Balance:
    """The motion of some runs, ready to be fitted in the white units of a noise.

    Parameters
    ----------
    runs
        What was measured.
    declared
        The mass. Unless `rig_mass` is among the candidates it keeps to its uncertainty.
    """

    def __init__(self, runs: Sequence[DrivenRun], declared: DeclaredMass) -> None:
        self.runs, self.declared = tuple(runs), declared
        self.law = Law(declared.mass, 0.0, 0.0, 0.0)
        self.noise = Noise(1.0, 1.0)
        self.lay()

    def lay(self) -> None:
        """Lay out the law's columns for the damping and the friction that are known so far."""
        self.samplings = [Sampling(run.dt, self.law.damping / self.law.mass) for run in self.runs]
        limit = 0.5 * (abs(self.law.minus) + abs(self.law.plus)) / self.law.mass
        self.doubts = [run.doubt(limit) for run in self.runs]
        both = list(zip(self.runs, self.samplings, strict=True))
        self.response = np.concatenate([run.accelerations(s) for run, s in both])
        self.drive = np.concatenate([run.driven(s) for run, s in both])
        self.base = np.concatenate([_law_columns(run, s) for run, s in both])
        self.lengths = [len(run.t) - 2 for run in self.runs]

    def take(self, noise: Noise) -> None:
        """Fit in the white units of a noise."""
        self.noise = noise
        self.whiteners = [Whitener(noise, s, d) for s, d in zip(self.samplings, self.doubts, strict=True)]
        self._determinant = sum(one.log_determinant for one in self.whiteners)
        self._count = sum(one.count for one in self.whiteners)
        self._white_base = self.whitened(np.column_stack([self.drive, -self.base]))
        self._white_response = self.whitened(self.response)
        self._kept: dict[tuple[object, ...], Floats] = {}

    @property
    def sure(self) -> NDArray[np.bool_]:
        """Rows (n',) in white units that say something."""
        return np.concatenate([one.sure[STEER.order :] for one in self.whiteners])

    def read_again(self, count: int, seed: int) -> Floats:
        """White residuals (n', count) of the noise alone, as other readings of the same motion would leave them.

        An encoder's rounding goes with the motion: its errors are those at other places of its scale, passed at the
        same speeds (B. Widrow, I. Kollar, "Quantization noise", 2008, chapter 20). What is left of the noise is drawn.
        """
        generator = np.random.default_rng(seed)
        out = []
        for run, sampling, white in zip(self.runs, self.samplings, self.whiteners, strict=True):
            if run.step:
                rounding = rounded(run, self.noise, count, generator)
                d = np.stack([self.noise.drawn(len(run.t), generator)[1] for _ in range(count)], axis=1)
                # what colour the innovations keep belongs to the force: the rounding has its own
                force = white.innovations(sampling.forced(d))[STEER.order :] * white.sure[STEER.order :, None]
                out.append(white(sampling.read(rounding)) + force)
            else:
                z = generator.standard_normal((len(run.t) - 3 - STEER.order, count))
                out.append(z * white.sure[STEER.order :, None])
        return np.concatenate(out)

    def settle(self) -> MotionFit:
        """Estimate the noise, the motion and the declared law from each other; the last fit."""
        reading, force = (max(one) for one in zip(*(run.least for run in self.runs), strict=True))
        self.least = Noise(reading, force / self.declared.mass)
        # with friction free the sign of the velocity is known well enough for a first law
        self.law = self._plain()
        self.lay()
        noise = fitted(self._rows(self._left(self.law)), self.least)
        for _ in range(STEER.rounds):
            self.lay()
            self.take(noise)
            fit = self.fit(law=self.law)
            # a better law may show another noise: it is sought anew, from everywhere
            noise = fitted(self._rows(self.residual(fit)), self.least)
            for _ in range(STEER.rounds - 1):
                self.take(noise)
                fit = self.fit(law=self.law)
                noise = fitted(self._rows(self.residual(fit)), self.least, noise)
            self.take(noise)
            fit = self.fit(law=self.law)
            rows = self._rows(self.residual(fit))
            self.law = fit.law
            self.runs = tuple(moved(run, noise, own) for run, own in zip(self.runs, rows, strict=True))
        self.lay()
        self.take(noise)
        return self.shorter(self.renoised(self.fit(law=self.law)))

    def _plain(self) -> Law:
        """A first law by least squares, with the declared mass, of the velocity as smoothed."""
        m = self.declared.mass
        parts = []
        for run, base in zip(self.runs, np.split(self.base, np.cumsum(self.lengths)[:-1]), strict=True):
            sure = ~run.rest[1:-1]
            a = np.gradient(run.v, run.dt)[1:-1]
            parts.append(np.column_stack([base, run.drive[1:-1] - m * a])[sure])
        rows = np.concatenate(parts)
        b = np.linalg.lstsq(rows[:, :3], rows[:, 3], rcond=None)[0]
        return Law(m, *(max(float(one), 0.0) for one in b))

    def _left(self, law: Law) -> Floats:
        numbers = np.array([0.0, law.minus, law.plus])
        return np.asarray(self.response - (self.drive - self.base @ numbers) / law.mass, dtype=np.float64)

    def _rows(self, residual: Floats) -> list[Rows]:
        parts = np.split(residual, np.cumsum(self.lengths)[:-1])
        return [Rows(r, s, d) for r, s, d in zip(parts, self.samplings, self.doubts, strict=True)]

    def renoised(self, fit: MotionFit, rounds: int = STEER.rounds - 1) -> MotionFit:
        """The fit with the noise that goes with it: in turn, as the noise hardly moves the fit."""
        for _ in range(rounds):
            noise = fitted(self._rows(self.residual(fit)), self.least, fit.noise)
            self.take(noise)
            fit = self.fit(fit.choices, fit.law)
        return fit

    def shorter(self, fit: MotionFit) -> MotionFit:
        """The fit in the likeliest of its own noise and of noises of short memory, everything fitted in each.

        Noise of long memory takes for its own what a slow effect does; with the effect in the fit it has less to do,
        and no small step from there leads to the noise that is left.
        """
        best = fit
        for pole in POLES[:-1]:
            noise = replace(fit.noise, pole=pole, filter=(1.0,))
            for _ in range(STEER.rounds - 1):
                self.take(noise)
                noise = fitted(self._rows(self.residual(self.fit(fit.choices, fit.law))), self.least, noise)
            self.take(noise)
            own = self.fit(fit.choices, fit.law)
            if own.deviance < best.deviance:
                best = own
        self.at(best)
        return best

    def columns(self, term: ForceTerm, inside: Floats, law: Law) -> Floats:
        """A candidate's columns (n, m) in N, as they act on the rows that are fitted."""
        return np.concatenate(
            [spread(term.columns(run, inside, law), run.sure if term.sliding else None) for run in self.runs]
        )

    def white_columns(self, term: ForceTerm, inside: Floats, law: Law) -> Floats:
        """The same in white units; the last ones are remembered."""
        key = (term.name, inside.tobytes(), law if term.scaled else None)
        if key not in self._kept:
            if len(self._kept) > STEER.remembered:
                self._kept.pop(next(iter(self._kept)))
            self._kept[key] = self.whitened(self.columns(term, inside, law))
        return self._kept[key]

    def whitened(self, rows: Floats) -> Floats:
        """Rows in white units."""
        parts = np.split(rows, np.cumsum(self.lengths)[:-1])
        return np.concatenate([white(part) for white, part in zip(self.whiteners, parts, strict=True)])

    def fit(self, choices: Sequence[Choice] = (), law: Law | None = None) -> MotionFit:
        """Fit the law's numbers and the candidates' amplitudes, their scanned numbers and the noise held.

        Parameters
        ----------
        choices
            Candidates; one named `rig_mass` frees the mass.
        law
            Friction with which candidates that scale with it are computed at first; None: from a fit without them.
        """
        if law is None:
            law = self.once((), self.law).law
        for _ in range(2 if any(one.term.scaled for one in choices) else 1):
            out = self.once(choices, law)
            law = out.law
        return out

    def held(self, choices: Sequence[Choice]) -> bool:
        """Is the mass as declared, exactly?"""
        return self.declared.uncertainty == 0 and not any(one.name == "rig_mass" for one in choices)

    def at(self, fit: MotionFit) -> None:
        """Go back to the white units of a fit."""
        if fit.noise is not self.noise:
            self.take(fit.noise)

    def design(self, choices: Sequence[Choice], law: Law) -> tuple[Floats, Floats]:
        """White response (n',) and columns (n', k): drive, law, candidates; the last row is the declared mass."""
        drive, parts = self._white_base[:, 0], []
        for one in choices:
            if one.name == "rig_mass":
                continue
            w = self.white_columns(one.term, one.inside, law)
            if one.term.fixed:
                drive = drive - w[:, 0]
            else:
                parts.append(-w)
        X = np.column_stack([drive, self._white_base[:, 1:], *parts])
        y = self._white_response
        if self.declared.uncertainty > 0 and not any(one.name == "rig_mass" for one in choices):
            last = np.zeros(X.shape[1])
            last[0] = self.declared.mass / self.declared.uncertainty
            X, y = np.vstack([X, last]), np.append(y, 1 / self.declared.uncertainty)
        return y, X

    def once(self, choices: Sequence[Choice], law: Law) -> MotionFit:
        """One fit with candidates that scale with friction computed with that of `law`."""
        y, X = self.design(choices, law)
        scale = lengths(X)
        if self.held(choices):
            b = np.zeros(X.shape[1])
            b[0] = 1 / self.declared.mass
            b[1:], rank = _solved((X / scale)[:, 1:], y - b[0] * X[:, 0])
            b[1:] /= scale[1:]
        else:
            b, rank = _solved(X / scale, y)
            b /= scale
        white = y - X @ b
        chi2 = float(white @ white)
        inside = sum(len(one.inside) for one in choices)
        return MotionFit(
            tuple(choices), self.law_of(b), self.amplitudes(choices, b), b, white[: len(self._white_response)],
            chi2, self._count, int(rank) + inside, self.noise, chi2 + self._determinant,
        )  # fmt: skip

    def law_of(self, b: Floats) -> Law:
        """The law of fitted coefficients: what is fitted of the damping is beside that of the sampling."""
        mass = 1 / float(b[0]) if b[0] > 0 else float("inf")
        rate = self.samplings[0].rate + float(b[1])
        return Law(mass, rate * mass, float(b[2]) * mass, float(b[3]) * mass)

    def amplitudes(self, choices: Sequence[Choice], b: Floats) -> tuple[Floats, ...]:
        """Coefficients of the candidates in N."""
        out, at = [], 4
        for one in choices:
            width = 0 if one.term.fixed or one.name == "rig_mass" else one.term.amplitudes
            out.append(b[at : at + width] / b[0] if b[0] > 0 else np.full(width, np.nan))
            at += width
        return tuple(out)

    def residual(self, fit: MotionFit) -> Floats:
        """What a fit leaves of the accelerations (n,), not whitened, of these runs or others."""
        law = fit.law
        y = self.response * law.mass - self.drive
        numbers = np.array([law.damping - self.samplings[0].rate * law.mass, law.minus, law.plus])
        y = y + self.base @ numbers
        for one, b in zip(fit.choices, fit.amplitudes, strict=True):
            if one.name != "rig_mass":
                c = self.columns(one.term, one.inside, law)
                y = y + (c[:, 0] if one.term.fixed else c @ b)
        return np.asarray(y / law.mass, dtype=np.float64)

    def predicted(self, fit: MotionFit) -> Floats:
        """Residual (n',) in white units of a fit to other runs: nothing is fitted here."""
        return self.whitened(self.residual(fit))

    def like(self, other: Balance) -> None:
        """Take the law and the noise of another balance, and smooth the motion with them."""
        self.law = other.law
        for _ in range(2):
            self.lay()
            rows = self._rows(self._left(self.law))
            self.runs = tuple(moved(run, other.noise, own) for run, own in zip(self.runs, rows, strict=True))
        self.lay()
        self.take(other.noise)

    def sharpen(self, choices: Sequence[Choice], law: Law, *, last: bool = False) -> MotionFit:
        """Fit the scanned numbers too, from where they are: all of them, or those of the last candidate alone."""
        moving = choices[-1:] if last else choices
        held = tuple(choices[: len(choices) - len(moving)])
        start = np.concatenate([np.zeros(0), *(np.log(np.abs(one.inside)) for one in moving)])
        if not start.size:
            return self.fit(choices, law)
        steps = np.concatenate([[self.step(one)] * len(one.inside) for one in moving])

        def at(z: Floats) -> tuple[Choice, ...]:
            out, k = list(held), 0
            for one in moving:
                part = slice(k, k + len(one.inside))
                inside = np.sign(one.inside) * np.exp(start[part] + steps[part] * z[part])
                out.append(Choice(one.term, inside))
                k = part.stop
            return tuple(out)

        def white(z: Floats) -> Floats:
            return self.once(at(z), law).white

        still, small = np.zeros(len(start)), np.full(len(start), STEP)
        solved = scipy.optimize.least_squares(
            white,
            still,
            diff_step=small,
            bounds=(-6, 6),
            max_nfev=POLICY.candidate_steps,
            ftol=1e-5,
            xtol=1e-3,
        )
        return self.fit(at(solved.x), law)

    def step(self, one: Choice) -> float:
        """Natural step of the logarithm of a scanned number: a wave's is that which slips a radian over the record."""
        if one.term.scanned == ("L",):
            return float(one.inside[0] / (2 * np.pi * max(np.ptp(run.x) for run in self.runs)))
        if one.term.scanned == ("w",):
            span = self.runs[-1].t[-1] - self.runs[0].t[0]
            return float(1 / (one.inside[0] * span))
        return 0.3


def _law_columns(run: DrivenRun, sampling: Sampling) -> Floats:
    """Velocity and the two directions of friction (n - 2, 3), in N for the law's numbers.

    Friction is held over each interval, and left to the noise where its sign is in doubt.
    """
    s = np.where(run.sure, run.sign[:-1], 0.0)
    sides = [np.convolve(one, sampling.held, mode="valid") for one in (np.minimum(s, 0), np.maximum(s, 0))]
    return np.column_stack([run.v[1:-1], *sides])


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
