"""The program that parses a binary file in a process of its own; it imports nothing of the package, to start fast.

Usage: main.py PARSER FILE [COLUMN ...], with PARSER a module beside this one. It writes one line of JSON, then the
columns as float64. A damaged file can end a library by a signal, ask for any amount of memory or never come to an end:
the process has limits.
"""

from __future__ import annotations

import json
import os
import sys
import warnings
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np

SECONDS = 60  # of processor time that any file may take, and one more for each MB


def limit(file: str) -> None:
    """Limit memory to what the machine has, and processor time by the size of the file."""
    try:
        import resource
    except ImportError:  # no such limits on Windows
        return
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    seconds = SECONDS + Path(file).stat().st_size // 10**6
    for what, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, seconds)):
        _, hard = resource.getrlimit(what)
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (most, hard))


def parser(name: str) -> Any:
    """Return the module of a parser."""
    spec = spec_from_file_location(f"parser_{name}", Path(__file__).with_name(f"{name}.py"))
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def answered(module: Any, file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what a parser answers; any exception of its library is the file's fault."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            head, columns = module.answer(file, names)
    except (Exception, RecursionError) as error:  # a damaged file makes a library raise nearly anything
        reason = (str(error).splitlines() or [""])[0] or type(error).__name__
        return {"damaged": reason}, []
    head["sizes"] = [column.size for column in columns]
    return head, columns


def main() -> None:
    """Answer on standard output."""
    name, file, *names = sys.argv[1:]
    limit(file)
    try:
        module = parser(name)
    except ImportError as error:
        head, columns = {"lacking": error.name}, list[np.ndarray]()
    else:
        head, columns = answered(module, file, names)
    sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
    for column in columns:
        sys.stdout.buffer.write(np.ascontiguousarray(column, dtype=np.float64).data)


if __name__ == "__main__":
    main()
