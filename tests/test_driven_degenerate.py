"""Records of a driven slider that determine little: what nothing moves has no number, and nothing is divided by it."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.discovery.driven_slider.search import possible
from stickslip.likelihoods.driven_slider.dictionary import tried
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import Choice, DeclaredMass
from stickslip.likelihoods.driven_slider.intervals import intervals
from stickslip.likelihoods.driven_slider.motion import band, motion
from stickslip.likelihoods.driven_slider.noise import Noise
from stickslip.likelihoods.driven_slider.terms import Law, grids, terms

MASS, DT = 12.0, 2e-3
RIG = ss.DrivenSlider(mass=MASS)
T = np.arange(2500) * DT
TERMS = {one.name: one for one in terms()}


def moved(drive, minus=7.0, plus=5.0, damping=30.0):
    """Positions (n,) under a drive that is held from sample to sample, by small steps."""
    x = v = 0.0
    out = np.empty(len(drive))
    for i, force in enumerate(drive):
        out[i] = x
        for _ in range(20):
            limit = plus if v > 0 or (v == 0 and force > 0) else minus
            if v == 0 and abs(force) <= limit:
                continue
            way = np.sign(v) if v else np.sign(force)
            new = v + DT / 20 * (force - damping * v - way * limit) / MASS
            v = 0.0 if new * v < 0 else new
            x += DT / 20 * v
    return out


@functools.cache
def balanced(kind, noise=1e-7):
    drive = DRIVES[kind]
    x = moved(drive) + noise * np.random.default_rng(0).standard_normal(len(drive))
    band(T, x, drive, MASS)
    out = Balance([motion("run", T, x, drive, MASS)], DeclaredMass(MASS))
    out.law = Law(MASS, 30.0, 7.0, 5.0)
    out.lay()
    out.take(Noise(noise, 1e-3))
    return out


TO_AND_FRO = 60 * np.sin(2.2 * T) + 25 * np.sin(8 * T + 1)
ONE_WAY = 40 + 5 * np.sin(3 * T) + 4 * np.sin(40 * T)
DRIVES = {
    "to and fro": TO_AND_FRO,
    "one way": ONE_WAY,
    "none": np.zeros_like(T),
    "constant": np.full_like(T, 60.0),
}


@pytest.mark.parametrize("name", [name for name, one in TERMS.items() if one.scanned])
@pytest.mark.parametrize("at", ["least", "greatest"])
@pytest.mark.parametrize("drive", ["to and fro", "one way"])
def test_intervals_of_what_the_record_does_not_determine_are_finite(name, at, drive) -> None:
    balance = balanced(drive)
    term = TERMS[name]
    tried = grids(balance.runs)[term.scanned[0]]
    inside = tried[[0 if at == "least" else -1]] * (
        1e-9 if at == "least" and name == "contact_compliance" else 1
    )
    fit = balance.fit([Choice(term, inside)], Law(MASS, 30.0, 7.0, 5.0))
    for one in intervals(balance, fit).effects[name].values():
        assert one.low is not None
        assert one.high is not None
        assert np.isfinite([one.low, one.high]).all()
        assert one.low <= one.high


def test_a_number_that_changes_nothing_may_be_anything_that_is_tried() -> None:
    balance = balanced("to and fro")
    term, tried = TERMS["contact_compliance"], grids(balance.runs)["d"]
    fit = balance.fit([Choice(term, np.array([1e-12]))], Law(MASS, 30.0, 7.0, 5.0))
    k = intervals(balance, fit).effects["contact_compliance"]["k"]
    assert k.low is not None
    assert k.high is not None
    assert k.low == pytest.approx(6.0 / tried[-1], rel=0.2)
    assert k.high == pytest.approx(6.0 / 1e-12, rel=0.2)


def test_friction_of_a_direction_never_taken_has_no_interval() -> None:
    balance = balanced("one way")
    law = intervals(balance, balance.fit()).law
    assert (law["kinetic"].low, law["kinetic"].high) == (None, None)
    assert law["kinetic_plus"].low is not None


def test_a_slider_that_mostly_rests_is_tried_at_the_waves_that_it_passes_when_it_moves() -> None:
    x = 0.1 * np.cumsum(np.mod(T, 4) < 1.3) * DT
    run = replace(
        balanced("to and fro").runs[0], reading=x, x=x, v=np.gradient(x, DT), rest=np.gradient(x) == 0
    )
    assert np.median(np.abs(run.v)) == 0.0
    assert len(grids([run])["L"]) < 1100


@pytest.mark.parametrize("name", ["drive_lag", "contact_compliance", "stribeck_peak", "position_ripple"])
def test_a_number_at_the_end_of_what_is_tried_is_none(name) -> None:
    term = TERMS[name]
    own = grids(balanced("to and fro").runs)
    ends = own[term.scanned[0]]
    for value, right in ((ends.min(), False), (ends.max(), False), (np.median(ends), True)):
        assert tried(own, [Choice(term, np.array([value]))]) is right


def test_numbers_that_no_catalogue_allows_make_no_candidate() -> None:
    balance = balanced("to and fro")
    term = TERMS["friction_ripple"]
    fit = balance.fit([Choice(term, np.array([0.05]))])
    assert possible(fit)
    scaled = replace(fit, amplitudes=(np.array([3.0, 0.0]),))
    assert not possible(scaled)


@pytest.mark.parametrize("drive", ["none", "constant"])
def test_a_drive_that_never_changes_is_refused_in_a_line(drive) -> None:
    with pytest.raises(ss.InputError, match="the drive never changes"):
        balanced(drive)
