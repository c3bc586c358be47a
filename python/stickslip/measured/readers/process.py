"""The process that parses binary files for this one: started at the first file, asked again, replaced when it ends."""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
import psutil
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SECONDS = 60  # that any file may take, and one more for each MB; hundreds of MB take seconds
MEMORY = psutil.virtual_memory().total // 2  # the columns are there twice: there and here
PROGRAM = Path(__file__).with_name("parsers") / "main.py"


ALARM = 14  # SIGALRM, which Windows does not name
TOO_LONG = 124  # with which the parser ends where there is no such signal


class EndedError(Exception):
    """The process ended while it parsed a file."""


class Process:
    """One child process that answers requests, one at a time.

    A child that met a damaged file is ended: nobody knows what that left behind in it. A forked copy of this process
    starts its own.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None
        self._said: IO[bytes] | None = None  # its standard error: a pipe nobody reads would block it
        if hasattr(os, "register_at_fork"):  # Windows has no fork
            os.register_at_fork(after_in_child=self._forget)
        atexit.register(self.close)

    def ask(
        self, parser: str, format_name: str, file: Path, names: Sequence[str]
    ) -> tuple[dict[str, Any], list[Floats]]:
        """Return what a parser says of a file, and the columns asked for.

        Parameters
        ----------
        parser
            A module of `parsers`.
        format_name
            What a person calls its files, for errors.

        Raises
        ------
        EndedError
            The parser ended, or took too long.
        """
        seconds = SECONDS + file.stat().st_size // 10**6
        request = {"parser": parser, "file": str(file.absolute()), "names": list(names)}
        with self._lock:
            try:
                head, columns = _answer(self._running(), request | {"seconds": seconds, "memory": MEMORY})
            except (EOFError, BrokenPipeError):
                raise EndedError(self._last_words(format_name, seconds)) from None
            except BaseException:
                self.close()
                raise
            if "damaged" in head or "memory" in head:
                self.close()
            return head, columns

    def close(self) -> None:
        """End the child, if there is one."""
        if self._child is not None:
            self._child.kill()
            self._ended()

    def _ended(self) -> tuple[int, bytes]:
        """The status of a child that ends, and what it said."""
        child, said, self._child, self._said = self._child, self._said, None, None
        assert child is not None
        assert said is not None
        child.communicate()
        with said:
            said.seek(0)
            return child.returncode, said.read()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._child is not None and self._child.poll() is not None:
            self.close()  # something ended it between two files
        if self._child is None:
            command, pipe = [sys.executable, "-P", str(PROGRAM)], subprocess.PIPE
            self._said = tempfile.TemporaryFile()  # noqa: SIM115  # closed with the child
            threads = {"OPENBLAS_NUM_THREADS": "1"}  # it multiplies nothing, and a thread takes address space
            self._child = subprocess.Popen(
                command, stdin=pipe, stdout=pipe, stderr=self._said, env=os.environ | threads
            )
        return self._child

    def _last_words(self, name: str, seconds: int) -> str:
        """Why the child ended."""
        code, said = self._ended()
        if code in (-ALARM, TOO_LONG):
            return f"not parsed within {seconds} s; a damaged {name} file, or too long a record: save it in parts"
        if code < 0:
            return f"a damaged {name} file (its parser was ended by signal {-code}); save it again"
        last = (said.decode(errors="replace").strip().splitlines() or ["no words"])[-1]
        return f"the process that parses {name} files failed: {last}"

    def _forget(self) -> None:
        """In a forked copy: the child is not its own."""
        self._lock = threading.Lock()
        child, said, self._child, self._said = self._child, self._said, None, None
        if child is not None:
            child.returncode = 0
            for one in (child.stdin, child.stdout, said):
                if one is not None:
                    one.close()


def _answer(
    child: subprocess.Popen[bytes], request: dict[str, object]
) -> tuple[dict[str, Any], list[Floats]]:
    assert child.stdin is not None
    assert child.stdout is not None
    child.stdin.write(json.dumps(request).encode() + b"\n")
    child.stdin.flush()
    line = child.stdout.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    head: dict[str, Any] = json.loads(line)
    columns: list[Floats] = []
    for size in head.get("sizes", ()):
        columns.append(np.empty(size))
        if size and child.stdout.readinto(columns[-1].data.cast("B")) != 8 * size:  # type: ignore[attr-defined]
            raise EOFError
    return head, columns


PROCESS = Process()
