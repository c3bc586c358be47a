"""The figure of a file's columns, one above the other over the time."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from stickslip.measured.inspection import Inspection
from stickslip.shown.plot.curves import STYLE, label

MOST = 12  # columns drawn
POINTS = 4000  # drawn of a column: the least and the greatest of each stretch


def columns(inspection: Inspection) -> Figure:
    """Draw every column of numbers over the time, or over the sample where the file has no times."""
    time = inspection.time
    drawn = [
        one for one in inspection.columns if one is not time and one.values is not None and one.values.size
    ]
    drawn = drawn[:MOST]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 1.2 + 1.3 * max(len(drawn), 1)), layout="constrained")
        axes = figure.subplots(max(len(drawn), 1), 1, squeeze=False, sharex=True)[:, 0]
        for ax, one in zip(axes, drawn, strict=False):
            x = np.asarray(one.values)
            timed = time is not None and time.values is not None and time.values.size == x.size
            t = np.asarray(time.values) if timed and time is not None else np.arange(x.size)
            at = _telling(x)
            ax.plot(t[at], x[at], lw=0.7)
            ax.locator_params(nbins=5)
            ax.set_ylabel(label(one.head.rpartition("/")[2], one.unit or "1"))
        axes[-1].set_xlabel(
            "sample" if time is None else label(time.head.rpartition("/")[2], time.unit or "1")
        )
    return figure


def _telling(x: np.ndarray) -> np.ndarray:
    """Samples that show a long column as all of them would: extremes of stretches, in order."""
    if x.size <= 2 * POINTS:
        return np.arange(x.size)
    edges = np.linspace(0, x.size, POINTS + 1).astype(int)[:-1]
    low = [a + int(np.argmin(x[a:b])) for a, b in zip(edges, [*edges[1:], x.size], strict=True)]
    high = [a + int(np.argmax(x[a:b])) for a, b in zip(edges, [*edges[1:], x.size], strict=True)]
    return np.unique([*low, *high])
