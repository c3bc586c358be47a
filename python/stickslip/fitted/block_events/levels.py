"""From the two ends of a slip to forces: what the contact carried at breakaway, and the level of sliding behind it.

The belt carries the block at its speed v_b up to the breakaway at x = S, so that the contact bears the spring and the
damper, static = k S + c v_b. In the slip m x'' + c x' + k x = kinetic, from S until x' is v_b again, at x = X. Without
damping kinetic = k (S + X)/2; damping shortens the fall, and the level follows from the same closed form (`cycle`),
with the frequency and the damping of the model.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Effect
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.fitted.block_events.cycle import LOG_W2, NUMBERS, RATE, RELEASE, ZETA, K, S, arrest

Floats = NDArray[np.float64]
ROUNDS = 60  # each leaves at most (1 - exp(-pi zeta/sqrt(1 - zeta^2)))/2 of the error: under a half


def number_of(model: Model, name: str, key: str) -> float:
    """A number of an effect of the model, 0 without the effect."""
    return next(
        (float(one.parameters[key]) for one in model.effects if isinstance(one, Effect) and one.name == name),
        0.0,
    )


def true_stiffness(model: Model) -> float:
    """The spring's stiffness, a declared one that is wrong corrected."""
    assert isinstance(model.rig, BlockOnBelt)
    return model.rig.stiffness * (1 + number_of(model, "rig_stiffness", "e"))


def damping(model: Model, speed: float) -> float:
    """Viscous damping c: declared, found, and what quadratic damping comes to in a slip of largest speed `speed`."""
    assert isinstance(model.rig, BlockOnBelt)
    squared = 8 * speed / (3 * np.pi) * number_of(model, "block_quadratic_damping", "c")
    return float(model.rig.damping + number_of(model, "block_viscous_damping", "c") + squared)


def carried(model: Model, x: Floats, speed: float) -> Floats:
    """Force on the contact while the belt carries the block at `speed`: k x + k3 x^3 + c v + c2 v^2.

    Parameters
    ----------
    model : Model
        Of a `BlockOnBelt`.
    x : array
        Deflections.
    speed : float
        Of the belt, positive.
    """
    cubic = number_of(model, "spring_cubic_k1", "k")
    squared = number_of(model, "block_quadratic_damping", "c") * speed**2
    return np.asarray(
        true_stiffness(model) * x + cubic * x**3 + damping(model, 0.0) * speed + squared, dtype=np.float64
    )


def sliding(model: Model, top: Floats, bottom: Floats, speed: float, log_w2: float) -> Floats:
    """Level of sliding of slips by their two ends.

    A cubic spring counts by its energy, (S^4 - X^4)/4 over S - X: exact without damping.

    Parameters
    ----------
    model : Model
        Of a `BlockOnBelt`.
    top, bottom : (e,) arrays
        Deflections at breakaway and at capture.
    speed : float
        Of the belt, at which both happen.
    log_w2 : float
        ln(k/m) of the model on this run.

    Returns
    -------
    (e,) array
        Forces.
    """
    stiffness, cubic = true_stiffness(model), number_of(model, "spring_cubic_k1", "k")
    w = float(np.exp(0.5 * log_w2))
    fastest = 0.5 * (top - bottom) * w
    p = np.zeros((len(top), NUMBERS))
    p[:, S], p[:, K], p[:, RELEASE], p[:, RATE], p[:, LOG_W2] = top, 0.5 * (top + bottom), 0.0, speed, log_w2
    p[:, ZETA] = [damping(model, float(u)) * w / (2 * stiffness) for u in fastest]
    for _ in range(ROUNDS):
        # without damping the capture lies as far below the level as the breakaway above it
        off = bottom - arrest(p)
        p[:, K] += 0.5 * off
        if np.all(np.abs(off) < 1e-9 * (top - bottom)):
            break
    return np.asarray(stiffness * p[:, K] + 0.25 * cubic * (top + bottom) * (top**2 + bottom**2))
