"""Variables of MATLAB files (version 4 to 7.2), parsed in a child process: a damaged file cannot end this one."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import InputError, Place, quoted

Floats = NDArray[np.float64]

_CHILD = Path(__file__).with_name("matlab_child.py")


def read(file: Path, names: Sequence[str] = ()) -> tuple[list[str], dict[str, Floats]]:
    """Return the names of all variables and, if each is there just once, the real vectors that were asked for.

    Raises
    ------
    InputError
        The file is damaged, of version 7.3 or not of MATLAB; a variable is no real vector.
    """
    command = [sys.executable, "-P", str(_CHILD), str(file.absolute()), *names]
    pipe = subprocess.PIPE
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, check=False)
    if done.returncode < 0:
        words = f"a damaged MATLAB file (its parser was ended by signal {-done.returncode}); save it again"
        raise InputError(words, place=Place(str(file)))
    if done.returncode:
        last = (done.stderr.decode(errors="replace").strip().splitlines() or ["no words"])[-1]
        words = f"the process that parses MATLAB files failed: {quoted(last, 120)}"
        raise InputError(words, place=Place(str(file)))
    end = done.stdout.index(b"\n") + 1
    head = json.loads(done.stdout[:end])
    if "fault" in head:
        place = Place(str(file), column=head.get("column"))
        raise InputError(quoted(head["fault"], 180), place=place)
    values: dict[str, Floats] = {}
    for name, size in head["columns"]:
        values[name] = np.frombuffer(done.stdout, np.float64, size, end).copy()
        end += 8 * size
    return list(head["known"]), values
