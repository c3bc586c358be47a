"""Velocity and acceleration of a noisy stick-slip record: (3.1), a low-pass and the smoother against the truth.

Usage: python bench/bench_derivatives.py [--figure docs/figures/derivatives]

Prints the root-mean-square errors, (3.1) and the low-pass each at the setting that suits them best (the
smoother gets no such help), and draws one stick-slip cycle as SVG and PNG.
"""

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from stickslip.measured.signals import Derivatives, Smoothed, derivatives, lowpass, smooth

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from stick_slip_truth import Truth, paper_rig

DT = 0.04
TAUS = np.geomspace(0.01, 1.0, 25)
Floats = NDArray[np.float64]


def rms(error: Floats) -> float:
    return float(np.sqrt(np.mean(error**2)))


def delayed(truth: Truth, name: str, lag: float) -> Floats:
    return np.interp(truth.t - lag, truth.t, getattr(truth, name))


def best_recursion(truth: Truth, x: Floats, align: str, name: str) -> tuple[float, Derivatives]:
    tried = []
    for tau in TAUS:
        d = derivatives(x, DT, float(tau), align=align)  # type: ignore[arg-type]
        lag = getattr(d, "lag_" + name) if align == "match" else 0.0
        tried.append((rms((getattr(d, name) - delayed(truth, name, lag))[d.settled]), d))
    return min(tried, key=lambda pair: pair[0])


def best_lowpass(truth: Truth, x: Floats, name: str) -> float:
    errors = []
    for cutoff in np.geomspace(0.2, 6.0, 20):
        y = lowpass(x, DT, float(cutoff)).x
        v = np.gradient(y, DT)
        errors.append(rms((v if name == "v" else np.gradient(v, DT)) - getattr(truth, name)))
    return min(errors)


def table(truth: Truth, sigmas: tuple[float, ...]) -> None:
    print(f"{'noise':>7}  {'method':38} {'v rms':>9} {'a rms':>9}")
    for sigma in sigmas:
        x = truth.x + sigma * np.random.default_rng(1).normal(size=truth.t.size)
        smoothed = smooth(truth.t, x, belt_speed=truth.belt_speed)
        spline = smooth(truth.t, x)
        rows = {
            "(3.1), lag left in": [best_recursion(truth, x, "none", q)[0] for q in "va"],
            "(3.1), shifted": [best_recursion(truth, x, "shift", q)[0] for q in "va"],
            "(3.1), matched": [best_recursion(truth, x, "match", q)[0] for q in "va"],
            "elliptic, zero phase, differences": [best_lowpass(truth, x, q) for q in "va"],
            "smoothing spline (no belt given)": [rms(spline.v - truth.v), rms(spline.a - truth.a)],
            "stick-slip smoother": [rms(smoothed.v - truth.v), rms(smoothed.a - truth.a)],
        }
        for method, (v, a) in rows.items():
            print(f"{sigma:7.4f}  {method:38} {v:9.5f} {a:9.5f}")


def draw(truth: Truth, sigma: float, stem: Path) -> None:
    x = truth.x + sigma * np.random.default_rng(1).normal(size=truth.t.size)
    smoothed = smooth(truth.t, x, belt_speed=truth.belt_speed)
    chain = best_recursion(truth, x, "match", "a")[1]
    late = derivatives(x, DT, chain.differentiator.tau, align="none")
    figure, axes = plt.subplots(2, 2, figsize=(10, 6.4), width_ratios=(1.7, 1), layout="constrained")
    window = (22.4, 30.0)
    panel(axes[0, 0], truth, smoothed, (late.v, chain.v, chain.lag_v), "v", window)
    panel(axes[1, 0], truth, smoothed, (late.a, chain.a, chain.lag_a), "a", window)
    axes[0, 0].set_ylabel("velocity")
    axes[1, 0].set(ylabel="acceleration", xlabel="time")
    phase(axes[0, 1], axes[1, 1], truth, smoothed, late, chain)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=5, frameon=False)
    stem.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(stem.with_suffix(".svg"), metadata={"Date": None})
    figure.savefig(stem.with_suffix(".png"), dpi=150)


COLOURS = {"truth": "0.15", "late": "#c9a227", "chain": "#2a6fbb", "smoother": "#d1495b"}


def panel(
    axes: Axes, truth: Truth, smoothed: Smoothed, recursion: tuple[Floats, Floats, float], name: str,
    window: tuple[float, float],
) -> None:  # fmt: skip
    late, chain, lag = recursion
    value, std = getattr(smoothed, name), getattr(smoothed, name + "_std")
    for begin, end in smoothed.sticks:
        axes.axvspan(
            begin, end, color="0.93", lw=0, label="stick found" if begin == smoothed.sticks[0, 0] else None
        )
    axes.plot(truth.t, late, color=COLOURS["late"], lw=1.0, label="(3.1) as it comes")
    axes.plot(truth.t - lag, chain, color=COLOURS["chain"], lw=1.2, label="(3.1), lag compensated")
    axes.fill_between(
        smoothed.t, value - 2 * std, value + 2 * std, color=COLOURS["smoother"], alpha=0.25, lw=0
    )
    axes.plot(smoothed.t, value, color=COLOURS["smoother"], lw=1.8, label="smoother, ±2 std")
    axes.plot(truth.t, getattr(truth, name), color=COLOURS["truth"], lw=1.0, ls=(0, (4, 2)), label="truth")
    axes.set_xlim(window)
    inside = (truth.t > window[0]) & (truth.t < window[1])
    low, high = getattr(truth, name)[inside].min(), getattr(truth, name)[inside].max()
    axes.set_ylim(low - 0.22 * (high - low), high + 0.22 * (high - low))
    axes.spines[["top", "right"]].set_visible(False)


def phase(
    upper: Axes, lower: Axes, truth: Truth, smoothed: Smoothed, late: Derivatives, chain: Derivatives
) -> None:
    """Friction on the block from each estimate, T = -alpha1 (a + x1) - eta1 (v + y2) - y1, over v_w."""
    y2 = np.gradient(truth.y, truth.t)

    def force(x: Floats, v: Floats, a: Floats, lag: float) -> Floats:
        y, rate = np.interp(truth.t - lag, truth.t, truth.y), np.interp(truth.t - lag, truth.t, y2)
        return np.asarray(-16.0 * (a + x) - 0.1 * (v + rate) - y)

    v_b = truth.belt_speed
    slip = truth.mode != 0
    exact = force(truth.x, truth.v, truth.a, 0.0)
    for axes, points, colour, name in (
        (upper, (chain.v, force(chain.x, chain.v, chain.a, chain.lag_x)), COLOURS["chain"], "chain"),
        (
            lower,
            (smoothed.v, force(smoothed.x, smoothed.v, smoothed.a, 0.0)),
            COLOURS["smoother"],
            "smoother",
        ),
    ):
        if name == "chain":
            unaligned = force(late.x, late.v, late.a, 0.0)
            axes.plot(late.v - v_b, unaligned, ".", ms=1.6, color=COLOURS["late"], rasterized=True)
        use = smoothed.mode != 0 if name == "smoother" else np.ones_like(slip)
        axes.plot(points[0][use] - v_b, points[1][use], ".", ms=1.6, color=colour, rasterized=True)
        order = np.argsort(truth.v[slip])
        axes.plot(
            truth.v[slip][order] - v_b, exact[slip][order], color=COLOURS["truth"], lw=1.0, ls=(0, (4, 2))
        )
        axes.set(xlim=(-0.45, 0.04), ylim=(-7.2, 1.0), ylabel="friction $T$")
        axes.spines[["top", "right"]].set_visible(False)
    upper.set_title("friction by (3.1): its lag makes the loop", fontsize="medium")
    lower.set_title("friction by the smoother, slips only", fontsize="medium")
    lower.set_xlabel("speed against the belt $v_w$")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--figure", type=Path, help="stem of the SVG and PNG to write")
    options = parser.parse_args()
    truth = paper_rig(np.arange(2500) * DT)
    table(truth, (0.0005, 0.001, 0.002))
    if options.figure:
        draw(truth, 0.001, options.figure)


if __name__ == "__main__":
    main()
