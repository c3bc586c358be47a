"""Cost of a step of the core on chains of 1 to 8 blocks, and of a law as a tape beside the named one.

    python bench/bench_bodies.py

Asserts that runs end, and that eight coordinates cost no more than n^2 would make of one.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

import stickslip as ss
from bodies_core import Bodies, Law
from stickslip import _core

T_END = 400.0
LAWS = {
    "linear in u": (Law("Fk + 0.02*u", "Fs"), {"Fk": 0.6, "Fs": 1.0}),
    "stribeck": (Law("Fk + (Fs - Fk)*exp(-(u/vs)**2) + 0.02*u", "Fs"), {"Fk": 0.6, "Fs": 1.0, "vs": 0.2}),
}


def chain(n: int, law: Law, numbers: dict[str, float]) -> Bodies:
    """Blocks in a row, the first of them on a belt."""
    K = np.eye(n) * 2.6 - 0.8 * (np.eye(n, k=1) + np.eye(n, k=-1))
    return Bodies(np.eye(n), 0.02 * K, K, np.eye(n)[:1], [law], numbers, [[(0.0, "0.1")]])


def best(run: Callable[[], object], times: int = 15) -> float:
    """Least time of several calls, in seconds."""
    out = []
    for _ in range(times):
        begin = time.process_time()
        run()
        out.append(time.process_time() - begin)
    return min(out)


def main() -> None:
    """Print microseconds a step."""
    print("n   " + "   ".join(f"{name:>14}" for name in LAWS) + "   us a step")
    costs = {}
    for n in range(1, 9):
        for name, (law, numbers) in LAWS.items():
            rig, start = chain(n, law, numbers), [0.5] + [0.0] * (2 * n - 1)

            def run(t_end: float = T_END, rig: Bodies = rig, start: list[float] = start) -> dict[str, object]:
                return rig.run(start, t_end, t_eval=[t_end], rtol=1e-10, atol=1e-12)

            got = run()
            assert got["outcome"] == _core.Outcome.finished
            costs[n, name] = (best(run) - best(lambda run=run: run(1e-9))) / got["steps"] * 1e6
        print(f"{n}   " + "   ".join(f"{costs[n, name]:14.2f}" for name in LAWS))
    for name in LAWS:
        assert costs[8, name] < 64 * costs[1, name]
    model = ss.Model(
        rig=ss.BlockOnBelt(mass=1, stiffness=1), friction=ss.HyperbolicFriction(scale=1, decay=3)
    )
    rig = Bodies(
        np.eye(1), np.zeros((1, 1)), np.eye(1), np.eye(1), [Law("scale/(1 + decay*u)", "scale")],
        {"scale": 1.0, "decay": 3.0}, [[(0.0, "0.2")]],
    )  # fmt: skip
    options = {"t_eval": [2000.0], "rtol": 1e-10, "atol": 1e-12}
    named = best(lambda: ss.simulate(model, belt_speed=0.2, initial=(0.5, 0.0), t_end=2000.0, **options))
    tape = best(lambda: rig.run([0.5, 0.0], 2000.0, **options))
    print(f"hyperbolic block on a belt: named {named * 1e3:.2f} ms, as a tape {tape * 1e3:.2f} ms")


if __name__ == "__main__":
    main()
