"""The program that parses a MATLAB file in a process of its own; it imports nothing of the package, to start fast.

A damaged file can end scipy's parser by a segmentation fault, which no `except` catches.

Usage: matlab_child.py FILE [VARIABLE ...]. It writes one line of JSON, then the variables as float64.
"""

from __future__ import annotations

import json
import sys
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
        array = np.asarray(found[name])
        if array.dtype.kind not in "iufb" or array.ndim > 2 or max(array.shape) != array.size:
            words = f"a {array.dtype.name} array of shape {array.shape}; a channel is a real vector"
            return {"known": known, "fault": words, "column": name}, []
        columns.append(np.ascontiguousarray(array.ravel(), dtype=np.float64))
        head["columns"].append([name, array.size])
    return head, columns


def main() -> None:
    """Answer on standard output; any exception of the parser is the file's fault."""
    try:
        head, columns = answer(sys.argv[1], sys.argv[2:])
    except NotImplementedError:
        head, columns = {"fault": "a MATLAB 7.3 file; save it with -v7"}, []
    except Exception as error:  # a damaged file makes the parser raise nearly anything
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        head, columns = {"fault": f"not a MATLAB file, or a damaged one ({reason})"}, []
    sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
    for column in columns:
        sys.stdout.buffer.write(column.data)


if __name__ == "__main__":
    main()
