"""A search that names few effects: for tests of what is said of one, not of what stands beside it."""

from dataclasses import replace

import pytest

from stickslip.discovery.general_rig import bench as general_rig
from stickslip.discovery.laboratory import block_bench, two_degree


def naming(monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    """Let a search in a laboratory name at most so many effects; half of its time goes into looking for a next one."""
    for bench in (block_bench, two_degree, general_rig):
        monkeypatch.setattr(bench, "POLICY", replace(bench.POLICY, most_effects=most))
