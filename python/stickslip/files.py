"""Outputs appear whole or not at all, and take the place of nothing that is somebody else's.

One rule for all commands: a file that is there already is replaced only if a former result put it there and nobody has
changed it since, or by `--force`; a device, a pipe or an input never. Beside the files a record says whose they are. A
link to a single output is followed; one in a folder of results is refused.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stickslip.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

RECORD = ".stickslip.json"  # in a folder: what results were put there, with their digests
FINER = 1e-4  # of a sampling interval: how finely times are written
MOST_DIGITS = 17  # of a double


def with_figure(out: Path, figure: bool = True) -> tuple[Path, ...]:
    """Return an output and, where a figure is drawn beside it, its SVG and PNG."""
    return (out, *(out.with_suffix(kind) for kind in (".svg", ".png"))) if figure else (out,)


@contextmanager
def chosen(
    targets: Sequence[Path], inputs: Mapping[str, Path], *, force: bool = False, key: str = "--out"
) -> Iterator[None]:
    """Files whose names the user chose, each written by `whole` meanwhile: refused before any work, noted after it.

    Parameters
    ----------
    targets
        What may be written: an output, and its figures after it.
    inputs
        Files that are read, by the argument that names them: never replaced.
    force
        Replace files whosever they are.
    key
        The option that names them.

    Raises
    ------
    InputError
        One is an input, a device, another target, or a file that no former result put there or that was changed since.
    """
    for i, target in enumerate(targets):
        _refuse_chosen(target, targets[:i], inputs, force, key)
    before = [_stamp(one) for one in targets]
    try:
        yield
    finally:
        for target, stamp in zip(targets, before, strict=True):
            if _stamp(target) not in (None, stamp):
                _note(target.resolve())


def _refuse_chosen(
    target: Path, others: Sequence[Path], inputs: Mapping[str, Path], force: bool, key: str
) -> None:
    """Refuse to write to a place that the user named."""
    if target.name == RECORD:
        raise InputError("the record of results has this name; give another file", key=key, value=str(target))
    try:
        there = _regular(target)
        near = next(one for one in there.parents if one.exists())
        if not near.is_dir() or not os.access(near, os.W_OK | os.X_OK):
            code = errno.EACCES if near.is_dir() else errno.ENOTDIR
            raise OSError(code, os.strerror(code))
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", key=key, value=str(target)) from None
    whose = "its figure" if others else "it"
    for name, path in inputs.items():
        if there.exists() and path.exists() and there.samefile(path):
            words = f"{whose} would overwrite {name} ('{path}'); give another file"
            raise InputError(words, key=key, value=str(target))
    if target in others:
        raise InputError("its figure would overwrite it; end it in .csv", key=key, value=str(target))
    if force or not there.exists() or (put := _former(there.parent).get(there.name)) == _digest(there):
        return
    why = "no former result put it there" if put is None else "it was changed since it was written"
    words = f"is there already, and {why}; give another file, or --force to replace it"
    raise InputError(words, key=key, value=str(target))


def _stamp(file: Path) -> tuple[int, int] | None:
    """What differs after a file was replaced; None: there is none."""
    try:
        status = file.stat()
    except OSError:
        return None
    return status.st_ino, status.st_mtime_ns


def _note(file: Path) -> None:
    """Note in the folder's record that a result put a file there."""
    record = {k: v for k, v in _former(file.parent).items() if (file.parent / k).is_file()}
    _write_record(file.parent / RECORD, record | {file.name: _digest(file)})


def _write_record(path: Path, record: Mapping[str, str]) -> None:
    text = json.dumps(dict(sorted(record.items())), indent=1) + "\n"
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A temporary path in the target's folder, renamed to `path` on success and removed on failure.

    Raises
    ------
    InputError
        The place is no file, or cannot be written to, or there is no room.
    """
    temporary = None
    try:
        target = _regular(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem[:100]}.", suffix=target.suffix
        )
        os.close(handle)
        temporary = Path(name)
        yield temporary
        temporary.chmod(0o666 & ~_mask())
        temporary.replace(target)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


@contextmanager
def folder(
    target: Path, names: Sequence[str], *, force: bool = False, inputs: Iterable[Path] = ()
) -> Iterator[Path]:
    """A temporary folder in the target, or beside one that is not there yet, whose files are moved on success.

    Parameters
    ----------
    target
        The folder; made if absent.
    names
        What may be written into it: paths relative to it, with `*` for any name. Those of an earlier result that this
        one has not are removed.
    force
        Replace files of these names whosever they are.
    inputs
        Files that are read: never replaced.

    Raises
    ------
    InputError
        The place is a file, cannot be written to, or holds a file of one of these names that no former result put
        there, or that was changed since; said before any work is done.
    """
    temporary, given = None, target
    try:
        target = _resolved(target)
        if target.exists() and not target.is_dir():
            raise InputError("is a file; give a folder", key="--out", value=str(given))
        _refuse_foreign(target, given, names, force, inputs)
        target.parent.mkdir(parents=True, exist_ok=True)
        near = target if target.exists() else target.parent  # on the disk of what it is moved to
        temporary = Path(tempfile.mkdtemp(dir=near, prefix=f".{target.name[:100]}."))
        yield temporary
        _refuse_foreign(target, given, names, force, inputs)
        _move(temporary, target, names)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", key="--out", value=str(given)) from None
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)


def _regular(path: Path) -> Path:
    """Where to write for `path`: at the end of its links, which must be a regular file or nothing."""
    target = _resolved(path)
    if target.is_dir():
        raise InputError(f"{path}: is a folder; give a file")
    if target.exists() and not target.is_file():
        raise InputError(f"{path}: is a device or a pipe; give a file")
    return target


def _resolved(path: Path) -> Path:
    """The end of a path's links; an OSError where they lead in a circle, as for all else that cannot be opened."""
    try:
        return path.resolve()
    except RuntimeError:  # of Python before 3.13
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP)) from None


def _mask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _digest(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _former(target: Path) -> dict[str, str]:
    """What former results put into a folder: digests by relative path."""
    try:
        found = json.loads((target / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}


def _there(target: Path, names: Sequence[str]) -> list[Path]:
    """The files in a folder that have one of the names."""
    return sorted({file for name in names for file in target.glob(name)})


def _refuse_foreign(
    target: Path, given: Path, names: Sequence[str], force: bool, inputs: Iterable[Path]
) -> None:
    """Refuse to replace what is not a former result's, in a folder as it was given."""
    former = _former(target)
    for inner in sorted({Path(name).parts[0] for name in names if len(Path(name).parts) > 1}):
        if (target / inner).is_symlink() or ((target / inner).exists() and not (target / inner).is_dir()):
            words = f"holds '{inner}', which is no folder; move it, or give another folder"
            raise InputError(words, key="--out", value=str(given))
    read = [one for one in inputs if one.exists()]
    for file in _there(target, names):
        name = file.relative_to(target).as_posix()
        if not file.is_file() or file.is_symlink():
            what = "a link" if file.is_symlink() else "not a file"
            words = f"holds '{name}', which is {what} and would be replaced; move it, or give another folder"
            raise InputError(words, key="--out", value=str(given))
        if any(file.samefile(one) for one in read):
            words = f"holds '{name}', which is read here; give another folder"
            raise InputError(words, key="--out", value=str(given))
        if not force and former.get(name) != _digest(file):
            whose = "was changed since it was written" if name in former else "no former result put there"
            words = f"holds '{name}', which {whose}; give another folder, or --force to replace it"
            raise InputError(words, key="--out", value=str(given))


def _move(temporary: Path, target: Path, names: Sequence[str]) -> None:
    """Move the new files in, take away those of an earlier result, and note whose they are."""
    new = {file.relative_to(temporary).as_posix(): file for file in temporary.rglob("*") if file.is_file()}
    gone = [file for file in _there(target, names) if file.relative_to(target).as_posix() not in new]
    record = {k: v for k, v in _former(target).items() if (target / k).is_file()}
    record |= {name: _digest(file) for name, file in new.items()}
    for file in gone:  # beside the new files it would tell another story
        file.unlink()
        record.pop(file.relative_to(target).as_posix(), None)
    _write_record(temporary / RECORD, record)
    if not target.exists():
        temporary.chmod(0o777 & ~_mask())
        temporary.rename(target)
        return
    for name in (*sorted(new), RECORD):
        there = target / name
        there.parent.mkdir(parents=True, exist_ok=True)
        (temporary / name).replace(there)


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
