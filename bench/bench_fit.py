"""Fit of the declared law to six runs of 2,500 samples, beside a library's least squares on the same residuals.

Usage: python bench/bench_fit.py [--repeat 5] [--threads 2]

The readings are simulated with noise; the fit starts from Table 1, about a tenth off. The rival is scipy's
trust-region least squares with the same exact derivatives, in which the windows' own states are unknowns like the
others. Exits with an error where the two do not reach the same chi-squared, or it is not that of the noise.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import block_diag, csr_matrix, hstack, vstack

import stickslip as ss
from stickslip.declared.units import Channel
from stickslip.fitted.data import prepare
from stickslip.fitted.engine import Engine
from stickslip.fitted.solve import LeastSquaresFit, fit
from stickslip.fitted.unknowns import Hypothesis, law_unknowns
from stickslip.fitted.window import moved
from stickslip.fitted.windows import cut
from stickslip.measured.case import Recording

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
LAW = ss.PaperFriction(
    T_s_minus=5.4, A1=3.0, A2=3.1, t1=0.037, t2=0.28, T_min_minus=1.55, T_s_plus=3.9, T_min_plus=0.8
)
SPEEDS = (0.06, 0.1, 0.14, -0.06, -0.1, -0.14)
SAMPLES, STEP, NOISE = 2500, 0.04, 1e-3


def recordings() -> list[Recording]:
    """Six runs of the reference rig with noise on both readings."""
    rng = np.random.default_rng(5)
    t = STEP * np.arange(SAMPLES)
    out = []
    for i, speed in enumerate(SPEEDS):
        run = ss.simulate(
            ss.Model(RIG, friction=LAW), belt_speed=speed, initial=(0.1 * np.sign(speed), speed, 0.05, 0.0),
            t_end=float(t[-1]), t_eval=t,
        )  # fmt: skip
        x, y = (run.state[:, k] + NOISE * rng.standard_normal(SAMPLES) for k in (0, 2))
        raw, channels = {"t": t, "x1": x, "y1": y}, {one: Channel(one) for one in ("t", "x1", "y1")}
        given, factors = {"x1": NOISE, "y1": NOISE}, dict.fromkeys(raw, 1.0)
        source = Path(f"run_{i}.csv")
        out.append(
            Recording(f"run_{i}", "train", RIG, speed, t, x, y, None, raw, channels, factors, given, source)
        )
    return out


def by_library(engine: Engine, windows: list, vector: NDArray[np.float64]) -> float:
    """chi-squared that scipy's least squares reaches on the same windows."""
    p = len(vector)
    ends = p + np.cumsum([0, *(len(w.free) for w in windows)])

    def parts(z: NDArray[np.float64]) -> list:
        own = [
            moved(w, z[a:b] - w.state[list(w.free)])
            for w, a, b in zip(windows, ends[:-1], ends[1:], strict=True)
        ]
        blocks = engine.blocks(z[:p], own)
        if blocks is None:
            raise SystemExit("bench_fit: the rival went where nothing can be simulated")
        return blocks

    def residual(z: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.concatenate([b.r for b in parts(z)])

    def jacobian(z: NDArray[np.float64]) -> csr_matrix:
        blocks = parts(z)
        shared = vstack([csr_matrix(-b.J) for b in blocks])
        return csr_matrix(hstack([shared, block_diag([-b.K for b in blocks])]))

    start = np.concatenate([vector, *(w.state[list(w.free)] for w in windows)])
    found = least_squares(residual, start, jacobian, method="trf", x_scale="jac", ftol=1e-6)
    return float(2 * found.cost)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    told = parser.parse_args()
    data = prepare(recordings())
    start = ss.Model(RIG, friction=ss.PaperFriction())
    h = Hypothesis(start, law_unknowns(start, start), {})

    def ours() -> LeastSquaresFit:
        found = fit(Engine(data, h, told.threads), h.start(len(data)), cut(data, h.model, 1.0))
        if found is None:
            raise SystemExit("bench_fit: the fit failed")
        return found

    seconds = []
    for _ in range(told.repeat):
        begin = time.perf_counter()
        found = ours()
        seconds.append(time.perf_counter() - begin)
    begin = time.perf_counter()
    engine = Engine(data, h, told.threads)
    theirs = by_library(engine, cut(data, h.model, 1.0), h.start(len(data)))
    library = time.perf_counter() - begin
    out = {
        "readings": found.readings,
        "windows": len(found.windows),
        "seconds": float(np.median(seconds)),
        "seconds by scipy": library,
        "chi-squared per reading": found.per_reading,
        "chi-squared": found.chi2,
        "chi-squared by scipy": theirs,
    }
    rounded = {name: one if isinstance(one, int) else float(f"{one:.6g}") for name, one in out.items()}
    print(json.dumps(rounded, indent=2))
    wrong = abs(found.per_reading - 1) > 4 * np.sqrt(2 / found.readings) or found.chi2 > 1.001 * theirs + 1
    if wrong:
        print("bench_fit: the fit did not reach the noise, or the library's fit is better", file=sys.stderr)
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
