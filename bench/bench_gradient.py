"""Price of a gradient: derivatives by 12 parameters beside plain runs of the same trajectory.

Usage: python bench/bench_gradient.py [--repeat 200]

Plain runs and gradients take turns in one process; the medians of processor time are compared. The
gradient is first held to central differences. Exits with an error where it is wrong or costs more than 6 plain runs.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable

import numpy as np

import stickslip as ss

NAMES = (
    "alpha1", "alpha2", "beta3", "eta1", "eta12", "T_s_minus", "A1", "A2", "t1", "t2", "belt_speed", "initial.x1",
)  # fmt: skip
RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
START = 0.3  # x1; the block rests on the belt
LIMIT = 6.0


def final(values: dict[str, float], t_end: float, names: tuple[str, ...] = ()) -> ss.Trajectory:
    """Run the reference rig with some numbers moved, to one sample at the end."""
    numbers = dict(values)
    v_b, x1 = numbers.pop("belt_speed", 0.1), numbers.pop("initial.x1", START)
    model = ss.Model(RIG, friction=ss.PaperFriction()).replace(numbers)
    return ss.simulate(
        model, belt_speed=v_b, initial=(x1, v_b, 0.0, 0.0), t_end=t_end, t_eval=[t_end], sensitivity=names,
    )  # fmt: skip


def check(t_end: float) -> float:
    """Greatest relative error of the gradient against central differences of fourth order."""
    gradient = final({}, t_end, NAMES).sensitivity[0]
    base = {"belt_speed": 0.1, "initial.x1": START, **ss.Model(RIG, friction=ss.PaperFriction()).parameters}
    worst = 0.0
    for k, name in enumerate(NAMES):
        h = 1e-4 * abs(base[name])
        moved = [final({name: base[name] + j * h}, t_end).state[0] for j in (1, -1, 2, -2)]
        slope = (8 * (moved[0] - moved[1]) - (moved[2] - moved[3])) / (12 * h)
        worst = max(worst, float(np.abs(gradient[:, k] - slope).max() / np.abs(slope).max()))
    return worst


def medians(calls: list[Callable[[], object]], repeat: int) -> list[float]:
    """Median processor seconds of each call, the calls taking turns."""
    times = np.zeros((repeat, len(calls)))
    for row in times:
        for j, call in enumerate(calls):
            begin = time.process_time()
            call()
            row[j] = time.process_time() - begin
    return [float(x) for x in np.median(times, axis=0)]


def main() -> None:
    """Check, measure, report."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeat", type=int, default=200)
    options = parser.parse_args()
    error = check(60.0)
    plain, gradient = medians(
        [lambda: final({}, 1000.0), lambda: final({}, 1000.0, NAMES)],
        options.repeat,
    )
    print(json.dumps({"build": ss.build_config(), "transitions": len(final({}, 1000.0).transitions)}))
    print(f"gradient by {len(NAMES)} parameters against central differences: relative error {error:.1e}")
    print(
        f"plain run {plain * 1e3:.3f} ms, gradient {gradient * 1e3:.3f} ms: {gradient / plain:.2f} plain runs"
    )
    if error > 1e-7:
        sys.exit("the gradient is wrong")
    if gradient > LIMIT * plain:
        sys.exit(f"the gradient costs more than {LIMIT:g} plain runs")


if __name__ == "__main__":
    main()
