"""The laws of a rig of bodies or matrices from its recordings: laws, declared constants and scatter together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.bodies_model import named_laws
from stickslip.declared.effect import effect
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.places import CHANNEL
from stickslip.declared.rigs.general import ContactRow, GeneralRig
from stickslip.declared.uncertainty import SIGMAS_95, Uncertainty
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.constant import Constant
from stickslip.fitted.identified import Estimate, Spread, Status, estimate
from stickslip.fitted.identify_words import EXPLAINED
from stickslip.likelihoods.bodies_bench import BodiesBench, bench_of
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit, unexplained
from stickslip.likelihoods.identified_rig import IdentifiedRig
from stickslip.likelihoods.mixed import solve
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import factor
from stickslip.likelihoods.variances import Deviance
from stickslip.measured.case import Case
from stickslip.measured.recording import Recording

Floats = NDArray[np.float64]
NEARBY = 1e-3  # step of the slopes of the deviance by the logarithm of a scatter
HARDLY, TOLD_ALREADY = 0.1, 0.99  # shares of the declared in what is known, as of an `Estimate`
POOR = 0.5  # weight of a window below which the laws are no model of it

Tell = Callable[[str, float], None]


def identify_bodies(
    source: Case | Recording | Sequence[Recording],
    *,
    rig: GeneralRig | None = None,
    friction: FrictionLaw | Mapping[str, FrictionLaw] | None = None,
    progress: Tell | None = None,
) -> IdentifiedRig:
    """Identify the laws of a rig of bodies or matrices.

    The runs are cut from mid-stick to mid-stick; of each window the state at its start is free, and friction of every
    contact is its own. The law is that of the mean event (`stickslip.likelihoods.bodies_windows`).

    Parameters
    ----------
    source
        A case, of which the "train" runs are used; or recordings.
    rig, friction
        Needed for recordings: the rig, and the laws that a fit starts from.
    progress
        Called with what is being done and the share done.

    Raises
    ------
    InputError
        A law has states that carry no load at rest, or a run is too short.
    StickslipError
        No law of this kind moves the rig like the readings.
    """
    tell = progress or (lambda _what, _share: None)
    model, runs, known = _material(source, rig, friction)
    tell("reading the motion", 0.0)
    bench = bench_of(model, runs, known)
    tell(f"fitting {len(bench.stretches)} windows", 0.1)
    try:
        fit = null(bench.windows(), POLICY)
    except (FloatingPointError, np.linalg.LinAlgError):
        words = (
            "no window of the runs can be simulated with laws of this kind; are rig, units and speeds right?"
        )
        raise StickslipError(words) from None
    tell("done", 1.0)
    return _found(bench, fit)


def _material(
    source: Case | Recording | Sequence[Recording],
    rig: GeneralRig | None,
    friction: FrictionLaw | Mapping[str, FrictionLaw] | None,
) -> tuple[Model, Sequence[Recording], Uncertainty]:
    if isinstance(source, Case):
        if rig not in (None, source.rig):
            raise InputError("a case has its own rig; leave it out", key="rig")
        model = source.model(friction=named_laws(friction) if friction is not None else None)  # type: ignore[arg-type]
        return model, source.train, source.uncertainty
    runs = [source] if isinstance(source, Recording) else list(source)
    if not runs:
        raise InputError("no run to identify from", key="source")
    if friction is None:
        raise InputError("missing: the laws that a fit starts from", key="friction")
    first = runs[0]
    model = Model(rig or first.rig, friction=friction, channels=dict(first.channels))  # type: ignore[arg-type]
    return model, runs, Uncertainty.usual(model.rig, channels=first.channels)


def _found(bench: BodiesBench, fit: Fit) -> IdentifiedRig:
    assert fit.solution is not None
    assert fit.linear is not None
    values, names = fit.values(), list(bench.model.friction.numbers)
    model = after(bench.model, values)
    left = float(fit.solution.misfit.sum())
    count = float((fit.linear.count * fit.linear.weight[:, None]).sum())
    freedom = max(count - float(fit.freedom.sum()) - len(fit.at), 1.0)
    places = [i for i, one in enumerate(fit.windows.numbers) if one.name in names]
    known = _known(fit)
    estimates, constants = _estimates(bench, fit, known, values), _constants(bench, fit, known)
    return IdentifiedRig(
        model=model,
        declared=bench.model,
        estimates=estimates,
        names=tuple(fit.windows.numbers[i].name for i in places),
        covariance=_turned(fit, known, places),
        scatter=scatter(fit),
        constants=constants,
        offsets=_offsets(bench, fit, known),
        noise=dict(
            zip(
                bench.data[0].channels, np.median([r.noise for r in bench.data], axis=0).tolist(), strict=True
            )
        ),
        reduced_chi2=left / freedom,
        windows=len(bench.stretches),
        fastest=_fastest(bench),
        messages=_messages(bench, fit, left / freedom, estimates, constants),
    )


def after(model: Model, values: Mapping[str, float]) -> Model:
    """Return a model with the numbers of a fit; gains of coordinates and velocities are effects of their channels."""
    assert isinstance(model.rig, GeneralRig)
    found = {f"{name}{CHANNEL}": values.get(f"gain.{name}", 0.0) for name in model.rig.state_names}
    declared = [one for one in model.effects if one.name == "sensor_gain" and one.where in found]
    for one in declared:
        found[one.where] = (1 + found[one.where]) * (1 + one.parameters["e"]) - 1
    gains = [effect("sensor_gain", where=where, e=e) for where, e in found.items() if e]
    kept = [one for one in model.effects if one not in declared]
    numbers = {name: values[name] for name in model.parameters if name in values}
    return replace(model.replace(numbers), effects=(*kept, *gains))


def _turned(fit: Fit, known: Floats, places: Sequence[int]) -> Floats:
    """Covariance of numbers, from that of their coordinates, `known`."""
    slopes = np.array([fit.windows.numbers[i].slope(float(fit.at[i])) for i in places])
    part = known[np.ix_(places, places)]
    return np.asarray(slopes[:, None] * part * slopes, dtype=np.float64)


def _estimates(
    bench: BodiesBench, fit: Fit, known: Floats, values: Mapping[str, float]
) -> dict[str, Estimate]:
    """Every number of the laws, within its bounds; one that was not fitted is as declared."""
    out = {}
    places = {one.name: i for i, one in enumerate(fit.windows.numbers)}
    for name, start in bench.model.friction.numbers.items():
        if name not in places:
            out[name] = Estimate(start, None, None, None, "unidentified", start)
            continue
        i = places[name]
        number = fit.windows.numbers[i]
        sd = math.sqrt(float(known[i, i]))
        share = min((sd / number.sd) ** 2, 1.0)
        std = sd * number.slope(float(fit.at[i]))
        made = estimate(values[name], std, share, start)
        least = -math.inf if number.low == -math.inf else number.value(number.low)
        low = None if made.low is None else max(made.low, least)
        out[name] = Estimate(made.value, low, made.high, made.std, made.status, start)
    return out


def _offsets(bench: BodiesBench, fit: Fit, known: Floats) -> dict[str, Estimate]:
    """What must be added to sensors' columns: what is declared, less what the fit finds them to read too much."""
    out, channel_of = {}, {f"offset.{name}": name for name in bench.data[0].offsets}
    for i, one in enumerate(fit.windows.numbers):
        if one.name not in channel_of:
            continue
        name = channel_of[one.name]
        declared, size = bench.data[0].offsets[name]
        sd = math.sqrt(float(known[i, i]))
        value, share = declared - float(fit.at[i]), (sd / size) ** 2  # of the information that is declared
        status: Status = (
            "unidentified" if share >= TOLD_ALREADY else "weak" if share > HARDLY else "identified"
        )
        out[name] = Estimate(value, value - SIGMAS_95 * sd, value + SIGMAS_95 * sd, sd, status, declared)
    return out


def _constants(bench: BodiesBench, fit: Fit, covariance: Floats) -> dict[str, Constant]:
    """What the runs say of constants and gains."""
    out = {}
    for i, one in enumerate(fit.windows.numbers):
        if one.name not in bench.declared.names:
            continue
        k = bench.declared.names.index(one.name)
        sd = math.sqrt(float(covariance[i, i]))
        gain = one.name in bench.declared.gains
        declared = 1.0 if gain else bench.model.parameters[one.name]
        size = 1.0 + one.value(float(fit.at[i])) if gain else one.value(float(fit.at[i]))
        low, high = sorted(declared * size * math.exp(s * SIGMAS_95 * sd) for s in (-1, 1))
        known = math.sqrt(float(bench.declared.covariance[k, k]))
        out[one.name] = Constant(declared * size, low, high, declared, known)
    return out


def scatter(fit: Fit) -> dict[str, Spread]:
    """Return what differs from window to window, with intervals by the curvature of the deviance."""
    covariance, out = _of_sizes(fit), {}
    for i, name in enumerate(fit.population.names):
        sd, value = math.sqrt(float(covariance[i, i])), fit.population.sizes[i]
        out[name] = Spread(value, value * math.exp(-SIGMAS_95 * sd), value * math.exp(SIGMAS_95 * sd))
    return out


def _of_sizes(fit: Fit) -> Floats:
    """Covariance of the logarithms of what differs and of the noise's factors, (k + channels, k + channels)."""
    population, noise = fit.population, fit.noise
    assert fit.linear is not None
    prior = fit.windows.prior.at(fit.at)
    usual = population.usual(fit.windows.policy)
    free = Deviance(fit.linear, fit.windows.places, prior, fit.random, population, *usual)
    x = np.concatenate([population.coordinates(), np.log(noise)])
    curvature = np.empty((len(x), len(x)))
    for i in range(len(x)):
        step = np.zeros(len(x))
        step[i] = NEARBY
        curvature[i] = (free(x + step)[1] - free(x - step)[1]) / (2 * NEARBY)
    size, turn = np.linalg.eigh(0.5 * (curvature + curvature.T))
    return np.asarray(2 * (turn / np.maximum(size, 2e-2)) @ turn.T)


def _known(fit: Fit) -> Floats:
    """
    Covariance of the shared numbers' coordinates, (p, p), scatter as well known as the windows tell it.

    A level that no reading shows follows from how much it would scatter, if that were known.
    """
    assert fit.linear is not None
    assert fit.solution is not None
    at, prior, bounds = fit.population.coordinates(), fit.windows.prior.at(fit.at), fit.windows.steps(fit.at)
    moves = np.zeros((len(fit.at), len(at)))
    for i in range(len(at)):
        step = np.zeros(len(at))
        step[i] = NEARBY
        sides = (
            solve(
                fit.linear,
                factor(fit.population.moved(at + side * step), fit.windows.places),
                fit.noise,
                *prior,
                fit.random,
                bounds=bounds,
            ).shared
            for side in (1, -1)
        )
        moves[:, i] = np.subtract(*sides) / (2 * NEARBY)
    sizes = _of_sizes(fit)[: len(at), : len(at)]
    return np.asarray(fit.solution.covariance + moves @ sizes @ moves.T)


def _fastest(bench: BodiesBench) -> dict[str, float]:
    """The fastest slip that the runs show, by the names of the contacts."""
    assert isinstance(bench.model.rig, GeneralRig)
    out = {}
    for one in bench.model.rig.equations.contacts:
        slips = [np.max(np.abs(one.slip(run.v, run.belt(run.t)))) for run in bench.data]
        out[one.name] = float(max(slips))
    return out


def _messages(
    bench: BodiesBench,
    fit: Fit,
    reduced: float,
    estimates: Mapping[str, Estimate],
    constants: Mapping[str, Constant],
) -> tuple[str, ...]:
    assert fit.linear is not None
    out = []
    lost = int(sum(block is None for block in fit.blocks))
    poor = int((fit.linear.weight < POOR).sum()) - lost
    if lost or poor:
        out.append(
            f"{lost} of {len(fit.blocks)} windows cannot be simulated, and {poor} fit poorly; they count less"
        )
    if unexplained(fit) > POLICY.noise_left:
        words = f"{unexplained(fit):.3g} times the noise's variance is left: something acts that the laws do not say,"
        words += " or the fit went astray; no number here can be relied on. `discover` looks for what acts"
        out.append(words)
    elif reduced > EXPLAINED:
        out.append(
            f"the declared laws do not explain the readings (chi-squared {reduced:.3g} per degree of freedom); the "
            "intervals know nothing of what they leave, and `stickslip discover` looks for what is missing"
        )
    if len(fit.blocks) < POLICY.fewest_windows:
        words = f"{len(fit.blocks)} windows tell little of how friction scatters; record longer"
        out.append(words)
    unseen = sorted(
        {
            one.name
            for run in bench.data
            for one, told in zip(_contacts(bench), run.seen, strict=True)
            if not told
        }
    )
    if unseen:
        out.append(f"the motion at {', '.join(unseen)} is not read: it is found from the other coordinates")
    for name, one in constants.items():
        if one.beyond and unexplained(fit) <= POLICY.noise_left:
            words = (
                f"{name} is {one.value:.4g}, {abs(one.off):.2g} standard uncertainties from what is declared"
            )
            out.append(f"{words}: it, or what acts like it, is not {one.declared:.4g}")
    low = [n for n, e in estimates.items() if e.status == "weak"]
    if low:
        out.append(f"the readings say little of {', '.join(low)}")
    return tuple(out)


def _contacts(bench: BodiesBench) -> Sequence[ContactRow]:
    assert isinstance(bench.model.rig, GeneralRig)
    return bench.model.rig.equations.contacts
