"""Discovery on a block whose events all repeat: windows with random effects model it, their variances next to 0."""

from pathlib import Path

import pytest

import stickslip as ss
from scattering import KINETIC, STATIC, block_case
from short_search import naming


@pytest.mark.parametrize(
    ("effect", "number"),
    [
        pytest.param(ss.effect("block_viscous_damping", c=2.0), "c", marks=pytest.mark.study),
        (ss.effect("spring_cubic_k1", k=2.4e6), "k"),
    ],
)
def test_what_acts_where_every_event_repeats_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, effect: ss.Effect, number: str
) -> None:
    """Fewer numbers of each event, by which they were held against each other, had lost it."""
    naming(monkeypatch, 1)
    found = ss.discover(ss.load_case(block_case(tmp_path, (effect,), few=True, seed=5, scatter=0.0)))
    assert [one.name for one in found.effects] == [effect.name]
    own = found.effects[0].parameters[number]
    assert own.low is not None
    assert own.high is not None
    assert own.low < effect.parameters[number] < own.high
    assert found.error.after < 0.5 * found.error.before
    assert found.residual_after.chi2 < 1.1
    assert any("every event of a run is like every other" in one for one in found.messages)


@pytest.mark.study
def test_nothing_is_named_where_nothing_acts_and_every_event_repeats(tmp_path: Path) -> None:
    found = ss.discover(ss.load_case(block_case(tmp_path, few=True, seed=6, scatter=0.0)))
    assert found.effects == ()
    assert found.residual_after.chi2 < 1.1
    for name, true in (("static", STATIC), ("kinetic", KINETIC)):
        one = found.law[name]
        assert one.low is not None
        assert one.high is not None
        assert one.low < true < one.high
