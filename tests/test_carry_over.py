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
            "runs never used are less likely with it, by 9 in -2 log likelihood over 8 forecasts (p = 0.01)",
        ),
        (
            Likelihood(3.0, 8, 0.04),
            "most of 8 forecasts of runs never used are less likely with it (p = 0.04)",
        ),
    ],
    ids=["error", "too little", "against", "against by ranks alone"],
)
def test_a_doubt_is_said_as_its_numbers_are(held: Likelihood | None, said: str) -> None:
    assert doubt(ErrorBlock("metric", 0.1, 0.2, 0.05, (), likelihood=held)) == said
