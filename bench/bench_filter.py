"""(3.1) against scipy.signal.lfilter, in the same run and in turn, the answers compared first.

Usage: python bench/bench_filter.py [--repeats 15] [--json FILE]

Measure on a plain install (not an editable one). Prints median times and their ratio; fails if the
answers differ by more than rounding, or with --require R if a ratio falls below R.
"""

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

import stickslip
from stickslip.measured.signals import differentiator, first_order

CASES = {"1 channel x 1e6 samples": (1_000_000,), "8 channels x 1e6 samples": (1_000_000, 8)}


def rivals(x: NDArray[np.float64]) -> dict[str, Callable[[], NDArray[np.float64]]]:
    d = differentiator(dt=1e-3, tau=1e-2)
    start = -d.k0 * x[:1]  # lfilter supposes zeros before x[0]; this state makes its y[0] = 0
    return {
        "stickslip": lambda: first_order(x, d.a, d.k0, d.k1),
        "scipy": lambda: lfilter([d.k0, d.k1], [1.0, -d.a], x, axis=0, zi=start)[0],
    }


def measure(x: NDArray[np.float64], repeats: int) -> dict[str, float]:
    calls = rivals(x)
    ours, theirs = (call() for call in calls.values())
    difference = float(np.abs(ours - theirs).max())
    allowed = 1e-13 * float(np.abs(theirs).max())
    if difference > allowed:
        sys.exit(f"the answers differ by {difference:g}, more than {allowed:g}")
    del ours, theirs
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            begin = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - begin)
    medians = {name: statistics.median(t) for name, t in times.items()}
    return {**medians, "ratio": medians["scipy"] / medians["stickslip"], "difference": difference}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--require", type=float, default=0.0, help="fail below this ratio")
    parser.add_argument("--json", type=Path, help="also write the results here")
    options = parser.parse_args()
    random = np.random.default_rng(7)
    results = {}
    print(f"{'case':26} {'stickslip':>11} {'scipy':>11} {'ratio':>7} {'difference':>11}")
    for name, shape in CASES.items():
        r = measure(random.normal(size=shape).cumsum(axis=0), options.repeats)
        results[name] = r
        times = f"{1e3 * r['stickslip']:8.2f} ms {1e3 * r['scipy']:8.2f} ms"
        print(f"{name:26} {times} {r['ratio']:7.2f} {r['difference']:11.2g}")
    if options.json:
        record = {"build": stickslip.build_config(), "numpy": np.__version__, "results": results}
        options.json.write_text(json.dumps(record, indent=2) + "\n")
    worst = min(r["ratio"] for r in results.values())
    if worst < options.require:
        sys.exit(f"ratio {worst:.2f} is below the {options.require:g} required")


if __name__ == "__main__":
    main()
