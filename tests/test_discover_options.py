"""What `discover` is given acts on every kind of rig, or is refused before anything is searched."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import driven_truth as truth
import stickslip as ss
from slider_cases import case_of, rig_of


@pytest.fixture(params=["block_on_belt", "driven_slider"])
def case(request: pytest.FixtureRequest, tmp_path: Path) -> ss.Case:
    if request.param == "block_on_belt":
        return case_of(rig_of(0.02), tmp_path)
    return ss.load_case(truth.write_case(tmp_path))


def test_threads_are_a_number_of_cores_for_every_rig(case: ss.Case) -> None:
    with pytest.raises(ss.InputError, match="threads = 0: must be at least 1"):
        ss.discover(case, threads=0)


@pytest.mark.parametrize("at", [0, 1])
def test_a_run_of_a_driven_slider_with_a_mass_of_its_own_is_refused(tmp_path: Path, at: int) -> None:
    """It was fitted with the mass of the case, and its floor drawn with its own."""
    case = ss.load_case(truth.write_case(tmp_path))
    runs = list(case.runs)
    runs[at] = replace(runs[at], rig=ss.DrivenSlider(mass=2 * truth.MASS))
    with pytest.raises(ss.InputError, match="has another rig than the case"):
        ss.discover(replace(case, runs=tuple(runs)))
