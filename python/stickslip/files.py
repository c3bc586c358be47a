"""Outputs appear whole or not at all: written beside the target, then renamed over it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stickslip.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

FINER = 1e-4  # of a sampling interval: how finely times are written
MOST_DIGITS = 17  # of a double


def apart(out: Path, figure: bool, inputs: Mapping[str, Path]) -> None:
    """Refuse an output that would take the place of what it is made from, or of its own figure.

    Parameters
    ----------
    out
        The file to write.
    figure
        Whether a figure is drawn beside it, as SVG and PNG.
    inputs
        Files that are read, by the argument that names them.

    Raises
    ------
    InputError
        Two of them are one file.
    """
    drawn = [out.with_suffix(kind) for kind in (".svg", ".png")] if figure else []
    for name, path in inputs.items():
        for target in (out, *drawn):
            if target.exists() and path.exists() and target.samefile(path):
                whose = "its figure" if target is not out else "it"
                words = f"{whose} would overwrite {name} ('{path}'); give another file"
                raise InputError(words, key="--out", value=str(out))
    if out in drawn:
        words = "its figure would overwrite it; end it in .csv"
        raise InputError(words, key="--out", value=str(out))


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A temporary path in the target's folder, renamed to `path` on success and removed on failure.

    Raises
    ------
    InputError
        If the folder cannot be written to.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix)
    except OSError as e:
        raise InputError(f"{path}: cannot be written ({e.strerror})") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def time_digits(t: Iterable[float], least: int, finer: float = FINER) -> int:
    """Digits that tell times (n,) apart to `finer` of their closest interval, or all that a double has."""
    times = np.asarray(t, dtype=float)
    step = float(np.min(np.diff(times))) if len(times) > 1 else 0.0
    if not step > 0:
        return MOST_DIGITS
    before = np.floor(np.log10(np.max(np.abs(times)))) + 1  # the decimal point
    return int(np.clip(before + np.ceil(-np.log10(step * finer)), least, MOST_DIGITS))


def write_csv(frame: pd.DataFrame, path: Path, digits: int) -> None:
    """Write a table whose first column is the time: to `digits` digits, times to as many as tell them apart."""
    time = frame.columns[0]
    enough = time_digits(frame[time], digits)
    written = [f"{t:.{enough}g}" if enough < MOST_DIGITS else repr(float(t)) for t in frame[time]]
    frame = frame.assign(**{time: written})
    with whole(path) as temporary:
        frame.to_csv(temporary, index=False, float_format=f"%.{digits}g")
