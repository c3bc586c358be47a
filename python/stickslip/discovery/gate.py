"""The gate: how large the best of all rivals looks on this case's own noise, by parametric bootstrap of the scores.

At the declared law's fit each linear effect has a signature d (its sensitivity, law and states refitted, at zero
strength). Under noise alone the scores d.r/|d| are jointly normal with the signatures' correlations, so that the
bootstrap draws them directly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect import effect
from stickslip.discovery.result import Gate
from stickslip.discovery.search import Search, Trial
from stickslip.fitted.engine import Engine
from stickslip.fitted.solve import Fit
from stickslip.fitted.unknowns import Hypothesis, Unknown

Floats = NDArray[np.float64]
DRAWS = 2000
LEVEL = 0.01
LINEAR = tuple(  # at zero strength, with a shape where one is needed
    (kind.name, kind.scored_at) for kind in CATALOGUE.values() if kind.scored_at is not None
)


def largest_gain(search: Search, null: Trial) -> float:
    """How far the best single effect lowers chi-squared, less what its hidden states take up of the noise."""
    singles = [t for t in search.tried.values() if len(t.names) == 1]
    return max([null.fit.cost - t.fit.cost - t.hidden for t in singles] + [0.0])


def gate(null: Fit, observed: float, penalty: float, seed: int = 0) -> Gate:
    """Bootstrap of the largest score at the declared law's fit.

    `observed` is the largest fall of chi-squared that any rival reached, `penalty` what the choice demands; the
    threshold is the larger of that and of the quantile that noise passes once in a hundred.
    """
    D = signatures(null)
    size = np.sqrt(np.maximum(np.einsum("ij,ij->j", D, D), 1e-300))
    R = (D / size).T @ (D / size)
    values, vectors = np.linalg.eigh(R)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    z = np.random.default_rng(seed).standard_normal((DRAWS, len(values))) @ root.T
    draws = (z**2).max(axis=1)
    threshold = max(penalty, float(np.quantile(draws, 1 - LEVEL)))
    return Gate(observed, threshold, float(np.mean(draws > threshold)), np.sort(draws))


def signatures(null: Fit) -> Floats:
    """Signatures of the linear effects after refit, (readings, effects)."""
    base = null.engine.hypothesis.at(null.vector, len(null.engine.data)).model
    own = {one.name for one in base.effects}
    terms = [effect(name, **values) for name, values in LINEAR if name not in own]
    unknowns = tuple(
        Unknown(f"{t.name}.{p}", t.parameters[p], False, 0.0, 1.0)
        for t in terms
        for p in t.parameters
        if t.parameters[p] == 0
    )
    both = Hypothesis(base.with_effects([*base.effects, *terms]), unknowns, null.engine.hypothesis.phases)
    engine = Engine(null.engine.data, both, null.engine.threads, null.engine.learned)
    vector = np.zeros(len(unknowns))
    D, J = [], []
    found = engine.linearised(vector, null.windows)
    for w, b, more in zip(null.windows, null.blocks, found, strict=True):
        q = np.linalg.qr(b.K)[0]
        d = np.zeros((len(b.r), len(unknowns))) if more is None else np.nan_to_num(more.J)
        full = np.zeros((len(b.r), len(null.vector)))
        full[:, null.engine.hypothesis.columns(w.run)] = b.J
        D.append(d - q @ (q.T @ d))
        J.append(full - q @ (q.T @ full))
    signature, law = np.concatenate(D), np.concatenate(J)
    A = law.T @ law
    A += 1e-9 * np.trace(A) / len(A) * np.eye(len(A))
    return np.asarray(signature - law @ np.linalg.solve(A, law.T @ signature))
