"""Products of many small matrices in one thread: several would wait for each other, on a busy machine without end."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

Given = ParamSpec("Given")
Result = TypeVar("Result")


def one_thread(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """Return a function that multiplies matrices in one thread, whatever the environment says."""

    @wraps(function)
    def call(*given: Given.args, **named: Given.kwargs) -> Result:
        with threadpool_limits(1):
            return function(*given, **named)

    return call
