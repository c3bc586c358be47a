"""Records of a driven slider that determine little: what nothing moves has no number, and nothing is divided by it."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import stickslip as ss
from stickslip.discovery.driven_slider.fit import Balance, Choice
from stickslip.discovery.driven_slider.intervals import intervals
from stickslip.discovery.driven_slider.motion import Band, band, motion
from stickslip.discovery.driven_slider.search import possible
from stickslip.discovery.driven_slider.terms import Law, grids, terms

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
    over = band(T, x, drive, MASS)
    return Balance([motion("run", T, x, drive, over)], over, MASS)


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
    tried = grids(balance.runs, balance.band.cutoff)[term.scanned[0]]
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
    term, tried = TERMS["contact_compliance"], grids(balance.runs, balance.band.cutoff)["d"]
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
    x = np.where(np.mod(T, 4) < 1.3, 0.1 * np.cumsum(np.mod(T, 4) < 1.3) * DT, 0.0)
    x = np.maximum.accumulate(x)
    over = Band(20.0, np.ones(1), 1)
    run = motion("run", T, x, np.zeros_like(x), over)
    assert np.median(np.abs(run.v)) == 0.0
    assert len(grids([run], over.cutoff)["L"]) < 1000


def test_numbers_that_no_catalogue_allows_make_no_candidate() -> None:
    balance = balanced("to and fro")
    term = TERMS["friction_ripple"]
    fit = balance.fit([Choice(term, np.array([0.05]))])
    assert possible(fit)
    scaled = type(fit)(fit.choices, fit.law, (np.array([3.0, 0.0]),), fit.coefficients, fit.white, 1.0, 3)
    assert not possible(scaled)


@pytest.mark.parametrize("drive", ["none", "constant"])
def test_a_drive_that_never_changes_is_refused_in_a_line(drive) -> None:
    with pytest.raises(ss.InputError, match="the drive never changes"):
        balanced(drive)
