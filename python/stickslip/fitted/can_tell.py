"""What the runs of a case can tell and what they cannot, before a long search: a look at sticks and slips, and algebra.

Friction and an effect are told apart by the forces they need along the recorded motion. At slips and at breakaways the
numbers of the declared law can take up some of an effect's force; what they take up whole no search can find.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.catalogue import KINDS
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.effect_terms import At
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.rig import AnyRig, DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError, Place
from stickslip.fitted.identified import Branch
from stickslip.fitted.identify import measured
from stickslip.fitted.identify_windows import law_parameters, natural_period
from stickslip.measured.case import Case
from stickslip.measured.prepared import Measured
from stickslip.measured.sticks import LEAST_SLIP, Segment

Floats = NDArray[np.float64]

HIDDEN = (
    0.1  # of an effect's force left beside others, below which its number is known ten times worse than alone
)
SEEN = 400  # samples of a run's slips, and as many of its leg, that are looked at
STEP = 1e-3  # of a number, for a derivative


@dataclass(frozen=True)
class Look:
    """A run: its sticks and slips.

    Attributes
    ----------
    name, role, belt_speed
        Of the run; the speed is the model's number.
    sticks, minus, plus
        How many sticks, slips with v_w < 0 and slips with v_w > 0 there are, those at the ends of the record left out.
    samples
        Samples a slip lasts, the median; 0 without slips.
    width, swing
        Samples that the velocity is taken over, and those of half a natural period, which a slip lasts at least.
    size
        Size of a slip over the noise, the median; 0 without slips.
    """

    name: str
    role: str
    belt_speed: float
    sticks: int
    minus: int
    plus: int
    samples: float
    width: int
    swing: float
    size: float


@dataclass(frozen=True)
class Telling:
    """What the runs can and cannot tell.

    Attributes
    ----------
    looks
        Each run.
    told
        What the runs tell, a sentence each.
    lacks
        What they do not tell, and what would.
    hidden
        Of each effect that the law's numbers hide: the share of its force that is left beside them.
    alike
        Pairs of effects, and the share of the one that is left beside the other and the law.
    judged
        The effects that were looked at: those that add a force or a share of friction.
    """

    looks: tuple[Look, ...]
    told: tuple[str, ...]
    lacks: tuple[str, ...]
    hidden: Mapping[str, float]
    alike: Mapping[tuple[str, str], float]
    judged: tuple[str, ...]


def can_tell(case: Case) -> Telling:
    """Look at the runs of a case on a belt.

    Raises
    ------
    InputError
        The rig is none on a belt; a run is too short to tell stick from slip.
    """
    if isinstance(case.rig, DrivenSlider):
        words = (
            "a driven slider has no sticks on a belt to look for; its search is short: run stickslip discover"
        )
        raise InputError(words, place=Place(str(case.path)))
    if isinstance(case.rig, GeneralRig):
        words = f"a rig of kind '{case.rig.kind}' cannot be checked yet; run stickslip identify or discover"
        raise InputError(words, place=Place(str(case.path)))
    looked = [measured(run, run.rig) for run in case.runs]
    looks = tuple(_look(one, run.role, run.rig) for one, run in zip(looked, case.runs, strict=True))
    train = [one for one, look in zip(looked, looks, strict=True) if look.role == "train"]
    law = case.friction if case.declared_law is not None or isinstance(case.rig, Rig) else CoulombFriction()
    hidden, alike, judged = _ties(train, law, two_degree=isinstance(case.rig, Rig))
    told, lacks = _of_branches(looks, law)
    lacks += [*_of_roles(looks), *(words for one in looks for words in _of_run(one))]
    return Telling(looks, tuple(told), tuple(lacks), hidden, alike, judged)


def _look(one: Measured, role: str, rig: AnyRig) -> Look:
    slips = [slip for _, slip, _ in one.track.slips]
    lengths, sizes = [len(slip) for slip in slips], [one.track.size(slip) for slip in slips]
    return Look(
        one.name,
        role,
        one.belt_speed,
        len(one.track.sticks),
        sum(slip.mode < 0 for slip in slips),
        sum(slip.mode > 0 for slip in slips),
        float(np.median(lengths)) if slips else 0.0,
        one.track.width,
        0.5 * natural_period(rig) / float(np.median(np.diff(one.t))),
        float(np.median(sizes)) / float(one.noise[0]) if slips else 0.0,
    )


def _of_branches(looks: Sequence[Look], law: FrictionLaw) -> tuple[list[str], list[str]]:
    """What is told of both directions of slip, and what is not."""
    told, lacks = [], []
    if not any(one.minus + one.plus for one in looks):
        return [], []  # what each run says of it is enough
    branches: tuple[tuple[Branch, str], ...] = (("minus", "v_w < 0"), ("plus", "v_w > 0"))
    for name, which in branches:
        numbers, count = (
            len(law_parameters(law)[name]),
            sum(getattr(one, name) for one in looks if one.role == "train"),
        )
        if not count:
            others = [one.name for one in looks if getattr(one, name)]
            remedy = f"train on {others[0]}, which has some" if others else "run the belt the other way too"
            lacks.append(f"no slip with {which}: nothing is told of friction that way (T_{name}); {remedy}")
        elif count <= numbers:
            slips = "1 slip" if count == 1 else f"{count} slips"
            lacks.append(
                f"{slips} with {which} for {numbers} numbers of T_{name}: too few; record for longer"
            )
        else:
            share = f"{100 / np.sqrt(count):.2g} % of its scatter"
            told.append(
                f"{count} slips with {which}: the mean of what differs from slip to slip is known to {share}"
            )
    return told, lacks


def _of_roles(looks: Sequence[Look]) -> Iterator[str]:
    """What the runs lack together."""
    train = [one for one in looks if one.role == "train"]
    if not train:
        yield "no run has role = 'train': there is nothing to fit"
    if len(train) == len(looks):
        yield "no run has role = 'validate': no error can be told of runs that were never fitted"
    if len({round(abs(one.belt_speed), 12) for one in train}) == 1:
        yield (
            "one belt speed: what repeats along the belt and what repeats in time look alike (belt_seam, "
            "harmonic_forcing), and friction is seen at few speeds; a second one tells them apart"
        )


def _of_run(one: Look) -> Iterator[str]:
    """What a run lacks."""
    if not one.minus + one.plus:
        yield (
            f"{one.name}: no slip between two sticks; does the block slide throughout, is the belt speed or a unit "
            "wrong, or is the run too short?"
        )
        return
    if one.swing < one.width:
        yield (
            f"{one.name}: sampling is coarse: half a natural period, which a slip lasts, has {one.swing:.2g} samples, "
            f"and a velocity needs {one.width}; sample {one.width / one.swing:.1f} times as fast"
        )
    if one.size < LEAST_SLIP:
        yield f"{one.name}: a slip is {one.size:.2g} times the noise, hardly told from it; record it with less"


@dataclass(frozen=True)
class _Place:
    """Where forces are compared: the equation of the block (0) or of the angle body (1), and the state there.

    `v` is v_w, or its sign alone at a breakaway, where the block rests and `rest` is how long it did.
    """

    body: int
    at: At
    v: float
    rest: float | None = None


def _places(one: Measured, *, two_degree: bool) -> list[_Place]:
    """Samples of the slips and the breakaways before them; of the leg at any time."""
    track = one.track
    leg = _leg(one) if two_degree else np.zeros((2, len(track.t)))

    def at(i: int) -> At:
        y1, y2 = leg[:, i]
        return At(track.t[i], track.x[i], track.v[i], float(y1), float(y2), belt_speed=one.belt_speed)

    places = []
    for stick, slip, _ in track.slips:
        rest = float(track.t[stick.stop - 1] - track.t[stick.start])
        places.append(_Place(0, at(slip.start), float(slip.mode), rest))
    for i in _some([i for _, slip, _ in track.slips for i in _inside(slip)]):
        if (v := track.v[i] - one.belt_speed) != 0:
            places.append(_Place(0, at(i), float(v)))
    places += [_Place(1, at(i), 0.0) for i in _some(range(len(track.t)))] if two_degree else []
    return places


def _inside(slip: Segment) -> range:
    """A slip without its ends, where the velocity is blurred."""
    edge = len(slip) // 4
    return range(slip.start + edge, slip.stop - edge)


def _some(samples: Sequence[int]) -> Sequence[int]:
    return [samples[i] for i in np.linspace(0, len(samples) - 1, min(SEEN, len(samples))).astype(int)]


def _leg(one: Measured) -> Floats:
    """y1 and its velocity, smoothed as the block's."""
    from scipy.signal import savgol_filter

    good = np.isfinite(one.readings[:, 1])
    filled = np.interp(one.t, one.t[good], one.readings[good, 1])
    dt, width = float(np.median(np.diff(one.t))), one.track.width
    return np.array([savgol_filter(filled, width, 2, deriv=order, delta=dt) for order in (0, 1)])


def _ties(
    runs: Sequence[Measured], law: FrictionLaw, *, two_degree: bool
) -> tuple[dict[str, float], dict[tuple[str, str], float], tuple[str, ...]]:
    """Effects that the law hides, and those that act alike beside it."""
    places = [place for one in runs for place in _places(one, two_degree=two_degree)]
    if not places:
        return {}, {}, ()
    own = _basis(_law_columns(law, places))
    columns = {
        kind.name: c for kind in _judged(two_degree) if (c := _effect_columns(kind, law, places)).any()
    }
    hidden, left = {}, {}
    for name, column in columns.items():
        share, beside = _beside(column, own)
        if share < HIDDEN:
            hidden[name] = share
        else:
            left[name] = beside
    alike = {}
    names = list(left)
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            share = max(
                _beside(left[one], _basis(left[other]))[0], _beside(left[other], _basis(left[one]))[0]
            )
            if share < HIDDEN:
                alike[one, other] = share
    return hidden, alike, tuple(columns)


def _judged(two_degree: bool) -> list[EffectKind]:
    """Effects on a belt whose force can be written down along a recorded motion, linear in a number."""
    acts = [
        kind
        for kind in KINDS.values()
        if kind.on_belt is not None and kind.wave is None and (two_degree or not kind.two_degree)
    ]
    formulas = ("block", "angle_body", "friction", "peak", "aging")
    linear = [
        kind
        for kind in acts
        if any(getattr(kind.adds, name) is not None for name in formulas) and _linear(kind)
    ]
    # the numbers of a shape are known beforehand in the nondimensional units of (2.1) alone
    return [kind for kind in linear if two_degree or len(_linear(kind)) == len(kind.parameters)]


def _linear(kind: EffectKind) -> tuple[str, ...]:
    """The numbers it is linear in: those whose width a fit knows beforehand."""
    return tuple(one.name for one in kind.parameters if one.spread is not None)


def _basis(columns: Floats) -> Floats:
    """An orthonormal basis of what columns (n, k) span."""
    u, s, _ = np.linalg.svd(
        columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300), full_matrices=False
    )
    kept: Floats = u[:, s > 1e-9 * max(float(s.max(initial=0.0)), 1e-300)]
    return kept


def _beside(columns: Floats, basis: Floats) -> tuple[float, Floats]:
    """The largest share of columns that is left beside a basis, and what is left."""
    left = columns - basis @ (basis.T @ columns)
    sizes = np.linalg.norm(columns, axis=0)
    shares = np.linalg.norm(left, axis=0)[sizes > 0] / sizes[sizes > 0]
    return float(shares.max(initial=0.0)), left


def _law_columns(law: FrictionLaw, places: Sequence[_Place]) -> Floats:
    """What each number of the law changes in the force on the block, (n, numbers)."""
    columns = []
    for one in fields(law):
        value = getattr(law, one.name)
        if value is None:
            continue
        step = STEP * max(abs(value), STEP)
        for moved in (value + step, value - step):
            try:
                other = replace(law, **{one.name: moved})
            except InputError:  # at a bound; the other side of it will do
                continue
            change = (_friction(other, places) - _friction(law, places)) / (moved - value)
            columns.append(change)
            break
    return np.array(columns).T.reshape(len(places), -1)


def _friction(law: FrictionLaw, places: Sequence[_Place]) -> Floats:
    """The force of friction on the block: at its limit at a breakaway, none on the angle body."""
    limits = law.static_limits
    rests = np.array([place.rest is not None for place in places])
    v = np.array([place.v for place in places])
    static = np.where(v < 0, limits[0], limits[1])
    force: Floats = -np.sign(v) * np.where(rests, static, law.magnitude(v))
    return force


def _effect_columns(kind: EffectKind, law: FrictionLaw, places: Sequence[_Place]) -> Floats:
    """What each number that an effect is linear in changes in the forces, (n, numbers)."""
    start = {one.name: 0.0 for one in kind.parameters} | dict(kind.starts[0] if kind.starts else {})
    start |= dict(kind.scored_at or {})
    friction = _friction(law, places)
    columns = []
    for name in _linear(kind):
        weak = {**start, name: 0.0}
        strong = {**start, name: STEP}
        change = [
            _force(kind, strong, law, one, f) - _force(kind, weak, law, one, f)
            for one, f in zip(places, friction, strict=True)
        ]
        columns.append(np.array(change) / STEP)
    return np.array(columns).T.reshape(len(places), -1)


def _force(
    kind: EffectKind, p: Mapping[str, float], law: FrictionLaw, place: _Place, friction: float
) -> float:
    """The force of an effect at a place."""
    adds = kind.adds
    at = replace(place.at, static_minus=law.static_limits[0])
    if adds.sides is not None:
        at = replace(at, sides={kind.name: adds.sides.start(p, at)})
    if place.body:
        return float(adds.angle_body(p, at)) if adds.angle_body is not None else 0.0
    force = float(adds.block(p, at)) if adds.block is not None else 0.0
    if adds.friction is not None:
        force += friction * float(adds.friction(p, at))
    if adds.peak is not None:
        force -= float(np.sign(place.v)) * float(
            adds.peak(p, 0.0 if place.rest is not None else abs(place.v))
        )
    if adds.aging is not None and place.rest is not None:
        force -= float(np.sign(place.v)) * float(adds.aging(p, place.rest))
    return force
