"""An effect is one object: every fact that somebody asks for is there, for every file of `declared/effects/`."""

from __future__ import annotations

from dataclasses import fields
from importlib import import_module
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from stickslip import _core
from stickslip.declared import effects, friction
from stickslip.declared.catalogue import CATALOGUE, CONSTANTS, DRIVEN, KINDS
from stickslip.declared.dimensions import Dimension
from stickslip.declared.effect import TabulatedPlace, TabulatedVariable
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.effect_terms import Adds
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.law_numbers import measure_of
from stickslip.declared.laws import LAWS
from stickslip.declared.si import dimension

FILES = sorted(path.stem for path in Path(effects.__path__[0]).glob("*.py") if path.stem != "__init__")


def test_the_catalogue_is_the_folder() -> None:
    assert sorted(KINDS) == FILES


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_named_after_its_effect_which_has_a_place_on_some_rig(name: str) -> None:
    kind = import_module(f"{effects.__name__}.{name}").EFFECT
    assert kind.name == name
    assert kind.on_belt is not None or kind.on_slider is not None


def test_no_two_effects_have_one_rank() -> None:
    on_belt = [kind.on_belt for kind in KINDS.values() if kind.on_belt is not None]
    on_slider = [kind.on_slider for kind in KINDS.values() if kind.on_slider is not None]
    assert len(set(on_belt)) == len(on_belt) == len(CATALOGUE) + len(CONSTANTS)
    assert len(set(on_slider)) == len(on_slider) == len(DRIVEN)


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_an_effect_has_words_and_units(kind: EffectKind) -> None:
    assert kind.words
    assert kind.words[0].islower()
    assert all(isinstance(info.dimension, Dimension) and info.meaning for info in kind.parameters)


@pytest.mark.parametrize("kind", CATALOGUE.values(), ids=lambda kind: kind.name)
def test_discover_knows_how_to_seek_every_number(kind: EffectKind) -> None:
    for info in kind.parameters:
        if not info.per_run:
            assert (info.spread is None) != (info.sought is None), info.name
    for start in kind.starts:
        for key in start:
            low, high = kind.parameter(key).bounds
            assert low <= start[key] <= high
    reached = kind.starts or kind.wave
    assert reached or all(info.spread is not None for info in kind.parameters)


@pytest.mark.parametrize("kind", [*CATALOGUE.values(), *CONSTANTS.values()], ids=lambda kind: kind.name)
def test_the_core_has_the_states_of_every_effect_and_the_numbers_of_those_that_move(kind: EffectKind) -> None:
    assert set(kind.hidden) <= set(_core.STATES[4:])
    if kind.physics == "dynamics" and kind.corrects is None:
        assert kind.name in _core.EFFECTS
        assert {f"{kind.name}.{info.name}" for info in kind.parameters} <= set(_core.PARAMETERS)


# their equations are not sums: they change what the contact, the pivot, the belt or the command is
OWN_EQUATIONS = {
    "pivot_dry_friction",
    "friction_memory",
    "contact_compliance",
    "belt_load_droop",
    "drive_lag",
    "drive_delay",
}


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_an_effect_that_moves_the_rig_has_its_formula(kind: EffectKind) -> None:
    has = any(getattr(kind.adds, one.name) is not None for one in fields(Adds))
    moves = kind.physics == "dynamics" and kind.corrects is None
    assert has == (moves and kind.name not in OWN_EQUATIONS)


@pytest.mark.parametrize("kind", CATALOGUE.values(), ids=lambda kind: kind.name)
def test_a_hidden_state_has_a_start_for_fits(kind: EffectKind) -> None:
    starts = kind.behaves.hidden_start is not None
    assert starts == bool(set(kind.hidden) - {"dwell"})  # a rest is known from the mode a window starts in


@pytest.mark.parametrize("kind", CATALOGUE.values(), ids=lambda kind: kind.name)
def test_what_moves_with_time_says_when_it_repeats(kind: EffectKind) -> None:
    assert (kind.behaves.period is not None) == ("t" in kind.depends_on and kind.physics == "dynamics")


def test_a_curve_may_be_where_and_of_what_the_core_has_it() -> None:
    assert [where for where in get_args(TabulatedPlace) if not where.endswith("channel")] == list(
        _core.TABLE_PLACES
    )
    assert get_args(TabulatedVariable) == _core.TABLE_VARIABLES


def test_the_core_s_effects_have_a_file_here() -> None:
    assert {name for name in _core.EFFECTS if name not in CATALOGUE} == {"tabulated", "second_tabulated"}


LAW_FILES = sorted(path.stem for path in Path(friction.__path__[0]).glob("*.py") if path.stem != "__init__")


def test_the_laws_are_the_folder_and_the_core_s() -> None:
    assert sorted(LAWS) == LAW_FILES
    assert set(LAWS) == set(_core.LAWS)
    assert len({law.rank for law in LAWS.values()}) == len(LAWS)


@pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.kind)
def test_every_number_of_a_law_is_lowered_and_has_a_dimension(law: type[FrictionLaw]) -> None:
    numbers = {one.name for one in fields(law)}
    assert numbers == {*law.single, *law.each_way, *(f"{name}_plus" for name in law.each_way)}
    slots = {*law.single, *(f"{name}_{side}" for name in law.each_way for side in ("minus", "plus"))}
    assert {f"{law.kind}.{name}" for name in slots} <= set(_core.PARAMETERS)
    # a number is known by its name alone: laws that share one measure the same by it
    assert all(dimension(name) == measure_of(law.dimensions, name) for name in numbers)


@pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.kind)
@pytest.mark.parametrize("direction", [-1, 1])
def test_the_branch_of_the_reference_is_the_law(law: type[FrictionLaw], direction: int) -> None:
    made = law()
    branch, u = made.branch(direction), np.linspace(1e-3, 0.6, 200)
    held = u > (np.inf if branch.kink is None else branch.kink)
    magnitude = np.where(held, branch.above, branch.below(np.minimum(u, branch.kink or np.inf)))
    np.testing.assert_allclose(magnitude, made.magnitude(direction * u), rtol=1e-12)
    assert branch.static == made.static_limits[direction > 0]
