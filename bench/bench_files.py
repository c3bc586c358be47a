"""Reading large files: processor time and memory of `load_recording`, beside what the library alone takes.

Usage: python bench/bench_files.py [--megabytes 200] [--columns 2 10] [--points 5000000] [--segment 100]

Writes a CSV of so many megabytes for each number of columns, and a TDMS file of so many points in segments, into a
temporary folder; each is read in a process of its own, by the library alone and by the package. Needs npTDMS.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROWS = 200_000  # written at once
READ = {
    "pandas": "import pandas; pandas.read_csv({file!r}, usecols=[0, 1])",
    "pandas, all": "import pandas; pandas.read_csv({file!r})",
    "npTDMS": "from nptdms import TdmsFile\nwith TdmsFile.open({file!r}) as f:\n [c[:] for c in f['run'].channels()]",
    "stickslip": "import stickslip as ss\nss.load_recording({file!r}, ss.BlockOnBelt(mass=0.5, stiffness=500.0), "
    "channels={{'t': ss.Channel('t', 's'), 'spring_force': ss.Channel('F', 'N')}}, belt_speed='5 mm/s')",
    "inspect": "from stickslip.measured.inspection import inspect; inspect({file!r})",
}
MEASURED = """
import json, resource, sys, time
begin = time.perf_counter()
exec(sys.argv[1])
took = time.perf_counter() - begin
from stickslip.measured.readers.process import PROCESS
PROCESS.close()
who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
used = [resource.getrusage(one) for one in who]
print(json.dumps({"processor_s": sum(u.ru_utime + u.ru_stime for u in used), "wall_s": took,
                  "peak_mib": [u.ru_maxrss / 1024 for u in used]}))
"""


def measured(how: str, file: Path) -> dict[str, float]:
    """What one way of reading a file takes, imports included."""
    code = READ[how].replace("\\\n", "\n").format(file=str(file))
    done = subprocess.run([sys.executable, "-c", MEASURED, code], capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def write_csv(file: Path, megabytes: int, columns: int) -> int:
    """Write t and forces in so many columns; return the rows."""
    x = 1.5 + 0.4 * np.sin(0.3 * np.arange(ROWS)[:, None] + np.arange(columns - 1))
    rest = [",".join(f"{v:.6f}" for v in row) for row in x.tolist()]
    rows = 0
    with file.open("w") as stream:
        stream.write(",".join(["t [s]", "F [N]", *(f"c{i}" for i in range(columns - 2))]) + "\n")
        while stream.tell() < 1e6 * megabytes:
            stream.write("".join(f"{(rows + i) * 1e-4:.4f},{one}\n" for i, one in enumerate(rest)))
            rows += ROWS
    return rows


def write_tdms(file: Path, points: int, segment: int) -> None:
    """Write two channels in segments of so many points."""
    import nptdms

    t = np.arange(points) * 1e-4
    force = 1.5 + 0.4 * np.sin(0.3 * np.arange(points))
    with nptdms.TdmsWriter(str(file)) as writer:
        for i in range(0, points, segment):
            part = slice(i, i + segment)
            writer.write_segment(
                [nptdms.ChannelObject("run", "t", t[part]), nptdms.ChannelObject("run", "F", force[part])]
            )


def compare(what: str, file: Path, ways: tuple[str, ...]) -> None:
    """Print what the ways of reading a file take, the first being the library's of as many columns."""
    alone = 0.0
    for how in ways:
        got = measured(how, file)
        alone = alone or got["processor_s"]
        here, child = got["peak_mib"]
        print(
            f"{what:34} {how:11} {got['processor_s']:7.1f} s of processor, {got['processor_s'] / alone:5.2f} times, "
            f"{got['wall_s']:7.1f} s, peak {here:6.0f} MiB"
            + (f" and {child:.0f} MiB of its parser" if child else ""),
            flush=True,
        )


def main() -> None:
    """Write, read, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--megabytes", type=int, default=200)
    parser.add_argument("--columns", type=int, nargs="*", default=[2, 10])
    parser.add_argument("--points", type=int, default=5_000_000)
    parser.add_argument("--segment", type=int, default=100)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for columns in given.columns:
            file = Path(folder) / "run.csv"
            rows = write_csv(file, given.megabytes, columns)
            what = f"CSV, {rows} rows of {columns}"
            compare(what, file, ("pandas", "stickslip"))
            compare(what, file, ("pandas, all", "inspect"))
        if given.points:
            file = Path(folder) / "run.tdms"
            write_tdms(file, given.points, given.segment)
            compare(f"TDMS, {given.points} points of 2", file, ("npTDMS", "stickslip"))


if __name__ == "__main__":
    main()
