"""Forecasts of rigs of bodies and matrices: many runs of a model, each contact's friction drawn anew at every stick.

As `stickslip.likelihoods.ensemble`: what scatters, and by how much, the windows of the past say. A run to come begins
in the last stick of the past, its state and its friction drawn from what the readings since leave open.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.model import Model
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, ModelWarning, StickslipError, number
from stickslip.fitted.bodies_data import BodiesData, prepare_bodies
from stickslip.likelihoods.band import MEMBERS, SHOWN, band, standing
from stickslip.likelihoods.bodies_cuts import cuts, tail
from stickslip.likelihoods.bodies_starts import resolved
from stickslip.likelihoods.bodies_windows import BodiesWindows, RunWindows
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit, begin, unexplained
from stickslip.likelihoods.own_phases import as_it_ran
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.single_windows import window_posterior
from stickslip.likelihoods.symmetric_root import symmetric_root
from stickslip.measured.recording import Recording

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]
AHEAD = 1.5  # natural periods that members are simulated at once
MOST = 1_000_000  # samples of a forecast
RESTARTS = 20_000  # of one member


@dataclass(frozen=True)
class BodiesForecast:
    """
    Readings to come.

    Parameters
    ----------
    t : (n,) times from the past's first sample
    channels : names of the readings
    mean, low, high : (n, channels) expected readings, and the band that holds 95 % of the readings to come
    """

    t: Floats
    channels: tuple[str, ...]
    mean: Floats
    low: Floats
    high: Floats


def forecast_bodies(
    model: Model, recording: Recording, speeds: Mapping[str, Speed], horizon: float
) -> pd.DataFrame:
    """Return what follows a recording of such a rig: t, its channels, and their 95 % bands, in the recording's units.

    Parameters
    ----------
    model
        Of the rig that was recorded.
    recording
        The past.
    speeds
        What is prescribed, of the past and of the future; the recording's where it is not named. Where that was
        measured, of the future alone.
    horizon
        How far, in s.

    Raises
    ------
    InputError
        Another rig, a horizon that is not positive or too long, a past that is too short.
    StickslipError
        The model cannot follow the past.

    Warns
    -----
    ModelWarning
        The model leaves more of the past than noise.
    """
    import pandas as pd  # slow to import

    rig, own = recording.rig, model.rig
    if (
        not isinstance(own, GeneralRig)
        or not isinstance(rig, GeneralRig)
        or rig.state_names != own.state_names
    ):
        raise InputError(f"{recording.name} was recorded on another rig than the model's", key="model")
    past = replace(recording, speeds={**recording.speeds, **_coming(recording, speeds)})
    run = prepare_bodies(own, [past], model.friction)[0]
    step = float(np.median(np.diff(run.t)))
    count = int(number("horizon", horizon, above=0) / step + 0.05)
    if not 1 <= count <= MOST:
        words = f"gives {count} samples at intervals of {step:.3g} s; 1 to {MOST} can be forecast"
        raise InputError(words, key="horizon", value=horizon)
    found = distribution(model, run, run.t[-1] + step * np.arange(1, count + 1))
    columns = {"t": (found.t + float(recording.t[0])) / recording.factors["t"]}
    sides = (("_low", found.low), ("_high", found.high))
    kept = [(k, name) for k, name in enumerate(found.channels) if name != "belt"]
    for k, name in kept:
        columns[name] = recording.to_readings(name, found.mean[:, k])
    for k, name in kept:
        for end, side in sides:
            if f"{name}{end}" in columns:
                words = (
                    f"'{name}{end}' names a channel and the band of '{name}'; name the coordinate otherwise"
                )
                raise InputError(words, key="model")
            columns[f"{name}{end}"] = recording.to_readings(name, side[:, k])
    return pd.DataFrame(columns)


def _coming(recording: Recording, speeds: Mapping[str, Speed]) -> dict[str, Speed]:
    """What is prescribed; what was measured stays what the past had, and what is given follows it."""
    out = dict(speeds)
    for key in (f"{name}_speed" for name in recording.taken):
        if key not in speeds:
            raise InputError(
                "missing: the past's was measured, and tells nothing of what comes; give that", key=key
            )
        out[key] = recording.speeds[key].followed(speeds[key], float(recording.t[-1] - recording.t[0]))
    return out


def distribution(model: Model, run: BodiesData, future: Floats, seed: int = 0) -> BodiesForecast:
    """
    Return the readings that follow a run.

    Parameters
    ----------
    model : as identified
    run : the past
    future : (n,) times after the past's
    seed : of the draws
    """
    cut = cuts([run])
    if len(cut) < SHOWN:
        raise InputError(
            f"the past holds {len(cut)} windows; {SHOWN} are needed to see how friction scatters"
        )
    try:
        own, run = as_it_ran(model, run, cut)
        fit = null(BodiesWindows(own, [run], cut, [], Declared()), POLICY)
    except (FloatingPointError, np.linalg.LinAlgError):
        raise StickslipError("the model cannot follow the past: no window of it can be simulated") from None
    if (left := unexplained(fit)) > POLICY.noise_left:
        words = (
            f"the model leaves {left:.3g} times the noise of the past: what follows is as uncertain as that"
        )
        warnings.warn(words, ModelWarning, stacklevel=4)
    members = _Members(fit, run, future, np.random.default_rng(seed))
    whole = standing(np.stack([members.run(k) for k in range(MEMBERS)]))
    if whole is None:
        raise StickslipError("most runs of the model stop before the horizon")
    low, high = band(whole, run.noise * np.sqrt(np.maximum(fit.noise, 1.0)), members.rng)
    return BodiesForecast(future, run.channels, whole.mean(axis=0), low, high)


class _Members:
    """Members of an ensemble, simulated from stick to stick."""

    def __init__(self, fit: Fit, run: BodiesData, future: Floats, rng: np.random.Generator) -> None:
        of = fit.windows
        assert isinstance(of, BodiesWindows)
        self.data, self.future, self.rng, count = run, future, rng, len(fit.random)
        last = tail(run, of.stretches[-1])
        self.windows = BodiesWindows(of.model, [run], [last], [], Declared())
        self.point = RunWindows(self.windows, 0, np.zeros(0), [])
        self.ahead = AHEAD * run.periods[0]
        self.begins = self.windows.begins
        sizes = np.diag(fit.population.factor(of.places)[0])
        # so few events tell their mean and their standard deviation roughly: each member has those it may be of
        self.wide = np.sqrt(count / rng.chisquare(count, MEMBERS))[:, None] * sizes
        self.mean = fit.random.mean(axis=0) + self.wide * rng.standard_normal(
            (MEMBERS, len(sizes))
        ) / math.sqrt(count)
        self.own = self._begun(fit)

    def _begun(self, fit: Fit) -> Floats:
        """Numbers of the last window, (members, own), drawn from what it leaves open."""
        base = begin(self.windows)
        own = base.own.copy()
        own[:, self.begins :] = fit.random.mean(axis=0)
        found = window_posterior(replace(base, population=fit.population, noise=fit.noise, own=own), POLICY)
        if found is None:
            raise StickslipError("the model cannot follow the last readings")
        mean, covariance = found
        # what sticks has no speed of its own: its direction says nothing, and moves nothing
        root = symmetric_root(covariance, 1.0)
        return np.asarray(mean + self.rng.standard_normal((MEMBERS, len(mean))) @ root)

    def run(self, k: int) -> Floats:
        """Return the readings of a member at the times to come, (n, channels); NaN where it is lost."""
        own, point = self.own[k], self.point
        values, _ = point.started(0, own)
        effects = own[self.begins :].copy()
        cut = self.windows.stretches[0]
        t, modes, end = float(self.data.t[cut.start]), list(cut.modes), float(self.future[-1])
        out = np.full((len(self.future), self.windows.channels), np.nan)
        for _ in range(RESTARTS):
            until = min(t + self.ahead, end)
            asked = self.future[(self.future > t) & (self.future <= until)]
            raw = self._simulated(values, modes, t, until, asked)
            if raw is None:
                return out
            again = self._again(raw)
            stop = until if again is None else float(raw["transition_t"][again])
            kept = raw["t"] <= stop if again is not None else np.ones(len(raw["t"]), dtype=bool)
            kept &= np.isin(raw["t"], asked)
            part = {
                name: raw[name][kept]
                for name in ("t", "state", "sensitivity", "sensed", "sensed_sensitivity")
            }
            first = int(np.searchsorted(self.future, t, side="right"))
            out[first : first + int(kept.sum())] = point.read(part, own, False)[0]
            state = raw["state"][-1] if again is None else raw["transition_state"][again]
            after = raw["mode"][-1] if again is None else raw["transition_after"][again]
            before = after if again is None else raw["transition_before"][again]
            came = (before != 0) & (after == 0)
            self._restart(values, state, (after == 0) & ~came, stop - t)
            self._draw(k, values, effects, np.flatnonzero(came))
            t, modes = stop, [int(one) for one in after]
            if t >= end:
                return out
        return out

    def _simulated(
        self, values: Floats, modes: list[int], t: float, until: float, asked: Floats
    ) -> Mapping[str, Any] | None:
        policy, lowered = POLICY, self.point.lowered
        times = asked if len(asked) and asked[-1] == until else np.append(asked, until)
        raw: Mapping[str, Any] = _core.simulate_bodies(
            **lowered.arguments,
            values=values,
            modes=lowered.own.modes(modes),
            t_start=t,
            t_end=until,
            t_eval=times,
            rtol=policy.tolerance,
            atol=resolved(self.windows.scales[0], policy),
            locator=_core.Locator.henon,
            seeds=np.zeros((0, len(values))),
            max_transitions=policy.most_transitions,
            max_steps=policy.most_integration_steps,
            sensed=bool(self.windows.sensed),
        )
        return raw if raw["outcome"] == _core.Outcome.finished else None

    @staticmethod
    def _again(raw: Mapping[str, Any]) -> int | None:
        """The first transition at which a contact comes to rest."""
        rest = ((raw["transition_before"] != 0) & (raw["transition_after"] == 0)).any(axis=1)
        return int(np.argmax(rest)) if rest.any() else None

    def _restart(self, values: Floats, state: Floats, stuck: NDArray[np.bool_], span: float) -> None:
        """Put a state where the core begins; a contact that stuck all the while has done so for longer."""
        layout = self.point.lowered.layout
        values[layout["initial"] : layout["initial"] + len(state)] = state
        dwell = values[layout["dwell"] : layout["dwell"] + len(stuck)]
        dwell[:] = np.where(stuck, dwell + span, 0.0)

    def _draw(self, k: int, values: Floats, effects: Floats, contacts: NDArray[np.intp]) -> None:
        """Give contacts that came to rest the friction of their next event."""
        if not len(contacts):
            return
        fresh = self.mean[k] + self.wide[k] * self.rng.standard_normal(len(effects))
        for i, place in enumerate(self.point.effect_places):
            if place is not None and self.windows.contact_of[i] in contacts:
                values[place] = effects[i] = fresh[i]
