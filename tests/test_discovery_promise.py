"""What unknowns promise to first order, against normal equations written out."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.discovery.promise import rest

RNG = np.random.default_rng(3)
WINDOWS, READINGS, LAW, OWN = 6, 40, 3, 2
J = RNG.standard_normal((WINDOWS, READINGS, LAW))
K = RNG.standard_normal((WINDOWS, READINGS, OWN))
NEW = RNG.standard_normal((WINDOWS, READINGS, 2))
R = 0.5 * RNG.standard_normal((WINDOWS, READINGS)) + NEW @ [0.3, -0.2]
PRECISION = np.array([0.0, 5.0, 300.0])


def base(r=R):
    blocks = [SimpleNamespace(J=J[i], K=K[i], r=r[i]) for i in range(WINDOWS)]
    engine = SimpleNamespace(precision=PRECISION, columns=[np.arange(LAW)])
    windows = [SimpleNamespace(run=0)] * WINDOWS
    return SimpleNamespace(
        fit=SimpleNamespace(vector=np.zeros(LAW), engine=engine, windows=windows, blocks=blocks)
    )


def left(columns, penalty, chosen=range(WINDOWS)):
    """Least squares over the law, what is added, and every window's own states, with the Gaussians' weights."""
    chosen, shared = list(chosen), LAW + columns.shape[2]
    rows = []
    for at, i in enumerate(chosen):
        own = np.zeros((READINGS, OWN * len(chosen)))
        own[:, OWN * at : OWN * (at + 1)] = K[i]
        rows.append(np.hstack([J[i], columns[i], own]))
    A = np.vstack([*rows, np.hstack([np.diag(np.sqrt(penalty)), np.zeros((shared, OWN * len(chosen)))])])
    b = np.concatenate([R[chosen].ravel(), np.zeros(shared)])
    return float(np.sum((b - A @ np.linalg.lstsq(A, b)[0]) ** 2))


@pytest.mark.parametrize("spread", [np.inf, 0.5])
def test_numbers_common_to_all_windows(spread):
    expected = left(NEW, [*PRECISION, *[spread**-2] * 2])
    assert rest(base(), list(NEW), spread=spread) == pytest.approx(expected)
    assert expected < left(NEW[:, :, :0], PRECISION)


def test_numbers_of_each_window():
    apart = np.zeros((WINDOWS, READINGS, 2 * WINDOWS))
    for i in range(WINDOWS):
        apart[i, :, 2 * i : 2 * i + 2] = NEW[i]
    expected = left(apart, [*PRECISION, *[0.0] * 2 * WINDOWS])
    assert rest(base(), list(NEW), own=True) == pytest.approx(expected)


def test_a_window_that_could_not_be_differentiated_is_left_out():
    some = [None if i == 2 else one for i, one in enumerate(NEW)]
    kept = [i for i in range(WINDOWS) if i != 2]
    assert rest(base(), some) == pytest.approx(left(NEW, [*PRECISION, 0.0, 0.0], kept))


def test_a_window_gone_astray_has_the_say_of_one():
    """Its residual, however large, weighs about as much as the number of its readings."""
    astray = R.copy()
    astray[2] *= 1e3
    assert rest(base(astray), list(NEW)) < rest(base(), list(NEW)) + 1.1 * READINGS
