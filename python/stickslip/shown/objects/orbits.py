"""Cycles, branches, steady sliding and exponents."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes

from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.shown.objects.description import Cell, Description, ShownSamples, Span, describe
from stickslip.shown.objects.runs import read_in
from stickslip.shown.plot.branch import plot_branch
from stickslip.shown.plot.curves import GREY, MEASURED, SIMULATED, label
from stickslip.simulated.orbits.branch import Branch, SpecialPoint
from stickslip.simulated.orbits.cycle import LimitCycle
from stickslip.simulated.orbits.cycle_sensitivity import CycleSensitivity
from stickslip.simulated.orbits.lyapunov import LyapunovSpectrum
from stickslip.simulated.orbits.steady_sliding import SteadySliding

Row = tuple[Cell, ...]


def _complex(value: complex) -> str:
    if abs(value.imag) <= 1e-12 * abs(value):
        return f"{value.real:.5g}"
    return f"{value.real:.5g} {'+' if value.imag > 0 else '-'} {abs(value.imag):.5g}i"


def _sort(one: LimitCycle) -> str:
    return ("stable" if one.stable else "neutral" if one.neutral else "unstable") + (
        ", sticks" if one.sticks else ""
    )


@describe.register
def _cycle(one: LimitCycle) -> Description:
    read = read_in(one.model, one.states)
    unit = {name: "" if scale.unit == "1" else scale.unit for name, scale in read.items()}
    rows: list[Row] = [("period", read["t"].size * one.period, unit["t"])]
    rows += [
        (f"{name} on the section", float(read[name].size * x), unit[name])
        for name, x in zip(one.states, one.state, strict=True)
    ]
    rows += [(f"multiplier {k}", _complex(m), "") for k, m in enumerate(one.multipliers, 1)]

    def draw(ax: Axes) -> None:
        run = one.trajectory()
        first = run.state_names[0]
        names = first, "x2" if "x2" in run.state_names else f"v_{first}"
        x, v = (read[name].size * run.state[:, run.state_names.index(name)] for name in names)
        ax.plot(x, v, color=SIMULATED, lw=1.2)
        ax.set_xlabel(label(names[0], read[names[0]].unit))
        ax.set_ylabel(label(names[1], read[names[1]].unit))

    return Description(title=f"Limit cycle, {_sort(one)}", rows=rows, draw=draw)


@describe.register
def _sliding(one: SteadySliding) -> Description:
    rows: list[Row] = [(f"state {k}", float(x)) for k, x in enumerate(one.state, 1)]
    rows += [(f"eigenvalue {k}", _complex(x)) for k, x in enumerate(one.eigenvalues, 1)]
    sort = "stable" if one.stable else "unstable"
    return Description(title=f"steady sliding, {sort}", heads=("quantity", "value"), rows=rows)


@describe.register
def _special(one: SpecialPoint) -> Description:
    rows: list[Row] = [("value", one.value), ("period", one.period)]
    rows += [("turns round", one.turns_round), ("ends", one.ends)]
    rows += [("cycle", _sort(one.cycle))]
    return Description(
        title=f"{one.kind.replace('_', ' ')} at {one.value:.6g}", heads=("what", "value"), rows=rows
    )


@describe.register
def _branch(one: Branch) -> Description:
    rows: list[Row] = [(p.kind.replace("_", " "), p.value, p.period, _sort(p.cycle)) for p in one.special]
    kept = int(np.count_nonzero(one.stable))
    states = {f"{name}_section": one.state[:, k] for k, name in enumerate(one.states)}
    columns = {
        one.parameter: one.values,
        "period": one.period,
        "stick_time": one.stick_time,
        "stable": one.stable,
    }
    return Description(
        title=f"Branch of cycles over {one.parameter}: {len(one)} points, {kept} stable; {one.ends_told()}",
        heads=("bifurcation", one.parameter, "period", "cycle"),
        rows=rows,
        samples=ShownSamples({**columns, **states}, {}),
        draw=lambda ax: _small(ax, one),
        large=lambda: plot_branch(one),
    )


def _small(ax: Axes, one: Branch) -> None:
    for kept, style in ((one.stable, "-"), (~one.stable, "--")):
        ax.plot(one.values, np.where(kept, one.period, np.nan), color=SIMULATED, lw=1.2, ls=style)
    for point in one.special:
        ax.plot(point.value, point.period, "o", color=GREY, ms=3)
    ax.set_xlabel(one.parameter)
    ax.set_ylabel("period")


@describe.register
def _sensitivity(one: CycleSensitivity) -> Description:
    rows: list[Row] = [
        (name, float(one.period[k]), *(float(x) for x in one.state[:, k])) for k, name in enumerate(one.names)
    ]
    heads = ("by", "d period", *(f"d state {k}" for k in range(1, len(one.state) + 1)))
    return Description(title=f"derivatives of a cycle by {', '.join(one.names)}", heads=heads, rows=rows)


@describe.register
def _exponents(one: LyapunovSpectrum) -> Description:
    rows: list[Row] = []
    for k, (value, error) in enumerate(zip(one.exponents, one.standard_error, strict=True), 1):
        half = SIGMAS_95 * float(error)
        span = Span(float(value) - half, float(value) + half) if math.isfinite(half) else Span(None, None)
        rows.append((f"exponent {k}", float(value), span))

    def draw(ax: Axes) -> None:
        for column in one.history.T:
            ax.plot(one.t, np.where(np.isfinite(column), column, np.nan), color=MEASURED, lw=0.9)
        ax.set_xlabel("t")
        ax.set_ylabel("exponents up to then")

    chaos = "chaotic" if one.chaotic else "not chaotic"
    history = {f"exponent_{k}": column for k, column in enumerate(one.history.T, 1)}
    return Description(
        title=f"Lyapunov exponents, {chaos}; dimension {one.dimension:.4g}",
        heads=("quantity", "value", "95 % interval"),
        rows=rows,
        samples=ShownSamples({"t": one.t, **history}, {}),
        draw=draw,
    )
