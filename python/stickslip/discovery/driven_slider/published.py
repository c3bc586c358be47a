"""The published reference fits of EMPS, repeated: inverse dynamics by least squares, and the simulated loop.

Source: A. Janot, M. Gautier, M. Brunot, "Data set and reference models of EMPS", Workshop on Nonlinear System
Identification Benchmarks, Eindhoven, 2019. The fit there: position through a zero-phase Butterworth low-pass of order
4 at 100 Hz, central differences for velocity and acceleration, the first 49 samples dropped, drive and columns
decimated by 10 with a zero-phase Chebyshev low-pass (order 8, 0.05 dB, at 0.8 of the new Nyquist frequency), ordinary
least squares.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.simulated.driven_slider import Driven, Loop, closed_loop

Floats = NDArray[np.float64]

CUTOFF, ORDER = 100.0, 4  # Hz
BORDER = 49  # samples dropped at the start
DECIMATION = 10


@dataclass(frozen=True)
class InverseFit:
    """Least squares of the inverse dynamic model.

    Attributes
    ----------
    parameters : M [kg], Fv [N s/m], Fc [N], offset [N]; or M, Fv_plus, Fc_plus, Fv_minus, Fc_minus.
    deviations : standard deviation of each as published: residuals taken for white.
    relative_error : norm of the residual force over that of the force.
    t, force, residual : times, decimated drive and what the fit leaves of it (n,).
    """

    parameters: Mapping[str, float]
    deviations: Mapping[str, float]
    relative_error: float
    t: Floats
    force: Floats
    residual: Floats


def differentiated(t: Floats, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Position, velocity and acceleration (n,) as the published fit has them."""
    dt = float(np.median(np.diff(t)))
    b, a = scipy.signal.butter(ORDER, CUTOFF, fs=1 / dt)
    q = scipy.signal.filtfilt(b, a, x, padlen=3 * ORDER)
    v = np.gradient(q, dt)
    return q, v, np.gradient(v, dt)


def inverse_model(t: Floats, x: Floats, force: Floats, *, asymmetric: bool = False) -> InverseFit:
    """Fit M a + Fv v + Fc sgn(v) + offset = force, or friction for either direction without an offset.

    Parameters
    ----------
    t, x, force
        Times [s], position [m] and drive [N], (n,), sampled at 1 kHz.
    asymmetric
        Fv and Fc of their own for v > 0 (plus) and v < 0 (minus).
    """
    _, v, a = (one[BORDER:] for one in differentiated(t, x))
    s = np.sign(v)
    plus, minus = (1 + s) / 2, (1 - s) / 2
    if asymmetric:
        columns = {
            "M": a,
            "Fv_plus": v * plus,
            "Fc_plus": s * plus,
            "Fv_minus": v * minus,
            "Fc_minus": s * minus,
        }
    else:
        columns = {"M": a, "Fv": v, "Fc": s, "offset": np.ones_like(v)}
    X = np.column_stack([_decimated(one) for one in columns.values()])
    y = _decimated(force[BORDER:])
    b, *_ = np.linalg.lstsq(X, y, rcond=None)
    residual = y - X @ b
    spread = np.std(residual, ddof=1) * np.sqrt(np.diag(np.linalg.inv(X.T @ X)))
    names = list(columns)
    return InverseFit(
        dict(zip(names, map(float, b), strict=True)),
        dict(zip(names, map(float, spread), strict=True)),
        float(np.linalg.norm(residual) / np.linalg.norm(y)),
        t[BORDER:][_kept(len(v))],
        y,
        residual,
    )


def _kept(n: int) -> NDArray[np.intp]:
    """Samples that decimation keeps: every tenth, counted so that the last one of a whole block is there."""
    count = -(-n // DECIMATION)
    return np.arange(DECIMATION - (DECIMATION * count - n) - 1, n, DECIMATION)


def _decimated(x: Floats) -> Floats:
    b, a = scipy.signal.cheby1(8, 0.05, 0.8 / DECIMATION)
    return np.asarray(scipy.signal.filtfilt(b, a, x, padlen=24)[_kept(len(x))], dtype=np.float64)


@dataclass(frozen=True)
class LoopErrors:
    """Norm of the difference between simulated and measured over the norm of the measured."""

    position: float
    velocity: float
    acceleration: float
    force: float


def symmetric_model(parameters: Mapping[str, float]) -> Model:
    """The symmetric model as one of this package: the offset is a difference of friction between the directions."""
    Fc, offset = parameters["Fc"], parameters["offset"]
    law = CoulombFriction(
        static=Fc - offset, kinetic=Fc - offset, static_plus=Fc + offset, kinetic_plus=Fc + offset
    )
    return Model(DrivenSlider(mass=parameters["M"], damping=parameters["Fv"]), friction=law)


def loop_errors(
    model: Model, loop: Loop, t: Floats, reference: Floats, x: Floats, command: Floats
) -> tuple[Driven, LoopErrors]:
    """Simulate the loop and compare it with a record, as published.

    Parameters
    ----------
    model, loop
        What moves and what drives it.
    t, reference, x, command
        Times, set-point, measured position and recorded command (n,).
    """
    q, v, a = differentiated(t, x)
    run = closed_loop(model, loop, t, reference, start=(float(q[0]), 0.0))

    def error(measured: Floats, simulated: Floats) -> float:
        rest = measured[BORDER:] - simulated[BORDER:]
        return float(np.linalg.norm(rest) / np.linalg.norm(measured[BORDER:]))

    return run, LoopErrors(
        error(q, run.x), error(v, run.velocity), error(a, run.acceleration), error(command, run.command)
    )
