"""The law of a block that nobody declared is chosen before the search, as `identify` chooses it."""

from dataclasses import dataclass, replace
from pathlib import Path

import pytest

import stickslip as ss
from slider_cases import LAW, case_of, rig_of
from stickslip.discovery.laboratory.block_law import law_to_declare, with_law

FALLING = ss.HyperbolicFriction(scale=2.4, decay=8.0, constant=3.6)


@dataclass
class Left:
    """What of a search's report is asked."""

    chi2: float


@dataclass
class Told:
    residual_after: Left


@pytest.mark.parametrize("truth", [FALLING, LAW])
def test_what_is_not_declared_is_chosen(
    tmp_path: Path, truth: ss.HyperbolicFriction | ss.CoulombFriction
) -> None:
    case = case_of(rig_of(0.01), tmp_path, friction="none", law=truth, length=4.0, step=2e-3)
    told: list[str] = []
    chosen, said = with_law(case, told.append)
    assert told == ["choosing the law, as none is declared"]
    if truth is LAW:
        assert (chosen, said) == (case, ())
        return
    assert isinstance(chosen.declared_law, ss.HyperbolicFriction)
    assert chosen.declared_law.decay == pytest.approx(FALLING.decay, rel=0.2)
    assert "hyperbolic" in said[0]


def test_a_declared_law_is_kept_and_the_likelier_one_is_said(tmp_path: Path) -> None:
    text = 'kind = "coulomb"\nstatic = 6.0\nkinetic = 4.2'
    case = case_of(rig_of(0.01), tmp_path, friction=text, law=FALLING, length=4.0, step=2e-3)
    assert with_law(case, lambda _: None) == (case, ())
    assert law_to_declare(case, Told(Left(1.1)), lambda _: None) == ()  # type: ignore[arg-type]
    (said,) = law_to_declare(case, Told(Left(30.0)), lambda _: None)  # type: ignore[arg-type]
    assert "leave [friction] out, or declare it (kind = 'hyperbolic')" in said
    right = replace(case, friction=FALLING)
    assert law_to_declare(right, Told(Left(30.0)), lambda _: None) == ()  # type: ignore[arg-type]
