"""The order of the tests."""

from __future__ import annotations

import sys

import pytest

from stickslip.discovery.discover import discover


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first: a long one that begins last would be waited for by a core alone.

    Each is run by one process (see below): what a file makes once is not made twice.
    """
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Of several processes (`-n 2`) each takes whole files, in the order above, unless a way to share is asked for."""
    if getattr(config.option, "numprocesses", None) and config.option.dist == "no":
        config.option.dist, config.option.loadscopereorder = "loadfile", False


def pytest_configure() -> None:
    """A search starts no processes beside its own, unless it is asked for: tests run side by side, and patch."""
    sys.modules[discover.__module__].MOST_CORES = 1  # type: ignore[attr-defined]
