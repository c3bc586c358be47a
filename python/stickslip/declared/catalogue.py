"""The catalogue of effects that the declared model lacks: names, places, formulas, parameters and bounds.

Forces are in the bracket's units of (2.1): block terms are divided by alpha1, angle-body terms by alpha2.
v is v_w, u = |v|, R the kinetic magnitude; phases `phi` differ from run to run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from stickslip.errors import InputError, did_you_mean

Place = Literal["block", "angle_body", "both", "contact", "belt", "drive", "x1 channel", "y1 channel"]
Physics = Literal["dynamics", "reading"]


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter of an effect: its meaning, its bounds, and whether every run has its own value."""

    name: str
    meaning: str
    bounds: tuple[float, float] = (-math.inf, math.inf)
    per_run: bool = False
    open_below: bool = False  # the lower bound itself is excluded
    optional: bool = False  # 0 when left out


@dataclass(frozen=True)
class EffectKind:
    """An entry of the catalogue.

    `where` is the place it acts, `depends_on` the variables it adds, `physics` whether it changes the motion
    or only the reading, `hidden` the extra states it brings, `two_degree` whether it needs the angle body.
    """

    name: str
    where: Place
    formula: str
    parameters: tuple[ParameterInfo, ...]
    depends_on: tuple[str, ...]
    hidden: tuple[str, ...] = ()
    two_degree: bool = False

    @property
    def physics(self) -> Physics:
        """Say whether the effect acts on the motion or on a sensor's reading alone."""
        return "reading" if self.where.endswith("channel") else "dynamics"

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


def _free(name: str, meaning: str) -> ParameterInfo:
    return ParameterInfo(name, meaning)


def _positive(name: str, meaning: str) -> ParameterInfo:
    return ParameterInfo(name, meaning, (0.0, math.inf), open_below=True)


def _not_negative(name: str, meaning: str) -> ParameterInfo:
    return ParameterInfo(name, meaning, (0.0, math.inf))


_A = ParameterInfo("a", "relative amplitude", (-1.0, 1.0))
_PHI = ParameterInfo("phi", "phase at the start of the run", per_run=True)
_TAU = _positive("tau", "time constant")

_KINDS = (
    EffectKind("block_viscous_damping", "block", "-c x2", (_free("c", "damping"),), ("x2",)),
    EffectKind("block_quadratic_damping", "block", "-c x2 |x2|", (_free("c", "damping"),), ("x2",)),
    EffectKind("spring_cubic_k1", "block", "-k x1^3", (_free("k", "cubic stiffness"),), ("x1",)),
    EffectKind(
        "spring_cubic_k2",
        "both",
        "-k (x1+y1)^3 on each",
        (_free("k", "cubic stiffness"),),
        ("x1", "y1"),
        two_degree=True,
    ),
    EffectKind(
        "spring_cubic_k3", "angle_body", "-k y1^3", (_free("k", "cubic stiffness"),), ("y1",), two_degree=True
    ),
    EffectKind(
        "spring_gap_k3",
        "angle_body",
        "-k (y1 -+ d) beyond |y1| > d",
        (_not_negative("k", "stiffness of the stop"), _positive("d", "half width of the gap")),
        ("y1",),
        two_degree=True,
    ),
    EffectKind("constant_load", "block", "+f", (_free("f", "force"),), ()),
    EffectKind(
        "harmonic_forcing",
        "block",
        "+a sin(w t + phi)",
        (_free("a", "force amplitude"), _positive("w", "angular frequency"), _PHI),
        ("t",),
    ),
    EffectKind(
        "pivot_dry_friction",
        "angle_body",
        "-f sgn(y2), sticks at y2 = 0; with a creep speed v_c: -f tanh(y2/v_c)",
        (
            _not_negative("f", "friction force"),
            ParameterInfo(
                "v_c", "creep speed that rounds the sign; 0: sharp", (0.0, math.inf), optional=True
            ),
        ),
        ("y2",),
        two_degree=True,
    ),
    EffectKind(
        "normal_force_feedback",
        "contact",
        "friction times max(0, 1 + (beta2 y1 + eta2 y2)/T_s), T_s that of T_-",
        (_free("beta2", "stiffness feedback"), _free("eta2", "damping feedback")),
        ("y1", "y2"),
        two_degree=True,
    ),
    EffectKind(
        "stribeck_peak",
        "contact",
        "R and the static limits plus dT exp(-(u/v_s)^2)",
        (_free("dT", "height"), _positive("v_s", "width in speed")),
        ("v_w",),
    ),
    EffectKind(
        "static_aging",
        "contact",
        "static limits plus dT (1 - exp(-dwell/tau))",
        (_free("dT", "growth at long rest"), _TAU),
        ("memory",),
        hidden=("dwell",),
    ),
    EffectKind(
        "friction_memory",
        "contact",
        "R at the lagged speed |w|, tau w' = v - w; w = 0 on sticking",
        (_TAU,),
        ("v_w", "memory"),
        hidden=("w",),
    ),
    EffectKind(
        "friction_drift",
        "contact",
        "friction times 1 + r t within each run",
        (_free("r", "relative rate"),),
        ("t",),
    ),
    EffectKind(
        "belt_seam",
        "contact",
        "friction times 1 + a sin(2 pi (v_b t - x1)/L + phi)",
        (_A, _positive("L", "length of the belt"), _PHI),
        ("x1", "t"),
    ),
    EffectKind(
        "contact_compliance",
        "contact",
        "bristle z' = v - k |v| z/R(u), T = k z + c v; no rigid stick",
        (_positive("k", "bristle stiffness"), _not_negative("c", "bristle damping")),
        ("v_w", "memory"),
        hidden=("z",),
    ),
    EffectKind(
        "belt_speed_ripple",
        "belt",
        "belt speed v_b (1 + a sin(w t + phi))",
        (_A, _positive("w", "angular frequency"), _PHI),
        ("t",),
    ),
    EffectKind(
        "belt_load_droop",
        "belt",
        "belt speed v_b + b, tau b' = -k F - b, F the belt's force on the block",
        (_not_negative("k", "droop by force"), _TAU),
        ("memory",),
        hidden=("b",),
    ),
    EffectKind(
        "sensor_lag", "x1 channel", "first-order lag of the reading", (_TAU,), ("x1", "memory"), hidden=("m",)
    ),
    EffectKind(
        "sensor_delay",
        "y1 channel",
        "reading late against x1",
        (_free("delay", "time by which y1 is late"),),
        ("y1", "memory"),
        two_degree=True,
    ),
    EffectKind(
        "sensor_crosstalk",
        "x1 channel",
        "reads x1 + c y1",
        (_free("c", "share of y1"),),
        ("x1", "y1"),
        two_degree=True,
    ),
    EffectKind("sensor_nonlinearity", "x1 channel", "reads x1 + q x1^2", (_free("q", "curvature"),), ("x1",)),
    EffectKind("sensor_drift", "x1 channel", "reads x1 + r t within each run", (_free("r", "rate"),), ("t",)),
)

CATALOGUE: Mapping[str, EffectKind] = {kind.name: kind for kind in _KINDS}

_ERROR = ParameterInfo("e", "relative error", (-1.0, math.inf), open_below=True)

# a block on a belt may have been declared with a wrong number; a spring's force read off its deflection tells of both
_CONSTANTS = (
    EffectKind("rig_mass", "block", "the mass is (1 + e) times the declared one", (_ERROR,), ()),
    EffectKind("rig_stiffness", "block", "the spring is (1 + e) times as stiff as declared", (_ERROR,), ()),
    EffectKind("sensor_gain", "x1 channel", "reads (1 + e) times what it should", (_ERROR,), ("x1",)),
)

CONSTANTS: Mapping[str, EffectKind] = {kind.name: kind for kind in _CONSTANTS}

_L = ParameterInfo("L", "wavelength of the position", (0.0, math.inf), open_below=True)
_RATE = _free("r", "relative rate per unit of time")

POSITION_RIPPLES = ("position_ripple", "position_ripple_2", "position_ripple_3")  # one after the other

# a driven slider has no belt and no spring; what acts on it, SI throughout: T is its friction, F its drive
_DRIVEN = (
    EffectKind(
        "viscous_asymmetry",
        "contact",
        "-c abs(x2)",
        (_free("c", "half the difference of the dampings"),),
        ("x2",),
    ),
    EffectKind(
        "viscous_saturation",
        "contact",
        "T plus dT (1 - exp(-u/v_s)): friction that rises at low speed and levels off",
        (_free("dT", "rise"), _positive("v_s", "speed of the rise")),
        ("v_w",),
    ),
    EffectKind("position_load", "block", "-k x1", (_free("k", "stiffness"),), ("x1",)),
    EffectKind(
        "position_friction",
        "contact",
        "friction times 1 + r x1",
        (_free("r", "relative rate per unit of x1"),),
        ("x1",),
    ),
    EffectKind("load_drift", "block", "+r t", (_free("r", "rate"),), ("t",)),
    *(  # a screw with several ripples has one wavelength each
        EffectKind(name, "block", "+a sin(2 pi x1/L + phi)", (_free("a", "amplitude"), _L, _PHI), ("x1",))
        for name in POSITION_RIPPLES
    ),
    EffectKind(
        "friction_ripple", "contact", "friction times 1 + a sin(2 pi x1/L + phi)", (_A, _L, _PHI), ("x1",)
    ),
    EffectKind("drive_ripple", "drive", "drive times 1 + a sin(2 pi x1/L + phi)", (_A, _L, _PHI), ("x1",)),
    EffectKind("drive_gain_drift", "drive", "drive times 1 + r t", (_RATE,), ("t",)),
    EffectKind(
        "drive_nonlinearity",
        "drive",
        "drive times 1 + q abs(F)",
        (_free("q", "relative rate per unit of force"),),
        ("F",),
    ),
    EffectKind(
        "drive_lag",
        "drive",
        "tau f' = F - f, f the force that acts",
        (_positive("tau", "time constant"),),
        ("F",),
        hidden=("f",),
    ),
    EffectKind(
        "drive_delay", "drive", "the drive acts late", (_free("delay", "delay, negative if early"),), ("F",)
    ),
)
_SHARED = (
    "block_quadratic_damping",
    "stribeck_peak",
    "contact_compliance",
    "friction_drift",
    "harmonic_forcing",
)

DRIVEN: Mapping[str, EffectKind] = {
    **{name: CATALOGUE[name] for name in _SHARED},
    "rig_mass": CONSTANTS["rig_mass"],
    **{kind.name: kind for kind in _DRIVEN},
}
KINDS: Mapping[str, EffectKind] = {**CATALOGUE, **CONSTANTS, **DRIVEN}
