"""Derivatives of 100 random rigs, through 20 transitions each, against differences in extended precision.

Usage: python bench/bench_exact.py

The greatest error beside the greatest derivative of its kind (transition times, states at them, state at a fixed time).
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from test_derivatives import members

BOUND = 1e-7


def main() -> int:
    errors = np.concatenate([members(seed) for seed in range(4)])
    print(f"{len(errors)} rigs: greatest relative error {errors.max():.1e}, median {np.median(errors):.1e}")
    return int(errors.max() > BOUND)


if __name__ == "__main__":
    sys.exit(main())
