"""Forecasts and figures side by side, in processes of their own: most of them is Python, which threads do not share."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import pickle
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, ClassVar, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
IDLE = 20.0  # seconds after which processes that nobody asks for anything end
LOOK = 2.0  # seconds between looks for the process that started us
ONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class Workers:
    """Processes to fit, forecast and draw in; none where there is one core to use, or the machine lets us have none.

    `needs` names a module that they load while they wait for work.
    """

    _latest: ClassVar[tuple[Workers, int, float] | None] = None  # last asked, by which process, when
    _later: ClassVar[list[str]] = []  # modules that are needed when a search has ended

    def __init__(self, count: int, needs: str = __name__) -> None:
        self.count = min(count, os.cpu_count() or 1)
        self._pool = _pool(self.count, (needs, *self._later)) if self.count > 1 else None

    @classmethod
    def at_hand(cls) -> Workers:
        """The processes of a search that this one has just ended; else none: it takes longer to start any."""
        if cls._latest is not None and cls._latest[1] == os.getpid():
            workers, _, at = cls._latest
            if time.monotonic() - at < IDLE / 2:
                return workers
        return Workers(1)

    @classmethod
    def load_later(cls, module: str) -> None:
        """Let a module be loaded where it keeps nobody waiting: while processes wait for work, or this one for them."""
        if module not in cls._later:
            cls._later.append(module)

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """function(item) of every item, in their order."""
        todo = list(items)
        if self._pool is not None:
            self._asked()
        if self._pool is not None and len(todo) > 1:
            folder = os.getcwd()
            with tempfile.TemporaryDirectory() as passing:
                # written once, not once an item: what it holds may be large
                written = Path(passing) / "function"
                written.write_bytes(_dumped(function))
                try:
                    # not the pool's own map: what it cancels when interrupted, `stop` could not end without an outcry
                    under_way = [self._pool.submit(_call, str(written), folder, item) for item in todo]
                except RuntimeError:
                    self._pool, under_way = None, []
                for module in self._later if under_way else ():
                    importlib.import_module(module)
                try:
                    if under_way:
                        return [one.result() for one in under_way]
                except BrokenExecutor:
                    self._pool = None
        return [function(item) for item in todo]

    def ahead(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        """function(item) of items until no more is asked for, as many at once as there are processes."""
        todo = iter(items)
        while some := list(islice(todo, self.count)):
            yield from self.map(function, some)

    def _asked(self) -> None:
        Workers._latest = self, os.getpid(), time.monotonic()

    def stop(self) -> None:
        """End the processes at once, whatever they are at; what is asked for after that is computed here."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(kill_workers=True)


def _dumped(function: Callable[[Any], Any]) -> bytes:
    """A function as bytes, closures and all."""
    from loky.backend.reduction import dumps  # type: ignore[import-untyped]

    return bytes(dumps(function))


@lru_cache(maxsize=1)
def _function(written: str) -> Callable[[Any], Any]:
    # written by the process that started this one
    function: Callable[[Any], Any] = pickle.loads(Path(written).read_bytes())
    return function


def _call(written: str, folder: str, item: Any) -> Any:
    """The written function's value of an item, in the folder that its paths are of: the process may be older."""
    os.chdir(folder)
    return _function(written)(item)


ALONE = Workers(1)  # no processes: all is done here


def _pool(count: int, needs: tuple[str, ...]) -> Any:
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


def _ready(parent: int, needs: tuple[str, ...]) -> None:
    """What a worker needs later, loaded; the watch first: the parent may be dead before we come.

    Ctrl-C reaches all processes of a terminal: it is the parent's to end us, without a traceback of our own.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    import scipy.signal  # noqa: F401

    for module in needs:
        importlib.import_module(module)


def _end_with(parent: int) -> None:
    """End soon after the process that started this one: were that killed, our results would wait for it for ever."""
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)
