"""The process that parses MATLAB files for this one: started at the first file, asked again, replaced when it ends."""

from __future__ import annotations

import atexit
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SECONDS = 60  # for one file
MEMORY = 4 << 30  # bytes for one file, beyond what the parser takes itself
PROGRAM = Path(__file__).with_name("matlab_child.py")


class ParserError(Exception):
    """What a file, or a variable of it, has wrong."""

    def __init__(self, words: str, column: str | None = None) -> None:
        self.words, self.column = words, column
        super().__init__(words)


class Parser:
    """One child process that answers requests, one at a time.

    A child that met a fault is ended: nobody knows what a damaged file left behind in it. A forked copy of this
    process starts its own.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None
        os.register_at_fork(after_in_child=self._forget)
        atexit.register(self.close)

    def ask(self, file: Path, names: Sequence[str]) -> tuple[list[str], dict[str, str], dict[str, Floats]]:
        """Return all names, short names with what they stand for, and the columns asked for if each is there once.

        Raises
        ------
        ParserError
            The parser refused the file, or ended while it parsed it.
        """
        request = {"file": str(file.absolute()), "names": list(names), "seconds": SECONDS, "memory": MEMORY}
        with self._lock:
            try:
                return _answer(self._running(), request)
            except (EOFError, BrokenPipeError):
                raise ParserError(self._last_words()) from None
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        """End the child, if there is one."""
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            child.communicate()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._child is not None and self._child.poll() is not None:
            self.close()  # something ended it between two files
        if self._child is None:
            command, pipe = [sys.executable, "-P", str(PROGRAM)], subprocess.PIPE
            threads = {"OPENBLAS_NUM_THREADS": "1"}  # it multiplies nothing, and a thread takes address space
            self._child = subprocess.Popen(
                command, stdin=pipe, stdout=pipe, stderr=pipe, env=os.environ | threads
            )
        return self._child

    def _last_words(self) -> str:
        """Why the child ended."""
        assert self._child is not None
        child, self._child = self._child, None
        _, said = child.communicate()
        if child.returncode == -signal.SIGALRM:
            return f"not parsed within {SECONDS} s; a damaged MATLAB file, or too long a record: save it in parts"
        if child.returncode < 0:
            return (
                f"a damaged MATLAB file (its parser was ended by signal {-child.returncode}); save it again"
            )
        last = (said.decode(errors="replace").strip().splitlines() or ["no words"])[-1]
        return f"the process that parses MATLAB files failed: {last}"

    def _forget(self) -> None:
        """In a forked copy: the child is not its own."""
        self._lock = threading.Lock()
        child, self._child = self._child, None
        if child is not None:
            child.returncode = 0
            for pipe in (child.stdin, child.stdout, child.stderr):
                if pipe is not None:
                    pipe.close()


def _answer(
    child: subprocess.Popen[bytes], request: dict[str, object]
) -> tuple[list[str], dict[str, str], dict[str, Floats]]:
    assert child.stdin is not None
    assert child.stdout is not None
    child.stdin.write(json.dumps(request).encode() + b"\n")
    child.stdin.flush()
    line = child.stdout.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    head = json.loads(line)
    if "fault" in head:
        raise ParserError(head["fault"], head.get("column"))
    values: dict[str, Floats] = {}
    for name, size in head["columns"]:
        values[name] = np.empty(size)
        if size and child.stdout.readinto(values[name].data.cast("B")) != 8 * size:  # type: ignore[attr-defined]
            raise EOFError
    return list(head["known"]), dict(head["also"]), values


PARSER = Parser()
