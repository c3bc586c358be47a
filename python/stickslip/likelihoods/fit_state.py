"""Where a fit of windows stands, and what it costs there."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.event_windows import EventWindows
from stickslip.likelihoods.mixed import Solution, WindowProducts, taken
from stickslip.likelihoods.population import AnyScatter, factor

Floats = NDArray[np.float64]
LOST = 100.0  # chi-squared per reading of a window that cannot be simulated
BLANK = 1e-9
Windowed = EventWindows[Any, Any]


@dataclass
class Fit:
    """
    Where a fit stands.

    Parameters
    ----------
    windows : what is fitted
    at : (p,) coordinates of the shared numbers
    own : (w, own) the windows' own numbers
    population, noise : variances; noise is a factor of the declared variance, by channel
    linear : windows linearised there, weighted
    estimate : what they say of the population, None before the end
    knee : (w,) chi-squared beyond which a window counts by its logarithm
    steps : taken
    """

    windows: Windowed
    at: Floats
    own: Floats
    population: Any  # a `AnyScatter`, that of its windows
    noise: Floats
    knee: Floats
    linear: WindowProducts | None = None
    blocks: list[Floats | None] = field(default_factory=list, repr=False)
    deviance: float = np.inf
    solution: Solution | None = None
    steps: int = 0

    @property
    def freedom(self) -> Floats:
        """How many readings' worth of noise the windows' own numbers explain, by channel."""
        assert self.linear is not None
        assert self.solution is not None
        return taken(self.linear, factor(self.population, self.windows.places), self.solution, self.noise)

    @property
    def random(self) -> Floats:
        """Random effects of the windows, (w, effects)."""
        return self.own[:, self.windows.begins :]

    def values(self, run: int = 0) -> dict[str, float]:
        """Numbers of a run by name."""
        return self.windows.values(self.at, run)


def begin(windows: Windowed) -> Fit:
    """Return a fit at the declared numbers."""
    count = len(windows.stretches)
    at = np.array([one.start for one in windows.numbers])
    return Fit(
        windows, at, windows.first(), windows.scatter(), np.ones(windows.channels), np.full(count, np.inf)
    )


def misfits(fit: Fit) -> Floats:
    """Chi-squared by window where it is linearised; of one that failed, a large one."""
    assert fit.linear is not None
    chi = fit.linear.gram[:, :, -1, -1] @ (1.0 / fit.noise)
    lost = np.array([b is None for b in fit.blocks])
    return np.where(lost, LOST * fit.windows.sizes, chi)


def unexplained(fit: Fit) -> float:
    """Return chi-squared per reading of the median window, over the noise that is declared or seen."""
    chi = misfits(replace(fit, noise=np.ones(fit.windows.channels)))
    return float(np.median(chi / (fit.windows.sizes * fit.windows.channels)))


def soft(chi: Floats, knee: Floats) -> Floats:
    """Return chi-squared, that beyond the knee by its logarithm."""
    return np.where(chi > knee, knee * (1 + np.log(np.maximum(chi / knee, 1.0))), chi)


class Cost:
    """Penalised cost of windows at a population."""

    def __init__(self, fit: Fit, population: AnyScatter, noise: Floats) -> None:
        self.fit, self.noise = fit, noise
        roots = factor(population, fit.windows.places)
        covariance = roots @ roots.transpose(0, 2, 1)
        e = covariance.shape[1]
        # a scatter that is nothing holds its effects where they are
        self.inverse = np.linalg.inv(covariance + BLANK * np.eye(e))[fit.windows.runs]

    def of(self, blocks: list[Floats | None], own: Floats) -> tuple[Floats, Floats]:
        """Chi-squared and penalty of each window."""
        chi = np.array(
            [
                LOST * size if b is None else float((b[:, :, -1] ** 2).sum(0) @ (1.0 / self.noise))
                for b, size in zip(blocks, self.fit.windows.sizes, strict=True)
            ]
        )
        u = own[:, self.fit.windows.begins :]
        return soft(chi, self.fit.knee), np.einsum("wi,wij,wj->w", u, self.inverse, u)

    def total(self, blocks: list[Floats | None], own: Floats, at: Floats) -> tuple[Floats, float]:
        """Cost by window, and of all with the prior."""
        chi, held = self.of(blocks, own)
        each = chi + held
        return each, float(each.sum()) + self.fit.windows.prior.penalty(at)
