"""What has no name: a smooth curve in one variable, at one place, against the best that named effects do."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated, tabulated
from stickslip.discovery.promise import rest
from stickslip.discovery.result import Curve
from stickslip.discovery.search import CLEAN, Search, Trial, same
from stickslip.discovery.workers import each
from stickslip.fitted.engine import Engine
from stickslip.fitted.readings import Learned
from stickslip.fitted.unknowns import Hypothesis, Unknown
from stickslip.progress import StageStep
from stickslip.simulated.states import BELT, X2

Floats = NDArray[np.float64]
STATE = {"x1": 0, "x2": 1, "y1": 2, "y2": 3}
LOOSE = 3.0  # times wider a band is for its curve's mean, which the friction law takes up as well
KNOTS, FINE = 7, 15
PROMISING = 0.85  # of the excess that the best named effect leaves: what leaves more is not fitted closely
STALLED = 12.0  # and so much for the one that promised most
FURTHER = 3  # fits of a curve on finer knots at most
REACH = 0.05  # share by which the motion must reach further for another
RESOLVED = 0.8  # of the excess of a coarse curve: what finer knots must leave less than, to be fitted closely
OUTDONE = 0.15  # share of what names leave: a curve that leaves less is on the track of what has no name
FINER = 15.0  # processor seconds for finer knots of such a curve, at least
SLOW = 0.15  # share of the fastest slip within which the knots of a curve in v_w are nearly even
TERMS = {
    "block": ("x1", "x2", "y1", "y2", "t"),
    "angle_body": ("y1", "y2", "x1", "x2", "t"),
    "contact": ("x1", "y1", "v_w", "t", "x2", "y2"),
}
READINGS = {"x1": ("x1", "y1", "t"), "y1": ("y1", "x1", "t")}
SPREAD = {"block": 5.0, "angle_body": 5.0, "contact": 1.5}


@dataclass(frozen=True)
class Term:
    """A learned curve: its place, its variable, its knots. One that recurs is in time, its knots over one turn."""

    where: str  # "block", "angle_body", "contact", "x1 channel", "y1 channel"
    variable: str
    knots: tuple[float, ...]
    recurs: bool = False

    def step(self, doing: str) -> StageStep:
        """What is said when something is done with it, one of the curves."""
        return StageStep(f"{doing} a curve: {self.where} against {self.variable}", f"{doing} curves")

    @property
    def prefix(self) -> str:
        """Prefix of its parameters."""
        if self.where.endswith("channel"):
            return f"learned_{self.where[:2]}_{self.variable}"
        return f"tabulated_{self.where}_{self.variable}"


def ranges(trial: Trial) -> dict[str, Floats]:
    """Values that each variable takes along a fit's trajectories."""
    fit = trial.fit
    seen: dict[str, list[Floats]] = {name: [] for name in (*STATE, "v_w", "t")}
    done = fit.engine.simulate(fit.vector, fit.windows)
    for i, w in enumerate(fit.windows):
        if not done.ok[i]:
            continue
        state, run = done.state[done.of(i)], fit.engine.data[w.run]
        for name, column in STATE.items():
            seen[name].append(state[:, column])
        v = state[:, X2] - run.belt_speed - state[:, BELT]
        seen["v_w"].append(v[np.abs(v) > 1e-6])
        seen["t"].append(run.t[w.start : w.stop])
    return {name: np.concatenate(values) for name, values in seen.items()}


def knots_for(values: Floats, count: int, variable: str = "") -> tuple[float, ...]:
    """Knots over what was visited, but for its rarest thousandth, and one more beyond each end.

    They are even, but for v_w: friction changes most where the contact hardly slips, so that knots lie closer there.
    A natural spline has no curvature at its last knots: these must not lie where the readings are.
    """
    low, high = np.quantile(values, [0.001, 0.999])
    if variable != "v_w":
        return tuple(_stretched(low, high, count).tolist())
    slow = SLOW * max(abs(low), abs(high))
    even = _stretched(np.arcsinh(low / slow), np.arcsinh(high / slow), count)
    return tuple((slow * np.sinh(even)).tolist())


def _stretched(low: float, high: float, count: int) -> Floats:
    """Even numbers from low to high, and one more beyond each end."""
    step = (high - low) / (count - 1)
    return np.linspace(low - step, high + step, count + 2)


def terms(trial: Trial, count: int = KNOTS) -> Iterator[Term]:
    """All curves that are tried."""
    seen = ranges(trial)
    for where, variables in TERMS.items():
        for variable in variables:
            yield Term(where, variable, knots_for(seen[variable], count, variable))
    for channel, variables in READINGS.items():
        for variable in variables:
            yield Term(f"{channel} channel", variable, knots_for(seen[variable], count))


def _extended(base: Trial, term: Term) -> tuple[Hypothesis, tuple[Unknown, ...], tuple[Learned, ...]]:
    """The base's hypothesis with a curve in its model at zero, the curve's unknowns, the curves on readings."""
    h = base.hypothesis
    size = SPREAD.get(term.where, 0.5)
    unknowns = tuple(
        Unknown(f"{term.prefix}.value_{i}", 0.0, False, 0.0, size) for i in range(len(term.knots))
    )
    learned = base.fit.engine.learned
    if term.where.endswith("channel"):
        learned = (*learned, Learned(term.where[:2], term.variable, term.knots))
    else:
        curve = tabulated(term.where, term.variable, list(term.knots), [0.0] * len(term.knots))
        h = replace(h, model=h.model.with_effects([*h.model.effects, curve]))
    return h, unknowns, learned


def with_term(search: Search, base: Trial, term: Term, **options: float) -> Trial | None:
    """A trial with a curve added, from zero."""
    h, unknowns, learned = _extended(base, term)
    h = replace(h, unknowns=(*h.unknowns, *unknowns))
    return search.run(h, windows_of=base, learned=learned, **options)  # type: ignore[arg-type]


def sensitivity(base: Trial, term: Term) -> list[Floats | None]:
    """Derivatives of each window's residuals by a curve's values at zero; None where it cannot be simulated."""
    fit = base.fit
    h, unknowns, learned = _extended(base, term)
    engine = Engine(fit.engine.data, replace(h, unknowns=unknowns), fit.engine.threads, learned)
    found = engine.linearised(np.zeros(len(unknowns)), fit.windows)
    return [None if one is None else np.nan_to_num(one.J) for one in found]


def gain(base: Trial, term: Term) -> float:
    """Fall of chi-squared that a curve promises to first order."""
    more = sensitivity(base, term)
    return rest(base, _none_of(more)) - rest(base, more, spread=SPREAD.get(term.where, 0.5))


def gain_by_window(base: Trial, term: Term) -> float:
    """The same of a constant that each window has for itself, where the curve acts."""
    more = sensitivity(base, term)
    constant = [
        None if one is None else one.sum(axis=1, keepdims=True) for one in more
    ]  # all its values together
    return rest(base, _none_of(more)) - rest(base, constant, own=True)


def _none_of(more: Sequence[Floats | None]) -> list[Floats | None]:
    return [None if one is None else one[:, :0] for one in more]


@dataclass(frozen=True)
class Crude:
    """Curves crudely fitted, best first, and the one that promised most."""

    found: list[tuple[Term, Trial]]
    promised: Term

    def beyond(self, named: Trial) -> float:
        """Share that the best of them leaves of what the best of the named leaves over."""
        return beyond(self.found[0][1], named) if self.found else 1.0


def crude(search: Search, base: Trial, most: int = 6) -> Crude:
    """Curves added to `base`: screened by their scores, the best `most` fitted."""
    promised = scores(search, base)
    found: list[tuple[Term, Trial]] = []
    say = partial(Term.step, doing="learning")
    quick = partial(_quickly, base=base, first=promised[0][1])
    for term, task in each(search, quick, [term for _, term in promised[:most]], say):
        if search.left < 0.05 * search.budget and found:
            break
        trial = task.result()
        if trial is not None:
            found.append((term, trial))
    return Crude(sorted(found, key=lambda one: one[1].bic), promised[0][1])


def learn(
    search: Search, base: Trial, most: int = 6, beat: Trial | None = None, known: Crude | None = None
) -> list[tuple[Term, Trial]]:
    """Curves added to `base`, the best two of the crude ones fitted closely; best first.

    One that does no better than `beat` is not fitted closely.
    """
    known = crude(search, base, most) if known is None else known
    found, close = known.found, []
    tell = lambda one: f"learning closely: {one[0].where} against {one[0].variable}"  # noqa: E731
    for (term, *_), polished in each(search, _closely, _worth(found, known.promised, beat), tell):
        close.append((term, polished.result()))
        if close[-1][1].excess < CLEAN:
            break
    close.sort(key=lambda one: one[1].bic)
    if close and beat is not None and beyond(close[0][1], beat) < OUTDONE:
        search.extend(FINER)
    fine = []
    for one, finer in each(search, partial(_finer, base=base), close):
        # which place it is may show only once the curve is fine enough; one within the noise may still be too smooth
        clean = close[0][1].excess < CLEAN
        if (
            (clean and one is not close[0])
            or search.left < 0
            or (one[1].fit.cost > 0.7 * base.fit.cost and not clean)
        ):
            break
        better = finer.result()
        if better is not None:
            fine.append(better)
            if better[1].excess < CLEAN:
                break
    done = {term for term, _ in close}
    return sorted([*close, *fine, *(one for one in found if one[0] not in done)], key=lambda one: one[1].bic)


def beyond(curve: Trial, named: Trial) -> float:
    """Share that a curve leaves of what the best of the named leaves over."""
    return max(curve.chi2 - 1, 0.0) / max(named.chi2 - 1, 1e-9)


def _worth(
    found: list[tuple[Term, Trial]], promised: Term, beat: Trial | None
) -> Iterator[tuple[Term, Trial, int]]:
    """What to fit closely, and in how many turns: the two best, where they come near `beat`; and what promised most,
    though it stalled.
    """
    for i, (term, trial) in enumerate(found):
        left = 0.0 if beat is None else (trial.chi2 - 1) / max(beat.chi2 - 1, 1e-9)
        if i < 2 and left <= PROMISING:
            yield term, trial, 1
        elif term == promised and left <= STALLED:
            yield term, trial, 0


def scores(search: Search, base: Trial) -> list[tuple[float, Term]]:
    """Curves that may be added to `base` with the `gain` of each, greatest first."""
    say = partial(Term.step, doing="scoring")
    tasks = partial(each, search, partial(_scored, base=base), terms(base), say)
    return search.once(
        "scores",
        base,
        lambda: sorted(((task.result(), term) for term, task in tasks()), key=lambda one: -one[0]),
    )


def _scored(_: Search, term: Term, *, base: Trial) -> float:
    return gain(base, term)


def _quickly(search: Search, term: Term, *, base: Trial, first: Term) -> Trial | None:
    """A curve fitted crudely; the first patiently: far from the readings the way down begins flat."""
    if term == first:
        return with_term(search, base, term, iterations=60, rounds=3)
    return with_term(search, base, term, iterations=12, tolerance=1e-3, rounds=1, worst=0.98 * base.fit.cost)


def _closely(search: Search, one: tuple[Term, Trial, int]) -> Trial:
    """A curve fitted closely: in so many turns more, unless both sides lead to the same minimum."""
    _, trial, turns = one
    ends = search.sides(trial)
    best = min(ends, key=lambda end: end.fit.cost)
    if len(ends) > 1 and same([end.fit.cost for end in ends]):
        return best
    return search.polish(best, turns=turns, closed=True, further=0)  # near the noise finer knots do more


def _finer(search: Search, coarse: tuple[Term, Trial], *, base: Trial) -> tuple[Term, Trial] | None:
    """The same curve on more knots, started afresh, if that is better; again while it moves the motion further out."""
    best = coarse
    for _ in range(FURTHER):
        term, trial = best
        fine = Term(term.where, term.variable, knots_for(ranges(trial)[term.variable], FINE, term.variable))
        if best is not coarse and (trial.excess < CLEAN or _reach(fine) < (1 + REACH) * _reach(term)):
            break
        added = with_term(search, base, fine, iterations=25, rounds=2)
        if added is None:
            break
        # else it is not for knots that the coarse one fits badly
        if added.bic < trial.bic or added.chi2 - 1 < RESOLVED * (trial.chi2 - 1):
            added = _closely(search, (fine, added, 1))
        if added.bic > trial.bic:
            break
        best = fine, added
    return None if best is coarse else best


def _reach(term: Term) -> float:
    return term.knots[-1] - term.knots[0]


def repeating(term: Term, values: Floats) -> Tabulated:
    """The curve of a term that recurs, its phase 0."""
    return tabulated(term.where, term.variable, term.knots, values.tolist(), period=term.knots[-1])


def curve(term: Term, trial: Trial) -> Curve:
    """The learned curve with its band; of one that recurs a turn, from where it is 0."""
    fit, count, less = trial.fit, len(term.knots), ""
    names = [u.name for u in fit.engine.hypothesis.shared]
    free = range(1, count - 1) if term.recurs else range(count)
    index = [names.index(f"{term.prefix}.value_{i}") for i in free]
    covariance = fit.covariance[np.ix_(index, index)]
    if term.recurs:
        period = 2 * np.pi / fit.engine.hypothesis.values(fit.vector, 0)[f"{term.prefix}.w"]
        term = replace(term, knots=tuple(np.linspace(0.0, period, count).tolist()))
        x = np.linspace(0.0, period, 101)
        each_one = np.pad(np.eye(count - 2), ((0, 0), (1, 1)))
        basis = np.stack([repeating(term, one).curve(x) for one in each_one], 1)
    else:
        x = np.linspace(term.knots[1], term.knots[-2], 101)  # what was visited
        basis = Learned("x1", "x1", term.knots).basis(x)
        centred = basis - basis.mean(axis=0)
        if _half(basis, covariance).mean() > LOOSE * _half(centred, covariance).mean():
            basis, less = centred, ", less its mean"
    middle = basis @ fit.vector[index]
    half = _half(basis, covariance) * max(trial.chi2, 1.0) ** 0.5
    within = np.maximum(half, 1e-12)
    words = _sine(x, middle, within) if term.recurs else guess(x, middle, within, term.variable)
    return Curve(
        term.where, term.variable, _what(term) + less, x, middle, middle - half, middle + half,
        np.array(term.knots), words, term.knots[-1] if term.recurs else None,
    )  # fmt: skip


def _what(term: Term) -> str:
    words = {
        "block": "force on the block",
        "angle_body": "force on the angle body",
        "contact": "friction factor less 1",
    }
    return words.get(term.where, f"added to the {term.where[:2]} reading")


def _half(basis: Floats, covariance: Floats) -> Floats:
    """Half the width of the 95 % band of basis @ values."""
    return np.asarray(1.96 * np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", basis, covariance, basis), 0.0)))


def _sine(t: Floats, value: Floats, half: Floats) -> str | None:
    """One turn of a curve as a sine that stays within the band, or None."""
    w = 2 * np.pi / t[-1]
    A = np.stack([np.sin(w * t), np.cos(w * t), np.ones_like(t)], 1)
    c, *_ = np.linalg.lstsq(A, value, rcond=None)
    off = np.abs(A @ c - value)
    if np.mean(off < 1.5 * half) < 0.9 or np.sqrt(np.mean(off**2)) > 0.35 * np.std(value):
        return None
    return f"{math.hypot(c[0], c[1]):.3g} sin({w:.5g} t + phi)"


_SHAPES: dict[str, Callable[[Floats], Floats]] = {
    "{0}": lambda x: x,
    "|{0}|": np.abs,
    "{0}^2": lambda x: x**2,
    "{0} |{0}|": lambda x: x * np.abs(x),
    "{0}^3": lambda x: x**3,
    "sgn({0})": np.sign,
}


def guess(x: Floats, value: Floats, half: Floats, variable: str) -> str | None:
    """A formula c0 + c1 f(x) that stays within the band, or None."""
    for words, f in _SHAPES.items():
        A = np.stack([np.ones_like(x), f(x)], 1)
        c, *_ = np.linalg.lstsq(A / half[:, None], value / half, rcond=None)
        off = np.abs(A @ c - value)
        if np.mean(off < 1.5 * half) > 0.9 and np.sqrt(np.mean(off**2)) < 0.15 * np.std(value):
            return f"{c[1]:+.4g} {words.format(variable)} {c[0]:+.3g}"
    return None


def is_tabulated(name: str) -> bool:
    """Is this the name of a learned curve?"""
    return name.startswith(("tabulated_", "learned_"))


def has_curve(trial: Trial) -> bool:
    """Is there a learned curve in it?"""
    return any(map(is_tabulated, trial.names))


def called(name: str) -> str:
    """What a curve is called among rivals: its place and its variable."""
    if name.startswith("learned_"):
        channel, variable = name.removeprefix("learned_").split("_", 1)
        return f"a curve of the {channel} channel in {variable}"
    body = name.removeprefix("tabulated_")
    where = next(place for place in TERMS if body.startswith(f"{place}_"))
    return f"a curve on the {where.replace('_', ' ')} in {body.removeprefix(f'{where}_')}"
