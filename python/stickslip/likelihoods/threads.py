"""How many threads windows are simulated in: those of a search; one in each process that works beside others."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_COUNT: ContextVar[int] = ContextVar("threads", default=1)


def threads() -> int:
    """Return how many there are to use here."""
    return _COUNT.get()


@contextmanager
def side_by_side(count: int) -> Iterator[None]:
    """Let windows be simulated in so many; what comes of them is the same."""
    token = _COUNT.set(count)
    try:
        yield
    finally:
        _COUNT.reset(token)
