"""What was identified and compared of rigs of bodies and matrices."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from stickslip.likelihoods.bodies_compare import RigComparison
from stickslip.likelihoods.identified_rig import IdentifiedRig
from stickslip.shown.objects.description import Cell, Description, Span, describe
from stickslip.shown.plot import bodies
from stickslip.shown.plot.curves import MEASURED, SIMULATED

Row = tuple[Cell, ...]


@describe.register
def _identified(one: IdentifiedRig) -> Description:
    rows: list[Row] = [(name, e.value, Span(e.low, e.high), e.status) for name, e in one.estimates.items()]
    rows += [
        (f"scatter of {name}", s.value, Span(s.low, s.high), "scatter") for name, s in one.scatter.items()
    ]
    rows += [
        (name, c.value, Span(c.low, c.high), "not as declared" if c.beyond else "as declared")
        for name, c in one.constants.items()
    ]

    def draw(ax: Axes) -> None:
        for contact, law in zip(one.fastest, one.laws.values(), strict=False):
            u = np.linspace(1e-3, 1.0, 100) * one.fastest[contact]
            ax.plot(u, law.magnitude(u), label=contact)
        ax.legend()
        ax.set_xlabel("slip speed, SI")
        ax.set_ylabel("friction, SI")

    kinds = ", ".join(law.kind for law in one.laws.values())
    return Description(
        title=f"Identified {kinds}; chi-squared per degree of freedom {one.reduced_chi2:.3g}",
        heads=("number", "value", "95 % interval", "status"),
        rows=rows,
        notes=one.messages,
        draw=draw,
        large=lambda: bodies.laws(one),
    )


@describe.register
def _comparison(one: RigComparison) -> Description:
    rows: list[Row] = [
        (r.quantity, r.measured, r.simulated, r.difference, r.scatter, "" if r.unit == "1" else r.unit)
        for r in one.rows
    ]

    def draw(ax: Axes) -> None:
        late = len(one.t) // 2
        ax.plot(one.t[late:], one.readings[late:, 0], color=MEASURED, lw=1.6, label="measured")
        ax.plot(one.t[late:], one.simulated[late:, 0], color=SIMULATED, lw=0.8, label="simulated")
        ax.legend()
        ax.set_xlabel("t [s]")
        ax.set_ylabel(one.channels[0])

    return Description(
        title=f"RigComparison with '{one.recording.name}'",
        heads=("quantity", "measured", "simulated", "difference", "scatter", "unit"),
        rows=rows,
        notes=one.verdict(),
        draw=draw,
        large=lambda: bodies.beside(one),
    )
