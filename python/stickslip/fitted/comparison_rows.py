"""The rows of a comparison, and what they amount to in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stickslip.declared.scale import percent, plainly
from stickslip.fitted.dominant_cycle import SHARE
from stickslip.measured.recording import Recording

CYCLIC = ("period", "stick fraction", "slip amplitude", "largest slip speed")
# of the forecast's NRMSE, below which it is called so; 1 is forecasting the mean
GOOD = 0.2  # leaves 4 % of the variance
POOR = 0.7  # leaves half of it: above, it is no use


@dataclass(frozen=True)
class Row:
    """One line of the table; `scatter` is the standard deviation of the measured value from cycle to cycle.

    What is not finite is not known: it is None.
    """

    quantity: str
    unit: str
    measured: float | None
    simulated: float | None
    scatter: float | None
    meaning: str

    def __post_init__(self) -> None:
        for name in ("measured", "simulated", "scatter"):
            value = getattr(self, name)
            if value is not None and not np.isfinite(value):
                object.__setattr__(self, name, None)

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """Measured, simulated, difference and scatter as they are printed; a difference below them all is 0."""
        difference = self.difference
        if difference is not None and abs(difference) < 5e-5 * abs(self.measured or 1.0):
            difference = 0.0
        measured, simulated, off, scatter = (
            number(v) for v in (self.measured, self.simulated, difference, self.scatter)
        )
        return measured, simulated, off, scatter

    @property
    def difference(self) -> float | None:
        """Simulated minus measured, where there are both."""
        if self.measured is None or self.simulated is None:
            return None
        return self.simulated - self.measured


def number(value: float | None) -> str:
    """A table's cell: four digits, or a dash."""
    return "-" if value is None or not np.isfinite(value) else f"{value:.4g}"


def verdict(rows: Mapping[str, Row], recording: Recording) -> tuple[str, ...]:
    """Return sentences on a comparison's rows: what forecasts are worth, then each number beside its yardstick."""
    said = (_forecast(rows), _cycles(rows), _left_out(rows), _times(rows, recording), _shape(rows))
    return tuple(one for one in said if one)


def judged(nrmse: float) -> str:
    """Return what a forecast is worth by its NRMSE: "good" to 0.2, "poor" to 0.7, else "useless"."""
    return "good" if nrmse <= GOOD else "poor" if nrmse <= POOR else "useless"


def _cycles(rows: Mapping[str, Row]) -> str:
    near: list[str] = []
    far: list[str] = []
    for name in CYCLIC:
        row = rows.get(name)
        if row is None or row.difference is None or not row.scatter:
            continue
        ratio = abs(row.difference) / row.scatter
        (near if ratio <= 1 else far).append(name if ratio <= 1 else f"{name} ({ratio:.1f} times)")
    said = [f"{', '.join(near)}: off by less than single measured cycles scatter"] if near else []
    said += [f"{', '.join(far)}: off by more than single measured cycles scatter"] if far else []
    return "; ".join(said)


def _times(rows: Mapping[str, Row], recording: Recording) -> str:
    missed = rows.get("transitions missed")
    if missed is None or missed.simulated is None:
        return ""
    step = float(np.median(np.diff(recording.raw["t"]))) * recording.channels["t"].scale
    unit = "" if recording.unit("t") == "1" else f" {recording.unit('t')}"
    return (
        f"{missed.simulated:.0f} {missed.unit} transitions missed by forecasts from the cycle before; "
        f"hold the errors of the times against the sampling interval, {step:.3g}{unit}"
    )


def _shape(rows: Mapping[str, Row]) -> str:
    row = rows.get("phase-portrait distance")
    if row is None or row.simulated is None or row.scatter is None:
        return ""
    return (
        f"the portraits lie {percent(row.simulated)} of their size apart; the two halves of the measured one "
        f"{percent(row.scatter)}"
    )


def _left_out(rows: Mapping[str, Row]) -> str:
    row = rows.get("small slips left out")
    if row is None or not (row.measured or row.simulated):
        return ""
    theirs, ours = row.unit.removeprefix("of ").split("/")
    return (
        f"{row.measured:.0f} of {theirs} measured slips and {row.simulated:.0f} of {ours} simulated are below "
        f"{SHARE:g} of the typical one: left out, their time counted as stick"
    )


def _forecast(rows: Mapping[str, Row]) -> str:
    row = rows.get("forecast NRMSE")
    if row is None or row.simulated is None or not row.scatter:
        return ""
    times = row.simulated / row.scatter
    than_mean = ", no better than forecasting the mean" if row.simulated >= 1 else ""
    return (
        f"forecast from cycle to cycle: {judged(row.simulated)}{than_mean}; NRMSE {row.simulated:.3g} (good to "
        f"{GOOD:g}, poor to {POOR:g}, 1 is forecasting the mean), {plainly(times)} times what the noise alone leaves"
    )
