"""Where the time of a sweep goes: samples of the processor in workload P2 on one thread, by kind of work.

Usage: python bench/profile_sweep.py [--isa avx2] [--repeats 40] [--build build/profile]

Builds the core with symbols into its own folder (the installed one is stripped), and needs Linux's `perf`. Prints the
share of the core's samples in each kind of work, as JSON; what Python and the libraries below it take is left out.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
KINDS = {
    "expansion": r"expand|exp_poly",
    "landing": r"land|iterate|count_signs|only_root|stays_positive|crossing|sign_change|to_bernstein",
    "step length": r"step_from|step_plain|rough",
    "entering, leaving, changing mode": r"enter|finish_step|change|leave|copy_|start_member|build|fill_idle|report",
    "evaluation, bounds, moving on": r"run|evaluate|suspects|step|observe",
}
CHILD = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("stickslip._core", {core!r})
module = importlib.util.module_from_spec(spec); sys.modules["stickslip._core"] = module
spec.loader.exec_module(module)
sys.path.insert(0, {folder!r})
import numpy as np, bench_sweep as b
for _ in range({repeats}): b.sweep(np.arange(4096))
"""


def build(folder: Path) -> Path:
    """The core with symbols."""
    flags = [
        "-DCMAKE_CXX_FLAGS=-g -Wno-error",
        "-DCMAKE_STRIP=/bin/true",
        f"-DPython_EXECUTABLE={sys.executable}",
    ]
    subprocess.run(
        ["cmake", "--preset", "dev", "-B", str(folder), *flags],
        cwd=ROOT,
        check=True,
        stdout=subprocess.DEVNULL,
    )
    subprocess.run(
        ["cmake", "--build", str(folder), "--target", "_core"], check=True, stdout=subprocess.DEVNULL
    )
    return folder / f"_core{sysconfig.get_config_var('EXT_SUFFIX')}"


def samples(core: Path, isa: str | None, repeats: int) -> dict[str, float]:
    """Samples by function of the core."""
    code = CHILD.format(core=str(core), folder=str(ROOT / "bench"), repeats=repeats)
    chosen = {"STICKSLIP_ISA": isa} if isa else {}
    with tempfile.TemporaryDirectory() as folder:
        data = f"{folder}/perf.data"
        record = ["perf", "record", "-q", "-o", data, sys.executable, "-c", code]
        subprocess.run(record, env={**os.environ, **chosen}, check=True)
        report = ["perf", "report", "-i", data, "--no-children", "--dsos", core.name, "--sort", "symbol"]
        text = subprocess.run(report, check=True, capture_output=True, text=True).stdout
    found = re.findall(r"^\s+([\d.]+)%\s+\[\.\]\s+(.+?)\s*(?:-\s+-)?\s*$", text, re.MULTILINE)
    return {name: float(share) for share, name in found}


def kind(symbol: str) -> str:
    """Kind of work of a function, by its bare name."""
    bare = symbol
    while "<" in bare:  # template arguments, the innermost first
        shorter = re.sub(r"<[^<>]*>", "", bare)
        if shorter == bare:
            break
        bare = shorter
    name = bare.split("(")[0].split("::")[-1]
    return next((kind for kind, pattern in KINDS.items() if re.search(pattern, name)), "other")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--isa", choices=("baseline", "avx2", "avx512"), help="instruction set (default: the best)"
    )
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "profile")
    options = parser.parse_args()
    counted = samples(build(options.build), options.isa, options.repeats)
    whole = sum(counted.values())
    if not whole:
        sys.exit("no samples fell in the core: is the build stripped, or perf not allowed to count?")
    shares = dict.fromkeys([*KINDS, "other"], 0.0)
    for symbol, share in counted.items():
        shares[kind(symbol)] += share / whole
    print(json.dumps({name: round(share, 3) for name, share in shares.items()}, indent=2))


if __name__ == "__main__":
    main()
