"""Run the benchmarks, all or those named, one after the other.

    python bench/run.py [--store] [NAME ...]

--store keeps what each prints in bench/results/NAME.json, with the machine, the build and how busy the machine was; the
site makes its page of benchmarks of these files. What fails is not stored.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import platform
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import stickslip

HERE = Path(__file__).parent
RESULTS = HERE / "results"
KNOWN = {path.stem.removeprefix("bench_"): path for path in sorted(HERE.glob("bench_*.py"))}


def main(given: list[str] | None = None) -> int:
    """Run, print, and store where asked; return how the shell should see it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--store", action="store_true")
    asked = parser.parse_args(given)
    names = asked.names or list(KNOWN)
    if strangers := [name for name in names if name not in KNOWN]:
        print(f"bench: no benchmark {strangers[0]!r}; there are {', '.join(KNOWN)}", file=sys.stderr)
        return 2
    for key, value in stickslip.build_config().items():
        print(f"{key}: {value}")
    failed = []
    for name in names:
        print(f"\n== {name}", flush=True)
        if not run(KNOWN[name], RESULTS / f"{name}.json" if asked.store else None):
            failed.append(name)
    print(
        f"\n{len(names) - len(failed)} benchmarks ran" + (f", failed: {', '.join(failed)}" if failed else "")
    )
    return int(bool(failed))


def run(program: Path, into: Path | None = None) -> bool:
    """Run one, showing what it prints as it comes; store it; return whether it succeeded."""
    busy, began = os.getloadavg()[0], time.monotonic()
    printed = []
    with subprocess.Popen([sys.executable, "-u", program], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            print(line, end="", flush=True)
            printed.append(line.rstrip())
    if process.returncode == 0 and into is not None:
        result = {
            "what": (ast.get_docstring(ast.parse(program.read_text(encoding="utf-8"))) or "").splitlines()[0],
            "command": f"python bench/{program.name}",
            "printed": printed,
            "seconds": round(time.monotonic() - began, 1),
            "date": datetime.now(UTC).date().isoformat(),
            "installed": not Path(stickslip.__file__).is_relative_to(HERE.parent / "python"),
            "machine": {"processor": processor(), "cores": os.cpu_count(), "load": round(busy, 1)},
            "build": stickslip.build_config(),
        }
        into.parent.mkdir(exist_ok=True)
        into.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return process.returncode == 0


def processor() -> str:
    """What the processor calls itself."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text(encoding="utf-8").splitlines() if told.exists() else []
    return next(
        (line.partition(":")[2].strip() for line in lines if line.startswith("model name")),
        platform.processor(),
    )


if __name__ == "__main__":
    sys.exit(main())
