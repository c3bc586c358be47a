"""Odd and damaged files: the same numbers or one clear line, no shift, no traceback, no hang.

Usage: python bench/bench_odd_files.py [--texts 10000] [--damaged 2000] [--seed 0] [--keep FOLDER]

Header lines, units, separators, signs, encodings and line ends are moved over a good table in text; good files of each
format are cut, flipped, zeroed and given another beginning. Each is read by `load_recording`, and by `inspect`. The
table counts what came of them; files that gave a shift or a traceback are kept in FOLDER. What a damaged file holds may
be other numbers, where a digit or a sample was hit, and fewer of them without a word: one that was cut at the end of a
row or of a segment is a whole file.
"""

from __future__ import annotations

import argparse
import collections
import io
import signal
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import nptdms
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

import stickslip as ss
from stickslip.errors import StickslipError
from stickslip.measured.inspection import inspect
from stickslip.measured.readers import container
from stickslip.measured.readers.process import Process

N = 40
T = np.round(0.002 * np.arange(N), 6)
F = np.round(1.5 + 0.4 * np.sin(0.3 * np.arange(N)), 6)
RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
SECONDS = 100  # from which a file hangs: its parser is given 60
KINDS = ("same numbers", "one line", "other numbers", "fewer, and said", "fewer, unsaid", "traceback", "hang")
BAD = ("traceback", "hang")
SHIFTED = ("other numbers", "fewer, unsaid")  # of a table that is only written otherwise
Rng = np.random.Generator
Lines = list[list[str]]

PREAMBLE = (
    ["Friction test 12, dry"], ["Model", "DPO4104"], ["Sample Interval", "0.002"], ["Radius [mm]", "3.00"],
    ["Operator: M\u00fcller"], ["F over t"], ["Samples", "40"], ["# a note"], ["% another"], ["// third"], [],
    ["sep=;"], ["DATE", "05.03.2024"], ['Probe: 5" pin'], ["1", "2", "3"], ["t", "F"], ["[Header]"],
)  # fmt: skip
HEADS = (
    ("t", "F", "temp"), ("t [s]", "F [N]", "temp [\u00b0C]"), ("t(s)", "F(N)", "temp(K)"), ("t / s", "F / N", "temp"),
    ('"t"', '"F"', '"temp"'), ("t (Sec)", "F (Newtons)", "temp"), ("t [ms]", "F [N]", "temp"),
)  # fmt: skip
UNITS = (
    ("s", "N", "\u00b0C"),
    ("(s)", "(N)", "-"),
    ("", "", ""),
    ("SEC", "NEWTON", ""),
    ("s", "mN", "K"),
    ("s", "V", "V"),
)
ENCODINGS = ("utf-8", "utf-8-sig", "latin-1", "cp1252", "utf-16", "utf-16-le", "utf-16-be", "utf-32")


class Kept(Process):
    """The parsers' process, not ended after each damaged file: starting one takes longer than reading it."""

    def close(self) -> None:
        if self._child is not None and self._child.poll() is not None:
            super().close()


class TooLongError(Exception):
    """A file hangs."""


@contextmanager
def within(seconds: int) -> Iterator[None]:
    """Raise after so many seconds."""

    def late(*_: object) -> None:
        raise TooLongError

    signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)


def outcome(file: Path, names: tuple[str, str] = ("t", "F")) -> str:
    """Read a file as a user does, and say what came of it."""
    channels = {"t": ss.Channel(names[0], "s"), "spring_force": ss.Channel(names[1], "N")}
    what = "one line"
    try:
        with within(SECONDS):
            try:
                run = ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s")
                what = compared(run)
            except StickslipError as error:
                check_line(error)
            try:
                inspect(file)
            except StickslipError as error:
                check_line(error)
    except TooLongError:
        return "hang"
    except Exception as error:
        return f"traceback: {type(error).__name__}: {error}"
    return what


def check_line(error: StickslipError) -> None:
    """Raise where a message is no one line."""
    if not str(error).isprintable():
        raise ValueError(f"more than a line: {error!r}")


def compared(run: ss.Recording) -> str:
    """Say whether a recording has the numbers of the good file."""
    said = any(
        word in str(one) for one in run.findings for word in ("cut", "segment", "samples where", "left out")
    )
    if len(run) < N:
        return "fewer, and said" if said else "fewer, unsaid"
    t = run.raw["t"] - run.raw["t"][0]
    same = (
        len(run) == N and np.allclose(t, T, atol=2e-9) and np.allclose(run.raw["spring_force"], F, rtol=1e-7)
    )
    return "same numbers" if same else "other numbers"


# tables in text


def moved(rng: Rng) -> bytes:
    """A table in text over which something was moved."""
    order = rng.permutation(3)
    cells = [[f"{t:.6f}", f"{f:.6f}", str(23 + i)] for i, (t, f) in enumerate(zip(T, F, strict=True))]
    clock = rng.random()
    for i, row in enumerate(cells):
        row[0] = f"10:11:{12 + T[i]:09.6f}" if clock < 0.1 else row[0]
        row[0] = f"2024-03-05T10:11:{12 + T[i]:09.6f}" if clock > 0.9 else row[0]
    heads, units = HEADS[rng.integers(len(HEADS))], UNITS[rng.integers(len(UNITS))]
    separator = ",;\t "[rng.integers(4)]
    sign = "." if separator == "," else ".,"[rng.integers(2)]
    lines: Lines = [[one.replace(".", sign) for one in row] for row in cells]
    top: Lines = [list(heads)] + ([list(units)] if rng.random() < 0.4 else [])
    lines = [[row[i] for i in order] for row in top + lines]
    begin = [list(PREAMBLE[i]) for i in rng.integers(len(PREAMBLE), size=rng.integers(6))]
    lines = begin + lines
    for _ in range(rng.integers(3)):
        lines = one_move(lines, len(begin), len(top), rng)
    end = ("\n", "\r\n", "\r")[rng.choice(3, p=(0.5, 0.4, 0.1))]
    text = end.join(separator.join(row) for row in lines) + end * (rng.random() < 0.8)
    return text.encode(ENCODINGS[rng.choice(len(ENCODINGS))], errors="replace")


def one_move(lines: Lines, at: int, head: int, rng: Rng) -> Lines:
    """Move one thing: a line of the head, a cell, a sign, a separator."""
    lines, first = [list(row) for row in lines], at + head
    row = int(rng.integers(first, len(lines)))
    column = int(rng.integers(max(len(lines[row]), 1)))
    match int(rng.integers(12)):
        case 0:  # the names, or the units, some rows down
            lines.insert(min(first + int(rng.integers(1, 4)), len(lines) - 1), lines.pop(at))
        case 1:  # another line up
            lines.insert(int(rng.integers(at + 1)), lines.pop(first - 1))
        case 2 | 3 as which:
            lines.insert(row, ["# a note among the rows"] * (which - 2))
        case 4:
            lines.insert(row, list(lines[at]))  # the names again
        case 5:
            lines = [[*one, ""] if i >= at else one for i, one in enumerate(lines)]
        case 6:
            lines = [[f" {cell} " for cell in one] for one in lines]
        case 7:
            lines.append(["End of data"])
        case 8 if lines[row]:
            lines[row].insert(column, "")
        case 9 if lines[row]:
            lines[row][column] = lines[row][column].replace(".", ",")
        case 10 if lines[row]:
            lines[row][column] = f'"{lines[row][column]}"'
        case _ if lines[row]:
            cell = lines[row][column]
            other = (
                "n/a",
                "1\u00a0000.5",
                "nan",
                f"\u2212{cell}",
                "1e400",
                f"+{cell}e0",
                "0x10",
                f"{cell}\u00a0",
            )
            lines[row][column] = other[rng.integers(8)]
    return lines


# formats


def written() -> dict[str, tuple[bytes, tuple[str, str]]]:
    """Good files by their ends, with the names of their columns."""
    rows = [f"{t:.6f},{f:.6f}" for t, f in zip(T, F, strict=True)]
    made: dict[str, tuple[bytes, tuple[str, str]]] = {
        "csv": ("\n".join(["t,F", *rows, ""]).encode(), ("t", "F"))
    }
    head = (
        "LabVIEW Measurement\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\n\n"
    )
    head += f"Channels\t1\nSamples\t{N}\nX_Dimension\tTime\nDelta_X\t0.002\n***End_of_Header***\nX_Value\tF\tComment\n"
    made["lvm"] = (head + "".join(row.replace(",", "\t") + "\n" for row in rows)).encode(), ("X_Value", "F")
    with tempfile.TemporaryDirectory() as folder:
        for kind, names, write in WRITERS:
            file = Path(folder) / f"run.{kind}"
            write(file)
            made[kind] = file.read_bytes(), names
            if kind == "tdms":
                made["tdms_index"] = file.with_suffix(".tdms_index").read_bytes(), names
    return made


def tdms(file: Path) -> None:
    with nptdms.TdmsWriter(str(file), index_file=True) as writer:
        for part in np.array_split(F, 4):
            said = {"wf_increment": 0.002, "unit_string": "N"}
            writer.write_segment([nptdms.ChannelObject("run", "F", part, properties=said)])


def hdf5(file: Path) -> None:
    with h5py.File(file, "w") as f:
        f["t"], f["F"] = T, F


def matlab(file: Path) -> None:
    scipy.io.savemat(file, {"t": T, "F": F})


def matlab73(file: Path) -> None:
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", userblock_size=512) as f:
        for name, values in (("t", T), ("F", F)):
            f[name] = values[None]
            f[name].attrs["MATLAB_class"] = np.bytes_("double")
    content = bytearray(buffer.getvalue())
    content[:128] = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    file.write_bytes(content)


def parquet(file: Path) -> None:
    pq.write_table(pa.table({"t": T, "F": F}), file)


def wav(file: Path) -> None:
    scipy.io.wavfile.write(file, 500, F)


WRITERS: list[tuple[str, tuple[str, str], Callable[[Path], None]]] = [
    ("tdms", ("run/t", "run/F"), tdms), ("h5", ("t", "F"), hdf5), ("mat", ("t", "F"), matlab),
    ("mat73", ("t", "F"), matlab73), ("parquet", ("t", "F"), parquet), ("wav", ("t", "channel 1"), wav),
]  # fmt: skip


def damaged(good: bytes, how: int, rng: Rng) -> bytes:
    """A file of which something is not as it was."""
    data = bytearray(good)
    at = int(rng.integers(len(data)))
    match how % 8:
        case 0 | 1:
            del data[at:]
        case 2:
            for one in rng.integers(len(data), size=rng.integers(1, 9)):
                data[one] ^= 1 << int(rng.integers(8))
        case 3:  # in the head, where the sizes are
            data[int(rng.integers(min(len(data), 400)))] = int(rng.integers(256))
        case 4:
            data[at : at + 64] = bytes(len(data[at : at + 64]))
        case 5:
            data[: rng.integers(1, 9)] = rng.bytes(8)
        case 6:
            data[at:at] = rng.bytes(int(rng.integers(1, 40)))
        case _:
            data = bytearray(bytes(len(data)) if rng.random() < 0.1 else data[at:] + data[:at])
    return bytes(data)


# the table


def tried(files: Iterator[tuple[bytes, str, tuple[str, str]]], keep: Path | None) -> collections.Counter[str]:
    """Count what comes of files, given as their bytes, their end and their columns."""
    count: collections.Counter[str] = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        for i, (content, end, names) in enumerate(files):
            file = Path(folder) / f"run{i}.{end}"
            file.write_bytes(content)
            what = outcome(file, names)
            kind = what.partition(":")[0]
            count[kind] += 1
            if keep is not None and (kind in BAD or (end == "txt" and kind in SHIFTED)):
                (keep / f"{kind.replace(', ', '_').replace(' ', '_')}_{i}.{end}").write_bytes(content)
                print(f"  {end} {i}: {what[:150]}", flush=True)
            file.unlink()
    return count


def said(name: str, count: collections.Counter[str]) -> None:
    print(f"{name:12}" + "".join(f"{count[kind]:17}" for kind in KINDS), flush=True)


def main() -> int:
    """Write, read, count; the exit status is 1 where something is not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--texts", type=int, default=10_000)
    parser.add_argument("--damaged", type=int, default=2_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    given = parser.parse_args()
    if given.keep is not None:
        given.keep.mkdir(parents=True, exist_ok=True)
    kept: Any = Kept()
    container.PROCESS = kept
    warnings.simplefilter("ignore")
    print(f"{'':12}" + "".join(f"{kind:>17}" for kind in KINDS))
    rng = np.random.default_rng(given.seed)
    count = tried(((moved(rng), "txt", ("t", "F")) for _ in range(given.texts)), given.keep)
    said("text, moved", count)
    wrong = sum(count[kind] for kind in (*BAD, *SHIFTED))
    for end, (good, names) in written().items():
        suffix = "mat" if end == "mat73" else end
        files = ((damaged(good, i, rng), suffix, names) for i in range(given.damaged))
        count = tried(files, given.keep)
        said(end, count)
        wrong += sum(count[kind] for kind in BAD)
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
