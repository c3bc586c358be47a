"""Which of many cases are left to `./run all`."""

from collections.abc import Iterable
from typing import Any

import pytest


def few(every: Iterable[Any], kept: Iterable[Any]) -> list[Any]:
    """Return the cases, marked `study` but for those that are `kept`."""
    every, kept = list(every), list(kept)
    assert all(one in every for one in kept), "a case that is none"
    left = pytest.mark.study
    return [
        one if one in kept else pytest.param(*(one if isinstance(one, tuple) else (one,)), marks=left)
        for one in every
    ]
