"""Names that leave far more than the noise are not claimed: they stand in for what is not in the catalogue."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from stickslip.discovery.loop import _stood_in_for


def trial(chi2, cost=0.0, names=("belt_seam", "harmonic_forcing")):
    return SimpleNamespace(names=names, chi2=chi2, fit=SimpleNamespace(cost=cost))


@pytest.mark.parametrize(
    ("before", "after", "claimed"),
    [
        (100.0, 1.02, True),
        (100.0, 1.25, True),
        (100.0, 1.5, False),
        (1000.0, 2.9, True),
        (1000.0, 5.0, False),
    ],
)
def test_names_stand_only_if_little_is_left(before, after, claimed):
    tried = {("belt_seam",): trial(9.0, 500.0), ("harmonic_forcing",): trial(8.0, 400.0)}
    place = _stood_in_for(SimpleNamespace(tried=tried), trial(before), trial(after))
    assert place == (None if claimed else ("block", ("t",)))


def test_the_place_is_that_of_the_name_that_explains_most_alone():
    search = SimpleNamespace(tried={("belt_seam",): trial(3.0, 100.0)})
    assert _stood_in_for(search, trial(100.0), trial(4.0)) == ("contact", ("x1", "t"))
