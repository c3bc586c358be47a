"""The order of the tests."""

from __future__ import annotations

import gc
import sys

import numpy as np
import pytest

from stickslip.discovery.discover import discover


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """
    Cases beyond the sample of a test are studies; files with slow tests come first.

    A long one that begins last would be waited for by a core alone. Each file is run by one process (see below): what
    it makes once is not made twice.
    """
    cases: dict[tuple[object, str], list[pytest.Function]] = {}
    for item in items:
        if isinstance(item, pytest.Function) and item.get_closest_marker("sampled") is not None:
            cases.setdefault((item.path, item.originalname), []).append(item)
    for every in cases.values():
        marker = every[0].get_closest_marker("sampled")
        assert marker is not None
        kept = {round(at) for at in np.linspace(0, len(every) - 1, marker.args[0])}
        for place, case in enumerate(every):
            if place not in kept:
                case.add_marker(pytest.mark.study)
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Of several processes (`-n 2`) each takes whole files, in the order above, unless a way to share is asked for."""
    if getattr(config.option, "numprocesses", None) and config.option.dist == "no":
        config.option.dist, config.option.loadscopereorder = "loadfile", False


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """Cycles are looked for among what tests made, and seldom: among all the tests that took a tenth of the time."""
    gc.collect()
    gc.freeze()
    young, middle, _ = gc.get_threshold()
    gc.set_threshold(young, middle, 100)


def pytest_configure() -> None:
    """A search starts no processes beside its own, unless it is asked for: tests run side by side, and patch."""
    sys.modules[discover.__module__].MOST_CORES = 1  # type: ignore[attr-defined]
