"""The rigs: the two-degree-of-freedom rig of (2.1), the block on a belt, and the driven slider."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, ClassVar, Literal, Self, get_args

from stickslip.arguments import also_called, explained
from stickslip.declared.dimensions import (
    DAMPING,
    INERTIA,
    LENGTH,
    MASS,
    NUMBER,
    STIFFNESS,
    Dimension,
)
from stickslip.declared.quantity import InUnits, sized, with_unit
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError, did_you_mean, number
from stickslip.objects import Displayed, as_call

Coupling = Literal["reciprocal", "as_printed"]
NONDIMENSIONAL = ("alpha1", "alpha2", "beta3", "eta1", "eta12")  # the numbers of (2.1)
LONG = {"m": "mass", "k": "stiffness", "c": "damping"}  # of what a file may call shortly, a rig's own name


@explained
@dataclass(frozen=True)
class Scales(Displayed):
    """What is 1 in (2.1), in SI: every reading and every number of a model is turned with these.

    Parameters
    ----------
    length
        Displacement [m].
    omega
        Inverse of the time unit [1/s], omega^2 = (k1 + k2)/m.
    k2
        Stiffness [N/m].
    r
        Leg of the angle body [m]: y1 is the displacement r * angle of its end.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig.from_si(
    ...     m=42.3, J=0.277, r=0.1256, k1=6243, k2=362.1, k3=1234, c1=2.48, c2=2.94, length=8.9e-3
    ... )
    >>> print(f"1 of time is {rig.scales.time:.4f} s, 1 of force {rig.scales.force:.4f} N")
    1 of time is 0.0800 s, 1 of force 3.2227 N
    """

    __repr__ = as_call

    length: float
    omega: float
    k2: float
    r: float

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, number(field.name, getattr(self, field.name), above=0))

    @property
    def time(self) -> float:
        """Unit of time [s]."""
        return 1 / self.omega

    @property
    def velocity(self) -> float:
        """Unit of velocity [m/s]."""
        return self.length * self.omega

    @property
    def force(self) -> float:
        """Unit of force, T and the static limits included [N]."""
        return self.k2 * self.length


@explained
@dataclass(frozen=True, kw_only=True)
class Rig(Displayed):
    """Block on a belt, coupled to an angle body, nondimensional as in (2.1).

    State (x1, x2, y1, y2): block displacement and velocity, leg displacement and velocity.

    Parameters
    ----------
    alpha1
        1 + k1/k2, at least 1.
    alpha2
        omega^2 J/(r^2 k2), positive.
    beta3
        1 + k3/k2, at least 1.
    eta1
        c1 omega/k2, not negative.
    eta12
        eta1 + c2 omega/k2, at least eta1.
    coupling
        "reciprocal" (s = +1) or "as_printed" (s = -1), the sign of y1 on the block.
    scales
        Units of length, time and force; None for a rig declared nondimensional.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds, or the coupling is unknown.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> measured = ss.Rig.from_si(
    ...     m=42.3, J=0.277, r=0.1256, k1=6243, k2=362.1, k3=1234, c1=2.48, c2=2.94, length=8.9e-3
    ... )
    >>> print(f"{measured.alpha1:.3f}, {measured.alpha2:.3f}")
    18.241, 7.572
    """

    __repr__ = as_call

    state_names: ClassVar[tuple[str, ...]] = ("x1", "x2", "y1", "y2")
    elsewhere: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("m", "J", "r", "k1", "k2", "k3", "c1", "c2", "length"), "Rig.from_si takes constants in SI"
    )
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        **dict.fromkeys(NONDIMENSIONAL, NUMBER),
        "m": MASS,
        "J": INERTIA,
        "r": LENGTH,
        "length": LENGTH,
        **dict.fromkeys(("k1", "k2", "k3"), STIFFNESS),
        **dict.fromkeys(("c1", "c2"), DAMPING),
    }

    alpha1: float
    alpha2: float
    beta3: float
    eta1: float
    eta12: float
    coupling: Coupling = "reciprocal"
    scales: Scales | None = None

    def __post_init__(self) -> None:
        checked = {
            "alpha1": number("alpha1", self.alpha1, least=1, why="it is 1 + k1/k2"),
            "alpha2": number("alpha2", self.alpha2, above=0, why="it is the angle body's inertia"),
            "beta3": number("beta3", self.beta3, least=1, why="it is 1 + k3/k2"),
            "eta1": number("eta1", self.eta1, least=0, why="negative damping creates energy"),
        }
        why = "eta12 = eta1 + c2 omega/k2 with damping c2 >= 0"
        checked["eta12"] = number("eta12", self.eta12, least=checked["eta1"], why=why)
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        known = get_args(Coupling)
        if self.coupling not in known:
            hint = did_you_mean(str(self.coupling), known)
            raise InputError(f"unknown; {hint}", key="coupling", value=self.coupling)
        if self.scales is not None and not isinstance(self.scales, Scales):
            raise InputError("must be a Scales or None", key="scales", value=self.scales)

    @classmethod
    @explained
    def from_si(
        cls,
        *,
        m: float | str,
        J: float | str,
        r: float | str,
        k1: float | str,
        k2: float | str,
        k3: float | str,
        c1: float | str,
        c2: float | str,
        length: float | str,
        coupling: Coupling = "reciprocal",
    ) -> Self:
        """Make the rig of (2.1) from constants in SI, or with a unit ("1.2 kg"); `scales` remembers the units.

        Parameters
        ----------
        m, J, r
            Mass of the block [kg], moment of inertia of the angle body [kg m^2], its leg [m].
        k1, k2, k3
            Stiffnesses [N/m]; k2, the coupling spring, must be positive.
        c1, c2
            Dampings [N s/m].
        length
            Displacement that is 1 in (2.1) [m].
        coupling
            As for `Rig`.

        Raises
        ------
        InputError
            A number is not finite, or mass, inertia, stiffness or damping has the wrong sign.
        """
        given = {"m": m, "J": J, "r": r, "k1": k1, "k2": k2, "k3": k3, "c1": c1, "c2": c2, "length": length}
        si = {name: sized(value, cls.dimensions[name].unit, name) for name, value in given.items()}
        m, J, r, k2, length = (number(name, si[name], above=0) for name in ("m", "J", "r", "k2", "length"))
        k1, k3 = (number(name, si[name], least=0) for name in ("k1", "k3"))
        why = "negative damping creates energy"
        c1, c2 = (number(name, si[name], least=0, why=why) for name in ("c1", "c2"))
        omega = math.sqrt((k1 + k2) / m)
        if not (r * r * k2 > 0 and math.isfinite(omega * omega * J / (r * r * k2))):
            words = "too small beside J: alpha2 = omega^2 J/(r^2 k2) would be infinite"
            raise InputError(words, key="r", value=r)
        return cls(
            alpha1=1 + k1 / k2,
            alpha2=omega * omega * J / (r * r * k2),
            beta3=1 + k3 / k2,
            eta1=c1 * omega / k2,
            eta12=(c1 + c2) * omega / k2,
            coupling=coupling,
            scales=Scales(length=length, omega=omega, k2=k2, r=r),
        )

    def to_si(self) -> dict[str, float]:
        """Return m, J, r, k1, k2, k3, c1, c2 and length in SI, the keywords of `from_si`.

        Raises
        ------
        InputError
            The rig has no scales.
        """
        if self.scales is None:
            raise InputError("the rig is nondimensional: it has no scales to give SI constants with")
        length, omega, k2, r = self.scales.length, self.scales.omega, self.scales.k2, self.scales.r
        return {
            "m": self.alpha1 * k2 / omega**2,
            "J": self.alpha2 * r * r * k2 / omega**2,
            "r": r,
            "k1": (self.alpha1 - 1) * k2,
            "k2": k2,
            "k3": (self.beta3 - 1) * k2,
            "c1": self.eta1 * k2 / omega,
            "c2": (self.eta12 - self.eta1) * k2 / omega,
            "length": length,
        }


@also_called(LONG)
@explained
@dataclass(frozen=True, kw_only=True)
class BlockOnBelt(InUnits, Displayed):
    """A block on a spring on a belt: mass x1'' = -stiffness x1 - damping x1' - T(v_w).

    State (x1, x2). A belt with positive speed drags the block towards positive x1, so x1 is the spring's
    deflection. There are no scales: numbers in SI give results in SI; the defaults are nondimensional.

    Parameters
    ----------
    mass, stiffness
        Positive. Also called m and k, as in files.
    damping
        Not negative. Also called c.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass="500 g", stiffness="500 N/m")
    >>> model = ss.Model(rig, friction=ss.CoulombFriction(static=2.0, kinetic=1.2))  # N
    >>> run = ss.simulate(model, belt_speed=0.01, t_end=1)  # m/s, s
    >>> print(run.transitions)
        0.004179  slip - -> stick
        0.402086  stick  -> slip -
        0.513773  slip - -> stick
        0.833773  stick  -> slip -
        0.945460  slip - -> stick
    """

    __repr__ = as_call

    state_names: ClassVar[tuple[str, ...]] = ("x1", "x2")
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        **dict.fromkeys(("mass", "m"), MASS),
        **dict.fromkeys(("stiffness", "k"), STIFFNESS),
        **dict.fromkeys(("damping", "c"), DAMPING),
    }

    mass: float = 1.0
    stiffness: float = 1.0
    damping: float = 0.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            mass: float | str = 1.0,
            stiffness: float | str = 1.0,
            damping: float | str = 0.0,
            m: float | str = ...,
            k: float | str = ...,
            c: float | str = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        _to_si(self)
        object.__setattr__(self, "mass", number("mass", self.mass, above=0))
        object.__setattr__(self, "stiffness", number("stiffness", self.stiffness, above=0))
        why = "negative damping creates energy"
        object.__setattr__(self, "damping", number("damping", self.damping, least=0, why=why))


@also_called({"m": "mass", "c": "damping"})
@explained
@dataclass(frozen=True, kw_only=True)
class DrivenSlider(InUnits, Displayed):
    """An inertia with friction and no spring, moved by a known force: mass x2' = drive - damping x2 - T(x2).

    State (x1, x2). There is no belt: the sliding velocity v_w is x2. Numbers in SI, or with a unit, give results in SI.

    Parameters
    ----------
    mass
        Positive. Also called m, as in files.
    damping
        Not negative. Also called c.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.DrivenSlider(mass=95.1, damping="200 N s/m")
    >>> model = ss.Model(rig, friction=ss.CoulombFriction(static=20, kinetic=20))  # N
    >>> run = ss.simulate(model, drive="60*sin(6*t)", t_end=5)
    >>> print(f"{1e3 * run.x1.max():.1f} mm")
    26.1 mm
    """

    __repr__ = as_call

    state_names: ClassVar[tuple[str, ...]] = ("x1", "x2")
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        **dict.fromkeys(("mass", "m"), MASS),
        **dict.fromkeys(("damping", "c"), DAMPING),
    }

    mass: float
    damping: float = 0.0

    if TYPE_CHECKING:

        def __init__(self, *, mass: float | str, damping: float | str = 0.0) -> None: ...

    def __post_init__(self) -> None:
        _to_si(self)
        object.__setattr__(self, "mass", number("mass", self.mass, above=0))
        why = "negative damping creates energy"
        object.__setattr__(self, "damping", number("damping", self.damping, least=0, why=why))


def _to_si(rig: BlockOnBelt | DrivenSlider) -> None:
    """Turn what is given with a unit, and remember that it was."""
    units = dict[str, str]()
    for field in fields(rig):
        given, unit = getattr(rig, field.name), rig.dimensions[field.name].unit
        object.__setattr__(rig, field.name, sized(given, unit, field.name))
        if isinstance(given, str) and with_unit(given)[1]:
            units[field.name] = unit
    object.__setattr__(rig, "_units", units)


AnyRig = Rig | BlockOnBelt | DrivenSlider | GeneralRig


def only_simulated(rig: GeneralRig) -> InputError:
    """Return the error of what cannot yet be done with a rig of bodies or matrices."""
    return InputError(
        f"this works for rigs of kind 'two_degree' and 'block_on_belt', not yet for '{rig.kind}'", key="rig"
    )


def on_belt(rig: AnyRig) -> Rig | BlockOnBelt:
    """Return a named rig that has a belt.

    Raises
    ------
    InputError
        A driven slider has none, and what is asked cannot be asked of a rig of bodies or matrices.
    """
    if isinstance(rig, GeneralRig):
        raise only_simulated(rig)
    if isinstance(rig, DrivenSlider):
        words = "a driven slider has neither belt nor spring; `stickslip identify` fits its law"
        raise InputError(words, key="rig")
    return rig
