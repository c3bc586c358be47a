"""A sweep's store that was damaged: lost parts are computed or written again, spoilt ones are named."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import stickslip as ss

MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())


@pytest.mark.parametrize("name", ["status", "final_state"])
def test_a_damaged_store_is_named(tmp_path: Path, name: str) -> None:
    out = tmp_path / "a.zarr"
    ss.sweep(MODEL, {"belt_speed": [0.1, 0.2]}, t_end=2, out=out)
    shutil.rmtree(out / name)
    shutil.rmtree(out / "status" / "c", ignore_errors=True)
    with pytest.raises(ss.InputError, match=f"no array '{name}': it is damaged"):
        ss.sweep(MODEL, {"belt_speed": [0.1, 0.2]}, t_end=2, out=out)


@pytest.mark.parametrize("name", ["status", "final_state", "period"])
@pytest.mark.parametrize("rest", [b"nothing of the kind", b""])
def test_a_chunk_that_cannot_be_read_is_named(tmp_path: Path, name: str, rest: bytes) -> None:
    out, over = tmp_path / "a.zarr", {"belt_speed": [0.1, 0.2]}
    first = ss.sweep(MODEL, over, t_end=2, observe=("final_state", "period"), out=out).load()
    (chunk,) = [one for one in (out / name / "c").rglob("*") if one.is_file()]
    chunk.write_bytes(rest)
    with pytest.raises(ss.InputError, match=rf"the chunk {chunk.relative_to(out)} is damaged") as refused:
        ss.sweep(MODEL, over, t_end=2, observe=("final_state", "period"), out=out)
    assert "remove that file" in str(refused.value)
    chunk.unlink()
    xr.testing.assert_identical(
        ss.sweep(MODEL, over, t_end=2, observe=("final_state", "period"), out=out).load(), first
    )


def test_a_lost_chunk_is_computed_again_and_one_of_fill_values_is_not_lost(tmp_path: Path) -> None:
    out, over = tmp_path / "a.zarr", {"belt_speed": [0.1, 0.2]}
    first = ss.sweep(MODEL, over, t_end=0.1, observe=("final_state", "period"), out=out).load()
    assert np.isnan(first.period).all()  # none: the fill value
    (chunk,) = [one for one in (out / "period" / "c").rglob("*") if one.is_file()]
    (lost,) = [one for one in (out / "final_state" / "c").rglob("*") if one.is_file()]
    before = chunk.stat().st_mtime_ns
    ss.sweep(MODEL, over, t_end=0.1, observe=("final_state", "period"), out=out)
    assert chunk.stat().st_mtime_ns == before
    lost.unlink()
    xr.testing.assert_identical(
        ss.sweep(MODEL, over, t_end=0.1, observe=("final_state", "period"), out=out).load(), first
    )


@pytest.mark.parametrize("harm", ["lost", "truncated"])
def test_a_coordinate_that_was_lost_is_written_again(tmp_path: Path, harm: str) -> None:
    out, over = tmp_path / "a.zarr", {"belt_speed": [0.1, 0.2], "alpha1": ("belt_speed2", [10.0, 12.0])}
    first = ss.sweep(MODEL, over, t_end=2, out=out).load()
    for name in ("belt_speed", "alpha1", "state"):
        (chunk,) = [one for one in (out / name / "c").rglob("*") if one.is_file()]
        if harm == "lost":
            chunk.unlink()
        else:
            chunk.write_bytes(chunk.read_bytes()[:5])
    xr.testing.assert_identical(ss.sweep(MODEL, over, t_end=2, out=out).load(), first)


def test_a_changed_byte_of_a_chunk_is_noticed(tmp_path: Path) -> None:
    out, over = tmp_path / "a.zarr", {"belt_speed": np.linspace(0.1, 0.2, 20)}
    ss.sweep(MODEL, over, t_end=2, out=out)
    (chunk,) = [one for one in (out / "final_state" / "c").rglob("*") if one.is_file()]
    data = bytearray(chunk.read_bytes())
    data[len(data) // 2] ^= 0x40
    chunk.write_bytes(data)
    with pytest.raises(ss.InputError, match="is damaged"):
        ss.sweep(MODEL, over, t_end=2, out=out)


def test_an_array_whose_description_is_damaged_is_named(tmp_path: Path) -> None:
    out, over = tmp_path / "a.zarr", {"belt_speed": [0.1, 0.2]}
    ss.sweep(MODEL, over, t_end=2, out=out)
    (out / "final_state" / "zarr.json").write_text("{")
    with pytest.raises(ss.InputError, match="'final_state' that cannot be read"):
        ss.sweep(MODEL, over, t_end=2, out=out)


def test_chunks_that_changed_places_are_noticed(tmp_path: Path) -> None:
    out, over = tmp_path / "a.zarr", {"belt_speed": np.linspace(0.05, 0.4, 200_000)}
    first = ss.sweep(MODEL, over, t_end=0.1, observe="final_state", out=out).load()
    a, b, *_ = sorted((one for one in (out / "final_state" / "c").rglob("*") if one.is_file()), key=str)
    other = a.read_bytes()
    a.write_bytes(b.read_bytes())
    b.write_bytes(other)
    with pytest.raises(ss.InputError, match="is not the one written there"):
        ss.sweep(MODEL, over, t_end=0.1, observe="final_state", out=out)
    a.unlink()
    b.unlink()
    xr.testing.assert_identical(
        ss.sweep(MODEL, over, t_end=0.1, observe="final_state", out=out).load(), first
    )
