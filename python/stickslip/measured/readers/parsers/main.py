"""The program that parses binary files in a process of its own; it imports nothing of the package, to start fast.

A damaged file can end a library by a signal, which no `except` catches, ask for any amount of memory or never come to
an end. Requests come as lines of JSON: parser (a module beside this one), file, names, seconds, memory. An answer is a
line of JSON, then the columns as float64.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np

resource: Any
try:
    import resource
except ImportError:  # Windows: neither limits nor alarms
    resource = None

TOO_LONG = 124  # the status with which it ends where there is no alarm
Answer = tuple[dict[str, Any], list[np.ndarray]]


def limit(kind: int, most: int) -> None:
    """Limit this process softly, so that the next file may have another limit."""
    assert resource is not None
    _, hard = resource.getrlimit(kind)
    resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def limit_memory(more: int) -> None:
    """Limit address space to what the process has and so many bytes more, where the system can tell and limit it."""
    pages = Path("/proc/self/statm")
    if resource is not None and pages.exists():
        limit(resource.RLIMIT_AS, int(pages.read_text().split()[0]) * resource.getpagesize() + more)


@contextmanager
def limited_time(seconds: int) -> Iterator[None]:
    """End this process after so many seconds; where there is no alarm, only if its library lets threads run."""
    if hasattr(signal, "SIGALRM"):
        signal.alarm(seconds)
        try:
            yield
        finally:
            signal.alarm(0)
        return
    timer = threading.Timer(seconds, os._exit, [TOO_LONG])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@cache
def parser(name: str) -> Any:
    """Return the module of a parser."""
    spec = spec_from_file_location(f"parser_{name}", Path(__file__).with_name(f"{name}.py"))
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def answered(module: Any, file: str, names: list[str]) -> Answer:
    """Return what a parser answers; any exception of its library is the file's fault."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            head, columns = module.answer(file, names)
            columns = [np.ascontiguousarray(one, dtype=np.float64).ravel() for one in columns]
    except MemoryError:
        return {"memory": True}, []
    except (Exception, RecursionError) as error:  # a damaged file makes a library raise nearly anything
        reason = (str(error).splitlines() or [""])[0] or type(error).__name__
        return {"damaged": reason}, []
    head["sizes"] = [column.size for column in columns]
    return head, columns


def answered_within(request: dict[str, Any]) -> Answer:
    """The same, within so many seconds and so many bytes beyond what the process has."""
    try:
        module = parser(request["parser"])
    except ImportError as error:
        return {"lacking": error.name}, []
    limit_memory(request["memory"])
    with limited_time(request["seconds"]):
        return answered(module, request["file"], request["names"])


def main() -> None:
    """Answer requests until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever asks decides
    if resource is not None:
        limit(resource.RLIMIT_CORE, 0)
    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGALRM])
    for line in sys.stdin:
        head, columns = answered_within(json.loads(line))
        sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
        for column in columns:
            sys.stdout.buffer.write(column.data)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
