"""What a driven slider may have beyond its declared law: for each candidate the columns it adds to the force balance.

The balance is linear in the law's numbers and in a candidate's amplitudes; numbers inside a candidate (a wavelength, a
time constant) are scanned. A column c with coefficient b stands for -b c on the right side of mass x2' = F - ...,
so that F = mass x2' + damping x2 + T + sum b c.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import POSITION_RIPPLES as RIPPLES
from stickslip.likelihoods.driven_slider.motion import DrivenRun, instant
from stickslip.likelihoods.driven_slider.policy import STEER

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Law:
    """The declared law's numbers: mass, damping, kinetic friction for x2 < 0 and x2 > 0."""

    mass: float
    damping: float
    minus: float
    plus: float

    def friction(self, run: DrivenRun) -> Floats:
        """T (n,)."""
        return run.sign * np.where(run.sign > 0, self.plus, self.minus)


@dataclass(frozen=True)
class ForceTerm:
    """A candidate.

    Attributes
    ----------
    name : its name in the catalogue.
    scanned : names of the numbers inside it.
    amplitudes : how many columns it adds.
    columns : columns (n, amplitudes) of a run, from the scanned numbers (k,) and the law; where `many`, the scanned
        number may be an array (m,) of values, whose columns (n, m amplitudes) come side by side.
    parameters : the catalogue's parameters from scanned numbers and coefficients.
    fixed : its one column has the coefficient 1: all of the drive lags, or none.
    scaled : its columns go with the law's friction.
    sliding : it is friction, which may be anything while the sign of the velocity is in doubt.
    """

    name: str
    scanned: tuple[str, ...]
    amplitudes: int
    columns: Callable[[DrivenRun, Floats, Law], Floats]
    parameters: Callable[[Floats, Floats, Law], dict[str, float]]
    fixed: bool = False
    many: bool = False
    scaled: bool = False
    sliding: bool = False

    @property
    def size(self) -> int:
        """How many numbers it adds."""
        return len(self.scanned) + (0 if self.fixed else self.amplitudes)


def _one(
    name: str,
    parameter: str,
    column: Callable[[DrivenRun, Law], Floats],
    sign: float = 1.0,
    *,
    scaled: bool = False,
) -> ForceTerm:
    """A candidate with one amplitude and nothing inside; its parameter is `sign` times the coefficient."""
    return ForceTerm(
        name,
        (),
        1,
        lambda run, _, law: column(run, law)[:, None],
        lambda _, b, __: {parameter: sign * float(b[0])},
        scaled=scaled,
        sliding=scaled,
    )


def _wave(b: Floats) -> tuple[float, float]:
    """Amplitude and phase: -(b[0] cos + b[1] sin) = a sin(. + phi), as forces on the slider."""
    return float(np.hypot(b[0], b[1])), float(np.mod(np.arctan2(-b[0], -b[1]), 2 * np.pi))


def _pairs(turns: Floats, weight: Floats) -> Floats:
    """Cosine and sine of every column of `turns` (n, m), side by side (n, 2 m), times `weight` (n,)."""
    # within half a turn single precision is enough, and twice as fast
    angle = (turns - np.rint(turns)).astype(np.float32) * np.float32(2 * np.pi)
    both = np.empty((*angle.shape, 2), dtype=np.float32)
    np.cos(angle, out=both[..., 0])
    np.sin(angle, out=both[..., 1])
    both *= weight.astype(np.float32)[:, None, None]
    return both.reshape(len(turns), -1).astype(np.float64)


def _ripple(
    name: str, weight: Callable[[DrivenRun, Law], Floats], sign: float = 1.0, *, scaled: bool = False
) -> ForceTerm:
    """Something that goes with a sinusoid of the position."""

    def columns(run: DrivenRun, inside: Floats, law: Law) -> Floats:
        return _pairs(run.x[:, None] * (1 / inside), sign * weight(run, law))

    def parameters(inside: Floats, b: Floats, _: Law) -> dict[str, float]:
        a, phi = _wave(b)
        return {"a": a, "L": float(inside[0]), "phi": phi}

    return ForceTerm(name, ("L",), 2, columns, parameters, many=True, scaled=scaled, sliding=scaled)


def _harmonic() -> ForceTerm:
    def columns(run: DrivenRun, inside: Floats, _: Law) -> Floats:
        return _pairs(run.t[:, None] * (inside / (2 * np.pi)), np.ones(len(run.t)))

    def parameters(inside: Floats, b: Floats, _: Law) -> dict[str, float]:
        a, phi = _wave(b)
        return {"a": a, "w": float(inside[0]), "phi": phi}

    return ForceTerm("harmonic_forcing", ("w",), 2, columns, parameters, many=True)


def _stribeck() -> ForceTerm:
    def columns(run: DrivenRun, inside: Floats, _: Law) -> Floats:
        return np.asarray((run.sign * np.exp(-((run.v / inside[0]) ** 2)))[:, None])

    return ForceTerm(
        "stribeck_peak", ("v_s",), 1, columns, lambda i, b, _: {"dT": float(b[0]), "v_s": float(i[0])},
        sliding=True,
    )  # fmt: skip


def _thinning() -> ForceTerm:
    def columns(run: DrivenRun, inside: Floats, _: Law) -> Floats:
        return np.asarray((run.sign * -np.expm1(-np.abs(run.v) / inside[0]))[:, None])

    return ForceTerm(
        "viscous_saturation", ("v_s",), 1, columns, lambda i, b, _: {"dT": float(b[0]), "v_s": float(i[0])},
        sliding=True,
    )  # fmt: skip


def bristle(run: DrivenRun, d: float) -> Floats:
    """Relative bristle deflection z, |z| <= 1: dz/dx = (sgn(v) - z)/d, exact over each sample (n,)."""
    dx = np.diff(run.x)
    keep = np.exp(-np.abs(dx) / d)
    z = np.empty(len(run.x))
    z[0] = np.sign(run.v[0])
    s = np.sign(dx)
    for i in range(len(dx)):
        z[i + 1] = s[i] + (z[i] - s[i]) * keep[i]
    return z


def _compliance() -> ForceTerm:
    """Friction that follows a bristle instead of the sign: T z, with z as in `bristle`; 1/k = d/T."""

    def columns(run: DrivenRun, inside: Floats, law: Law) -> Floats:
        z = bristle(run, float(inside[0]))
        full = np.where(z > 0, law.plus, law.minus) * z
        return np.asarray((full - law.friction(run))[:, None])

    def parameters(inside: Floats, _: Floats, law: Law) -> dict[str, float]:
        return {"k": 0.5 * (law.minus + law.plus) / float(inside[0]), "c": 0.0}

    return ForceTerm(
        "contact_compliance", ("d",), 1, columns, parameters, fixed=True, scaled=True, sliding=True
    )


def _lag() -> ForceTerm:
    """The drive's force follows its command with a first-order lag: tau f' = command - f."""

    def columns(run: DrivenRun, inside: Floats, _: Law) -> Floats:
        return (run.drive - lagged(run, float(inside[0])))[:, None]

    return ForceTerm("drive_lag", ("tau",), 1, columns, lambda i, _, __: {"tau": float(i[0])}, fixed=True)


def lagged(run: DrivenRun, tau: float) -> Floats:
    """The lagged drive at the samples (n,), for a held command."""
    keep = np.exp(-run.dt / tau)
    at_end, _ = scipy.signal.lfilter([1 - keep], [1, -keep], run.command, zi=[keep * run.command[0]])
    at_start = np.concatenate([run.command[:1], at_end[:-1]])
    # mean over the interval that begins at each sample
    mean = run.command + (at_start - run.command) * (1 - keep) * tau / run.dt
    return instant(np.concatenate([mean[:1], 0.5 * (mean[1:] + mean[:-1])]))


def _delay() -> ForceTerm:
    def columns(run: DrivenRun, inside: Floats, _: Law) -> Floats:
        return np.asarray((run.drive - np.interp(run.t - inside[0], run.t, run.drive))[:, None])

    return ForceTerm(
        "drive_delay", ("delay",), 1, columns, lambda i, _, __: {"delay": float(i[0])}, fixed=True
    )


def terms() -> tuple[ForceTerm, ...]:
    """Every named candidate but `rig_mass`, which needs the declared mass."""
    return (
        _one("viscous_asymmetry", "c", lambda run, _: np.abs(run.v)),
        _one("block_quadratic_damping", "c", lambda run, _: run.v * np.abs(run.v)),
        _stribeck(),
        _thinning(),
        _compliance(),
        _one("position_load", "k", lambda run, _: run.x),
        _one("position_friction", "r", lambda run, law: law.friction(run) * run.x, scaled=True),
        _one("load_drift", "r", lambda run, _: run.t, -1.0),
        _one("friction_drift", "r", lambda run, law: law.friction(run) * run.t, scaled=True),
        _one("drive_gain_drift", "r", lambda run, _: run.drive * run.t, -1.0),
        _one("drive_nonlinearity", "q", lambda run, _: run.drive * np.abs(run.drive), -1.0),
        _lag(),
        _delay(),
        *(_ripple(name, lambda run, _: np.ones(len(run.t))) for name in RIPPLES),
        _ripple("friction_ripple", lambda run, law: law.friction(run), -1.0, scaled=True),
        _ripple("drive_ripple", lambda run, _: run.drive),
        _harmonic(),
    )


def usual_speed(run: DrivenRun) -> float:
    """Median speed; of the samples in motion, where the slider may be at rest at more than half of them."""
    moving = ~run.rest if np.mean(run.rest) > 0.5 else slice(None)
    return float(np.median(np.abs(run.v[moving])))


def grids(runs: Sequence[DrivenRun]) -> dict[str, Floats]:
    """Values to try of every scanned number, from what the runs can tell."""
    fastest = max(float(np.percentile(np.abs(run.v), 99)) for run in runs)
    slow = min(usual_speed(run) for run in runs if not run.rest.all())
    reach = max(float(np.ptp(run.x)) for run in runs)
    span = sum(float(run.t[-1] - run.t[0]) for run in runs)
    dt = runs[0].dt
    highest = STEER.highest / dt
    first, apart, most = STEER.fewest_waves, STEER.apart, STEER.most_waves
    waves = np.arange(first / reach, highest / slow, apart / reach)[:most]
    late = STEER.late * dt
    delays = np.linspace(-late / 3, late, STEER.values + 1)
    return {
        "v_s": np.geomspace(STEER.slowest * fastest, fastest, STEER.values),
        "d": np.geomspace(STEER.bristle[0] * reach, STEER.bristle[1] * reach, STEER.values),
        "tau": np.geomspace(0.1 * dt, 2 * late, STEER.values),
        "delay": delays[np.abs(delays) > 1e-9],
        "L": 1 / waves,
        "w": 2 * np.pi * np.arange(first / span, highest, apart / span)[:most],
    }
