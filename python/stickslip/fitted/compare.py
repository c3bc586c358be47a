"""Simulated against measured: the numbers of one table, and the curves of Fig. 4.

Both sides go through the same estimators: the simulation is sampled where the readings are and its velocity,
modes and transition times are read from the samples in the same way, so that what a filter does to one it does
to the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.arguments import explained, must_be
from stickslip.declared.bodies_model import check_closed_form
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.fitted.comparison_rows import Row, verdict
from stickslip.fitted.dominant_cycle import SHARE, Dominant, cycles, dominant
from stickslip.fitted.identify import BeltSpeed, measured
from stickslip.fitted.identify_windows import natural_period
from stickslip.fitted.model_runs import runs_of
from stickslip.measured import cutting
from stickslip.measured import sticks as segments
from stickslip.measured.case import Recording
from stickslip.measured.fit_window import Array
from stickslip.measured.prepared import Measured, Motion
from stickslip.objects import Drawn, one_line

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Drawn):
    """Result of `compare`.

    Attributes
    ----------
    rows : tuple of Row
        The table, a row a quantity: measured, simulated, and the scatter of single measured cycles.
    measured, simulated : Track
        Displacement, velocity and modes of both sides on the same times; the simulation runs freely from the
        state estimated at the start.
    readings, simulated_readings : (n, c) arrays
        Of the channels recorded, in the rig's units.
    units : mapping-like tuple
        Units of time, displacement and velocity in `rows`.
    model, recording
        What was compared.
    belt_speed : float
        v_b used, in the rig's units.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)  # kg, N/m
    >>> law = ss.CoulombFriction(static=2.0, kinetic=1.2)  # N
    >>> t = np.arange(0, 6, 0.002)
    >>> run = ss.simulate(ss.Model(rig, friction=law), belt_speed=0.01, t_end=6, t_eval=t)
    >>> x = 1e3 * run.x1 + 1e-3 * np.random.default_rng(0).standard_normal(t.size)  # mm
    >>> channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}
    >>> recording = ss.load_recording({"t": t, "x1": x}, rig, channels=channels, belt_speed=0.01)
    >>> compared = ss.compare(ss.Model(rig, friction=law), recording)
    >>> row = compared.rows[0]
    >>> print(f"{row.quantity}: {row.measured:.3f} measured, {row.simulated:.3f} simulated")
    period: 0.432 measured, 0.432 simulated
    """

    rows: tuple[Row, ...]
    measured: segments.Track
    simulated: segments.Track
    readings: Array
    simulated_readings: Array
    units: tuple[str, str, str]
    model: Model
    recording: Recording
    belt_speed: float

    def __str__(self) -> str:
        return self.table()

    def __repr__(self) -> str:
        return one_line(
            f"<Comparison with '{self.recording.name}': {len(self.rows)} rows, {len(self.measured.t)} samples>"
        )

    def row(self, quantity: str) -> Row:
        """The row of that name; KeyError if there is none."""
        return {r.quantity: r for r in self.rows}[quantity]

    def table(self) -> str:
        """The rows as plain text."""
        head = f"{'quantity':<34}{'measured':>12}{'simulated':>12}{'difference':>12}{'scatter':>11}  unit"
        lines = [head]
        for r in self.rows:
            cells = "".join(f"{cell:>12}" for cell in r.cells[:3])
            lines.append(f"{r.quantity:<34}{cells}{r.cells[3]:>11}  {r.unit}")
        return "\n".join([*lines, *self.verdict()])

    def verdict(self) -> tuple[str, ...]:
        """Sentences that say what the rows amount to, and what to hold them against."""
        return verdict({r.quantity: r for r in self.rows}, self.recording)

    def to_dict(self) -> dict[str, object]:
        """The rows for JSON."""
        return {
            "rows": [{**vars(r), "difference": r.difference} for r in self.rows],
            "belt_speed": self.belt_speed,
        }


@explained
def compare(
    model: Model,
    recording: Recording,
    *,
    belt_speed: BeltSpeed = "set-point",
    progress: Callable[[str, float], None] | None = None,
) -> Comparison:
    """Simulate the model with the run's belt speed from the run's estimated start, and measure both alike.

    Parameters
    ----------
    model : Model
    recording : Recording
    belt_speed : "set-point" or "plateau"
        As in `identify`.
    progress : callable, optional

    Returns
    -------
    Comparison
        With the rows period, stick fraction, slip amplitude, largest slip speed, small slips left out, release and
        capture time errors, missed transitions, phase-portrait distance and forecast error. Forecasts are those of
        `forecast`, from the readings before each window of one cycle or more. Period, amplitude and speed are means
        over the dominant cycle, from release to release of slips at least 0.3 times as large as the typical one
        (`stickslip.fitted.dominant_cycle`), of measurement and simulation alike; the time of smaller slips counts as
        stick.

    Raises
    ------
    InputError
        If the model does not belong to the recording's rig, or cannot be simulated from the estimated start.
    """
    must_be("model", model, Model, "load_model(file) or identify(case).model give one")
    check_closed_form(model.rig, model.friction)
    must_be("recording", recording, Recording, "one of a case's runs, like case.validate[0]")
    tell = progress or (lambda _what, _share: None)
    tell("reading modes", 0.0)
    run = _from_a_stick(
        measured(recording, model.rig, belt=belt_speed, motion=_motion(model, recording)), model
    )
    tell("simulating, and forecasting from cycle to cycle", 0.2)
    both = runs_of(run, model, recording, _windows(run, model))
    free, ahead, where = both.free, both.ahead, both.forecast
    ours = replace_track(run, free[:, 0])
    tell("comparing", 0.8)
    rows = [*_cycle_rows(dominant(run.track), dominant(_noisy(run, free)), recording)]
    rows += _timing_rows(run, ahead, where, recording)
    rows.append(_portrait_row(run, ours))
    rows.append(_forecast_row(run, ahead, where))
    tell("done", 1.0)
    units = (recording.unit("t"), recording.unit("x1"), speed_unit(recording)[0])
    return Comparison(
        tuple(rows), run.track, ours, run.readings, free, units, model, recording, run.belt_speed
    )


def _motion(model: Model, recording: Recording) -> Motion | None:
    """What stands between the motion of a block on a belt and its readings, which stick as fast as that says."""
    if isinstance(model.rig, Rig) or not model.effects:
        return None
    from stickslip.fitted.block_events.sensor import reading_of

    return reading_of(model, recording.channel("x1") == "spring_force").motion


def _from_a_stick(run: Measured, model: Model) -> Measured:
    """The run from its first stick on, for a block whose friction scatters: in mid-slip its start is not known."""
    sticks = run.track.sticks
    if isinstance(model.rig, Rig) or not sticks or run.track.segments[0].mode == 0:
        return run
    start = sticks[0].middle
    if len(run.t) - start < 3 * run.track.width:  # too little would be left to tell stick from slip
        return run
    t = run.t[start:]  # what depends on time goes by the run's own
    return replace(run, t=t, readings=run.readings[start:], track=replace(run.track.after(start), t=t))


def _windows(run: Measured, model: Model) -> list[tuple[int, int]]:
    """Samples of windows of about two cycles for forecasting."""
    length = 1.2 * natural_period(model.rig)
    return [b for b in cutting.cut(run.track, length) if b[1] - b[0] > segments.CLEAR]


def per_model(recording: Recording, channel: str) -> float:
    """How many of the channel's unit make 1 of the model's."""
    return recording.channels[recording.channel(channel)].scale / recording.factor(channel)


def speed_unit(recording: Recording) -> tuple[str, float]:
    """Unit for velocities, and how many of it make 1 of the model's."""
    if recording.channel("x1") == "spring_force":
        return "mm/s", 1e3
    t, x = recording.unit("t"), recording.unit("x1")
    return ("1" if t == x == "1" else f"{x}/{t}"), per_model(recording, "x1") / per_model(recording, "t")


def _cycle_rows(measured_: Dominant, simulated: Dominant, recording: Recording) -> list[Row]:
    """Mean numbers of the dominant cycle of both sides, and how many small slips are not in them."""
    both = measured_, simulated
    theirs, mine = (cycles(side.track) for side in both)
    t, x = per_model(recording, "t"), abs(per_model(recording, "x1"))
    unit, v = speed_unit(recording)
    what = (
        ("period", recording.unit("t"), t, theirs.period, mine.period, "from release to release"),
        (
            "slip amplitude",
            recording.unit("x1"),
            x,
            theirs.amplitude,
            mine.amplitude,
            "range of x1 from release to capture",
        ),
        ("largest slip speed", unit, abs(v), theirs.speed, mine.speed, "of |v_w| in a cycle"),
    )
    rows = [
        Row(name, unit, _mean(m * f), _mean(s * f), _std(m * f), meaning)
        for name, unit, f, m, s, meaning in what
    ]
    sticking, stuck = (float(np.mean(side.track.mode == 0)) for side in both)
    meaning = "share of the time outside the slips that count"
    rows.insert(1, Row("stick fraction", "1", sticking, stuck, _std(theirs.stick), meaning))
    left_out, ours = (float(side.left_out) for side in both)
    meaning = f"below {SHARE:g} of the typical slip, counted as stick in the other rows"
    rows.append(
        Row("small slips left out", f"of {both[0].slips}/{both[1].slips}", left_out, ours, None, meaning)
    )
    return rows


def _mean(x: Array) -> float | None:
    return float(x.mean()) if x.size else None


def _std(x: Array) -> float | None:
    return float(x.std(ddof=1)) if x.size > 1 else None


def _timing_rows(run: Measured, ahead: Array, where: Flags, recording: Recording) -> list[Row]:
    """Errors of release and capture times forecast from one cycle to the next, matched event by event."""
    out = []
    scale = per_model(recording, "t")
    if not where.any():
        return []
    filled = np.where(where, ahead[:, 0], run.track.x)
    theirs = dominant(run.track).track
    mine = dominant(replace_track(run, filled)).track
    missed = among = 0
    typical = cycles(theirs).period
    reach = 0.5 * float(np.median(typical)) if typical.size else np.inf
    for name, a, b in (
        ("release time error", theirs.releases, mine.releases),
        ("capture time error", theirs.captures, mine.captures),
    ):
        inside = where[np.clip(np.searchsorted(run.t, a), 0, len(where) - 1)]
        error, lost = matched(a[inside], b, reach)
        missed += lost
        rms = float(np.sqrt(np.mean(error**2))) * scale if error.size else None
        out.append(Row(name, recording.unit("t"), None, rms, None, "rms, forecast from the cycle before"))
        among += int(inside.sum())
    out.append(
        Row(
            "transitions missed",
            f"of {among}",
            None,
            float(missed),
            None,
            "no forecast one within half a period",
        )
    )
    return out


def _noisy(run: Measured, free: Array) -> segments.Track:
    """Track of the simulated readings with noise as large as the measured: the largest of noisy speeds is larger."""
    rng = np.random.default_rng(0)
    return replace_track(run, free[:, 0] + run.noise[0] * rng.standard_normal(len(run.t)))


def replace_track(run: Measured, x: Array) -> segments.Track:
    """Track of another displacement on the run's times, read with the run's filter and threshold."""
    motion = x if run.motion is None else run.motion(run.t, x, run.noise[0])[0]
    found = segments.track(
        run.t,
        motion,
        belt_speed=run.belt_speed,
        noise=run.noise[0],
        period=np.inf,
        width=run.track.width,
        threshold=run.track.threshold,
    )
    return found if run.motion is None else segments.as_read(found, run.t, x)


def matched(a: Array, b: Array, reach: float) -> tuple[Array, int]:
    """Differences b - a of events matched to their nearest within `reach`, and how many of `a` found none."""
    if not b.size:
        return np.array([]), len(a)
    nearest = b[np.argmin(np.abs(b[None, :] - a[:, None]), axis=1)] if a.size else a
    error = nearest - a
    near = np.abs(error) <= reach
    return error[near], int((~near).sum())


def portrait_distance(a: Array, b: Array, size: Array) -> float:
    """Symmetric mean nearest distance of two point sets in the plane, in units of `size` per axis.

    d = (mean_i min_j |a_i - b_j| + mean_j min_i |a_i - b_j|)/2 with coordinates divided by `size` (2,): 0.01 means
    that the portraits lie one hundredth of their size apart.
    """
    a, b = a / size, b / size
    there, back = (np.mean(scipy.spatial.cKDTree(p).query(q)[0]) for p, q in ((b, a), (a, b)))
    return float(0.5 * (there + back))


def steady(track: segments.Track) -> Array:
    """(x1, x2) of the second half of a run, (n, 2)."""
    half = len(track.t) // 2
    return np.column_stack([track.x[half:], track.v[half:]])


def _portrait_row(run: Measured, ours: segments.Track) -> Row:
    points = steady(run.track)
    size = np.ptp(points, axis=0)
    size = np.where(size > 0, size, 1.0)
    middle = len(points) // 2
    floor = portrait_distance(points[:middle], points[middle:], size)
    distance = portrait_distance(points, steady(ours), size)
    meaning = "symmetric mean nearest distance over the portrait's size; scatter: measured against itself"
    return Row("phase-portrait distance", "1", None, distance, floor, meaning)


def _forecast_row(run: Measured, ahead: Array, where: Flags) -> Row:
    x = run.readings[where, 0]
    ok = np.isfinite(x)
    spread = float(np.nanstd(run.readings[:, 0]))
    known = ok.any() and spread > 0
    value = float(np.sqrt(np.mean((ahead[where, 0][ok] - x[ok]) ** 2))) / spread if known else None
    meaning = "x1, from one cycle to the next, over its standard deviation; scatter: the noise alone"
    return Row("forecast NRMSE", "1", None, value, float(run.noise[0]) / spread if spread else None, meaning)
