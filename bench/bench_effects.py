"""Sweeps of models with effects: lanes against the scalar kernel, effect by effect, on one thread.

Usage: python bench/bench_effects.py [--repeats 3] [--members 2048]

Every answer of the lanes is held to the scalar kernel's before a time is taken. Measure on a quiet machine.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import stickslip as ss

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from every_effect import EFFECTS

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)


def sweep(kind: str, members: int, lanes: bool) -> Any:
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=EFFECTS[kind])
    over = {"belt_speed": np.linspace(0.02, 0.3, members // 32), "alpha1": np.linspace(10, 24, 32)}
    given = {"initial": (0.1, 0.1, 0, 0), "t_end": 100, "threads": 1, "rtol": 1e-8, "atol": 1e-8}
    observe = ("final_state", "transitions", "stick_fraction", "status")
    return ss.sweep(model, over, lanes=lanes, observe=observe, **given)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--members", type=int, default=2048)
    options = parser.parse_args()
    print(
        f"{ss.build_config()['isa']}, {ss.build_config()['simd_width']} lanes; microseconds a member to t = 100"
    )
    ratios = []
    for kind in EFFECTS:
        times: dict[bool, list[float]] = {False: [], True: []}
        results = {}
        for _ in range(options.repeats):
            for lanes in (False, True):
                begin = time.perf_counter()
                results[lanes] = sweep(kind, options.members, lanes)
                times[lanes].append((time.perf_counter() - begin) * 1e6 / options.members)
        apart = float(np.abs(results[True].final_state - results[False].final_state).max())
        if apart > 1e-7 or (results[True].transitions != results[False].transitions).any():
            sys.exit(f"{kind}: lanes and scalar kernel differ by {apart:.1e}")
        ratios.append(statistics.median(a / b for a, b in zip(times[False], times[True], strict=True)))
        alone, together = (statistics.median(times[lanes]) for lanes in (False, True))
        print(f"{kind:<32}{alone:8.0f} scalar{together:8.0f} lanes{ratios[-1]:7.2f}x", flush=True)
    print(f"median {statistics.median(ratios):.2f}x, least {min(ratios):.2f}x")


if __name__ == "__main__":
    main()
