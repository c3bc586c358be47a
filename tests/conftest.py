"""The order of the tests."""

from __future__ import annotations

import sys

import pytest

from stickslip.discovery.discover import discover


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first: a long one that begins last would be waited for by a core alone.

    Each is run by one process (`--dist loadfile` in `run`): what a file makes once is not made twice.
    """
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


def pytest_configure() -> None:
    """A search starts no processes beside its own, unless it is asked for: tests run side by side, and patch."""
    sys.modules[discover.__module__].MOST_CORES = 1  # type: ignore[attr-defined]
