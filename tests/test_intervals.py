"""Runs of True in a mask, against a count by hand."""

from itertools import groupby

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stickslip.measured.intervals import intervals


@given(st.lists(st.booleans(), max_size=60), st.integers(1, 4))
def test_runs_are_those_that_a_walk_along_the_mask_meets(mask: list[bool], apart: int) -> None:
    found = intervals(np.array(mask, dtype=bool), apart)
    met: list[list[int]] = []
    at = 0
    for holds, members in groupby(mask):
        length = len(list(members))
        if holds and met and at - met[-1][1] <= apart:
            met[-1][1] = at + length - 1
        elif holds:
            met.append([at, at + length - 1])
        at += length
    assert found.tolist() == met
