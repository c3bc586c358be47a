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
from scipy.io.matlab import MatlabFunction, MatlabOpaque

NESTED = ("struct", "cell")  # classes of variables that hold others
DEEPEST = 16  # structs in structs
WIDEST = 256  # columns of a matrix that are offered each


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for where each is there once.

    Parts are called as in MATLAB: `run.t` a field, `run(2).t` one of several structs, `data{1}` a cell, `data(:,1)` a
    column.
    """
    listed = whosmat(file)
    inside = {name for name, _, kind in listed if kind in NESTED}  # their parts are known by loading alone
    asked = {*names, *(name.partition("(:,")[0] for name in names)}
    load = inside | {name for name, _, _ in listed if name in asked}
    loaded = loadmat(file, variable_names=sorted(load)) if load else {}
    known: list[str] = []
    held: dict[str, np.ndarray] = {}
    for name, shape, _ in listed:
        found = _parts(name, loaded[name]) if name in load else {}
        known += found if name in load else _columns(name, shape)
        held |= found
    also = _also(known)
    own = [name if name in known else also.get(name, name) for name in names]
    if any(known.count(name) != 1 for name in own):
        return {"known": known, "also": also, "columns": []}, []
    for name in own:
        array = held[name]
        if array.dtype.kind not in "iufb" or not array.size or max(array.shape) != array.size:
            words = f"a {array.dtype.name} array of shape {array.shape}; a channel is a real vector"
            return {"known": known, "fault": words, "column": name}, []
    columns = [np.ascontiguousarray(held[name].ravel(), dtype=np.float64) for name in own]
    sizes = [[name, column.size] for name, column in zip(names, columns, strict=True)]
    return {"known": known, "also": also, "columns": sizes}, columns


def _parts(name: str, value: Any, depth: int = 0) -> dict[str, np.ndarray]:
    """The arrays in a variable by the names that MATLAB has for them; words in structs and cells are left out."""
    array = np.asarray(value)
    inner: dict[str, Any] = {}
    if isinstance(value, MatlabOpaque | MatlabFunction) or depth > DEEPEST:
        return {}
    if array.dtype.names is not None:
        for k, one in enumerate(array.ravel(order="F"), 1):
            of = name if array.size == 1 else f"{name}({k})"
            inner |= {f"{of}.{field}": one[field] for field in array.dtype.names}
    elif array.dtype == object and array.ndim:
        inner = {f"{name}{{{k}}}": one for k, one in enumerate(array.ravel(order="F"), 1)}
    elif depth and array.dtype.kind not in "iufbc":
        return {}
    else:
        columns = _columns(name, array.shape)
        return {name: array} if columns == [name] else dict(zip(columns, array.T, strict=True))
    return {key: one for k, v in inner.items() for key, one in _parts(k, v, depth + 1).items()}


def _columns(name: str, shape: tuple[int, ...]) -> list[str]:
    """The names of the columns of a matrix; that of a vector is its own."""
    if len(shape) != 2 or min(shape) < 2 or shape[1] > WIDEST:
        return [name]
    return [f"{name}(:,{j})" for j in range(1, shape[1] + 1)]


def _also(known: list[str]) -> dict[str, str]:
    """Fields by their last name where only one has it."""
    bare = [name.rpartition(".")[2] for name in known]
    return {
        last: name for last, name in zip(bare, known, strict=True) if bare.count(last) == 1 and last != name
    }


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
