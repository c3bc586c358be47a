"""Screening: what every effect of the catalogue would gain beside a fitted hypothesis, to first order."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect_kind import EffectKind
from stickslip.discovery.laboratory.hypothesis import LEAST, Bench, Term, label, of_term, sizes_of, term
from stickslip.discovery.laboratory.null import Null
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.laboratory.waves import WaveColumns, Waves, coarse, lasts, waves_at
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.event_windows import own_in
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.score import Columns, score
from stickslip.simulated.named_places import beside_formula

Floats = NDArray[np.float64]
AT_ONCE = 8  # frequencies that a worker is handed


@dataclass(frozen=True)
class Candidate:
    """
    An effect to be fitted, with where to start.

    Parameters
    ----------
    term : with its numbers by the score
    gain : predicted fall of -2 log marginal likelihood
    count : numbers that the score fits
    step : of the shared numbers beside it
    known : what of the gain every belt has
    """

    term: Term
    gain: float
    count: int
    step: Floats
    known: float = 0.0

    def price(self, windows: int) -> float:
        """Return the price of its numbers."""
        return self.count * math.log(windows)

    def worth(self, windows: int) -> float:
        """Return the gain less the price of its numbers."""
        return self.gain - self.known - self.price(windows)


@dataclass(frozen=True)
class Shapes:
    """Columns of an effect that does not come and go, one set for each value of what no score reaches."""

    count: int
    sets: tuple[Columns, ...]

    def gains(self, null: Null, drawn: list[Floats | None], shared: Floats) -> Floats:
        """Return the largest gain over all sets, for each draw."""
        best = np.zeros(shared.shape[1])
        for made in self.sets:
            one = null.projected(made)
            pull = null.along(one.columns, drawn, shared.shape[1]).sum(axis=0)
            best = np.maximum(best, null.gains(one.cross.sum(axis=0), one.square.sum(axis=0), pull, shared))
        return best


@dataclass(frozen=True)
class Screen:
    """
    What was scored.

    Parameters
    ----------
    ranked : every candidate that may gain, best first
    scored : the columns behind them, for draws
    """

    ranked: tuple[Candidate, ...]
    scored: tuple[Shapes | Waves, ...]

    @property
    def shapes(self) -> tuple[Shapes, ...]:
        """The columns of effects that do not come and go."""
        return tuple(one for one in self.scored if isinstance(one, Shapes))

    @property
    def gates(self) -> int:
        """How many gates there are: one for all shapes, one for each effect that comes and goes."""
        return 1 + len(self.scored) - len(self.shapes)

    def wave(self, name: str) -> Waves:
        """Return the columns of a periodic effect."""
        return next(one for one in self.scored if isinstance(one, Waves) and label(one.kind) == name)

    def of_belt(self, policy: Policy) -> tuple[WaveColumns, ...]:
        """Return the waves of the belt's speed at the frequencies that belts wobble at."""
        low, high = policy.slow
        return tuple(
            w
            for one in self.scored
            if isinstance(one, Waves) and one.bench.wobbles(one.kind)
            for w in one.waves
            if low <= w.w / one.kind.parameter("w").unit < high
        )


def screened(bench: Bench, fit: Fit, terms: Sequence[Term], workers: Workers = ALONE) -> Screen:
    """Return every effect that is not in the hypothesis."""
    taken, null = {one.name for one in terms}, Null(fit)
    kinds = [kind for kind in bench.kinds() if label(kind) not in taken and _beside(bench, kind, terms)]
    parts = [part for kind in kinds for part in _parts(bench, kind)]
    done = zip(parts, workers.map(partial(_part, bench, fit, terms, null), parts), strict=True)
    found: list[Candidate] = []
    scored: list[Shapes | Waves] = []
    for kind, made in groupby(done, lambda one: one[0][0]):
        if kind.wave:
            waves = Waves(bench, kind, [one for _, each in made for one in each])
            found.append(_wave(bench, fit, terms, waves, null))
            scored.append(waves)
        else:
            ((_, (one, shapes)),) = made
            scored.append(shapes)
            if one is not None:
                found.append(one)
    count = len(bench.stretches)
    return Screen(tuple(sorted(found, key=lambda one: -one.worth(count))), tuple(scored))


def _parts(bench: Bench, kind: EffectKind) -> list[tuple[EffectKind, Floats]]:
    """What of an effect's screening is done at once: all of it, or some of the frequencies of a wave."""
    every = coarse(bench, kind) if kind.wave else np.zeros(0)
    return [(kind, every[i : i + AT_ONCE]) for i in range(0, max(len(every), 1), AT_ONCE)]


def _part(bench: Bench, fit: Fit, terms: Sequence[Term], null: Null, part: tuple[EffectKind, Floats]) -> Any:
    """The columns of some frequencies; of another effect its candidate and its shapes."""
    kind, frequencies = part
    if kind.wave:
        return waves_at(bench, fit, terms, kind, frequencies.tolist())
    return _shape(bench, fit, terms, kind, null)


def _beside(bench: Bench, kind: EffectKind, terms: Sequence[Term]) -> bool:
    """Whether an effect acts beside others, and can be simulated beside them: some cannot beside a formula."""
    kinds = [kind, *(one.kind for one in terms)]
    names = [one.name for one in kinds]
    if any(one.behaves.idle and one.behaves.idle(bench.model.friction, names) for one in kinds):
        return False
    if (kind.wave and not lasts(bench, kind)) or not bench.has_room(kind, terms):
        return False
    formula = any(isinstance(one, RivalKind) and one.physics == "dynamics" for one in kinds)
    return not formula or all(isinstance(one, RivalKind) or beside_formula(one) for one in kinds)


def columns(bench: Bench, fit: Fit, terms: Sequence[Term], one: Term, names: Sequence[str]) -> Columns:
    """Return the derivatives of the readings by numbers of a further effect, at the fit."""
    windows = bench.windows((*terms, one))
    own = of_term(one, bench.policy)
    at = np.concatenate([fit.at, [n.start for n in own]])
    first = len(fit.at)
    wanted = [first + i for i, n in enumerate(own) if n.name in names]
    # the columns of a size that is fitted by its logarithm are those of the size itself
    plain = {first + i: n.slope(n.start) for i, n in enumerate(own)}
    scale = np.array([plain[j] for j in wanted])
    return [None if x is None else x / scale for x in windows.columns(at, fit.own, wanted)]


def _shape(
    bench: Bench, fit: Fit, terms: Sequence[Term], kind: EffectKind, null: Null
) -> tuple[Candidate | None, Shapes]:
    """An effect that does not come and go: best of a grid over what no score reaches."""
    if kind.anywhere.bristle is not None:
        return _other_contact(bench, fit, terms, kind, null)
    best: tuple[float, Floats, dict[str, float], tuple[str, ...], Columns] | None = None
    sets, count = [], 1
    for of, numbers, sizes in _places(bench, kind):
        names = tuple(f"{label(kind)}.{n}" for n in sizes)
        made = columns(bench, fit, terms, term(of, numbers), names)
        if all(one is None for one in made):  # no window moves like that
            continue
        sets.append(made)
        # what is 0 by declaration and stays 0 is no number
        count = sum(i.name in sizes or numbers[i.name] != 0 for i in kind.parameters)
        gain, size = null.scored(null.projected(made))
        if not _impossible(of, sizes, size) and (best is None or gain > best[0]):
            best = gain, size, numbers, sizes, made
    shapes = Shapes(count, tuple(sets))
    if best is None:
        return None, shapes
    gain, size, numbers, sizes, made = best
    step = np.zeros(len(fit.at))
    if gain > count * math.log(len(bench.stretches)):
        found = score(fit, made, bench.policy)
        gain, size, step = found.gain, found.size, found.step
        if _impossible(of, sizes, size):
            return None, shapes
    numbers = dict(numbers)
    for n, x in zip(sizes, size, strict=True):
        numbers[n] = _bounded(of, n, float(x))
    return Candidate(term(kind, numbers), gain, count, step), shapes


def _other_contact(
    bench: Bench, fit: Fit, terms: Sequence[Term], kind: EffectKind, null: Null
) -> tuple[Candidate | None, Shapes]:
    """
    Score a contact of another kind, which is nothing at no size: its columns are what it changes as it is.

    One that promises nothing stays a candidate: where a null is no model of the windows a score says little of it.
    """
    best: tuple[float, Mapping[str, float]] | None = None
    count, sets = len(kind.parameters), list[Columns]()
    for numbers in kind.starts:
        made = changes(bench, fit, terms, term(kind, numbers))
        if all(one is None for one in made):
            continue
        sets.append(made)
        gain, size = null.scored(null.projected(made))
        gain = gain if size[0] > 0 else 0.0
        if best is None or gain > best[0]:
            best = gain, numbers
    shapes = Shapes(count, tuple(sets))
    if best is None:
        return None, shapes
    gain, numbers = best
    return Candidate(term(kind, numbers), gain, count, np.zeros(len(fit.at))), shapes


def changes(bench: Bench, fit: Fit, terms: Sequence[Term], one: Term) -> Columns:
    """Return what a further effect changes of the readings, over the noise, all other numbers where they are."""
    windows = bench.windows((*terms, one))
    at = np.concatenate([fit.at, [n.start for n in of_term(one, bench.policy)]])
    blocks = windows.blocks(at, own_in(fit.own, fit.windows, windows), shared=(), local=False)
    return [
        None if was is None or now is None else (was[:, :, -1] - now[:, :, -1])[:, :, None]
        for was, now in zip(fit.blocks, blocks, strict=True)
    ]


def _places(bench: Bench, kind: EffectKind) -> Iterator[tuple[EffectKind, dict[str, float], tuple[str, ...]]]:
    """Where columns are taken: the effect, its numbers, and the names of those that they are of."""
    if isinstance(kind, RivalKind):
        yield from kind.tries(bench.policy.grid)
        return
    for numbers, sizes in _starts(bench, kind):
        yield kind, numbers, sizes


def _impossible(kind: EffectKind, sizes: Sequence[str], found: Floats) -> bool:
    """Whether the score asks for a size that the effect cannot have."""
    infos = [(kind.parameter(n), x) for n, x in zip(sizes, found, strict=True)]
    return any(one.least_found >= 0 > x or one.bounds[1] <= 0 < x for one, x in infos)


def _bounded(kind: EffectKind, name: str, size: float) -> float:
    info = kind.parameter(name)
    low, high = info.sought if info.sought is not None and info.spread is None else info.bounds
    return min(max(size, low), high)


def _starts(bench: Bench, kind: EffectKind) -> Iterator[tuple[dict[str, float], tuple[str, ...]]]:
    """Where an effect's columns are taken, and the numbers that they are of: its sizes."""
    sizes = tuple(i.name for i in sizes_of(kind))
    if sizes and all(i.spread is not None or i.optional for i in kind.parameters):
        yield dict.fromkeys((i.name for i in kind.parameters), 0.0), sizes
        return
    shapes = [i for i in kind.parameters if i.name not in sizes and not i.optional]
    if not sizes and len(shapes) == 1:
        small = bench.policy.singular * shapes[0].unit
        low, high = shapes[0].sought or (small, small)
        yield {**_optional(kind), shapes[0].name: min(max(small, low), high)}, (shapes[0].name,)
        return
    size = sizes[0] if sizes else shapes[0].name
    grid = [i for i in shapes if i.name != size]
    info, unit = kind.parameter(size), grid[0].unit
    nothing = 0.0 if sizes else (info.sought or (1e-6 * info.unit, info.unit))[0] * 1e-2
    for value in _grid(bench, kind, grid[0].sought or (0.01 * unit, 10.0 * unit), grid[0].of_size):
        yield {**_optional(kind), size: nothing, grid[0].name: value}, (size,)


def _optional(kind: EffectKind) -> dict[str, float]:
    return {i.name: 0.0 for i in kind.parameters if i.optional}


def _grid(bench: Bench, kind: EffectKind, sought: tuple[float, float], of_size: bool) -> Floats:
    """Values over what is sought, where the readings can tell."""
    if of_size:
        return bench.size_of(kind) * np.linspace(0.15, 0.9, bench.policy.grid)
    return np.geomspace(2 * sought[0], sought[1] / 2, bench.policy.grid)


def _wave(bench: Bench, fit: Fit, terms: Sequence[Term], waves: Waves, null: Null) -> Candidate:
    """An effect that comes and goes, its phase another in every run: best over how often."""
    kind = waves.kind
    assert kind.wave is not None
    w = waves.best(null)
    (wave,), runs = waves_at(bench, fit, terms, kind, [w]), len(bench.data)
    made = wave.columns
    place = [[2 * s.run, 2 * s.run + 1] for s in bench.stretches]
    found = score(fit, made, bench.policy, place=place, count=2 * runs)
    known = 0.0
    if bench.wobbles(kind):  # a wave as small as belts wobble is no finding
        precision = bench.wobble(fit.population) ** -2
        small = score(fit, made, bench.policy, place=place, count=2 * runs, precision=precision, refit=False)
        known = max(small.gain, 0.0)
    unit = kind.parameter("a").unit
    sine, cosine = found.size.reshape(runs, 2).T
    numbers = {
        "a": min(max(float(np.median(np.hypot(sine, cosine))), LEAST * unit), kind.wave.largest * unit),
        kind.wave.parameter: 2 * math.pi / w if kind.wave.along_belt else w,
        "phi": 0.0,
    }
    phases = tuple(float(x) for x in np.arctan2(cosine, sine))
    return Candidate(term(kind, numbers, phases), found.gain, waves.count, found.step, known)
