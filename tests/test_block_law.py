"""A law that falls with the speed of slip is said where it is likelier than Coulomb's, and much is left."""

from dataclasses import dataclass, replace
from pathlib import Path

import pytest

import stickslip as ss
from slider_cases import LAW, case_of, rig_of
from stickslip.discovery.laboratory.block_law import law_to_declare

FALLING = ss.HyperbolicFriction(scale=2.4, decay=8.0, constant=3.6)


@dataclass
class Left:
    """What of a search's report is asked."""

    chi2: float


@dataclass
class Told:
    residual_after: Left


@pytest.mark.sampled(1)
@pytest.mark.parametrize("declared", ["none", 'kind = "coulomb"\nstatic = 6.0\nkinetic = 4.2'])
def test_a_likelier_law_is_said_where_much_is_left(tmp_path: Path, declared: str) -> None:
    case = case_of(rig_of(0.01), tmp_path, friction=declared, law=FALLING, length=2.5, step=2e-3)
    assert law_to_declare(case, Told(Left(1.1)), lambda _: None) == ()  # type: ignore[arg-type]
    (said,) = law_to_declare(case, Told(Left(30.0)), lambda _: None)  # type: ignore[arg-type]
    assert "declare it (kind = 'hyperbolic'" in said
    right = replace(case, friction=FALLING, undeclared=())
    assert law_to_declare(right, Told(Left(30.0)), lambda _: None) == ()  # type: ignore[arg-type]


def test_nothing_is_said_where_no_law_is_likelier(tmp_path: Path) -> None:
    case = case_of(rig_of(0.01), tmp_path, friction="none", law=LAW, length=2.5, step=2e-3)
    assert law_to_declare(case, Told(Left(30.0)), lambda _: None) == ()  # type: ignore[arg-type]
