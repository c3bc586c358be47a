"""What a fit says of its shared numbers where friction of neighbouring events is alike."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.memory import KINETIC, STATIC, memory
from stickslip.likelihoods.mixed import beyond_rounding, eliminated, inverse_of, turned
from stickslip.likelihoods.population import factor

Floats = NDArray[np.float64]


def covariance(fit: Fit) -> Floats:
    """
    Return the covariance of the shared numbers, (p, p), friction of neighbouring events correlated as it is found.

    The fit takes windows for independent: H is then what they say, and its inverse the covariance. Where their random
    effects are correlated as m^k over k events the estimate is unbiased still, and its covariance is H^-1 M H^-1 (Liang
    and Zeger, Biometrika 73, 1986), with M = H + sum over pairs of windows of a run of B_i m^|i-j| B_j': B_i is what a
    white effect of window i moves in the slopes of the likelihood. Within an event static and kinetic friction go
    together as they are found to, where the fit takes what is static friction's own for independent; over k events
    the two are remembered as m_static^k and m_kinetic^k of that, as a first-order recurrence of both has it.
    """
    assert fit.linear is not None
    windows, linear = fit.windows, fit.linear
    p, roots = linear.shared, factor(fit.population, windows.places)
    scaled = np.einsum("wcij,c->wij", linear.gram, 1.0 / fit.noise) * linear.weight[:, None, None]
    a = turned(scaled, roots[linear.run], fit.random, p + linear.own)
    white, local = roots.shape[2], slice(p, -1)
    root, seen = eliminated(a, p, linear.own)
    cross = seen[:, :, :p].transpose(0, 2, 1)
    told = a[:, :p, :p] - cross @ seen[:, :, :p]
    effects = a[:, local, local][:, :, linear.own :]
    moved = a[:, :p, local][:, :, linear.own :] - cross @ (root @ effects)
    _, prior = windows.prior.at(fit.at)
    whole = np.diagonal(a[:, :p, :p], axis1=1, axis2=2).sum(axis=0)
    schur = told.sum(axis=0) + prior
    schur[range(p), range(p)] = beyond_rounding(schur, whole)
    inverse = inverse_of(schur)
    between = np.zeros((p, p))
    like = _remembered(fit, roots)
    together = likeness(fit)
    for number, members in enumerate(windows.by_run):
        b = moved[members]
        event = np.eye(white)  # what effects of one event have in common
        event[0] += together * _kinetic(roots[number][windows.kinetic])
        event = event + event.T - np.eye(white)
        between += np.einsum("wpk,kl,wql->pq", b, event - np.eye(white), b)
        for lag in range(1, len(members)):
            pairs = np.einsum("wpk,kl,wql->pq", b[lag:], like[:, None] ** lag * event, b[:-lag])
            between += pairs + pairs.T
    return np.asarray(inverse + inverse @ between @ inverse)


def _remembered(fit: Fit, roots: Floats) -> Floats:
    """Return what of each white effect is left an event later, (white,); of the belt's nothing is."""
    slides = np.abs(roots[:, fit.windows.kinetic]).any(axis=(0, 1))
    like = np.where(slides, memory(fit, KINETIC)[0], 0.0)
    like[0] = memory(fit, STATIC)[0]
    return like


def likeness(fit: Fit) -> float:
    """
    Return the correlation of what is static friction's own in an event with its kinetic friction.

    Two levels that are remembered unequally long cannot be wholly alike: theirs is at most that of two first-order
    recurrences whose news are the same.
    """
    along = static = kinetic = 0.0
    for members in fit.windows.by_run:
        own, whole = fit.random[members, 0], fit.random[members, fit.windows.kinetic].mean(axis=1)
        if len(members) > 1:
            own, whole = own - own.mean(), whole - whole.mean()
            along += float(own @ whole)
            static, kinetic = static + float(own @ own), kinetic + float(whole @ whole)
    if not (static > 0 and kinetic > 0):
        return 0.0
    first, second = memory(fit, STATIC)[0], memory(fit, KINETIC)[0]
    most = math.sqrt((1 - first**2) * (1 - second**2)) / (1 - first * second)
    return float(np.clip(along / math.sqrt(static * kinetic), -most, most))


def _kinetic(root: Floats) -> Floats:
    """Weights of the white effects in the mean of the kinetic curve, of length 1; of the rows of that curve."""
    mean = root.mean(axis=0)
    return np.asarray(mean / max(float(np.linalg.norm(mean)), 1e-300))
