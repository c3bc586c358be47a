"""A block on a belt in numbers like those of (2.1), for which the catalogue's bounds and the policy are made.

Time is counted in 1/omega, omega^2 = k/m; mass and stiffness are 16 as alpha1 is; the spring's largest deflection is
that of Table 1's block, whose static friction is 5.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from stickslip.declared.effect import Effect, FormulaEffect, Tabulated, effect, tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Scales
from stickslip.declared.scaled_formula import in_scales
from stickslip.declared.si import OF_VARIABLES, curve_dimension, dimension
from stickslip.fitted.data import Data
from stickslip.likelihoods.stretches import LATEST, SOONEST
from stickslip.measured.recording import Recording

ALPHA, STATIC = 16.0, 5.0


@dataclass(frozen=True)
class Scaled:
    """
    What is 1 in a block's scaled numbers.

    Parameters
    ----------
    rig : declared
    scales : its units
    """

    rig: BlockOnBelt
    scales: Scales

    def size(self, name: str) -> float:
        """Return the declared unit's number for 1 of a number of a model."""
        known = dimension(name)
        return 1.0 if known is None else known.size(self.scales)

    def block(self) -> BlockOnBelt:
        """Return the declared rig in scaled numbers."""
        damping = self.rig.damping / self.size("damping")
        return BlockOnBelt(mass=ALPHA, stiffness=ALPHA, damping=damping)

    def law(self, law: FrictionLaw, *, back: bool = False) -> FrictionLaw:
        """Return a law in scaled numbers, or `back` in the declared ones."""
        known = {one.name: getattr(law, one.name) for one in fields(law)}
        factor = {name: self.size(name) if back else 1 / self.size(name) for name in known}
        return type(law)(**{name: value * factor[name] for name, value in known.items() if value is not None})

    def effect(self, one: Effect | FormulaEffect, *, back: bool = True) -> Effect | FormulaEffect:
        """Return an effect of scaled numbers in the declared ones, or not `back`: of declared ones in scaled ones.

        A formula's numbers are the declared ones in both.
        """
        if isinstance(one, FormulaEffect):
            assert not back
            return in_scales(one, self.scales)
        sizes = {k: self.size(f"{one.name}.{k}") for k in one.parameters}
        return one.replace(**{k: v * sizes[k] if back else v / sizes[k] for k, v in one.parameters.items()})

    def of_curve(self, where: str, variable: str) -> tuple[float, float]:
        """Return the declared unit's numbers for 1 of what a curve is of, and for 1 of its values."""
        return OF_VARIABLES[variable].size(self.scales), curve_dimension(where).size(self.scales)

    def curve(self, one: Tabulated, gain: float = 0.0) -> Tabulated:
        """Return a curve of scaled numbers in the declared ones; the gain of windows scales what is added to them."""
        along, size = self.of_curve(one.where, one.variable)
        size *= 1 + gain if one.of_reading else 1.0
        knots, values = np.array(one.knots) * along, np.array(one.values) * size
        return tabulated(one.where, one.variable, knots, values)

    def model(
        self, made: Model, values: Mapping[str, float], gain: str, rivals: Sequence[FormulaEffect] = ()
    ) -> Model:
        """
        Return a model of scaled numbers in the declared ones, its constants as relative errors beside the declared.

        Parameters
        ----------
        made : its law and effects, scaled
        values : as fitted, scaled
        gain : name of the sensor's gain among them
        rivals : formulas as they are declared
        """
        own = {one.name: one for one in rivals}
        shares = {"rig_mass": values["mass"] / ALPHA - 1, "rig_stiffness": values["stiffness"] / ALPHA - 1}
        shares["sensor_gain"] = values.get(gain, 0.0)
        effects = [
            own[one.name].replace(**one.parameters)
            if isinstance(one, FormulaEffect)
            else self.curve(one, shares["sensor_gain"])
            if isinstance(one, Tabulated)
            else self.effect(one)
            for one in made.effects
        ]
        effects += [effect(name, e=e) for name, e in shares.items() if e != 0]
        return Model(
            replace(self.rig, damping=values["damping"] * self.size("damping")),
            friction=self.law(made.friction, back=True),
            effects=tuple(effects),
            channels=made.channels,
            noise=made.noise,
            scatter=made.scatter,
        )

    def data(self, run: Data) -> Data:
        """Return a run's times and belt speed in the declared units; its readings stay scaled."""
        length, omega = self.scales.length, self.scales.omega
        return replace(
            run, t=run.t / omega, belt_speed=run.belt_speed * length * omega, half=run.half / omega
        )

    def constants(self, rig: BlockOnBelt) -> dict[str, float]:
        """Return the constants, scaled, that a rig has other than the declared one."""
        names = ("mass", "stiffness", "damping")
        return {n: getattr(rig, n) / self.size(n) for n in names if getattr(rig, n) != getattr(self.rig, n)}

    def run(self, recording: Recording) -> Recording:
        """Return a recording in scaled numbers."""
        length, omega = self.scales.length, self.scales.omega
        return replace(
            recording,
            rig=self.block(),
            t=recording.t * omega,
            x1=recording.x1 / length,
            belt_speed=recording.belt_speed / (length * omega),
            noise={name: size / length for name, size in recording.noise.items()},
        )


def scaled(rig: BlockOnBelt, runs: Sequence[Recording]) -> Scaled:
    """Return the scales of a rig by the deflections that its runs show."""
    tops = [np.nanquantile(run.x1 * np.sign(run.belt_speed), LATEST) for run in runs]
    length = float(max(tops)) * ALPHA / STATIC
    omega = math.sqrt(rig.stiffness / rig.mass)
    return Scaled(rig, Scales(length=length, omega=omega, k2=rig.stiffness / ALPHA, r=length))


def start(declared: FrictionLaw | None, units: Scaled, runs: Sequence[Recording]) -> FrictionLaw:
    """Return the law that a fit starts from: levels as the readings show them, a law of another shape as declared."""
    if declared is not None and not isinstance(declared, CoulombFriction):
        return units.law(declared)
    ends = [np.nanquantile(run.x1 * np.sign(run.belt_speed), [SOONEST, LATEST]) for run in runs]
    low, high = np.mean(ends, axis=0) / units.scales.length * ALPHA
    return CoulombFriction(static=float(high), kinetic=float(np.clip(0.5 * (low + high), 0.05 * high, high)))
