"""How much friction and belt differ from event to event, and how far along the belt they stay alike."""

from __future__ import annotations

import math

import numpy as np

from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.fitted.identified import Scatter, Spread
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.correlated import likeness
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.memory import KINETIC, MOST, memory
from stickslip.likelihoods.population import STATIC
from stickslip.likelihoods.shown_levels import shown_levels


def scatter(fit: Fit, length: float) -> Scatter:
    """
    Return the scatter of a fit.

    Parameters
    ----------
    fit : at its best
    length : the rig's unit of x1 over that of the fit

    Intervals are those of a standard deviation from as many independent events as the correlated ones are worth:
    n (1 - m^2)/(1 + m^2) of them (Bartlett 1946), a share of 1/sqrt(2 n).
    """
    p = fit.population
    kinetic = p.declared().kinetic
    found, error = memory(fit, KINETIC)
    worth = max(len(fit.own) * (1 - found**2) / (1 + found**2), 2.0)

    def spread(value: float) -> Spread:
        return _spread(value, worth)

    alike = Spread(found, max(found - SIGMAS_95 * error, 0.0), min(found + SIGMAS_95 * error, MOST))
    way = None
    if alike.low > 0:
        windows = fit.windows
        assert isinstance(windows, BeltWindows)
        steps = [
            abs(windows.data[s.run].belt_speed)
            * (windows.data[s.run].t[s.stop - 1] - windows.data[s.run].t[s.start])
            for s in windows.stretches
        ]
        way = -float(np.mean(steps)) * length / math.log(found)
    static = math.sqrt(kinetic**2 + p.static**2 + 2 * likeness(fit) * kinetic * p.static)
    return Scatter(spread(static), spread(kinetic), spread(p.belt), alike, way)


def shown(fit: Fit) -> dict[str, Spread]:
    """
    Return the scatter that windows show by themselves, as if independent; none where the readings do not show it.

    It holds where no model does: a fit that is lost passes off as scatter what it lacks.
    """
    if (own := shown_levels(fit.windows, fit.at)) is None:
        return {}
    u = own[:, fit.windows.begins :]
    kinetic = u[:, fit.windows.kinetic].mean(axis=1)
    sizes = {"static": (1 + kinetic) * (1 + u[:, STATIC]), "kinetic": kinetic}
    return {name: _spread(float(np.std(one, ddof=1)), len(one)) for name, one in sizes.items()}


def _spread(value: float, worth: float) -> Spread:
    """A standard deviation of so many independent numbers."""
    factor = math.exp(SIGMAS_95 / math.sqrt(2 * worth))
    return Spread(value, value / factor, value * factor)
