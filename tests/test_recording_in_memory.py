"""Recordings of columns in memory are those of a file with the same columns, and as critical."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import stickslip as ss

RIG = ss.Rig.from_si(m=2.5, J=6e-4, r=0.05, k1=600, k2=100, k3=200, c1=1.0, c2=1.5, length=0.01)
CHANNELS = {
    "t": ss.Channel("time", "s"),
    "x1": ss.Channel("block", "mm"),
    "y1": ss.Channel("angle", "rad"),
    "belt": ss.Channel("drum", "mm/s"),
}


def columns(n: int = 400) -> dict[str, np.ndarray]:
    t = 0.01 * np.arange(n)
    rng = np.random.default_rng(1)
    read = {"time": t, "block": 3 * np.sin(9 * t), "angle": 0.1 * np.cos(9 * t), "drum": 12 + 0 * t}
    noisy = {name: one + (name != "time") * 1e-3 * rng.standard_normal(n) for name, one in read.items()}
    return {**noisy, "remark": np.array(["text"] * n)}


@pytest.mark.parametrize("kind", [dict, pd.DataFrame])
def test_memory_and_file_are_one(tmp_path: Path, kind: type) -> None:
    pd.DataFrame(columns()).to_csv(tmp_path / "run.csv", index=False, float_format="%.17g")
    options = {
        "channels": CHANNELS, "belt_speed": "12 mm/s", "role": "validate", "noise": {"x1": 1e-3},
        "window": (0.5, 3.0),
    }  # fmt: skip
    filed = ss.load_recording(tmp_path / "run.csv", RIG, **options)
    held = ss.load_recording(kind(columns()), RIG, name="run", **options)
    for name in ("t", "x1", "y1", "belt"):
        np.testing.assert_array_equal(getattr(held, name), getattr(filed, name))
    for name in ("name", "role", "rig", "belt_speed", "noise", "factors", "findings"):
        assert getattr(held, name) == getattr(filed, name)


def test_names_of_channels_are_names_of_columns_unless_said() -> None:
    t = 0.05 * np.arange(100)
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    given = {"t": list(t), "x1": np.sin(t), "y1": np.cos(t), "belt": 0.1 + 0 * t}
    run = ss.load_recording(given, rig, belt_speed=0.1)
    np.testing.assert_array_equal(run.x1, np.sin(t))
    assert run.belt is not None
    assert (run.name, run.role) == ("recording", "train")


def test_what_is_held_does_not_change_with_what_was_given() -> None:
    given = columns()
    run = ss.load_recording(given, RIG, channels=CHANNELS, belt_speed="12 mm/s")
    before = run.x1.copy()
    given["block"] *= 2
    np.testing.assert_array_equal(run.x1, before)


def spoilt(**new: object) -> dict[str, object]:
    return {**columns(), **new}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            spoilt(block=np.r_[0.0, np.nan, np.zeros(398)]),
            "bench, column 'block': nan at sample 1 (counted from 0)",
        ),
        (spoilt(angle=np.zeros(399)), "bench, column 'angle': 399 numbers, but column 'time' has 400"),
        (spoilt(angle=np.zeros((400, 2))), "bench, column 'angle': has 2 dimensions; a column has 1"),
        (spoilt(angle=["a"] * 400), "bench, column 'angle': not numbers"),
        (
            spoilt(time=np.r_[0.0, 0.0, np.arange(1, 399)]),
            "bench, column 'time': 0 twice in a row",
        ),
        (
            {k: v for k, v in columns().items() if k != "angle"},
            "bench, column 'angle': missing; there are time, block, drum, remark",
        ),
        ({k: v[:5] for k, v in columns().items()}, "bench: 5 samples; a run needs at least 8"),
    ],
)
def test_what_cannot_be_used_is_refused(given: dict[str, object], said: str) -> None:
    with pytest.raises(ss.InputError, match=re.escape(said)):
        ss.load_recording(given, RIG, channels=CHANNELS, belt_speed="12 mm/s", name="bench")  # type: ignore[arg-type]


@pytest.mark.parametrize("given", [None, 3, np.zeros((9, 3))])
def test_what_is_neither_a_file_nor_columns_is_said(given: object) -> None:
    with pytest.raises(ss.InputError, match="source: must be the path of a file"):
        ss.load_recording(given, RIG)  # type: ignore[arg-type]


def test_a_rig_is_asked_for() -> None:
    with pytest.raises(ss.InputError, match="rig: must be"):
        ss.load_recording(columns(), "rig")  # type: ignore[arg-type]
