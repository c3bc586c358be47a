"""What `discover` returns: verdict, effects, rivals, errors, and the arrays that a report draws.

One file, as it is the list of what a report may rest on: a third of it says what each field is.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import Enum
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.plain import Json, plain
from stickslip.errors import InputError
from stickslip.likelihoods.interval import Interval
from stickslip.measured.case import Case
from stickslip.measured.thinning import Thinned
from stickslip.objects import Drawn, contents, reporter

Floats = NDArray[np.float64]
AGAINST = 0.05  # chance of so little likelihood from which runs never fitted speak against what was found
WORSE = 1.02  # error after over error before, on runs never fitted, from which it is said to rise
SEEN = 4  # samples in stick, at least, of a block that sticks
TIED = 8.0  # difference in -2 log evidence below which two rivals are not told apart: odds of 55 to 1
LEFT = 12.0  # way against the belt, over the noise, below which a block never slips
SELDOM = 0.1  # and its share of slip


class Verdict(Enum):
    """What was found; the value is the word of report.json."""

    no_effect = "no_effect"
    effect_found = "effect_found"
    unlisted_effect = "unlisted_effect"


@dataclass(frozen=True)
class Alternative:
    """A rival that the data cannot tell from the winner, or can only just.

    Attributes
    ----------
    name : the effect's name.
    odds : probability of the rival against the winner's, 1 for equal.
    delta : how much more the winner lowers -2 log likelihood, penalties included.
    tied : no verdict between them is possible from these runs.
    exact : the tie is one of algebra; `reason` gives it.
    reason : one sentence.
    parameters : the rival's own estimates.
    correlation : between the two signatures after refit, -1 to 1; None if not computed.
    """

    name: str
    odds: float
    delta: float
    tied: bool
    exact: bool
    reason: str
    parameters: Mapping[str, Interval]
    correlation: float | None = None


@dataclass(frozen=True)
class Curve:
    """A learned curve g(variable) with its 95 % band, where the readings reach; (n,) arrays.

    `term` says what g is ("force on the block", "friction factor minus 1", "added to the x1 reading"), `unit` is
    always "1" (model units). `guess` is a formula that describes it adequately, or None. One that repeats in t has a
    `period`; each run then has a phase of its own.
    """

    where: str
    variable: str
    term: str
    x: Floats
    value: Floats
    low: Floats
    high: Floats
    knots: Floats
    guess: str | None
    period: float | None = None


@dataclass(frozen=True)
class Evidence:
    """Why an effect is believed; None where nothing was measured: of a guessed place, of a control that was not tried.

    Attributes
    ----------
    delta_chi2 : fall of chi-squared on the fitted windows when the effect joins, law refitted in both.
    delta_bic : the same with the penalty for its parameters.
    held_out_ratio : error with it over error without it, on windows held out of both fits.
    control : delta_chi2 of the best wrong effect in its place, beside the same others.
    control_name : which one that was.
    threshold : delta_chi2 that the gate demands.
    sentence : one line for a person.
    """

    delta_chi2: float | None
    delta_bic: float | None
    held_out_ratio: float | None
    control: float | None
    control_name: str
    threshold: float
    sentence: str

    @property
    def weight(self) -> float:
        """`delta_chi2`, 0 where it was not measured."""
        return self.delta_chi2 or 0.0


@dataclass(frozen=True)
class FoundEffect:
    """One effect of the verdict, in the words of report.json; an effect without a name is "unlisted"."""

    name: str
    where: str
    depends_on: tuple[str, ...]
    parameters: Mapping[str, Interval]
    evidence: Evidence
    alternatives: tuple[Alternative, ...]
    formula: str
    curve: Curve | None = None
    phases: Mapping[str, float] = field(default_factory=dict)  # run name -> phi, for effects that have one
    of_rig: bool = False  # a declared number of the rig that is wrong, not something beside it


@dataclass(frozen=True)
class Rival:
    """One line of the ranking: a hypothesis fitted jointly with the law.

    `names` is () for the declared law alone; `chi2` is per reading on the training windows; `bic` is relative to
    the best of the ranking (0); `score` is the screening's predicted fall of chi-squared, None if not screened.
    """

    names: tuple[str, ...]
    chi2: float
    bic: float
    parameters: Mapping[str, float]
    score: float | None
    chosen: bool


@dataclass(frozen=True)
class Part:
    """chi-squared per reading on one part of the record, with its sampling error and the readings it rests on."""

    what: str  # "channel", "mode", "speed", "time", "transition"
    name: str
    chi2: float
    error: float
    count: int


@dataclass(frozen=True)
class Residual:
    """Residual against the noise, absolutely.

    `chi2` per reading over all, `error` its sampling error; `whiteness` the largest normalised autocorrelation
    statistic (1 = the 95 % limit for white noise); `parts` where it sits; `sentence` for a person. `correlated`:
    channels whose residual goes on from reading to reading as white noise does not.
    """

    chi2: float
    error: float
    whiteness: float
    clean: bool
    parts: tuple[Part, ...]
    sentence: str
    correlated: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunView:
    """One run as measured and as the models have it; model units, (n,) arrays.

    `before`, `after` hold predicted readings: keys x1, y1 (and belt); `rate_*` is the rate of x1's.
    `state_before`/`state_after` are (n, 4) states, `force_before`/`force_after` the friction T and
    `speed_before`/`speed_after` v_w at the samples, `mode_*` in {-1, 0, 1}. Residuals are
    (measured - predicted)/noise. `low`, `high` are the 95 % band of the readings that the model after forecasts, where
    friction scatters. For train runs the trajectories are the fits, for validate runs one-cycle-ahead
    forecasts stitched together.
    """

    name: str
    role: str
    belt_speed: float
    t: Floats
    measured: Mapping[str, Floats]
    noise: Mapping[str, float]
    before: Mapping[str, Floats]
    after: Mapping[str, Floats]
    rate_before: Floats
    rate_after: Floats
    state_before: Floats
    state_after: Floats
    mode_before: NDArray[np.int8]
    mode_after: NDArray[np.int8]
    force_before: Floats
    force_after: Floats
    speed_before: Floats
    speed_after: Floats
    low: Mapping[str, Floats] = field(default_factory=dict)
    high: Mapping[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True)
class RunError:
    """Errors on one validate run. Each maps "before", "after", "floor" to a number.

    `one_cycle`, `two_cycles`: windowed forecast NRMSE; `transition_time`: median error of onsets of slip over the
    cycle; `period`, `stick_fraction`: absolute errors (of the cycle; of 1); `portrait`: mean distance of the
    phase portraits over their size. `rmse` in the readings' own units, by channel: {"x1": {"before": ..}}.
    """

    run: str
    belt_speed: float
    one_cycle: Mapping[str, float]
    two_cycles: Mapping[str, float]
    transition_time: Mapping[str, float]
    period: Mapping[str, float]
    stick_fraction: Mapping[str, float]
    portrait: Mapping[str, float]
    rmse: Mapping[str, Mapping[str, float]]
    unit: Mapping[str, str]


@dataclass(frozen=True)
class Likelihood:
    """How likely runs never fitted are with what was found, event by event.

    An event has friction of its own, as it scatters in the train runs. `gain`: by how much their -2 log likelihood
    falls with it, over all events (`forecasts`); `chance`: how often it would fall by so little if they were as likely
    without, by ranks of the events (Wilcoxon, one-sided): a single one in which much goes wrong decides nothing.
    `spare`: what the gain on the train runs has beyond the gate; None for what has no gate. `name`: the effect it is
    of, beside the others; "" for all that was found.
    """

    gain: float
    forecasts: int
    chance: float
    spare: float | None = None
    name: str = ""

    @property
    def against(self) -> bool:
        """Whether they speak against it by themselves."""
        return self.chance < AGAINST

    @property
    def too_little(self) -> bool:
        """Whether its gain on all runs together, these included, does not pass the gate."""
        return self.spare is not None and self.spare + self.gain < 0

    @property
    def carries(self) -> bool:
        """Whether runs never used leave what the train runs say of it."""
        return not (self.against or self.too_little)


@dataclass(frozen=True)
class ErrorBlock:
    """`error` of report.json: one metric over all validate runs, and every run's table.

    `covered`: share of the validate runs' readings that the 95 % band of the model after holds; None without a band.
    `likelihood` is that of the validate runs with what was found, or with the effect that they speak against; None
    where nothing was, or it cannot be told.
    """

    metric: str
    before: float
    after: float
    floor: float
    runs: tuple[RunError, ...]
    covered: float | None = None
    likelihood: Likelihood | None = None

    @property
    def rises(self) -> bool:
        """Whether it is larger after than before."""
        return self.after > WORSE * self.before

    @property
    def carries(self) -> bool:
        """
        Whether what was found carries over: runs never used are not clearly less likely with it.

        Nor do they take back by how much the train runs pass the gate. Where they are no more likely, or nobody can
        tell, their error must not rise. An error alone is a poor judge: most of it is friction of the next event, which
        no model knows.
        """
        held = self.likelihood
        speaks = held is not None and held.gain > 0
        return (held is None or held.carries) and (speaks or not self.rises)


@dataclass(frozen=True)
class Experiment:
    """One entry of the menu of next experiments.

    `separability`: for the two rivals named, the expected delta chi2 between them on this experiment after refit;
    `sufficient` where that would settle it.
    """

    what: str
    belt_speed: float | None
    between: tuple[str, str]
    separability: float
    sufficient: bool


@dataclass(frozen=True)
class Gate:
    """The parametric bootstrap on this case's own noise: largest score among all rivals, `draws` of them.

    `observed` is this case's; `threshold` is exceeded by noise alone with `probability`.
    """

    observed: float
    threshold: float
    probability: float
    draws: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Found(Drawn):
    """What `stickslip.discover` returns.

    Attributes
    ----------
    title, verdict
        What the case is called, and the `Verdict`.
    effects
        In order of weight; empty for `no_effect`.
    before, after
        Complete models, channels and noise included: the declared law identified alone, and with what was found.
        `model` is `after`.
    law, law_before
        Numbers of the friction law in `after`, and in `before`: name -> Interval.
    residual_before, residual_after, error
        What is left on the train runs; the errors on the validate runs.
    ranking, experiments
        All rivals fitted, and experiments that would separate those that are tied, best first.
    gate
        The bootstrap: what noise alone would gain.
    runs, spectrum
        What the figures draw. The spectrum has "frequency" (angular, in the model's units) and, "before" and "after",
        the mean normalised power of the residual, 1 for white noise (k,).
    messages, seconds
        Sentences a person should read (ties, one speed only, absorbed loads, ...); the time it took [s].
    constants
        What the runs say of declared constants, each with all others as declared, where that was asked: by the
        model's number ("alpha2", "mass", ...), or by the channel of a gain, which is 1 where it is as declared.
    scatter
        Relative standard deviations of what differs from event to event: "static" and "kinetic" friction, the "belt";
        empty where every event is like every other.
    unclaimed
        What the train runs would name, and runs that were not used are forecast worse with.
    thinned, case
        What was done to runs too long to be fitted reading by reading; what was searched, for `write_report`.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> true = ss.Model(ss.BlockOnBelt(mass=1.0), friction=ss.CoulombFriction(static=0.4, kinetic=0.25))
    >>> t = np.arange(0, 100, 0.1)
    >>> x1 = ss.simulate(true, belt_speed=0.1, initial=(0, 0.1), t_end=100, t_eval=t).x1
    >>> x1 = x1 + 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> found = ss.discover({"t": t, "x1": x1}, rig=true.rig, friction=true.friction, belt_speed=0.1)
    >>> found.verdict.value
    'no_effect'
    >>> print(f"kinetic friction {found.law['kinetic'].value:.3f}")
    kinetic friction 0.250
    """

    title: str
    verdict: Verdict
    effects: tuple[FoundEffect, ...]
    before: Model
    after: Model
    law: Mapping[str, Interval]
    law_before: Mapping[str, Interval]
    residual_before: Residual
    residual_after: Residual
    error: ErrorBlock
    ranking: tuple[Rival, ...]
    experiments: tuple[Experiment, ...]
    gate: Gate
    runs: tuple[RunView, ...]
    spectrum: Mapping[str, Floats]
    messages: tuple[str, ...]
    seconds: float
    constants: Mapping[str, Interval] = field(default_factory=dict, kw_only=True)
    scatter: Mapping[str, Interval] = field(default_factory=dict, kw_only=True)
    unclaimed: tuple[FoundEffect, ...] = field(default=(), kw_only=True)
    thinned: tuple[Thinned, ...] = field(default=(), kw_only=True)
    case: Case | None = field(default=None, kw_only=True)

    @property
    def model(self) -> Model:
        """The model after discovery."""
        return self.after

    @property
    def never(self) -> Literal["slips", "sticks"] | None:
        """What the block does in no train run, so that the readings are silent on what the law says of it.

        A window's own start may slip for a few samples within the noise: where no run leaves the belt, that is none.
        """
        train = [run for run in self.runs if run.role == "train"]
        if not train:  # a driven slider is not looked at like this
            return None
        mode = np.concatenate([run.mode_after[np.isfinite(run.state_after[:, 0])] for run in train])
        if np.count_nonzero(mode == 0) < SEEN:
            return "sticks"
        left = max(
            float(np.ptp(run.measured["x1"] - run.belt_speed * run.t)) / run.noise["x1"] for run in train
        )
        return "slips" if left < LEFT and np.mean(mode != 0) < SELDOM else None

    def write_report(self, out: str | os.PathLike[str], *, force: bool = False) -> list[Path]:
        """Write report.html, report.json, the models and the figures into a folder, made if absent.

        Parameters
        ----------
        out
            The folder. Files of an earlier result in it are replaced.
        force
            Replace files of these names that no earlier result put there, too.

        Returns
        -------
        list of Path
            What was written; report.html first.

        Raises
        ------
        InputError
            The folder cannot be written to, or holds somebody's own files of these names.
        """
        if self.case is None:
            raise InputError("holds no case, as one that `discover` returns does", key="found")
        command = (
            None if self.case.path.exists() else "stickslip.discover(...), in Python, of what was in memory"
        )
        return reporter()(self, self.case, out, force=force, command=command)

    @property
    def report(self) -> dict[str, Json]:
        """What report.json holds, as plain Python: numbers, strings, lists and dicts only.

        Of what `discover` did not return, and so holds no case, that without units, provenance and words.
        """
        return self.plain if self.case is None else contents()(self, self.case)

    @property
    def plain(self) -> dict[str, Json]:
        """The same as the search left it (no arrays of readings)."""
        skipped = {"before", "after", "runs", "spectrum", "constants", "unclaimed", "case"}
        items = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in skipped}
        return {name: plain(value) for name, value in items.items()}
