"""A model of a driven slider against a recording: its forecasts under the recorded drive beside the readings."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.errors import InputError
from stickslip.fitted.comparison_rows import Row
from stickslip.fitted.driven import followed
from stickslip.likelihoods.bodies_compare import RigComparison
from stickslip.measured.recording import Recording

Floats = NDArray[np.float64]
FASTEST = 0.999  # quantile that counts as the largest speed
WIDTH = 9  # samples of a mean, which takes the noise off a speed


def compare_driven(
    model: Model, recording: Recording, progress: Callable[[str, float], None] | None = None
) -> RigComparison:
    """Let a model follow a record in pieces, each from the state before it, and measure both alike.

    Parameters
    ----------
    model, recording
        Of one slider.
    progress
        Called with what is being done and the share done.

    Raises
    ------
    InputError
        Another rig, or a record that is too short.
    StickslipError
        The model cannot be simulated.
    """
    tell = progress or (lambda _what, _share: None)
    tell("simulating", 0.0)
    found = followed(model, recording)
    begins = np.concatenate([[0], found.ends[:-1] + 1])
    missed = (found.made - found.read)[found.ends]
    moved = found.read[found.ends] - found.read[begins]
    error, far = (float(np.sqrt(np.mean(one**2))) for one in (missed, moved))
    ahead = float(np.mean(found.t[found.ends] - found.t[begins]))
    unit = "1" if recording.channels["x1"].unit == "1" else "m"
    of_time = "" if unit == "1" else " s"
    if not far:
        raise InputError(
            f"{recording.name}: the slider is at the same place at the end of every piece", key="x1"
        )
    speed, second = (_fastest(one, found.t, begins) for one in (found.read, found.made))
    how = f"{ahead:.3g}{of_time} ahead"
    rows = (
        Row(
            "largest speed",
            "1" if unit == "1" else "m/s",
            speed,
            second,
            None,
            "exceeded by 0.1 % of the samples",
        ),
        Row("position missed", unit, None, error, None, f"{how}, root mean square"),
        Row(
            "forecast error",
            "1",
            None,
            error / far,
            None,
            f"{how}, over how far it moves meanwhile",
        ),
    )
    tell("done", 1.0)
    columns = (found.read[:, None], found.made[:, None])
    return RigComparison(
        rows, model, recording, found.t, ("x1",), *columns, f"{ahead:.3g}{of_time}", tuple(begins.tolist())
    )


def _fastest(x: Floats, t: Floats, begins: NDArray[np.intp]) -> float:
    """The largest speed within pieces, of means over a few samples."""
    parts = zip(np.split(x, begins[1:]), np.split(t, begins[1:]), strict=True)
    slopes = [np.gradient(_smooth(a), _smooth(b)) for a, b in parts if len(a) > WIDTH + 1]
    return float(np.quantile(np.abs(np.concatenate(slopes)), FASTEST)) if slopes else np.nan


def _smooth(x: Floats) -> Floats:
    return np.convolve(x, np.ones(WIDTH) / WIDTH, mode="valid")
