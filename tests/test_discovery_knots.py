"""Where the knots of a learned curve lie, and that a curve within the noise is still tried on finer ones."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.discovery import unlisted
from stickslip.discovery.unlisted import FINE, KNOTS, SLOW, Term, knots_for, learn

SEEN = np.linspace(-0.4, 0.8, 20_001)
LOW, HIGH = np.quantile(SEEN, [0.001, 0.999])


@pytest.mark.parametrize("variable", ["x1", "v_w"])
def test_knots_reach_one_beyond_what_was_visited(variable):
    knots = np.array(knots_for(SEEN, KNOTS, variable))
    assert len(knots) == KNOTS + 2
    assert knots[1] == pytest.approx(LOW)
    assert knots[-2] == pytest.approx(HIGH)
    assert knots[0] < LOW < HIGH < knots[-1]
    assert (np.diff(knots) > 0).all()


def test_knots_are_even_but_for_slip_speeds():
    assert np.diff(knots_for(SEEN, FINE, "x1")) == pytest.approx((HIGH - LOW) / (FINE - 1))
    knots = np.array(knots_for(SEEN, FINE, "v_w"))
    gaps, middle = np.diff(knots), (knots[1:] + knots[:-1]) / 2
    even = np.diff(np.arcsinh(knots / (SLOW * 0.8)))
    assert even == pytest.approx(even[0], rel=1e-2)
    assert gaps[np.argmin(np.abs(middle))] == gaps.min()
    assert gaps[-2] > 3 * gaps.min()


def trial(chi2, excess, bic):
    return SimpleNamespace(chi2=chi2, excess=excess, bic=bic, fit=SimpleNamespace(cost=chi2))


def learned(monkeypatch, fine_bic):
    """What is learned where the coarse curve is within the noise."""
    terms = [Term("contact", v, knots_for(SEEN, KNOTS, v)) for v in ("v_w", "x1")]
    coarse = {"v_w": trial(1.009, 1.1, 500.0), "x1": trial(1.3, 40.0, 900.0)}
    fitted = []

    def with_term(_search, _base, term, **_):
        fitted.append((term.variable, len(term.knots)))
        return trial(1.0, 0.0, fine_bic) if len(term.knots) > KNOTS + 2 else coarse[term.variable]

    def submit(function, *args):
        return SimpleNamespace(result=lambda: function(search, *args), cancel=lambda: None)

    monkeypatch.setattr(unlisted, "terms", lambda _: terms)
    monkeypatch.setattr(unlisted, "gain", lambda _, term: 10.0 if term.variable == "v_w" else 5.0)
    monkeypatch.setattr(unlisted, "with_term", with_term)
    monkeypatch.setattr(unlisted, "ranges", lambda _: {"v_w": SEEN, "x1": SEEN})
    search = SimpleNamespace(
        left=100.0,
        budget=100.0,
        progress=lambda _: None,
        polish=lambda one, **_: one,
        sides=lambda one: [one],
        submit=submit,
        at_once=1,
        once=lambda _what, _of, compute: compute(),
    )
    return learn(search, trial(3.0, 200.0, 3000.0)), fitted


def test_a_curve_within_the_noise_is_tried_on_finer_knots(monkeypatch):
    curves, fitted = learned(monkeypatch, fine_bic=400.0)
    assert ("v_w", FINE + 2) in fitted
    assert ("x1", FINE + 2) not in fitted
    assert (curves[0][0].variable, len(curves[0][0].knots)) == ("v_w", FINE + 2)


def test_finer_knots_that_are_not_worth_their_number_are_dropped(monkeypatch):
    curves, _ = learned(monkeypatch, fine_bic=600.0)
    assert (curves[0][0].variable, len(curves[0][0].knots)) == ("v_w", KNOTS + 2)


def test_a_curve_is_fitted_again_while_the_motion_reaches_further(monkeypatch):
    reach, fitted = iter([1.2, 1.5, 1.52, 9.0]), []
    monkeypatch.setattr(unlisted, "ranges", lambda _: {"x1": next(reach) * SEEN})

    def with_term(_search, _base, term, **_):
        fitted.append(term.knots[-2] / HIGH)
        return trial(5.0 / fitted[-1], 50.0, 900.0 / fitted[-1])

    monkeypatch.setattr(unlisted, "with_term", with_term)
    search = SimpleNamespace(polish=lambda one, **_: one, sides=lambda one: [one])
    coarse = Term("y1 channel", "x1", knots_for(SEEN, KNOTS)), trial(9.0, 90.0, 1000.0)
    term, best = unlisted._finer(search, coarse, base=None)
    assert fitted == pytest.approx([1.2, 1.5])
    assert (len(term.knots), best.bic) == (FINE + 2, pytest.approx(600.0))
