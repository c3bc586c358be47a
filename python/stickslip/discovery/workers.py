"""Forecasts and figures side by side, in processes of their own: most of them is Python, which threads do not share."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor
from typing import Any, ClassVar, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
IDLE = 20.0  # seconds after which processes that nobody asks for anything end
LOOK = 2.0  # seconds between looks for the process that started us
ONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class Workers:
    """Processes to forecast and draw in; none where there is one core to use, or the machine does not let us have any.

    `needs` names a module that they load while they wait for work.
    """

    _latest: ClassVar[tuple[Workers, int, float] | None] = None  # last asked, by which process, when

    def __init__(self, count: int, needs: str = __name__) -> None:
        self.count = min(count, os.cpu_count() or 1)
        self._pool = _pool(self.count, needs) if self.count > 1 else None

    @classmethod
    def at_hand(cls) -> Workers:
        """The processes of a search that this one has just ended; else none: it takes longer to start any."""
        if cls._latest is not None and cls._latest[1] == os.getpid():
            workers, _, at = cls._latest
            if time.monotonic() - at < IDLE / 2:
                return workers
        return Workers(1)

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """function(item) of every item, in their order."""
        todo = list(items)
        if self._pool is not None:
            self._asked()
            try:
                # not the pool's own map: what it cancels when interrupted, `stop` could not end without an outcry
                under_way = [self._pool.submit(function, item) for item in todo]
            except RuntimeError:
                self._pool, under_way = None, []
            try:
                if under_way:
                    return [one.result() for one in under_way]
            except BrokenExecutor:
                self._pool = None
        return [function(item) for item in todo]

    def _asked(self) -> None:
        Workers._latest = self, os.getpid(), time.monotonic()

    def stop(self) -> None:
        """End the processes at once, whatever they are at; what is asked for after that is computed here."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(kill_workers=True)


def _pool(count: int, needs: str) -> Any:
    """A pool of processes, or None where the system has no semaphores for it or we are a process that may not fork."""
    from loky import get_reusable_executor  # type: ignore[import-untyped]

    if multiprocessing.current_process().daemon:
        return None
    try:
        pool = get_reusable_executor(
            count, timeout=IDLE, env=ONE, initializer=_ready, initargs=(os.getpid(), needs)
        )
        pool.submit(int)  # start them now: they take a second to come
    except (OSError, ImportError, NotImplementedError):
        return None
    return pool


def _ready(parent: int, needs: str) -> None:
    """What a worker needs later, loaded; the watch first: the parent may be dead before we come.

    Ctrl-C reaches all processes of a terminal: it is the parent's to end us, without a traceback of our own.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    import scipy.signal  # noqa: F401

    importlib.import_module(needs)


def _end_with(parent: int) -> None:
    """End soon after the process that started this one: were that killed, our results would wait for it for ever."""
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)
