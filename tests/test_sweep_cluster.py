"""Sweeps on a dask cluster that is not as it should be: other builds, lost workers, clients that cannot be used."""

from __future__ import annotations

import asyncio
import os
import signal
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import stickslip as ss
from stickslip.simulated.sweep import cluster as sweep_cluster
from stickslip.simulated.sweep import store as sweep_store

distributed = pytest.importorskip("distributed")

MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
OVER = {"belt_speed": np.linspace(0.02, 0.3, 40), "alpha1": np.linspace(8, 40, 40)}


def run(**more: Any) -> xr.Dataset:
    return ss.sweep(MODEL, OVER, t_end=100, initial=(0.1, 0.1, 0, 0), **more)


@contextmanager
def cluster(**settings: Any) -> Iterator[Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of ports and of workers that go
        with (
            distributed.LocalCluster(threads_per_worker=1, dashboard_address=":0", **settings) as one,
            distributed.Client(one) as client,
        ):
            yield client


@pytest.mark.skipif(ss.build_config()["isa"] == "baseline", reason="there is no narrower instruction set")
def test_workers_of_another_instruction_set_are_refused() -> None:
    with (
        cluster(n_workers=1, env={"STICKSLIP_ISA": "baseline"}) as client,
        pytest.raises(ss.InputError, match="a worker computes with baseline instructions") as told,
    ):
        run(client=client)
    assert str(told.value).startswith("client: ")
    assert "STICKSLIP_ISA=baseline in the environment of both" in str(told.value)


def test_a_worker_of_another_version_says_so() -> None:
    isa, version = sweep_cluster.build()
    said = sweep_cluster.computed_here(None, None, (isa, "0.0.0"))  # type: ignore[arg-type]  # it looks at neither
    assert said == f"a worker has stickslip {version}, this process 0.0.0; install the same version on both"


def test_a_store_of_another_version_is_another_sweep(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    given: dict[str, Any] = {"t_end": 2, "belt_speed": 0.1, "out": tmp_path / "a.zarr"}
    ss.sweep(MODEL, {"alpha1": [16.0]}, **given)
    group = zarr.open_group(str(tmp_path / "a.zarr"), mode="r+")
    settings = dict(group.attrs["settings"])
    for there in ("0.0.0", None):
        settings.pop("stickslip_version")
        group.attrs["settings"] = settings | ({"stickslip_version": there} if there else {})
        settings = dict(group.attrs["settings"]) | {"stickslip_version": ""}
        with pytest.raises(
            ss.InputError, match=f"another stickslip_version: there {there or 'unknown'}, here"
        ):
            ss.sweep(MODEL, {"alpha1": [16.0]}, **given)


@contextmanager
def killing(client: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """All workers are killed where the third chunk arrives."""
    delivered: list[int] = []
    put = sweep_store.MemorySink.put

    def kill(self: sweep_store.MemorySink, block: Any, arrays: Any) -> None:
        put(self, block, arrays)
        delivered.append(block.start)
        if len(delivered) == 3:
            for pid in client.run(os.getpid).values():
                os.kill(pid, signal.SIGKILL)
            time.sleep(1.0)  # until the scheduler has noticed

    with monkeypatch.context() as patch:
        patch.setattr(sweep_store.MemorySink, "put", kill)
        yield delivered


@pytest.mark.study
@pytest.mark.slow
def test_all_workers_killed_and_started_again(monkeypatch: pytest.MonkeyPatch) -> None:
    with cluster(n_workers=2) as client, killing(client, monkeypatch) as delivered:
        ds = run(client=client)
    assert len(delivered) == len(set(delivered)) > 5
    xr.testing.assert_identical(ds, run(threads=2))


class Losing:
    """A client that loses whatever it is given, from the chunk of a number on."""

    status, asynchronous = "running", False

    def __init__(self, client: Any, after: int) -> None:
        self.client, self.after, self.given = client, after, 0

    def submit(self, *given: Any, **named: Any) -> Any:
        future = self.client.submit(*given, **named)
        self.given += 1
        if self.given > self.after:
            self.client.cancel([future])
        else:
            distributed.wait(future)
        return future

    def __getattr__(self, name: str) -> Any:
        return getattr(self.client, name)


def test_a_cluster_that_keeps_losing_its_workers_is_given_up(tmp_path: Path) -> None:
    out = tmp_path / "a.zarr"
    with cluster(n_workers=1, processes=False) as client:
        with pytest.raises(
            ss.InputError, match=r"^client: the cluster lost its workers 3 times in a row before any"
        ):
            run(client=Losing(client, 0))
        with pytest.warns(
            UserWarning, match=r"lost its workers 3 times in a row: \d+ of 1600 members computed"
        ):
            part = run(client=Losing(client, 2))
        assert 0 < int((part.status >= 0).sum()) < part.status.size
        with pytest.raises(ss.InputError, match=r"members are in the store, and the same call goes on$"):
            run(client=Losing(client, 2), out=out)
        whole = run(client=client, out=out).load()
    xr.testing.assert_identical(whole.drop_attrs(), run(threads=2).drop_attrs())


def test_a_client_that_cannot_be_used_is_refused() -> None:
    with cluster(n_workers=1, processes=False) as client:
        pass
    with pytest.raises(ss.InputError, match=r"^client: is closed; give one that is open$"):
        run(client=client)

    async def from_a_loop() -> None:
        async with (
            distributed.LocalCluster(
                n_workers=1, processes=False, asynchronous=True, dashboard_address=":0"
            ) as one,
            distributed.Client(one, asynchronous=True) as other,
        ):
            run(client=other)

    with pytest.raises(
        ss.InputError, match=r"^client: is asynchronous; give one made without asynchronous=True"
    ):
        asyncio.run(from_a_loop())
