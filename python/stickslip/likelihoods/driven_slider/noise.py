"""The noise of a driven slider's record, its likelihood, and what is left when its colour is taken out.

The slider obeys `x2' = (F - friction - ...)/mass - damping/mass x2 + d`, with F and d held over each sampling interval,
and its position is read as `x + e`: e is white, d an autoregression of order 1. Without the velocity that is, exactly,

    x[k+1] - (1 + alpha) x[k] + alpha x[k-1] = held f[k] + before f[k-1],   alpha = exp(-damping dt/mass),

so that the residual of that line is `P e + B d`, P and B short filters. Its covariance is banded, and its banded
Cholesky factor, lower triangular in time, is the Kalman filter of the record: row k of the solution is what reading
k + 1 adds to all before it. That is why a drive that answers to the readings does not bias a fit: it answers to earlier
ones. While the sign of the velocity is in doubt friction may be anything up to its limit: there d has a white part of
that size more, and what such rows add to the others says nothing of the noise or of a force: they are left out, so that
the likelihood is that of the sure rows given all that came before them (a partial likelihood). What colour the
innovations keep is taken out by an autoregression of their own.

Sources: banded factor as filter, A. Harvey, "Forecasting, structural time series models and the Kalman filter", 1989,
chapter 3; partial likelihood, D. R. Cox, Biometrika 62, 1975, 269; closed loops, L. Ljung, "System identification",
1999, section 13.4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.likelihoods.driven_slider.policy import STEER

Floats = NDArray[np.float64]


POLES = (0.0, 0.8, 0.98)  # memory of the force noise where its likelihood is sought from


@dataclass(frozen=True)
class Sampling:
    """How a slider with damping/mass = `rate` [1/s] moves from sample to sample, `dt` s apart.

    Forces held over the interval after and the one before a sample add to the line above with `held` and `before`,
    per unit of `size`, their sum.
    """

    dt: float
    rate: float

    @cached_property
    def alpha(self) -> float:
        """What an interval leaves of the velocity."""
        return float(np.exp(-self.rate * self.dt))

    @cached_property
    def _moved(self) -> tuple[float, float]:
        """Way per velocity, and per acceleration, within an interval; series where they cancel."""
        z = self.rate * self.dt
        if abs(z) < 1e-4:
            return self.dt * (1 - z / 2 + z * z / 6), self.dt**2 * (1 / 2 - z / 6 + z * z / 24)
        way = -float(np.expm1(-z)) / self.rate
        return way, (self.dt - way) / self.rate

    @cached_property
    def size(self) -> float:
        """Sum of the weights [s^2]."""
        way, accelerated = self._moved
        return accelerated + way**2 - self.alpha * accelerated

    @cached_property
    def held(self) -> Floats:
        """Weights (2,) of the intervals after and before, sum 1."""
        way, accelerated = self._moved
        return np.array([accelerated, way**2 - self.alpha * accelerated]) / self.size

    @cached_property
    def position(self) -> Floats:
        """Weights (3,) of x[k+1], x[k], x[k-1]: an acceleration."""
        return np.array([1.0, -(1 + self.alpha), self.alpha]) / self.size

    def read(self, x: Floats) -> Floats:
        """What positions (n, ..) say (n - 2, ..)."""
        coming, now, last = self.position
        return np.asarray(coming * x[2:] + now * x[1:-1] + last * x[:-2], dtype=np.float64)

    def forced(self, d: Floats) -> Floats:
        """What forces (n, ..), held over the interval after each sample, add to that (n - 2, ..)."""
        after, before = self.held
        return np.asarray(after * d[1:-1] + before * d[:-2], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Noise:
    """The noise of a record.

    `reading` [m] is the standard deviation of e, `force` [m/s^2] that of what is new in d, `pole` d's memory per
    sample; `filter` (1, h[1], ..., h[m]) whitens the innovations that are left.
    """

    reading: float
    force: float
    pole: float = 0.0
    filter: tuple[float, ...] = (1.0,)

    @property
    def std(self) -> float:
        """Standard deviation of d [m/s^2]."""
        return self.force / float(np.sqrt(1 - self.pole**2))

    def drawn(self, n: int, generator: np.random.Generator) -> tuple[Floats, Floats]:
        """Realisations (n,) of e and d."""
        e = self.reading * generator.standard_normal(n)
        w = generator.standard_normal(n + 4000)
        d = scipy.signal.lfilter([self.force], [1.0, -self.pole], w)
        return e, np.asarray(d[-n:], dtype=np.float64)


class Whitener:
    """Takes the colour of a noise out of residuals of one run.

    Parameters
    ----------
    noise, sampling
        What to take out; how the run is sampled.
    doubt
        Variance (n,) of friction over the mass, held over the interval after each of the run's n samples; 0 where the
        sign of the velocity is known.

    Notes
    -----
    Residuals are (n - 2,), one a sample but the first and the last; of the white ones `1 + order` are lost. They are
    0 where friction in doubt reaches; `sure` is where it does not, `count` how many of them are kept.
    """

    def __init__(self, noise: Noise, sampling: Sampling, doubt: Floats) -> None:
        self.noise = noise
        colour = np.array([1.0, -noise.pole])
        self.c_e = noise.reading * np.convolve(colour, sampling.position)
        c_w, c_q = noise.force * sampling.held, np.convolve(colour, sampling.held)
        n = len(doubt) - 3  # rows: samples 2 to n - 2
        self.band = np.zeros((4, n))
        for j, one in enumerate(_lags(self.c_e)):
            self.band[j] += one
        for j, one in enumerate(_lags(c_w)):
            self.band[j] += one
        for j in range(3):
            for i in range(3 - j):
                # row r is of sample r + 2, and holds force number i of the interval that begins at r + 2 - i
                self.band[j] += c_q[i] * c_q[i + j] * doubt[2 - i : 2 - i + n]
        self.sure = (doubt[2:-1] == 0) & (doubt[1:-2] == 0) & (doubt[:-3] == 0)
        self.factor = scipy.linalg.cholesky_banded(self.band, lower=True, check_finite=False)

    @property
    def count(self) -> int:
        """White residuals that say something."""
        return int(np.count_nonzero(self.sure[STEER.order :]))

    @property
    def log_determinant(self) -> float:
        """Of the factor that is divided by, squared, over the rows that say something."""
        return 2 * float(np.sum(np.log(self.factor[0][STEER.order :][self.sure[STEER.order :]])))

    def innovations(self, rows: Floats) -> Floats:
        """White but for what colour is left: (n - 3, m) of residuals (n - 2, m)."""
        own = rows[1:] - self.noise.pole * rows[:-1]
        if own.ndim == 2 and own.shape[1] >= STEER.together:
            return self._together(own)
        return self._solved(own)

    def _solved(self, rows: Floats, *, transposed: bool = False) -> Floats:
        columns = np.asfortranarray(rows.reshape(len(rows), -1))
        out, _ = scipy.linalg.lapack.dtbtrs(self.factor, columns, uplo="L", trans="T" if transposed else "N")
        return np.ascontiguousarray(out).reshape(rows.shape)

    def _together(self, rows: Floats) -> Floats:
        """The same for many columns: a row at a time costs less than a column at a time."""
        out = np.ascontiguousarray(rows)
        f = self.factor
        for k in range(len(out)):
            first = max(k - 3, 0)
            back = np.array([f[k - i, i] for i in range(first, k)])
            if k:
                out[k] -= back @ out[first:k]
            out[k] /= f[0, k]
        return out

    def __call__(self, rows: Floats) -> Floats:
        """White residuals (n - 3 - order, m) of residuals (n - 2, m)."""
        w = self.innovations(rows)
        out = w[STEER.order :].copy()
        for j, h in enumerate(self.noise.filter[1:], 1):
            out += h * w[STEER.order - j : len(w) - j]
        out[~self.sure[STEER.order :]] = 0.0
        return np.asarray(out, dtype=np.float64)

    def coloured(self, white: Floats) -> Floats:
        """A residual (n - 2, ..) of white numbers (n - 3, ..): the inverse, but for what came before."""
        v = scipy.signal.lfilter([1.0], self.noise.filter, white, axis=0).T
        own = np.zeros((*v.shape[:-1], v.shape[-1] + 1))
        own[..., 1:] = self.factor[0] * v
        for j in range(1, 4):
            own[..., 1 + j :] += self.factor[j, :-j] * v[..., :-j]
        return np.asarray(scipy.signal.lfilter([1.0], [1.0, -self.noise.pole], own).T)

    def reading_noise(self, rows: Floats) -> Floats:
        """The expected e (n,) behind residuals (n - 2,): what a smoother takes off the readings."""
        own = rows[1:] - self.noise.pole * rows[:-1]
        v = self._solved(self._solved(own), transposed=True)
        # row r holds e of samples r + 3, r + 2, r + 1, r
        return np.convolve(v, self.noise.reading * self.c_e[::-1])


def _lags(c: Floats) -> Floats:
    return np.asarray(np.correlate(c, c, "full")[len(c) - 1 :], dtype=np.float64)


@dataclass(frozen=True)
class Rows:
    """What the likelihood of a noise is of: a run's residuals (n - 2,), its sampling and its doubt."""

    residual: Floats
    sampling: Sampling
    doubt: Floats


def fitted(runs: Sequence[Rows], least: Noise, start: Noise | None = None) -> Noise:
    """Maximise the likelihood of residuals over reading noise, force noise and its memory; then whiten what is left.

    Parameters
    ----------
    runs
        Residuals of one or several runs.
    least
        Neither noise is taken smaller: nothing is known better than a record is written.
    start
        Where to begin; None: from the residuals' own size.
    """
    low = np.log([least.reading, least.force])
    bounds = [(low[0], low[0] + 30), (low[1], low[1] + 30), (0.0, 6.0)]

    def at(z: Floats) -> Noise:
        return Noise(float(np.exp(z[0])), float(np.exp(z[1])), float(np.tanh(z[2])))

    def deviance(z: Floats) -> float:
        return _deviance(at(z), runs)

    one = (
        _sized(start, runs, least)
        if start
        else min(_starts(runs, least), key=lambda one: _deviance(one, runs))
    )
    z = np.clip([np.log(one.reading), np.log(one.force), np.arctanh(one.pole)], *np.transpose(bounds))
    simplex = z + np.vstack([np.zeros(3), (0.3 if start else 0.7) * np.eye(3)])
    found = scipy.optimize.minimize(
        deviance, z, method="Nelder-Mead", bounds=bounds,
        options={"initial_simplex": simplex, "xatol": 0.01, "fatol": 0.05, "maxfev": 60 if start else 150},
    )  # fmt: skip
    return whitened(at(found.x), runs)


def _sized(noise: Noise, runs: Sequence[Rows], least: Noise) -> Noise:
    """The noise made as large as it is, its colour kept."""
    power, n = 0.0, 1
    for one in runs:
        white = Whitener(noise, one.sampling, one.doubt)
        w = white.innovations(one.residual)[white.sure]
        power, n = power + float(w @ w), n + len(w)
    size = float(np.sqrt(power / n))
    return replace(
        noise, reading=max(size * noise.reading, least.reading), force=max(size * noise.force, least.force)
    )


def _starts(runs: Sequence[Rows], least: Noise) -> list[Noise]:
    """Reading noise that leaves all of the residual or little of it, force noise of any size, short and long."""
    size = float(np.median([np.std(one.residual) for one in runs]))
    position = float(np.linalg.norm(runs[0].sampling.position))
    return [
        Noise(max(share * size / position, 2 * least.reading), float(force), pole)
        for share in (1.0, 0.01)
        for force in np.geomspace(2 * least.force, max(size, 4 * least.force), 12)
        for pole in POLES
    ]


def _deviance(noise: Noise, runs: Sequence[Rows]) -> float:
    """-2 log likelihood with the best colour of the innovations, priced; but for a constant."""
    try:
        return _whitened(noise, runs)[1]
    except np.linalg.LinAlgError:
        return 1e300


def whitened(noise: Noise, runs: Sequence[Rows]) -> Noise:
    """The noise with an autoregression of what its innovations leave; the order by Schwarz's criterion."""
    return _whitened(noise, runs)[0]


def _whitened(noise: Noise, runs: Sequence[Rows]) -> tuple[Noise, float]:
    """That noise, and -2 log likelihood with the price of the order."""
    r, n, fixed = np.zeros(STEER.order + 1), 1, 0.0
    for one in runs:
        white = Whitener(noise, one.sampling, one.doubt)
        w = np.where(white.sure, white.innovations(one.residual), 0.0)
        r += [float(w[k:] @ w[: len(w) - k]) for k in range(STEER.order + 1)]
        n += int(np.count_nonzero(white.sure))
        fixed += 2 * float(np.sum(np.log(white.factor[0][white.sure])))
    r /= n
    if r[0] < 0.5:  # less is left than the least noise
        return noise, n * float(r[0]) + fixed
    best, h = np.inf, np.ones(1)
    for order, (own, left) in enumerate(autoregressions(r)):
        score = n * left + float(np.log(n)) * order
        if score < best:
            best, h = score, own
    return replace(noise, filter=tuple(map(float, h))), best + fixed


def autoregressions(r: Floats) -> Iterator[tuple[Floats, float]]:
    """Of autocovariances (m + 1,): the filter (1, h[1], ..) of each order 0 to m, and the variance it leaves.

    One recursion gives all: N. Levinson, J. Math. Phys. 25, 1946, 261; J. Durbin, Rev. Int. Stat. Inst. 28, 1960, 233.
    """
    h, left = np.ones(1), float(r[0])
    yield h, left
    for order in range(1, len(r)):
        reflected = -float(h @ r[order:0:-1]) / left
        h = np.append(h, 0.0)
        h = h + reflected * h[::-1]
        left *= 1 - reflected**2
        yield h, left
