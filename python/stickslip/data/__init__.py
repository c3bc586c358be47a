"""Recordings that come with the package, and one in closed form to try things on."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import unknown

__all__ = ["example", "examples", "stick_slip"]


def examples() -> tuple[str, ...]:
    """Return the names of the cases that come with the package."""
    return tuple(sorted(one.parent.name for one in _here().glob("*/rig.toml")))


def example(name: str = "paper_slider") -> Path:
    """Return the folder of a case that comes with the package, for `load_case`.

    Parameters
    ----------
    name
        "paper_slider": paper on paper pulled by a spring, 14.4 s at 2 kHz.

    Raises
    ------
    InputError
        There is no such case.
    """
    if name not in examples():
        raise unknown("example", name, examples())
    return _here() / name


def stick_slip(noise: float = 1e-6) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a record of a block that sticks and slips: 0.5 kg on a spring of 500 N/m, on a belt at 10 mm/s.

    Friction is Coulomb's, 2.0 N at rest and 1.2 N in sliding. The motion is in closed form: a straight line in each
    stick, half an oscillation and a little more about 1.2 N / (500 N/m) in each slip.

    Parameters
    ----------
    noise
        Standard deviation of the noise on the readings [m]; the same numbers at every call.

    Returns
    -------
    t, x
        Times of 6 s at 500 Hz [s], and the spring's deflection [m], each (3000,).

    Examples
    --------
    >>> from stickslip import data
    >>> t, x = data.stick_slip()
    >>> print(f"slips begin at {x.max():.4f} m")
    slips begin at 0.0040 m
    """
    stiffness, static, kinetic, speed, omega = 500.0, 2.0, 1.2, 0.01, np.sqrt(500.0 / 0.5)
    t = 0.002 * np.arange(3000, dtype=np.float64)
    first, drop = static / stiffness / speed, (static - kinetic) / stiffness
    slip = 2 * (np.pi - np.arctan(drop * omega / speed)) / omega  # how long, up to the belt's speed again
    since = (t - first) % (slip + 2 * drop / speed)  # the onset before
    swing = kinetic / stiffness + drop * np.cos(omega * since) + speed / omega * np.sin(omega * since)
    ride = kinetic / stiffness - drop + speed * (since - slip)
    x = np.where(t < first, speed * t, np.where(since < slip, swing, ride))
    return t, x + noise * np.random.default_rng(0).standard_normal(t.size)


def _here() -> Path:
    return Path(str(files(__name__)))
