"""Which windows of a rig of bodies hold one event each is asked again beside what was found."""

from __future__ import annotations

import sys
from pathlib import Path

import stickslip as ss
from stickslip.declared.model import Model
from stickslip.discovery.general_rig.bench import bench_of, of_single_events
from stickslip.discovery.general_rig.loop import beside
from stickslip.discovery.laboratory.hypothesis import label, term
from stickslip.discovery.laboratory.trials import Trial
from stickslip.likelihoods.fit import begun, fitted, null

sys.path.insert(0, str(Path(__file__).parent.parent / "bench" / "discovery"))
from general_draw import PLANS, write_case

sys.path.pop(0)
PLACE = "spring_cubic_k1@link_1"


def test_windows_in_which_an_effect_does_much_are_fitted_once_it_is_known(tmp_path: Path) -> None:
    """The declared model left out 7 of 84, and the cubic spring was 10 % off, five standard errors."""
    truth = write_case(tmp_path / "drill", PLANS["drill"](), 54001, effect=True)
    case = ss.load_case(tmp_path / "drill")
    declared = case.model()
    every = bench_of(Model(declared.rig, friction=declared.friction), case.train, case.uncertainty)
    few = of_single_events(every, null(every.windows(), every.policy))
    assert len(few.stretches) < len(every.stretches)
    size = truth["effects"][0]["parameters"]["k"]
    kinds = {label(one): one for one in every.kinds()}
    one = term(kinds[PLACE], {"k": size})
    found = Trial((one,), fitted(begun(few.windows((one,))), every.policy))
    again = beside(every, found)
    assert [*map(id, again.stretches)] != [*map(id, few.stretches)]
    fit = fitted(begun(again.windows((one,))), every.policy)
    i = [number.name for number in fit.windows.numbers].index(f"{PLACE}.k")
    assert fit.solution is not None
    assert abs(fit.at[i] - size) < 2.5 * fit.solution.covariance[i, i] ** 0.5
