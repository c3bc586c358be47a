"""A learned curve in words: the plain formula that stays within its band."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_SHAPES: dict[str, Callable[[Floats], Floats]] = {
    "{0}": lambda x: x,
    "|{0}|": np.abs,
    "{0}^2": lambda x: x**2,
    "{0} |{0}|": lambda x: x * np.abs(x),
    "{0}^3": lambda x: x**3,
    "sgn({0})": np.sign,
}


def guess(x: Floats, value: Floats, half: Floats, variable: str) -> str | None:
    """
    Return a formula c0 + c1 f(x) that describes a curve, or None.

    Parameters
    ----------
    x, value, half : (n,) the curve, and half the width of its band
    variable : what x is called
    """
    for words, f in _SHAPES.items():
        A = np.stack([np.ones_like(x), f(x)], 1)
        c, *_ = np.linalg.lstsq(A / half[:, None], value / half, rcond=None)
        off = np.abs(A @ c - value)
        if np.mean(off < 1.5 * half) > 0.9 and np.sqrt(np.mean(off**2)) < 0.15 * np.std(value):
            return f"{c[1]:+.4g} {words.format(variable)} {c[0]:+.3g}"
    return None
