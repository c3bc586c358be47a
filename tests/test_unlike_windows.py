"""Windows with friction like no other's are no events, and go where they are few."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stickslip as ss
from scattering import MASS, STIFFNESS, Acting, block_case, block_runs
from stickslip.discovery.laboratory.block_bench import bench_of
from stickslip.discovery.laboratory.unused import stood_out
from stickslip.likelihoods.repeating import unlike

WINDOWS, KNOTS = 40, 3


def fit(static: float = 0.0, level: float = 0.0, belt: float = 0.0, bodies: bool = False) -> Any:
    """Random effects of windows that scatter by 0.01, one of them off by so much more."""
    u = 0.01 * np.random.default_rng(2).standard_normal((WINDOWS, KNOTS + 2))
    u[7] += [static, *[level] * KNOTS, belt]
    windows = SimpleNamespace(statics=(0,), kinetic=slice(1, 1 + KNOTS), belt=None if bodies else KNOTS + 1)
    return SimpleNamespace(random=u, windows=windows)


def test_what_scatters_is_like_the_others() -> None:
    assert not unlike(fit()).any()


@pytest.mark.parametrize("which", ["static", "level", "belt"])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_window_that_stands_out_is_unlike(which: str, sign: int) -> None:
    assert np.flatnonzero(unlike(fit(**{which: sign * 0.2}))).tolist() == [7]


def test_a_rig_without_a_belt_has_none_that_stands_out() -> None:
    assert not unlike(fit(belt=0.5, bodies=True)).any()


def test_few_windows_go_and_many_stay(tmp_path: Path) -> None:
    bench = bench_of(ss.load_case(block_case(tmp_path, few=True, seed=5)))[0]
    out = np.zeros(len(bench.stretches), dtype=bool)
    assert bench.less(out) is bench
    out[2] = True
    assert bench.less(out).stretches == [*bench.stretches[:2], *bench.stretches[3:]]
    out[: int(0.3 * len(out))] = True
    assert bench.less(out) is bench


def test_what_stood_out_is_said(tmp_path: Path) -> None:
    every = bench_of(ss.load_case(block_case(tmp_path, few=True, seed=5)))[0].stretches
    assert stood_out(every, every) == ()
    (said,) = stood_out(every, every[2:])
    assert said.startswith(f"2 of {len(every)} windows are not fitted: beside what was found their friction")


@pytest.mark.study
def test_a_ripple_is_found_without_what_was_no_stick(tmp_path: Path) -> None:
    """Of a belt whose speed comes and goes a window may begin where the block only rides as fast for a while."""
    rng, end = np.random.default_rng(1), 3.0
    often = 2.7 * math.sqrt(STIFFNESS / MASS)

    def runs() -> Iterator[tuple[str, float, list[Acting], tuple[float, float]]]:
        for name, speed in {"a": 0.06, "b": 0.11, "c": 0.08}.items():
            ripple = ss.effect("belt_speed_ripple", a=0.12, w=often, phi=rng.uniform(0, 6.28))
            wanders = ss.tabulated("contact", "t", np.linspace(0, end, 24), 0.03 * rng.standard_normal(24))
            yield name, speed, [ripple, wanders], (0.0, speed)

    found = ss.discover(ss.load_case(block_runs(tmp_path, runs(), end, rng)))
    assert [one.name for one in found.effects] == ["belt_speed_ripple"]
    numbers = found.effects[0].parameters
    assert numbers["w"].value == pytest.approx(often, rel=0.01)
    assert numbers["a"].value == pytest.approx(0.12, rel=0.05)
    assert any("windows are not fitted: beside what was found" in one for one in found.messages)
