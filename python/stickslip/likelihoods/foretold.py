"""How likely a run never fitted is under what was forecast of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import soft

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


def deviance(members: Floats, noise: Floats, readings: Floats, read: Mask, knee: float = np.inf) -> float:
    """
    Return -2 log of the density of readings to come, a constant apart.

    Members are taken as draws of one normal distribution: what lies off their mean in a way in which they differ from
    each other is likely, as the time of the next slip; what lies off in another way is noise or an error.

    Parameters
    ----------
    members : (m, n, channels) forecasts, without noise
    noise : (channels,) standard deviations
    readings : (n, channels)
    read : (n, channels) where one was taken
    knee : chi-squared per reading beyond which a forecast counts by its logarithm, as a window of a fit does: one that
        goes astray says no more than that
    """
    variance = np.broadcast_to(noise**2, readings.shape)[read]
    mean = members.mean(axis=0)
    off = (readings - mean)[read] / np.sqrt(variance)
    apart = (members - mean)[:, read] / np.sqrt(variance * (len(members) - 1))
    among = (
        np.eye(len(members)) + apart @ apart.T
    )  # the matrix inversion lemma: members are few, readings many
    along = apart @ off
    chi = np.array([off @ off - along @ np.linalg.solve(among, along)])
    volume = np.linalg.slogdet(among)[1] + np.log(variance).sum()
    return float(soft(chi, np.array([knee * len(off)]))[0] + volume)
