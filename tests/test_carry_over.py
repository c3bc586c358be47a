"""Why names that the train runs give are not claimed: in words that the numbers beside them bear out."""

from __future__ import annotations

import pytest

from stickslip.discovery.carry_over import doubt
from stickslip.discovery.result import ErrorBlock, Likelihood


@pytest.mark.parametrize(
    ("held", "said"),
    [
        (None, "the error on runs never used RISES from 0.1 to 0.2"),
        (
            Likelihood(-4.0, 8, 0.2, spare=1.0),
            "runs never used are less likely with it, by 4 in -2 log likelihood: "
            "more than the 1 by which the train runs pass the gate",
        ),
        (
            Likelihood(-9.0, 8, 0.01),
            "runs never used are less likely with it, by 9 in -2 log likelihood over 8 events (p = 0.01)",
        ),
        (
            Likelihood(3.0, 8, 0.04),
            "most of 8 events of runs never used are less likely with it (p = 0.04)",
        ),
        (
            Likelihood(-2.0, 8, 0.3, spare=90.0),
            "the error on runs never used RISES from 0.1 to 0.2, and they are no more likely with it",
        ),
        (
            Likelihood(-9.0, 8, 0.2, spare=2.0, name="sensor_lag"),
            "runs never used are less likely with sensor_lag, by 9 in -2 log likelihood: "
            "more than the 2 by which the train runs pass the gate",
        ),
    ],
    ids=["error", "too little", "against", "against by ranks alone", "error and no gain", "of one effect"],
)
def test_a_doubt_is_said_as_its_numbers_are(held: Likelihood | None, said: str) -> None:
    error = ErrorBlock("metric", 0.1, 0.2, 0.05, (), likelihood=held)
    assert not error.carries
    assert doubt(error) == said


@pytest.mark.parametrize(
    ("held", "after", "carries"),
    [
        (None, 0.1, True),
        (None, 0.103, False),
        (Likelihood(3.0, 8, 0.6, spare=0.0), 0.2, True),
        (Likelihood(-0.5, 8, 0.4, spare=9.0), 0.1, True),
        (Likelihood(-0.5, 8, 0.4, spare=9.0), 0.2, False),
    ],
    ids=["nobody can tell", "an error that rises", "likelier", "no likelier", "no likelier, and further off"],
)
def test_an_error_that_rises_decides_where_likelihood_does_not(
    held: Likelihood | None, after: float, carries: bool
) -> None:
    assert ErrorBlock("metric", 0.1, after, 0.05, (), likelihood=held).carries == carries
