"""The program that parses binary files in a process of its own; it imports nothing of the package, to start fast.

A damaged file can end a library by a signal, which no `except` catches, ask for any amount of memory or never come to
an end. Requests come as lines of JSON: parser (a module beside this one), file, names, seconds, memory. An answer is a
line of JSON, then the columns as float64.
"""

from __future__ import annotations

import json
import resource
import signal
import sys
import warnings
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np

Answer = tuple[dict[str, Any], list[np.ndarray]]


def limit(kind: int, most: int) -> None:
    """Limit this process softly, so that the next file may have another limit."""
    _, hard = resource.getrlimit(kind)
    resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def own_memory() -> int:
    """Bytes of address space that this process has."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


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
    limit(resource.RLIMIT_AS, own_memory() + request["memory"])
    signal.alarm(request["seconds"])  # it ends this process, whatever the library does
    try:
        return answered(module, request["file"], request["names"])
    finally:
        signal.alarm(0)


def main() -> None:
    """Answer requests until there are no more."""
    limit(resource.RLIMIT_CORE, 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever asks decides
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
