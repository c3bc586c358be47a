"""A fitted motion of a driven slider: candidates with their numbers, what they leave, and how likely it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.driven_slider.noise import Noise
from stickslip.likelihoods.driven_slider.terms import ForceTerm, Law

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Choice:
    """A candidate with its scanned numbers (k,)."""

    term: ForceTerm
    inside: Floats

    @property
    def name(self) -> str:
        """The candidate's name."""
        return self.term.name


@dataclass(frozen=True)
class DeclaredMass:
    """The declared mass [kg] and the relative standard uncertainty of what the motion says of it."""

    mass: float
    uncertainty: float = 0.0


@dataclass(frozen=True, eq=False)
class MotionFit:
    """A fitted motion.

    `choices` are the candidates in it, `amplitudes` their coefficients, `law` the declared law's numbers,
    `coefficients` those of all columns over the mass, `white` (n',) the residual in white units, 0 where friction is
    in doubt, the `count` of others being what is fitted, `chi2` its sum of squares with that of the declared mass,
    `freedom` how many numbers were fitted, `noise` that in whose white units; `deviance` is -2 log likelihood.
    """

    choices: tuple[Choice, ...]
    law: Law
    amplitudes: tuple[Floats, ...]
    coefficients: Floats
    white: Floats
    chi2: float
    count: int
    freedom: int
    noise: Noise
    deviance: float

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the candidates in it."""
        return tuple(one.name for one in self.choices)

    @property
    def per_reading(self) -> float:
        """chi2 over its degrees of freedom."""
        return self.chi2 / max(self.count - self.freedom, 1)

    @property
    def price(self) -> float:
        """Of a number in -2 log likelihood (BIC)."""
        return float(np.log(max(self.count, 1)))

    def parameters(self) -> dict[str, dict[str, float]]:
        """Every candidate's numbers under its catalogue names."""
        return {
            one.name: one.term.parameters(one.inside, b, self.law)
            for one, b in zip(self.choices, self.amplitudes, strict=True)
        }
