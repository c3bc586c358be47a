"""Figures of a driven slider's report: friction over velocity, residual in time, over wavelength and over frequency."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stickslip.declared.catalogue import POSITION_RIPPLES
from stickslip.declared.model import Model
from stickslip.discovery.driven_slider.result import DrivenFound, ForceView
from stickslip.shown.plot.curves import GREY, LIMIT, MEASURED, SIMULATED, STYLE
from stickslip.shown.plot.drawing import Drawing
from stickslip.simulated.driven_slider import Slider

Floats = NDArray[np.float64]

BEFORE, AFTER = SIMULATED, LIMIT
DOTS = 5000


def friction(found: DrivenFound) -> Figure:
    """What drive and inertia leave, against velocity, and the friction of both models."""
    figure = Drawing(figsize=(7.6, 4.2), layout="constrained")
    ax = figure.subplots()
    v = np.concatenate([one.v for one in found.views])
    force = np.concatenate([one.friction for one in found.views])
    if v.size > DOTS:
        kept = np.random.default_rng(0).choice(v.size, DOTS, replace=False)
        v, force = v[kept], force[kept]
    ax.plot(v, force, ".", color=MEASURED, ms=2.5, alpha=0.35, mew=0, rasterized=True)
    ax.plot([], [], ".", color=MEASURED, ms=7, label="drive less inertia, from the readings")
    fastest = float(np.abs(v).max())
    for model, colour, style, name in _models(found):
        for u in (np.linspace(-fastest, 0, 400)[:-1], np.linspace(0, fastest, 400)[1:]):
            ax.plot(u, resistance(model, u), color=colour, ls=style, lw=1.7, label=name)
            name = "_"
    ax.axhline(0, color=GREY, lw=0.5)
    ax.set_xlabel("velocity [m/s]")
    ax.set_ylabel("force [N]")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def resistance(model: Model, v: Floats) -> Floats:
    """The force against motion at velocities `v` (n,), what depends on position, time or drive left out."""
    slider = Slider(model, 1e-3)
    for name in ("position_load", "position_friction", "friction_ripple", "friction_drift", "load_drift"):
        slider.p.pop(name, None)
    for name in [n for n in slider.p if n in POSITION_RIPPLES or n == "harmonic_forcing"]:
        slider.p.pop(name)
    slider.curves = [one for one in slider.curves if one.variable in ("v_w", "x2")]
    low, high = slider.limits(np.zeros_like(v), v, 0.0)
    block = slider.block(np.zeros_like(v), v, 0.0)
    return np.asarray(slider.damping * v - block + np.where(v > 0, high, -low), dtype=np.float64)


def _models(found: DrivenFound) -> list[tuple[Model, str, str, str]]:
    out = [(found.before, BEFORE, "--", "declared model")]
    if found.effects:
        out.append((found.after, AFTER, "-", "with what was found"))
    return out


def in_time(found: DrivenFound) -> Figure:
    """Force that either model leaves unexplained, on a validate run."""
    view = _shown(found)
    figure = Drawing(figsize=(7.6, 4.4), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True, height_ratios=(1, 1.6))
    axes[0].plot(view.t, view.force, color=MEASURED, lw=0.8)
    axes[0].set_ylabel("drive [N]")
    axes[1].plot(view.t, view.before, color=BEFORE, lw=0.6, label="declared model")
    if found.effects:
        axes[1].plot(view.t, view.after, color=AFTER, lw=0.6, label="with what was found")
    axes[1].axhspan(
        -2 * found.noise, 2 * found.noise, color=GREY, alpha=0.15, lw=0, label="± 2 process noise"
    )
    axes[1].set_ylabel("unexplained force [N]")
    axes[1].set_xlabel(f"t [s], {view.name}")
    reach = 1.1 * float(np.percentile(np.abs(view.before), 99.8))
    axes[1].set_ylim(-reach, reach)
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def _shown(found: DrivenFound) -> ForceView:
    return next((one for one in found.views if one.role == "validate"), found.views[0])


def wavelengths(found: DrivenFound) -> Figure:
    """What a force periodic in position would explain, over its wavelength."""
    figure = Drawing(figsize=(7.6, 3.4), layout="constrained")
    ax = figure.subplots()
    length = 1e3 * found.waves["wavelength"]
    ax.plot(
        length, np.maximum(found.waves["before"], 1), color=BEFORE, lw=0.9, label="beside the declared model"
    )
    if found.effects:
        ax.plot(
            length, np.maximum(found.waves["after"], 1), color=AFTER, lw=0.9, label="beside what was found"
        )
    _gate(ax, found)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel("wavelength [mm]")
    ax.set_ylabel("fall of chi-squared")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def _gate(ax: Axes, found: DrivenFound) -> None:
    ax.axhline(found.gate.threshold, color="black", lw=1.0, ls=":", label="gate")


def spectrum(found: DrivenFound) -> Figure:
    """Power of the residual over that of the process noise, over frequency."""
    figure = Drawing(figsize=(7.6, 3.2), layout="constrained")
    ax = figure.subplots()
    f = found.spectrum["frequency"] / (2 * np.pi)
    ax.semilogy(f, found.spectrum["before"], color=BEFORE, lw=1.0, label="declared model")
    if found.effects:
        ax.semilogy(f, found.spectrum["after"], color=AFTER, lw=1.0, label="with what was found")
    ax.axhline(1.0, color="black", lw=1.0, ls=":", label="process noise")
    ax.axvline(found.cutoff, color=GREY, lw=0.8, label="end of the band")
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("power over that of the noise")
    figure.legend(loc="outside upper center", ncols=4)
    return figure


def weights(found: DrivenFound) -> Figure:
    """What each effect explains, the best wrong one in its place, and the gate."""
    figure = Drawing(figsize=(7.6, 0.36 * len(found.effects) + 1.2), layout="constrained")
    ax = figure.subplots()
    names = [one.name if one.curve is None else f"curve of {one.depends_on[0]}" for one in found.effects]
    for y, one in enumerate(found.effects):
        ax.plot([one.evidence.weight], [y], "o", color=AFTER, label="the effect" if y == 0 else "_")
        if one.evidence.control:
            label = "best wrong effect in its place" if y == 0 else "_"
            ax.plot([one.evidence.control], [y], "x", color=BEFORE, label=label)
        for other in one.alternatives:
            if other.tied and not other.exact:
                ax.annotate(
                    f"tied: {other.name}",
                    (one.evidence.delta_chi2, y),
                    (8, -3),
                    textcoords="offset points",
                    fontsize=8,
                )
    ax.axvline(found.gate.threshold, color="black", lw=1.0, ls=":", label="gate")
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.set_xscale("log")
    ax.margins(x=0.2)
    ax.set_xlabel("fall of chi-squared, everything else refitted")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


FIGURES: Mapping[str, Callable[[DrivenFound], Figure]] = {
    "friction": friction,
    "residual_in_time": in_time,
    "wavelengths": wavelengths,
    "residual_spectrum": spectrum,
    "weights": weights,
}


def drawn(found: DrivenFound) -> dict[str, Figure]:
    """Every figure that the result has something for."""
    with mpl.rc_context(STYLE):
        return {name: draw(found) for name, draw in FIGURES.items() if found.effects or name != "weights"}
