"""What an effect is made of: one object holds its facts, and whoever needs one asks it.

Every file of `effects/` holds such an object, `EFFECT`; the catalogue is all of them. Forces are in the bracket's
units of (2.1): block terms are divided by alpha1, angle-body terms by alpha2. v is v_w, u = |v|, R the kinetic
magnitude; phases `phi` differ from run to run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import ANGLE, ANGULAR_FREQUENCY, LENGTH, NUMBER, TIME, Dimension
from stickslip.declared.effect_terms import Adds, Behaves
from stickslip.errors import InputError, did_you_mean
from stickslip.objects import one_line

Place = Literal["block", "angle_body", "both", "contact", "belt", "drive", "x1 channel", "y1 channel"]
Physics = Literal["dynamics", "reading"]


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter of an effect.

    Parameters
    ----------
    name, meaning
        As declared, and in words.
    bounds
        What may be declared.
    per_run
        Every run has its own value.
    open_below
        The lower bound itself is excluded.
    optional
        0 when left out.
    dimension
        What it measures.
    spread
        Of a number that acts linearly: width of the weak Gaussian about 0 that a fit holds it by, far beyond what a
        rig shows.
    sought
        Of a positive number: between what bounds a fit seeks it. Beyond, the effect is another one (or none) and its
        motion stiff.
    as_named
        Above 0 the effect is what its name says. Below, it may be declared, but is no finding: a peak that is a trough
        has another cause.
    of_size
        Its values in `EffectKind.starts` are shares of the size of y1.
    unit
        What is 1 in numbers like those of (2.1), in those that its bounds are in.
    """

    name: str
    meaning: str
    bounds: tuple[float, float] = (-math.inf, math.inf)
    per_run: bool = False
    open_below: bool = False
    optional: bool = False
    dimension: Dimension = NUMBER
    spread: float | None = None
    sought: tuple[float, float] | None = None
    of_size: bool = False
    as_named: bool = False
    unit: float = 1.0

    @property
    def given_in(self) -> Dimension:
        """What a unit of it must measure: a phase is an angle."""
        return ANGLE if self.per_run else self.dimension

    @property
    def least_found(self) -> float:
        """The least that a search may find."""
        return max(self.bounds[0], 0.0) if self.as_named else self.bounds[0]

    def allows(self, value: float) -> bool:
        """Whether a number may be declared of it."""
        low, high = self.bounds
        return low < value <= high if self.open_below else low <= value <= high


@dataclass(frozen=True)
class Wave:
    """Which parameter of a periodic effect tells how soon it comes again, and the largest amplitude to start from.

    It is an angular frequency in time, or a wavelength along the belt.
    """

    parameter: str
    along_belt: bool
    largest: float


@dataclass(frozen=True)
class EffectKind:
    """All facts of an effect.

    Parameters
    ----------
    name, where, formula, words
        As declared; the place it acts; what it adds; what it is in plain words.
    parameters, depends_on
        In the order of the core; the variables it adds to the model.
    hidden
        States it brings.
    two_degree
        It needs the angle body.
    both_ways
        While every run slips one way, it is a change of the friction law.
    on_belt, on_slider
        Its rank among the effects of rigs on a belt, and among those of a driven slider; None where it has no place.
    corrects
        The declared constant that it corrects: a number of the rig, or a "reading".
    starts
        Numbers that `discover` starts from, where no linear score reaches them all.
    scored_at
        Numbers at zero strength at which noise alone is asked how large the effect may look; None: not asked.
    wave
        Of a periodic effect.
    adds, behaves
        Its formulas, and what else one may ask of it.
    anywhere
        How it acts on a rig of bodies or matrices, at any place of it.
    by
        At a place of a rig of bodies or matrices: the coordinate that it couples this place to.
    drawn
        Numbers at which the documents draw it: a motion with it can be told by the eye from one without.
    """

    name: str
    where: Place
    formula: str
    words: str
    parameters: tuple[ParameterInfo, ...]
    depends_on: tuple[str, ...]
    hidden: tuple[str, ...] = ()
    two_degree: bool = False
    both_ways: bool = False
    on_belt: int | None = None
    on_slider: int | None = None
    corrects: str | None = None
    starts: tuple[Mapping[str, float], ...] = field(default=(), hash=False)
    scored_at: Mapping[str, float] | None = field(default=None, hash=False)
    wave: Wave | None = None
    adds: Adds = field(default_factory=Adds)
    behaves: Behaves = field(default_factory=Behaves)
    anywhere: Acts = field(kw_only=True)
    drawn: Mapping[str, float] = field(kw_only=True, hash=False)
    by: str = ""

    def __repr__(self) -> str:
        return one_line(f"<{self.name}: {self.words}; {', '.join(self.parameter_names)}>")

    @property
    def physics(self) -> Physics:
        """Say whether the effect acts on the motion or on a sensor's reading alone."""
        return "reading" if self.where.endswith("channel") else "dynamics"

    @property
    def nameless(self) -> bool:
        """Whether it is a curve that no one declared, which the search made by itself."""
        return False

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the catalogue."""
        return tuple(info.name for info in self.parameters)

    def parameter(self, name: str) -> ParameterInfo:
        """Return the named parameter, or raise `InputError` with the nearest one."""
        for info in self.parameters:
            if info.name == name:
                return info
        hint = did_you_mean(name, self.parameter_names)
        raise InputError(f"effect '{self.name}' has no parameter '{name}'; {hint}")


def free(
    name: str, meaning: str, dimension: Dimension, spread: float | None = None, *, as_named: bool = False
) -> ParameterInfo:
    """A number of either sign."""
    return ParameterInfo(name, meaning, dimension=dimension, spread=spread, as_named=as_named)


def positive(
    name: str, meaning: str, dimension: Dimension, sought: tuple[float, float] | None = None, **more: bool
) -> ParameterInfo:
    """A number above 0."""
    bounds = (0.0, math.inf)
    return ParameterInfo(name, meaning, bounds, open_below=True, dimension=dimension, sought=sought, **more)


def not_negative(
    name: str, meaning: str, dimension: Dimension, sought: tuple[float, float] | None = None, **more: bool
) -> ParameterInfo:
    """A number that may be 0."""
    return ParameterInfo(name, meaning, (0.0, math.inf), dimension=dimension, sought=sought, **more)


def amplitude(spread: float | None = None) -> ParameterInfo:
    """A relative amplitude."""
    return ParameterInfo("a", "relative amplitude", (-1.0, 1.0), spread=spread)


def time_constant(sought: tuple[float, float] | None = None) -> ParameterInfo:
    """A time constant tau."""
    return positive("tau", "time constant", TIME, sought)


def frequency() -> ParameterInfo:
    """An angular frequency w."""
    return positive("w", "angular frequency", ANGULAR_FREQUENCY, (0.05, 60.0))


def wavelength() -> ParameterInfo:
    """A wavelength L along the track."""
    return positive("L", "wavelength of the position", LENGTH)


def relative_error() -> ParameterInfo:
    """How far a declared number is off."""
    return ParameterInfo("e", "relative error", (-1.0, math.inf), open_below=True)


PHASE = ParameterInfo("phi", "phase at the start of the run", per_run=True)
