"""Fits side by side, in processes of their own: most of a fit is Python, which threads do not share."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, InvalidStateError
from contextlib import suppress
from typing import Any, ClassVar, Concatenate, ParamSpec, Protocol, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
Got = TypeVar("Got", covariant=True)
Rest = ParamSpec("Rest")
IDLE = 20.0  # seconds after which processes that nobody asks for anything end
LOOK = 2.0  # seconds between looks for the process that started us
ONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class Task(Protocol[Got]):
    """What was handed out."""

    def result(self) -> Got:
        """Wait for it."""

    def cancel(self) -> None:
        """Nobody needs it."""


class Asking(Protocol):
    """What hands fits out: a search."""

    began: float  # processor seconds at which its clock started

    @property
    def progress(self) -> Callable[[str], None]:
        """What tells a person what is being done."""

    @property
    def at_once(self) -> int:
        """How many fits run side by side."""

    def submit(self, function: Callable[..., Result], *args: Any) -> Task[Result]:
        """Have function(search, ...) computed elsewhere, or when it is asked for."""

    def away(self) -> Any:
        """The search as another process needs it."""

    def back(self, value: object, seconds: float) -> None:
        """Take in what came back from another process."""


Asker = TypeVar("Asker", bound=Asking)


class Workers:
    """Processes to fit and draw in; none where there is one core to use, or the machine does not let us have any.

    `needs` names a module that they load while they wait for work.
    """

    _latest: ClassVar[tuple[Workers, int, float] | None] = None  # last asked, by which process, when

    def __init__(self, count: int, needs: str = __name__) -> None:
        self.count = min(count, os.cpu_count() or 1)
        self._pool = _pool(self.count, needs) if self.count > 1 else None

    def submit(
        self,
        search: Asker,
        function: Callable[Concatenate[Asker, Rest], Result],
        *args: Rest.args,
        **options: Rest.kwargs,
    ) -> Task[Result]:
        """Have function(search, ...) computed elsewhere; what it does to the search itself is lost."""
        here = lambda: function(search, *args, **options)  # noqa: E731
        if self._pool is not None:
            try:
                future = _submit(self._pool, _timed, search.away(), function, args, options)
            except RuntimeError:  # one of them died, or another search ended them: from now on alone
                self._pool = None
            else:
                self._asked()
                return _Elsewhere(future, search, here)
        return _Later(here)

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


class _Later:
    """Computed here, when it is asked for."""

    def __init__(self, compute: Callable[[], Any]) -> None:
        self.result = compute

    def cancel(self) -> None:
        """Was not begun."""


class _Elsewhere:
    """Computed by another process; here, if that dies."""

    def __init__(self, future: Any, search: Asking, here: Callable[[], Any]) -> None:
        self._future, self._search, self._here = future, search, here

    def result(self) -> Any:
        try:
            value, seconds = self._future.result()
        except BrokenExecutor:
            return self._here()
        self._search.back(value, seconds)
        return value

    def cancel(self) -> None:
        self._future.cancel()


def each(
    search: Asker,
    function: Callable[[Asker, Item], Result],
    items: Iterable[Item],
    say: Callable[[Item], str] | None = None,
    ahead: int = 1,
) -> Iterator[tuple[Item, Task[Result]]]:
    """Items with function(search, item) as tasks, in their order; some are begun before they are asked for.

    As many as there are processes; `ahead` times as many where all will be asked for and some take far longer.
    """
    todo, under_way = iter(items), deque[tuple[Item, Task[Result]]]()
    most = search.at_once if search.at_once == 1 else ahead * search.at_once
    try:
        while True:
            for item in todo:
                if say is not None:
                    search.progress(say(item))
                under_way.append((item, search.submit(function, item)))
                if len(under_way) >= most:
                    break
            if not under_way:
                return
            yield under_way.popleft()
    finally:
        for _, task in under_way:
            task.cancel()


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


def _submit(pool: Any, function: Callable[..., Any], *args: Any) -> Any:
    """A future of the pool, which `stop` can end without an outcry where it was cancelled."""
    future = pool.submit(function, *args)
    fail = future.set_exception

    def failed(error: BaseException) -> None:
        with suppress(InvalidStateError):  # loky's thread, killing all, would stop with a traceback
            fail(error)

    future.set_exception = failed
    return future


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


def _timed(
    search: Asking, function: Callable[..., Result], args: tuple[Any, ...], options: dict[str, Any]
) -> tuple[Result, float]:
    search.began = began = time.process_time()
    return function(search, *args, **options), time.process_time() - began
