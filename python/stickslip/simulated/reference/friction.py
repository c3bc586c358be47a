"""The friction laws as `reference` reads them: magnitudes R(u), u = |v_w|, one analytic piece at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from stickslip.declared.friction import CoulombFriction, HyperbolicFriction, PaperFriction

Value = Any  # a float or complex number, or an array of either


@dataclass(frozen=True)
class Branch:
    """One direction of a friction law: static limit, R(u) below the kink, constant R beyond it."""

    static: float
    below: Callable[[Value], Value]
    above: float = 0.0
    kink: float | None = None


def branch(law: object, direction: int) -> Branch:
    """Magnitudes of `law` for slip with the sign `direction`: Table 1, Coulomb, hyperbolic."""
    if isinstance(law, PaperFriction):
        return _minus(law) if direction < 0 else _plus(law)
    if isinstance(law, CoulombFriction):
        static, kinetic = law.static, law.kinetic
        if direction > 0:
            static = static if law.static_plus is None else law.static_plus
            kinetic = kinetic if law.kinetic_plus is None else law.kinetic_plus
        return Branch(static, lambda u: kinetic + 0 * u)
    if isinstance(law, HyperbolicFriction):
        names = ("scale", "decay", "constant", "quadratic")
        plus = [getattr(law, f"{n}_plus") for n in names] if direction > 0 else [None] * 4
        a, d, c, q = (getattr(law, n) if p is None else p for n, p in zip(names, plus, strict=True))
        return Branch(a + c, lambda u: a / (1 + d * u) + c + q * u * u)
    raise TypeError(f"the reference knows no friction law {type(law).__name__}")


def _minus(law: PaperFriction) -> Branch:
    """T_- of (4.2), read as 0.28 - u, held at T_min_minus once it falls there."""
    end = abs(law.v_w_min)

    def curve(u: Value) -> Value:
        e1, e2 = np.exp(-(end - u) / law.t1), np.exp(-(end - u) / law.t2)
        return law.T_s_minus - law.A1 * e1 - law.A2 * e2

    with np.errstate(over="ignore"):
        high = end
        while curve(high) > law.T_min_minus and high < 1e6:
            high *= 2
        if curve(0.0) <= law.T_min_minus:
            return Branch(law.T_s_minus, lambda u: law.T_min_minus + 0 * u)
        if curve(high) > law.T_min_minus:  # amplitudes so small that it never gets there
            return Branch(law.T_s_minus, curve)
        kink = float(brentq(lambda u: curve(u) - law.T_min_minus, 0.0, high, xtol=1e-16, rtol=1e-15))

    def below(u: Value) -> Value:
        # a trial stage far beyond the kink must not meet the exponentials' blow-up
        return curve(np.where(u.real > kink + 0.05, kink + 0.05, u))

    return Branch(law.T_s_minus, below, law.T_min_minus, kink)


def _plus(law: PaperFriction) -> Branch:
    """T_+ of (4.1), held at T_min_plus beyond the fitted range."""
    slope = (law.T_s_plus - law.T_min_plus) / law.v_w_max
    return Branch(law.T_s_plus, lambda u: law.T_s_plus - slope * u, law.T_min_plus, law.v_w_max)
