"""Work in other processes: the same numbers, in order, and what happens when a process dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import loky
import pytest

from discover_cases import FEW, make_case
from stickslip.discovery import workers
from stickslip.discovery.discover import discover
from stickslip.discovery.workers import IDLE, Workers


def runs(process):
    """Is there such a process that is not over? Not every machine's first process buries the dead."""
    stat = Path(f"/proc/{process}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"


def signed_root(parent, number):
    return -(number**0.5) if os.getpid() == parent else number**0.5


def number_or_death(parent, number):
    if os.getpid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_a_map_is_in_order_and_computed_elsewhere():
    root = partial(signed_root, os.getpid())
    assert Workers(2).map(root, [9.0, 4.0, 1.0]) == [3.0, 2.0, 1.0]
    assert Workers(1).map(root, [9.0, 4.0]) == [-3.0, -2.0]


def test_a_map_is_computed_here_after_a_worker_died():
    broken = Workers(2)
    assert broken.map(partial(number_or_death, os.getpid()), [1, 2, 3]) == [1, 2, 3]
    assert broken.map(partial(signed_root, os.getpid()), [9.0]) == [-3.0]


def test_without_semaphores_there_are_no_workers(monkeypatch):
    def missing(*_, **__):
        raise OSError("no /dev/shm")

    monkeypatch.setattr("loky.get_reusable_executor", missing)
    assert Workers(2).map(partial(signed_root, os.getpid()), [9.0]) == [-3.0]


def test_an_interrupt_ends_the_workers(monkeypatch):
    stopped = []
    monkeypatch.setattr(workers.Workers, "stop", lambda self: stopped.append(self))

    def interrupt(words):
        if "readings" not in words:  # before them there are no workers
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        discover(make_case(length=24.0, speeds=FEW), progress=interrupt)
    assert len(stopped) == 1


def test_a_worker_ends_with_the_process_that_started_it(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import os, signal\n"
        "from stickslip.discovery.workers import Workers\n"
        "workers = Workers(2)\n"
        "print(workers.map(lambda _: os.getpid(), [0])[0], flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False)
    worker = int(done.stdout)
    assert done.returncode == -signal.SIGKILL
    end = time.monotonic() + 30
    while runs(worker) and time.monotonic() < end:
        time.sleep(0.2)
    assert not runs(worker)


def test_processes_at_hand_are_those_of_a_search_just_ended_in_this_process(monkeypatch):
    asked = Workers(2)
    asked.map(abs, [2])
    assert Workers.at_hand() is asked
    for module, name, other in (
        (os, "getpid", os.getpid() + 1),
        (time, "monotonic", time.monotonic() + IDLE),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, lambda other=other: other)
            assert Workers.at_hand().count == 1
    assert Workers.at_hand() is asked


def test_there_are_no_processes_at_hand_before_a_search() -> None:
    script = "from stickslip.discovery.workers import Workers; print(Workers.at_hand().count)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "1"


def test_an_interrupted_map_cancels_nothing_under_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is cancelled makes the pool's own thread cry out when it is stopped."""

    class Interrupted(Future[int]):
        def result(self, timeout: float | None = None) -> int:
            raise KeyboardInterrupt(timeout)

    handed: list[Future[int]] = [Interrupted(), Future(), Future()]
    todo = iter([Future(), *handed])  # the first starts the processes
    pool = SimpleNamespace(submit=lambda *_: next(todo), map=None)
    monkeypatch.setattr(loky, "get_reusable_executor", lambda *_, **__: pool)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    asked = Workers(2)
    with pytest.raises(KeyboardInterrupt):
        asked.map(abs, [1, 2, 3])
    assert next(todo, None) is None
    assert not any(one.cancelled() for one in handed)


def test_paths_are_of_the_folder_that_one_is_in_now(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    workers = Workers(2)
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        assert set(workers.map(here, range(4))) == {str(tmp_path / name)}


def here(_: int) -> str:
    return os.getcwd()
