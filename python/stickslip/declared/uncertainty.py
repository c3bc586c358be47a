"""How well declared numbers are known: relative standard uncertainties of a rig's constants and of sensors' gains.

A declared constant is never exact. `[uncertainty]` of a case says how nearly each is known; of what it does not
name a default is taken. A number is declared * (1 + e), e with mean 0 and the standard deviation given here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.quantity import with_unit
from stickslip.declared.rig import LONG, NONDIMENSIONAL, AnyRig, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError, did_you_mean, number

SIGMAS_95 = 1.959963985  # standard deviations either side of a Gaussian's mean that hold 95 % of it
MASS, STIFFNESS, DAMPING, GAIN, EXACT = 0.015, 0.015, 0.15, 0.005, 0.0
# of what no one says anything of; a leg is a length, and so is the unit of length
USUAL: Mapping[str, float] = {
    **dict.fromkeys(("m", "J", "mass", "alpha2"), MASS),
    **dict.fromkeys(("k", "k1", "k2", "k3", "stiffness", "alpha1", "beta3"), STIFFNESS),
    **dict.fromkeys(("c", "c1", "c2", "damping", "eta1", "eta12"), DAMPING),
    "r": EXACT,
}
UNITS_OF_MEASURE = ("length",)  # what is 1: chosen, not measured
BY_TRAIT: Mapping[str, float] = {"inertia": MASS, "stiffness": STIFFNESS, "damping": DAMPING}
GAINS = (
    "x1",
    "y1",
    "spring_force",
    "drive",
)  # channels whose sensor has a gain; of a general rig, its states
# powers of the unit of time, 1/omega, that numbers of (2.1) have: in another unit they are others
ON_TIME: Mapping[str, float] = {"alpha1": -2.0, "alpha2": -2.0, "eta1": -1.0, "eta12": -1.0, "stiffness": 2.0}
STEP = 1e-5  # relative, of central differences: their error is its square


@dataclass(frozen=True)
class Uncertainty:
    """Relative standard uncertainties of a declared rig and of the gains of its sensors.

    Attributes
    ----------
    rig
        The declared rig.
    values
        Its constants by their declared names, as declared.
    constants
        Relative standard uncertainty by declared name; 0 is exact.
    gains
        Relative standard uncertainty of a sensor's gain by channel.
    """

    rig: AnyRig
    values: Mapping[str, float]
    constants: Mapping[str, float]
    gains: Mapping[str, float]

    @classmethod
    def usual(
        cls, rig: AnyRig, table: Mapping[str, object] | None = None, channels: Iterable[str] = GAINS
    ) -> Self:
        """Return the defaults for a rig.

        Parameters
        ----------
        rig
            The declared rig.
        table
            [rig] as the file has it; None: the rig's own names, those of SI where it has scales.
        channels
            What is recorded: each channel of `GAINS` has a gain. Of a rig of bodies or matrices every sensor has one;
            those that read the same thing are known where `channels` has a `Channel` each.
        """
        known = numbers(rig)
        if isinstance(rig, GeneralRig):
            uncertain = rig.uncertain
            usual = {name: BY_TRAIT[trait] for name, trait in uncertain.items()}
            told: Mapping[str, object] = channels if isinstance(channels, Mapping) else {}
            sensors = [*rig.state_names, *rig.equations.sensed]
            read = [name for name in sensors if name in set(channels)]
            read += [
                name
                for name, one in told.items()
                if name not in sensors and hasattr(one, "reads") and one.reads
            ]
            return cls(rig, {name: known[name] for name in uncertain}, usual, dict.fromkeys(read, GAIN))
        names = _own_names(rig) if table is None else _declared_names(rig, table)
        values = {name: _value(table, name, known[name]) for name in names}
        constants = {name: USUAL[name] for name in names}
        return cls(rig, values, constants, {name: GAIN for name in GAINS if name in set(channels)})

    def with_table(self, table: Mapping[str, object]) -> Self:
        """Return it with what [uncertainty] says: numbers, or text like "0.5 %".

        Raises
        ------
        InputError
            An unknown key (with the nearest known one), or what is no relative uncertainty from 0 to 1.
        """
        constants, gains = dict(self.constants), dict(self.gains)
        if isinstance(self.rig, GeneralRig):
            table = _flat(table)
        for name, given in table.items():
            if name in UNITS_OF_MEASURE:
                raise InputError("a unit of measure, which is exact; leave it out", key=name)
            if name not in constants and name not in gains:
                hint = did_you_mean(name, [*constants, *gains])
                raise InputError(f"neither a number of [rig] nor a recorded gain; {hint}", key=name)
            (constants if name in constants else gains)[name] = relative(name, given)
        return replace(self, constants=constants, gains=gains)

    def of(self, rig: AnyRig) -> Self:
        """Return the same for another rig of the kind: one whose run had another spring, say."""
        if rig == self.rig:
            return self
        return replace(self, rig=rig, values={name: numbers(rig)[name] for name in self.values})

    @property
    def names(self) -> tuple[str, ...]:
        """What `relative` and `covariance` know: declared constants, numbers of the model, scales, gains."""
        return (*self._slopes, *self.gains)

    def relative(self, name: str) -> float:
        """Relative standard uncertainty of a declared constant, a number of the model, or a gain.

        Raises
        ------
        InputError
            No such number.
        """
        return math.sqrt(float(self.covariance([name])[0, 0]))

    def covariance(self, names: Sequence[str] = NONDIMENSIONAL) -> NDArray[np.float64]:
        """Covariance of relative errors, (n, n), to first order.

        Constants and gains are independent. Numbers of (2.1) made from SI constants are not, as k2 and m are in
        several of them; `omega`, the unit of time, is one more such number: with another mass or spring every
        record is read on another scale of time.

        Parameters
        ----------
        names
            Declared constants, numbers of the model ("alpha1", "omega", "mass", ...) or channels with a gain.

        Raises
        ------
        InputError
            No such number.
        """
        rows = np.array([self._row(name) for name in names]).reshape(len(names), -1)
        own = np.array([*self.constants.values(), *self.gains.values()])
        return np.asarray((rows * own**2) @ rows.T, dtype=np.float64)

    def on_time(
        self, names: Sequence[str], freed: str | None = None, wide: float = 0.0
    ) -> NDArray[np.float64]:
        """Covariance of relative errors of numbers that are counted in the declared unit of time, (n, n).

        Of a rig in SI the unit of time is in doubt as its mass and its springs are. A fit that counts time in the
        declared one has a mass alpha1, an inertia alpha2 and dampings in that unit; what the block's springs,
        alpha1 where it is right, are beside the mass is "stiffness".

        Parameters
        ----------
        names
            As for `covariance`, and "stiffness".
        freed, wide
            A constant or a gain that is not as declared, and the variance of its relative error beside its own.

        Raises
        ------
        InputError
            No such number.
        """
        rows = np.array([self._row_on_time(name) for name in names]).reshape(len(names), -1)
        own = np.array([*self.constants.values(), *self.gains.values()]) ** 2
        whole = (rows * own) @ rows.T
        if freed is not None:
            free = self._row(freed) * own
            along = rows @ free / float(self._row(freed) @ free)
            whole = whole + wide * np.outer(along, along)
        return np.asarray(whole, dtype=np.float64)

    def _row_on_time(self, name: str) -> NDArray[np.float64]:
        """`_row` of a number counted in the declared unit of time."""
        if not isinstance(self.rig, Rig) or name not in ON_TIME:
            return self._row(name)
        along = ON_TIME[name] * self._row("omega")
        return along if name == "stiffness" else self._row(name) + along

    def _row(self, name: str) -> NDArray[np.float64]:
        """Relative change of a number for a relative change of each constant and each gain."""
        keys = [*self.constants, *(f"gain of {channel}" for channel in self.gains)]
        if name in self._slopes:
            return np.array([self._slopes[name].get(key, 0.0) for key in keys])
        if name in self.gains:
            return np.array([float(key == f"gain of {name}") for key in keys])
        raise InputError(f"no number of this rig; {did_you_mean(name, self.names)}", key=name)

    @cached_property
    def _slopes(self) -> dict[str, dict[str, float]]:
        """d log(number) / d log(constant): by the number, by the constant."""
        out: dict[str, dict[str, float]] = {name: {name: 1.0} for name in self.constants}
        if not isinstance(self.rig, Rig):
            return out | {LONG[name]: {name: 1.0} for name in self.constants if name in LONG}
        if "m" not in self.constants:
            return out | {"omega": {}}  # a unit of measure, as nothing is made from a mass
        for name in (*NONDIMENSIONAL, "omega"):
            out[name] = {constant: self._slope(name, constant) for constant in self.constants}
        return out

    def _slope(self, name: str, constant: str) -> float:
        """One of the slopes, by `Rig.from_si` itself: the formulas of (2.1) stand there and nowhere else."""
        assert isinstance(self.rig, Rig)
        si = self.rig.to_si()
        sides = [
            Rig.from_si(**{**si, constant: si[constant] * (1 + e)})  # type: ignore[arg-type]
            for e in (STEP, -STEP)
        ]
        up, down = (numbers(side)[name] for side in sides)
        return 0.0 if up == down else (up - down) / (STEP * (up + down))


def _flat(table: Mapping[str, object]) -> dict[str, object]:
    """Return `bit.inertia = 0.01`, which TOML reads as a table in a table, by its name with a dot."""
    out: dict[str, object] = {}
    for name, given in table.items():
        inner = given if isinstance(given, Mapping) else None
        out |= {name: given} if inner is None else {f"{name}.{key}": one for key, one in inner.items()}
    return out


def numbers(rig: AnyRig) -> dict[str, float]:
    """Every number of a rig by every name it may be declared by."""
    if isinstance(rig, GeneralRig):
        return rig.numbers
    if isinstance(rig, Rig):
        out = {name: float(getattr(rig, name)) for name in NONDIMENSIONAL}
        return out if rig.scales is None else out | {"omega": rig.scales.omega} | rig.to_si()
    own = {name: float(getattr(rig, name)) for name in LONG.values() if hasattr(rig, name)}
    return own | {short: own[name] for short, name in LONG.items() if name in own}


def _own_names(rig: AnyRig) -> list[str]:
    if isinstance(rig, Rig):
        return [*NONDIMENSIONAL] if rig.scales is None else [name for name in rig.to_si() if name in USUAL]
    return [name for name in LONG.values() if hasattr(rig, name)]


def _declared_names(rig: AnyRig, table: Mapping[str, object]) -> list[str]:
    """Names by which a file declares a rig, with those of numbers it leaves out."""
    if isinstance(rig, Rig):
        return [name for name in table if name in USUAL]
    short = table.keys() & LONG.keys()
    return [key if short else long for key, long in LONG.items() if hasattr(rig, long)]


def _value(table: Mapping[str, object] | None, name: str, value: float) -> float:
    """Return a number as the file has it: a rig makes SI constants anew, which may cost the last bit."""
    given = None if table is None else table.get(name)
    return float(given) if isinstance(given, (int, float)) else value


def relative(name: str, given: object) -> float:
    """Return the relative standard uncertainty that was written: 0.005, or "0.5 %".

    Raises
    ------
    InputError
        Neither, negative, or above 1.
    """
    size, unit = given, ""
    if isinstance(given, str):
        try:
            size, unit = with_unit(given)
        except ValueError:
            unit = given
        if unit not in ("", "1", "%"):
            words = "not a relative uncertainty; give one like 0.005 or '0.5 %'"
            raise InputError(words, key=name, value=given)
    why = "relative: 0.015 is 1.5 %"
    share = number(name, size, least=0, most=100.0 if unit == "%" else 1.0, why=why)  # type: ignore[arg-type]
    return share / 100 if unit == "%" else share
