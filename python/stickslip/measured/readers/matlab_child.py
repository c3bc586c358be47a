"""The program that parses MATLAB files in a process of its own; it imports nothing of the package, to start fast.

A damaged file can end scipy's parser by a segmentation fault, which no `except` catches; it can also ask for endless
memory or time. Requests come as lines of JSON: file, names, seconds, memory. An answer is a line of JSON, then the
variables as float64.
"""

from __future__ import annotations

import json
import resource
import signal
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat, whosmat


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for where each is there once."""
    known = [name for name, _, _ in whosmat(file)]
    head: dict[str, Any] = {"known": known, "columns": []}
    columns: list[np.ndarray] = []
    if any(known.count(name) != 1 for name in names):
        return head, columns
    found = loadmat(file, variable_names=names) if names else {}
    for name in names:
        array = np.asarray(found.pop(name))
        if array.dtype.kind not in "iufb" or array.ndim > 2 or max(array.shape) != array.size:
            words = f"a {array.dtype.name} array of shape {array.shape}; a channel is a real vector"
            return {"known": known, "fault": words, "column": name}, []
        columns.append(np.ascontiguousarray(array.ravel(), dtype=np.float64))
        head["columns"].append([name, array.size])
    return head, columns


def limit(kind: int, most: int) -> None:
    """Limit this process softly, so that the next file may have another limit."""
    _, hard = resource.getrlimit(kind)
    resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def own_memory() -> int:
    """Bytes of address space that this process has."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def answer_within(request: dict[str, Any]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """The same, within so many seconds and bytes; any exception of the parser is the file's fault."""
    limit(resource.RLIMIT_AS, own_memory() + request["memory"])
    signal.alarm(request["seconds"])  # it ends this process, whatever the parser does
    try:
        return answer(request["file"], request["names"])
    except MemoryError:
        words = f"it needs more than {request['memory'] / 2**30:.3g} GiB of memory"
        return {"fault": f"{words}; a damaged MATLAB file, or too long a record: save it in parts"}, []
    except NotImplementedError:
        return {"fault": "a MATLAB 7.3 file; save it with -v7"}, []
    except Exception as error:  # a damaged file makes the parser raise nearly anything
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        return {"fault": f"not a MATLAB file, or a damaged one ({reason})"}, []
    finally:
        signal.alarm(0)


def main() -> None:
    """Answer requests until there are no more."""
    limit(resource.RLIMIT_CORE, 0)
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever asks decides
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGALRM])
    for line in sys.stdin:
        head, columns = answer_within(json.loads(line))
        sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
        for column in columns:
            sys.stdout.buffer.write(column.data)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
