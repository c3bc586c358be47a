"""Sweeps out of core and on a cluster: resumed, killed and spread out, they are the same to the last bit."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

import stickslip as ss
from stickslip.cli.commands import main
from stickslip.simulated.sweep import store as sweep_store
from stickslip.simulated.sweep.observables import OBSERVABLES
from stickslip.simulated.sweep.request import GridBlock, Request

zarr = pytest.importorskip("zarr")

MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
OVER = {"belt_speed": np.linspace(0.02, 0.3, 50), "alpha1": ("a", np.linspace(8, 40, 40))}
SETTINGS: dict[str, Any] = {
    "t_end": 100.0,
    "after": 50.0,
    "initial": (0.1, 0.1, 0, 0),
    "observe": tuple(OBSERVABLES),
}


def run(**more: Any) -> xr.Dataset:
    return ss.sweep(MODEL, OVER, **(SETTINGS | more))


@pytest.fixture(scope="module")
def memory() -> xr.Dataset:
    return run(threads=2)


def test_store_is_what_memory_holds(memory: xr.Dataset, tmp_path: Path) -> None:
    xr.testing.assert_identical(run(out=tmp_path / "a.zarr").load().drop_attrs(), memory.drop_attrs())
    with xr.open_zarr(tmp_path / "a.zarr") as plain:  # without our help, and without a warning
        assert plain.status.attrs["flag_meanings"].startswith("not_computed finished")
        assert set(plain.coords) == {"alpha1", "belt_speed", "state"}


def test_nothing_that_is_there_is_computed_again(tmp_path: Path) -> None:
    first = run(out=tmp_path / "a.zarr").load()
    chunks = [one for one in (tmp_path / "a.zarr").rglob("*") if one.is_file() and "c" in one.parts]
    written = {one: one.stat().st_mtime_ns for one in chunks}
    assert written
    xr.testing.assert_identical(run(out=tmp_path / "a.zarr").load(), first)
    assert {one: one.stat().st_mtime_ns for one in written} == written


def test_an_interrupt_keeps_what_is_done(
    memory: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compute = Request.compute

    def interrupted(self: Request, start: int, stop: int) -> Any:
        if start > self.grid.members // 2:
            raise KeyboardInterrupt
        return compute(self, start, stop)

    for out in (None, tmp_path / "a.zarr"):
        with monkeypatch.context() as patch:
            patch.setattr(Request, "compute", interrupted)
            with pytest.warns(UserWarning, match="of 2000 members computed"):
                part = run(threads=1, out=out).load()
        done = part.status.values >= 0
        assert 0 < done.sum() < done.size
        assert np.array_equal(part.final_state.values[done], memory.final_state.values[done])
        assert np.isnan(part.final_state.values[~done]).all()
        assert (part.transitions.values[~done] == -1).all()
    xr.testing.assert_identical(run(out=tmp_path / "a.zarr").load().drop_attrs(), memory.drop_attrs())


CHILD = """
import sys, time
import numpy as np
sys.path[:0] = {path!r}
import test_sweep_store as t
from stickslip.simulated.sweep.store import ZarrSink
put = ZarrSink.put
def slowly(self, block, arrays):
    put(self, block, arrays)
    print("chunk", flush=True)
    time.sleep(0.05)
ZarrSink.put = slowly
t.run(out={out!r}, threads=2)
"""


def test_killed_and_started_again(memory: xr.Dataset, tmp_path: Path) -> None:
    out = tmp_path / "a.zarr"
    code = CHILD.format(path=[str(Path(__file__).parent)], out=str(out))
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "chunk\n"
    os.kill(child.pid, signal.SIGKILL)
    assert child.wait() == -signal.SIGKILL
    child.stdout.close()
    status = zarr.open_array(str(out / "status"), mode="r")[:]
    assert (status >= 0).any()
    assert (status < 0).any()
    xr.testing.assert_identical(run(out=out).load().drop_attrs(), memory.drop_attrs())


def test_a_chunk_half_written_is_computed_again(memory: xr.Dataset, tmp_path: Path) -> None:
    out = tmp_path / "a.zarr"
    run(out=out)
    chunks = sorted(path for path in (out / "status" / "c").rglob("*") if path.is_file())
    assert len(chunks) > 1
    for chunk in (chunks[0], chunks[-1]):  # the mark is missing; what was written before it is spoilt
        place = chunk.relative_to(out / "status")
        chunk.unlink()
        (out / "points" / place / "0" / "0").write_bytes(b"")
    xr.testing.assert_identical(run(out=out).load().drop_attrs(), memory.drop_attrs())


def test_blocks_are_runs_of_members_and_chunks_of_the_store() -> None:
    from stickslip.simulated.lowering import lower
    from stickslip.simulated.sweep.grid import make_grid

    lowered = lower(MODEL, 0.1)
    for shape in ((50,), (7, 11), (3, 5, 700), (20, 1, 9), (4000, 3), (2, 40000)):
        names = ("belt_speed", "alpha1", "alpha2")
        over = {name: np.linspace(8, 9, n) for name, n in zip(names, shape, strict=False)}
        grid = make_grid(over, MODEL, lowered, frozenset())
        request = Request(
            MODEL,
            grid,
            0.1,
            tuple(lowered.initial((0, 0, 0, 0))),
            100.0,
            0.0,
            1e-8,
            1e-8,
            ("status",),
            8,
            True,
            1000,
        )
        number = np.arange(grid.members).reshape(shape)
        blocks: list[GridBlock] = list(request.blocks())
        for block in blocks:
            assert np.array_equal(number[block.index].ravel(), np.arange(block.start, block.stop))
            assert all(one.start % c == 0 for one, c in zip(block.index, request.block_shape, strict=True))
        assert [one.start for one in blocks[1:]] == [one.stop for one in blocks[:-1]]
        assert blocks[-1].stop == grid.members
        assert request.grid.values(3, 7).shape == (4, len(shape))


RIG_TABLE = """
[rig]
alpha1 = 16
alpha2 = 8
beta3 = 4
eta1 = 0.1
eta12 = 0.2
"""
SWEEP = (
    RIG_TABLE
    + """
[sweep]
t_end = 100
after = 50
initial = [0.1, 0.1, 0, 0]
observe = ["stick_fraction", "final_state"]
[over]
belt_speed = { start = 0.02, stop = 0.3, count = 50 }
alpha1 = { values = [8.0, 16.0, 40.0], dim = "a" }
"""
)


def test_the_command(tmp_path: Path) -> None:
    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    arguments = ["sweep", str(tmp_path / "sweep.toml"), "--out", str(tmp_path / "r.zarr")]
    for _ in range(2):
        result = CliRunner().invoke(main, arguments)
        assert result.exit_code == 0, result.output
        assert "150 members: 150 finished" in result.output
    over = {"belt_speed": np.linspace(0.02, 0.3, 50), "alpha1": ("a", [8.0, 16.0, 40.0])}
    told = ss.sweep(MODEL, over, **(SETTINGS | {"observe": ("stick_fraction", "final_state")}))
    with xr.open_zarr(tmp_path / "r.zarr") as ds:
        assert np.array_equal(ds.final_state.values, told.final_state.values)
        assert np.array_equal(ds.stick_fraction.values, told.stick_fraction.values)


def test_the_command_says_how_to_go_on_when_it_is_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> Any:
        raise KeyboardInterrupt

    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    arguments = ["sweep", str(tmp_path / "sweep.toml"), "--out", str(tmp_path / "r.zarr")]
    with monkeypatch.context() as patch:
        patch.setattr(Request, "compute", interrupted)
        result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 130  # as a shell reports of a program that Ctrl-C ended
    assert "the same command goes on with" in result.output
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0
    assert "150 members: 150 finished" in result.output


def test_a_fault_of_the_store_is_not_looked_for_in_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    arguments = ["sweep", str(tmp_path / "sweep.toml"), "--out", str(tmp_path / "sweep.toml")]
    told = CliRunner().invoke(main, arguments).output
    assert "--out = " in told
    assert "exists and is not a store of a sweep" in told
    assert "line" not in told
    monkeypatch.setitem(sys.modules, "zarr", None)  # as on a plain install
    told = CliRunner().invoke(main, arguments).output
    assert "--out: needs zarr; pip install 'stickslip[sweep]'" in told


@pytest.mark.slow
def test_two_workers_one_killed(memory: xr.Dataset, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of ports and of the worker that goes
        with (
            distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster,
            distributed.Client(cluster) as client,
        ):
            victim = next(iter(client.run(os.getpid).values()))
            delivered = 0

            put = sweep_store.ZarrSink.put

            def killing(self: sweep_store.ZarrSink, block: GridBlock, arrays: Any) -> None:
                nonlocal delivered
                put(self, block, arrays)
                delivered += 1
                if delivered == 2:
                    os.kill(victim, signal.SIGKILL)

            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(sweep_store.ZarrSink, "put", killing)
                ds = run(client=client, out=tmp_path / "a.zarr").load()
    assert delivered > 2
    xr.testing.assert_identical(ds.drop_attrs(), memory.drop_attrs())
    shutil.rmtree(tmp_path / "a.zarr")


LONG = """
import signal, sys, warnings
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in what it runs behind
sys.path[:0] = {path!r}
warnings.simplefilter("ignore")
import numpy as np
import stickslip as ss
import test_sweep_store as t
over = dict(belt_speed=np.linspace(0.02, 0.3, 1000), alpha1=np.linspace(8, 40, 500))
print("go", flush=True)
ds = ss.sweep(t.MODEL, over, t_end=400.0, initial=(0.1, 0.1, 0, 0))
print(int((ds.status >= 0).sum()), flush=True)
"""


@pytest.mark.study
def test_time_to_interrupt() -> None:
    """Ctrl-C in a sweep that would take minutes comes back at once, with what is done; a busy machine is given time."""
    code = LONG.format(path=[str(Path(__file__).parent)])
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "go\n"
    time.sleep(2.0)
    begin = time.monotonic()
    child.send_signal(signal.SIGINT)
    done = int(child.stdout.readline())
    assert time.monotonic() - begin < 10.0
    child.stdout.close()
    child.wait(10)
    assert 0 < done < 500_000


def test_another_order_of_the_dimensions_is_another_store(tmp_path: Path) -> None:
    out = tmp_path / "a.zarr"
    over = {"belt_speed": np.linspace(0.05, 0.3, 4), "alpha1": np.linspace(8, 40, 5)}
    ss.sweep(MODEL, over, t_end=2, out=out)
    with pytest.raises(ss.InputError, match="in the order belt_speed, alpha1"):
        ss.sweep(MODEL, dict(reversed(over.items())), t_end=2, out=out)
    # of names on one dimension the order does not matter
    shared = {"belt_speed": ("i", np.linspace(0.05, 0.3, 4)), "alpha1": ("i", np.linspace(8, 40, 4))}
    first = ss.sweep(MODEL, shared, t_end=2, out=tmp_path / "b.zarr").load()
    again = ss.sweep(MODEL, dict(reversed(shared.items())), t_end=2, out=tmp_path / "b.zarr").load()
    xr.testing.assert_identical(first, again)


FILE = (
    RIG_TABLE
    + """
[friction]
kind = "paper"

[sweep]
t_end = 2
belt_speed = 0.1
observe = "final_state"

[over]
"""
)


def swept(tmp_path: Path, over: str) -> tuple[str, Path]:
    """What the command says of a file with this [over]; its store."""
    file, out = tmp_path / "sweep.toml", tmp_path / "a.zarr"
    file.write_text(FILE + over)
    return CliRunner().invoke(main, ["sweep", str(file), "--out", str(out)]).output, out


def test_a_file_may_say_it_briefly(tmp_path: Path) -> None:
    said, out = swept(tmp_path, "alpha1 = [15, 16]\ninitial.x1 = { start = 0.0, stop = 0.1, count = 3 }\n")
    assert "6 members: 6 finished" in said
    assert dict(xr.open_zarr(out, consolidated=False).sizes) == {"alpha1": 2, "initial.x1": 3, "state": 4}


@pytest.mark.parametrize(
    ("over", "line"),
    [
        ("alpha1 = []", "[over] key 'alpha1': empty; the grid has no members"),
        ("alpha7 = [1]", "[over] key 'alpha7': unknown parameter 'alpha7'; did you mean"),
        ("alpha1 = [1, inf]", "[over] key 'alpha1': entry 1 is inf"),
    ],
)
def test_a_fault_of_what_varies_is_said_of_its_table(tmp_path: Path, over: str, line: str) -> None:
    said, out = swept(tmp_path, over)
    assert line in said.replace("\n", " ")
    assert not out.exists()


def test_the_slower_of_two_that_make_a_store_goes_on_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    over, out = {"belt_speed": [0.1, 0.2]}, tmp_path / "a.zarr"
    first = ss.sweep(MODEL, over, t_end=2, out=out).load()
    # a race cannot be had at will: it was not there when it was looked for
    monkeypatch.setattr(sweep_store, "there_is", lambda _: False)
    xr.testing.assert_identical(ss.sweep(MODEL, over, t_end=2, out=out).load(), first)
    with pytest.raises(ss.InputError, match="holds a sweep with another t_end"):
        ss.sweep(MODEL, over, t_end=3, out=out)
    assert [one.name for one in tmp_path.iterdir()] == ["a.zarr"]
