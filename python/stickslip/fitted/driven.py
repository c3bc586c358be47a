"""A model of a driven slider against a record of it: where it stands, what follows, and how far off that is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.drive import drive_of
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, StickslipError, number
from stickslip.measured.recording import Recording
from stickslip.simulated.simulate import simulate
from stickslip.simulated.trajectory import Trajectory

Floats = NDArray[np.float64]
PAST = 24  # samples before an instant from which the state there is taken
TURNS = 6  # of the fit of that state
STAYS = 1e-6  # weight beside a reading of where that fit begins
STARTS = 40  # forecasts within the past whose errors say how far off one may be
FEWEST = 6  # of these
GROWS = 1.5  # power of time by which a doubt of the force grows, integrated twice, beyond what the past shows
MOST = 1_000_000  # samples of a forecast
RESOLVED = 1e-10  # of how far the slider moves, and of 1: a position may be of micrometres, in SI
PIECES = 40  # a comparison follows the record in so many


@dataclass(frozen=True)
class DrivenForecast:
    """
    Positions to come.

    Parameters
    ----------
    t : (n,) times of the record's clock
    mean, low, high : (n,) expected readings, and the band that holds 95 % of the readings to come
    """

    t: Floats
    mean: Floats
    low: Floats
    high: Floats


def forecast_driven(model: Model, recording: Recording, drive: object, horizon: float) -> DrivenForecast:
    """Return what follows a record of a driven slider under a drive to come.

    The state is that of the model which passes best through the last readings; the band is as wide as such forecasts
    erred within the record.

    Parameters
    ----------
    model, recording
        Of one slider.
    drive
        Force after the last sample's interval, as `simulate` takes it; t is the record's.
    horizon
        How far, in the model's unit of time.

    Raises
    ------
    InputError
        The drive is missing or wrong, the horizon too short or long, the record too short.
    StickslipError
        The model cannot be simulated.
    """
    _check_record(recording)
    t, step = recording.t, float(np.median(np.diff(recording.t)))
    count = int(number("horizon", horizon, above=0) / step + 0.05)
    if not 1 <= count <= MOST:
        words = f"gives {count} samples at intervals of {step:.3g}; 1 to {MOST} can be forecast"
        raise InputError(words, key="horizon", value=horizon)
    future = drive_of(drive, model.rig)
    assert future is not None
    known = recorded_drive(recording)
    last = len(t) - 1
    times = t[last] + step * np.arange(1, count + 1)
    course = known.followed(future, float(t[last]) + step)
    mean = _ahead(model, course, recording, last, times)
    half = _half_width(model, known, recording, count)
    return DrivenForecast(times, mean, mean - half, mean + half)


def recorded_drive(recording: Recording) -> Speed:
    """Return the force of the drive over a record [N], each sample held until the next."""
    course = drive_of((recording.t, recording.drive), recording.rig)
    assert course is not None
    return course


def _check_record(recording: Recording) -> None:
    if not isinstance(recording.rig, DrivenSlider) or recording.drive is None:
        raise InputError(f"{recording.name} was recorded on another rig than the model's", key="model")
    if len(recording.t) < PAST + 2 * FEWEST:
        words = f"{PAST + 2 * FEWEST} are needed to see how the slider moves"
        raise InputError(f"{recording.name} has {len(recording.t)} samples; {words}")


def _ahead(model: Model, course: Speed, recording: Recording, at: int, times: Floats) -> Floats:
    """Positions at times after a sample, from the state that the readings before it show."""
    late = [one.parameters["delay"] for one in model.effects if one.name == "drive_delay"]
    first, last = float(recording.t[at - PAST + 1]), float(times[-1])
    course = course.within(first - max([0.0, *late]), last - min([0.0, *late]))
    begun = _begun(model, course, recording, at)
    run = simulate(
        model, drive=course, initial=begun, t_end=float(times[-1]), t_eval=times, atol=_resolved(recording)
    )
    if len(run.t) < len(times):
        raise StickslipError(f"the model's run {run.status}")
    return run.x1


def _resolved(recording: Recording) -> float:
    return RESOLVED * min(float(np.ptp(recording.x1)), 1.0)


def _begun(model: Model, course: Speed, recording: Recording, at: int) -> Trajectory:
    """The run of the model that passes best through the readings up to a sample, and ends there."""
    part = slice(at - PAST + 1, at + 1)
    t, x = recording.t[part], recording.x1[part]
    since = (t - t[0]) / (t[-1] - t[0])
    cubic = np.vander(since, 4, increasing=True)
    b = np.linalg.lstsq(cubic, x, rcond=None)[0]
    unit = max(float(np.std(x - cubic @ b)), RESOLVED * float(np.ptp(recording.x1))) or 1.0

    held = _hidden(model, course, float(t[0]), recording)

    @lru_cache(maxsize=4)
    def run(*start: float) -> Trajectory:
        return simulate(
            model,
            drive=course,
            initial=[*start, *held(np.array(start))],
            t_start=float(t[0]),
            t_end=float(t[-1]),
            t_eval=t,
            atol=_resolved(recording),
            sensitivity=("initial.x1", "initial.x2"),
        )

    def missed(start: Floats) -> Floats:
        made = run(*start.tolist())
        return (made.x1 - x) / unit if len(made.t) == len(t) else np.full(len(t), np.inf)

    def slopes(start: Floats) -> Floats:
        return run(*start.tolist()).sensitivity[:, 0] / unit

    starts = [np.array([b[0], b[1] / (t[-1] - t[0])]), np.array([float(x.mean()), 0.0])]
    first = min(starts, key=lambda one: float(missed(one) @ missed(one)))
    if len(run(*first.tolist()).t) < len(t):
        raise StickslipError(f"the model's run {run(*first.tolist()).status}")
    # what no reading tells, as the speed of a slider at rest, stays where it is
    stays = np.diag([STAYS / unit, STAYS * (t[-1] - t[0]) / unit])

    def off(start: Floats) -> Floats:
        return np.concatenate([missed(start), stays @ (start - first)])

    found = scipy.optimize.least_squares(
        off,
        first,
        jac=lambda start: np.concatenate([slopes(start), stays]),  # type: ignore[misc]
        x_scale="jac",
        max_nfev=TURNS,
    )
    return run(*found.x.tolist())


def _hidden(
    model: Model, course: Speed, begin: float, recording: Recording
) -> Callable[[Floats], list[float]]:
    """What gives the hidden states at an instant from a start there: a lagging drive as the record has driven it."""
    lag = next((one.parameters["tau"] for one in model.effects if one.name == "drive_lag"), None)
    if lag is None:
        return lambda _: []
    late = sum(one.parameters["delay"] for one in model.effects if one.name == "drive_delay")
    assert recording.drive is not None
    past = recording.t + late < begin
    ends = np.append(recording.t[past][1:] + late, begin)
    force = float(recording.drive[0])
    for own, lasts in zip(recording.drive[past], ends - (recording.t[past] + late), strict=True):
        force = own + (force - own) * np.exp(-lasts / lag)

    def states(start: Floats) -> list[float]:
        first = simulate(
            model, drive=course, initial=start, t_start=begin, t_end=begin + 1e-9, t_eval=[begin]
        )
        return [
            force if name == "drive_lag.f" else float(first.hidden[name][0]) for name in first.hidden_names
        ]

    return states


def _half_width(model: Model, known: Speed, recording: Recording, count: int) -> Floats:
    """
    Half of the band of readings so many samples ahead, (count,): by how far such forecasts were off within the record.

    Forecasts that overlap are no two: of few that do not, the band is that of Student's t.
    """
    n = len(recording.t)
    reach = max(min(count, (n - PAST) // 2), 1)
    at = np.unique(np.linspace(PAST - 1, n - 1 - reach, STARTS).astype(int))
    missed = np.array([one for one in _misses(model, known, recording, at, reach) if one is not None])
    if len(missed) < FEWEST:
        raise StickslipError("the model does not follow the record: no band of what follows is known")
    seen = np.maximum.accumulate(np.sqrt(np.mean(missed**2, axis=0)))
    beyond = seen[-1] * (np.arange(reach + 1, count + 1) / reach) ** GROWS
    ahead = np.arange(1, count + 1)
    apart = np.clip((n - PAST) / np.minimum(ahead, reach), 1.0, len(missed))
    return np.asarray(scipy.stats.t.ppf(0.975, apart) * np.concatenate([seen, beyond]))


def _misses(
    model: Model, known: Speed, recording: Recording, at: NDArray[np.intp], reach: int
) -> Iterator[Floats | None]:
    for i in at:
        try:
            made = _ahead(model, known, recording, int(i), recording.t[i + 1 : i + 1 + reach])
        except StickslipError:
            yield None
            continue
        yield made - recording.x1[i + 1 : i + 1 + reach]


def missed_ahead(model: Model, recording: Recording, ahead: float) -> Floats:
    """Return how far off forecasts of a record are so long ahead, (m,); they begin half as far apart.

    Raises
    ------
    InputError
        The record is of another rig, or too short.
    StickslipError
        The model cannot be simulated.
    """
    _check_record(recording)
    known, t = recorded_drive(recording), recording.t
    steps = max(round(ahead / float(np.median(np.diff(t)))), 1)
    begins = np.arange(PAST - 1, len(t) - steps, max(steps // 2, 1))
    made = [_ahead(model, known, recording, int(i), t[[i + steps]])[0] for i in begins]
    return np.asarray(made - recording.x1[begins + steps])


@dataclass(frozen=True)
class Followed:
    """
    A record that a model followed in pieces, each from the state that the readings before it show.

    Parameters
    ----------
    t, read, made : (n,) times, readings, and the model's positions
    ends : (m,) where each piece ends
    """

    t: Floats
    read: Floats
    made: Floats
    ends: NDArray[np.intp]


def followed(model: Model, recording: Recording) -> Followed:
    """Follow a record in pieces.

    Raises
    ------
    InputError
        Of another rig, or too short.
    StickslipError
        The model cannot be simulated.
    """
    _check_record(recording)
    known, n = recorded_drive(recording), len(recording.t)
    ends = np.unique(np.linspace(PAST - 1, n - 1, min(PIECES, (n - PAST) // 2) + 1).astype(int))
    made = [
        _ahead(model, known, recording, int(a), recording.t[a + 1 : b + 1])
        for a, b in zip(ends[:-1], ends[1:], strict=True)
    ]
    part = slice(PAST, n)
    return Followed(recording.t[part], recording.x1[part], np.concatenate(made), ends[1:] - PAST)
