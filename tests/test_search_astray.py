"""A search on a rig of bodies whose best hypothesis is no model of the runs says so, and reports the model before."""

from pathlib import Path
from typing import Any

import pytest

import stickslip as ss
from bodies_cases import CASES, recorded
from bodies_files import written
from stickslip.discovery.general_rig import loop
from stickslip.discovery.general_rig.bench import GeneralBench
from stickslip.discovery.laboratory.hypothesis import label, term
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.result import Verdict
from stickslip.errors import StickslipError
from stickslip.likelihoods.fit import null


def strayed(bench: GeneralBench, *_: Any, **__: Any) -> Searched:
    """A search that ends with a force on the pin."""
    base = Trial((), null(bench.windows(), bench.policy))
    (kind,) = [one for one in bench.kinds() if label(one) == "harmonic_forcing@across"]
    return Searched(base, Trial((term(kind, {"a": 0.1, "w": 60.0, "phi": 0.0}),), base.fit))


@pytest.mark.parametrize("whole", [False, True])
def test_four_minutes_of_search_do_not_end_in_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: bool
) -> None:
    runs = [(role, *recorded(CASES["pin"](), 50 + seed, level=0.02, static=0.02, lasts=4.0))
            for seed, role in enumerate(("train", "validate"))]  # fmt: skip
    written(tmp_path, runs)
    monkeypatch.setattr(loop, "search", strayed)
    monkeypatch.setattr(loop, "_other_windows", lambda *_: False)
    asked: list[object] = []

    def lost(fit: object) -> bool:
        asked.append(fit)
        return whole or len(asked) > 1  # first it is asked of the model before

    monkeypatch.setattr(loop, "lost", lost)
    if whole:
        with pytest.raises(StickslipError, match="do not move the rig like the readings"):
            loop.discover(ss.load_case(tmp_path), lambda _: None, 0)
        return
    found = loop.discover(ss.load_case(tmp_path), lambda _: None, 0)
    assert found.verdict is Verdict.no_effect
    assert found.effects == ()
    assert found.messages[0] == loop.ASTRAY
