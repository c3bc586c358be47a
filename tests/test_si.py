"""SI values against physics: a rig simulated in SI moves as the bare one does, with every number converted."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pint
import pytest

import stickslip as ss
from every_effect import made
from stickslip.declared import dimensions
from stickslip.declared.catalogue import CATALOGUE, CONSTANTS, DRIVEN, KINDS
from stickslip.declared.dimensions import Dimension
from stickslip.declared.effect_terms import At
from stickslip.declared.laws import LAWS
from stickslip.declared.model import idle
from stickslip.declared.rig import Scales
from stickslip.declared.si import OF_EFFECTS, OF_LAWS, SI, curve_dimension, scales_of, si_of
from stickslip.declared.units import Channel
from stickslip.simulated.driven_slider import forecast
from stickslip.simulated.reference import integrate as reference
from test_acts import LAWS as PLAIN
from test_acts import UNEVEN
from test_driven_simulate import model as slider
from test_driven_simulate import numbers_of

MASS, STIFFNESS, LENGTH = 0.037, 168.0, 0.0023
SCALES = Scales(length=LENGTH, omega=(STIFFNESS / MASS) ** 0.5, k2=STIFFNESS, r=1.0)
NAMED = [one for one in vars(dimensions).values() if isinstance(one, Dimension)]
PINT = {"1": "", "N s/m": "N*s/m", "N s^2/m^2": "N*s^2/m^2", "kg m^2": "kg*m^2", "m/(N s)": "m/(N*s)"}
UNITS = {"t": Channel("t", "s"), "x1": Channel("x1", "mm")}


@cache
def registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


@pytest.mark.parametrize("one", NAMED, ids=lambda one: one.unit)
def test_the_unit_is_that_of_the_exponents(one: Dimension) -> None:
    """m^a (1/s)^b (N/m)^c is the unit said: by a library of units, not by us."""
    units = registry()
    said = units.Quantity(1.0, PINT.get(one.unit, one.unit)).to_base_units()
    made_of = units.Quantity(1.0, "m") ** one.a * units.Quantity(1.0, "1/s") ** one.b
    made_of = (made_of * units.Quantity(1.0, "N/m") ** one.c).to_base_units()
    said_plain = said / units.Quantity(1.0, "rad") if one.unit == "rad/s" else said
    assert said_plain.dimensionality == made_of.dimensionality
    assert said_plain.magnitude == pytest.approx(1.0)


def in_si(numbers: dict[str, float], measured: dict[str, Dimension]) -> dict[str, float]:
    return {name: value * measured[name].size(SCALES) for name, value in numbers.items()}


def effect_in_si(one: ss.Effect) -> ss.Effect:
    numbers = in_si(dict(one.parameters), {p.name: p.dimension for p in one.kind.parameters})
    return ss.effect(one.name, **numbers)


def law_in_si(law: ss.FrictionLaw) -> ss.FrictionLaw:
    given = {f.name: getattr(law, f.name) for f in fields(law) if getattr(law, f.name) is not None}
    return type(law)(**in_si(given, dict(OF_LAWS)))


def agree(law: ss.FrictionLaw, *effects: ss.Effect | ss.Tabulated, physical: list[object]) -> None:
    """The rig in SI, and the one whose mass, stiffness and length are 1: the same motion and readings, scaled."""
    plain = ss.Model(ss.BlockOnBelt(mass=1, stiffness=1, damping=0.02), friction=law, effects=effects)
    damping = 0.02 * STIFFNESS / SCALES.omega
    rig = ss.BlockOnBelt(mass=MASS, stiffness=STIFFNESS, damping=damping)
    heavy = ss.Model(rig, friction=law_in_si(law), effects=physical)  # type: ignore[arg-type]
    t, speed = np.linspace(0.0, 20.0, 201), 0.2
    ours = ss.simulate(
        plain, belt_speed=speed, initial=(0.1, 0.1), t_end=20.0, t_eval=t, rtol=1e-11, atol=1e-11
    )
    theirs = ss.simulate(
        heavy,
        belt_speed=speed * SCALES.velocity,
        initial=(0.1 * LENGTH, 0.1 * SCALES.velocity),
        t_end=20.0 * SCALES.time,
        t_eval=t * SCALES.time,
        rtol=1e-11,
        atol=1e-13,
    )
    size = np.array([LENGTH, SCALES.velocity])
    assert len(theirs.transitions.t) == len(ours.transitions.t) > 2
    np.testing.assert_allclose(theirs.state / size, ours.state, atol=1e-6)
    read = [
        reference.readings(
            model,
            reference.simulate(model, belt_speed=v, initial=z, t_end=float(at[-1])),
            at,
            interpolated=True,
        )[:, 0]
        / unit
        for model, v, z, at, unit in (
            (plain, speed, (0.1, 0.1), t[:61], 1.0),
            (heavy, speed * SCALES.velocity, tuple(0.1 * size), t[:61] * SCALES.time, LENGTH),
        )
    ]
    np.testing.assert_allclose(read[1], read[0], atol=1e-5)


@pytest.mark.parametrize("law", UNEVEN.values(), ids=list(UNEVEN))
def test_a_law_in_si_moves_the_block_as_the_bare_one_does(law: ss.FrictionLaw) -> None:
    if isinstance(law, ss.PaperFriction):  # its levels are large beside the spring: it still slips
        law = replace(law, T_s_minus=2.0, A1=0.8, A2=0.6, T_min_minus=0.6, T_s_plus=1.5, T_min_plus=0.4)
    agree(law, physical=[])


ON_THE_BLOCK = [name for name, kind in {**CATALOGUE, **CONSTANTS}.items() if not kind.two_degree]


@pytest.mark.parametrize("name", ON_THE_BLOCK)
def test_an_effect_in_si_moves_the_block_as_the_bare_one_does(name: str) -> None:
    law = next(one for one in (PLAIN["coulomb"], PLAIN["hyperbolic"]) if not idle(one, [name]))
    one = made(name) if name != "belt_load_droop" else ss.effect(name, k=0.02, tau=0.5)
    agree(law, one, physical=[effect_in_si(one)])


@pytest.mark.parametrize("where", ["block", "contact", "x1 channel"])
def test_a_curve_in_si_moves_the_block_as_the_bare_one_does(where: str) -> None:
    knots, values = np.array([-0.6, -0.2, 0.1, 0.4, 1.0]), np.array([0.02, -0.03, 0.05, 0.02, -0.04])
    size = curve_dimension(where).size(SCALES)
    agree(
        PLAIN["coulomb"],
        ss.tabulated(where, "x1", knots, values),
        physical=[ss.tabulated(where, "x1", knots * LENGTH, values * size)],
    )


FORMULAS = {"block": dimensions.FORCE, "angle_body": dimensions.FORCE, "friction": dimensions.NUMBER}


@pytest.mark.parametrize("name", [name for name in CATALOGUE if KINDS[name].two_degree])
def test_what_an_effect_adds_in_si_is_what_it_adds_bare(name: str) -> None:
    """Two degrees of freedom: forces and shares by the effect's own formula, of numbers, places and speeds in SI."""
    kind, generator = KINDS[name], np.random.default_rng(3)
    one = made(name)
    heavy = effect_in_si(one)
    for _ in range(20):
        x1, x2, y1, y2, t = generator.normal(0, 0.3, 5)
        side = {name: float(generator.integers(-1, 2) if name != "normal_force_feedback" else 1)}
        bare = At(t, x1, x2, y1, y2, belt_speed=0.1, static_minus=1.2, sides=side)
        full = At(
            t * SCALES.time, x1 * LENGTH, x2 * SCALES.velocity, y1 * LENGTH, y2 * SCALES.velocity,
            belt_speed=0.1 * SCALES.velocity, static_minus=1.2 * SCALES.force, sides=side,
        )  # fmt: skip
        for place, measures in FORMULAS.items():
            formula = getattr(kind.adds, place)
            if formula is not None:
                ours, theirs = formula(one.parameters, bare), formula(heavy.parameters, full)
                assert theirs == pytest.approx(ours * measures.size(SCALES), rel=1e-9, abs=1e-12)


def bare(numbers: dict[str, float], measured: dict[str, Dimension]) -> dict[str, float]:
    return {name: value / measured[name].size(SCALES) for name, value in numbers.items()}


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", DRIVEN)
def test_an_effect_of_a_driven_slider_in_si_moves_it_as_the_bare_one_does(name: str) -> None:
    dt = 1e-3
    numbers = {**numbers_of(name), **({"delay": 0.0095} if name == "drive_delay" else {})}  # not at a sample
    effect = ss.effect(name, **numbers)
    heavy = slider(effect)
    one = ss.effect(
        name, **bare(dict(effect.parameters), {p.name: p.dimension for p in effect.kind.parameters})
    )
    rig = {n: getattr(heavy.rig, n) for n in ("mass", "damping")}
    law = {f.name: getattr(heavy.friction, f.name) for f in fields(heavy.friction)}
    plain = ss.Model(
        ss.DrivenSlider(**bare(rig, dict(ss.DrivenSlider.dimensions))),
        friction=ss.CoulombFriction(**bare(law, dict(OF_LAWS))),
        effects=[one],
    )
    t = np.arange(301) * dt
    drive, start, v = 25 * np.sin(30 * t), np.array([0]), np.array([0.05])
    theirs = forecast(heavy, t, drive, start, np.zeros(1), v, 300)
    ours = forecast(
        plain, t / SCALES.time, drive / SCALES.force, start, np.zeros(1), v / SCALES.velocity, 300
    )
    assert np.ptp(ours) > 0
    np.testing.assert_allclose(ours * LENGTH, theirs, atol=1e-9 * np.ptp(theirs))


def test_every_number_has_its_dimension() -> None:
    for law in LAWS.values():
        for one in fields(law):
            # a name that two laws have measures the same in both
            assert (
                OF_LAWS[one.name]
                == law.dimensions[
                    one.name.removesuffix("_plus") if one.name not in law.dimensions else one.name
                ]
            )
    for kind in {**CATALOGUE, **CONSTANTS, **DRIVEN}.values():
        assert all(f"{kind.name}.{p.name}" in OF_EFFECTS for p in kind.parameters)
    for rig in (ss.Rig, ss.BlockOnBelt, ss.DrivenSlider):
        assert {f.name for f in fields(rig)} - {"coupling", "scales"} <= set(rig.dimensions)


def test_a_model_without_units_has_no_si_values() -> None:
    bare = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    for rig in (bare, ss.BlockOnBelt(mass=1, stiffness=1), ss.DrivenSlider(mass=1)):
        assert scales_of(rig) is None
        assert si_of("static", rig, {"t": Channel("t"), "x1": Channel("x1")}) is None
    for rig in (ss.BlockOnBelt(mass=1, stiffness=1), ss.DrivenSlider(mass=1)):
        assert si_of("static", rig, UNITS) == SI(1.0, "N")
        assert si_of("static_aging.tau", rig, UNITS) == SI(1.0, "s")
        assert si_of("rig_mass.e", rig, UNITS) is None


def test_a_curve_of_friction_or_of_the_belts_speed_is_a_share() -> None:
    """A curve of the belt's speed was multiplied by the unit of force."""
    assert curve_dimension("contact") == curve_dimension("belt") == dimensions.NUMBER
    assert curve_dimension("block") == dimensions.FORCE
    assert curve_dimension("x1 channel") == dimensions.LENGTH
