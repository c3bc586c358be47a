"""Discovery where friction differs from event to event and a constant is only nearly right."""

from pathlib import Path

import pytest

import stickslip as ss
from scattering import case

SCATTER, OFF = 0.02, 0.008


def test_nothing_is_named_where_only_friction_scatters(tmp_path: Path) -> None:
    found = ss.discover(ss.load_case(case(tmp_path, (), SCATTER, OFF, 1)), threads=1)
    assert found.verdict.value == "no_effect"
    assert found.scatter["kinetic"].value == pytest.approx(SCATTER, rel=0.35)
    one = found.constants["alpha2"]
    assert one.low is not None
    assert one.high is not None
    assert one.low < 8.0 < one.high
    assert any("differs from event to event" in words for words in found.messages)


def test_an_effect_is_named_through_the_scatter(tmp_path: Path) -> None:
    effect = ss.effect("block_viscous_damping", c=1.0)
    found = ss.discover(ss.load_case(case(tmp_path, (effect,), SCATTER, OFF, 2)), threads=1)
    assert [one.name for one in found.effects] == ["block_viscous_damping"]
    number = found.effects[0].parameters["c"]
    assert number.low is not None
    assert number.high is not None
    assert number.low < 1.0 < number.high
    assert found.scatter["kinetic"].value == pytest.approx(SCATTER, rel=0.35)
    assert found.error.after < found.error.before


def test_where_every_event_repeats_scatter_is_none(tmp_path: Path) -> None:
    found = ss.discover(ss.load_case(case(tmp_path, (), 0.0, 0.0, 3)), threads=1)
    assert found.verdict.value == "no_effect"
    assert found.scatter == {}
    assert found.residual_after.clean
