"""Rivals that come near: effects and learned curves, each once, by what they leave with their price."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from stickslip.discovery import evidence, outcome
from stickslip.discovery.choice import Choice
from stickslip.discovery.evidence import TIED, alternatives
from stickslip.discovery.unlisted import READINGS, TERMS, Term, called


def trial(names, bic, partial=False):
    return SimpleNamespace(names=names, bic=bic, partial=partial, fit=names)


@pytest.fixture(autouse=True)
def no_fits(monkeypatch):
    monkeypatch.setattr(evidence, "of_effect", lambda fit, label: {f"{label} of {len(fit)}": 1.0})
    monkeypatch.setattr(evidence, "correlation", lambda *_: 0.5)


def test_every_curve_has_a_name_of_its_own():
    every = [Term(where, one, (0.0, 1.0)) for where, variables in TERMS.items() for one in variables]
    every += [Term(f"{where} channel", one, (0.0, 1.0)) for where, some in READINGS.items() for one in some]
    names = {called(term.prefix) for term in every}
    assert len(names) == len(every)
    assert {
        "a curve on the contact in v_w",
        "a curve on the angle body in y2",
        "a curve of the x1 channel in t",
    } <= names


def test_a_curve_at_another_place_that_does_as_well_is_tied():
    chosen = trial(("tabulated_block_x1",), 1000.0)
    rivals = [
        chosen,
        trial(("tabulated_contact_x1",), 1000.0 + 2.5 * TIED),  # the same as the next, cruder
        trial(("tabulated_contact_x1",), 1000.0 + 0.9 * TIED),
        trial(("sensor_crosstalk",), 1000.0 + 2.9 * TIED),
        trial(("belt_seam",), 1000.0 + 3.1 * TIED),
        trial(("belt_seam",), 500.0, partial=True),  # of half of the readings
        trial(("belt_seam", "sensor_lag"), 1000.0),
        trial((), 1000.0),
    ]
    found = alternatives(chosen, rivals, "tabulated_block_x1")
    assert [(one.name, one.tied) for one in found] == [
        ("a curve on the contact in x1", True),
        ("sensor_crosstalk", False),
    ]
    assert found[0].odds == pytest.approx(math.exp(-0.45 * TIED))
    assert found[0].parameters == {}
    assert found[1].parameters == {"sensor_crosstalk of 1": 1.0}


def test_a_learned_curve_is_held_against_names_and_curves_alike(monkeypatch):
    chosen, other, named = (
        trial((n,), 1000.0) for n in ("tabulated_block_x1", "tabulated_contact_x1", "belt_seam")
    )
    monkeypatch.setattr(outcome.ev, "evidence", lambda *_: SimpleNamespace(weight=1.0))
    monkeypatch.setattr(
        outcome.ev, "alternatives", lambda _, rivals, name: (name, *(one.names[0] for one in rivals))
    )
    monkeypatch.setattr(
        outcome.unlisted, "curve", lambda *_: SimpleNamespace(term="f(x1)", period=None, guess=None)
    )
    monkeypatch.setattr(outcome, "of_effect", lambda *_: {})
    monkeypatch.setattr(outcome, "phases", lambda *_: {})
    made = Choice(trial((), 9000.0), chosen, Term("block", "x1", (0.0, 1.0)), [chosen, other])
    search = SimpleNamespace(tried={named.names: named})
    (found,) = outcome.effects(search, made, chosen, 10.0)
    name, *rivals = found.alternatives
    assert name == "tabulated_block_x1"
    assert set(rivals) == {"belt_seam", "tabulated_block_x1", "tabulated_contact_x1"}


def test_of_two_effects_each_has_rivals_beside_the_other():
    chosen = trial(("sensor_lag", "belt_seam"), 1000.0)
    rivals = [
        trial(("belt_seam", "sensor_delay"), 1001.0),
        trial(("sensor_lag", "static_aging"), 1002.0),
        trial(("static_aging", "friction_drift"), 990.0),
    ]
    lag, seam = (alternatives(chosen, rivals, name) for name in chosen.names)
    assert [one.name for one in lag] == ["sensor_delay"]
    assert lag[0].reason.startswith("without a driven run")
    assert [one.name for one in seam] == ["static_aging"]
