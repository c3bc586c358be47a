"""A law that a case of a block on a belt declares is used, never replaced by one of another kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from slider_cases import LAW, NOISE, STATIC, case_of, rig_of
from studies import few

FALLING = ss.HyperbolicFriction(scale=2.4, decay=8.0, constant=3.6)
DECLARED = {
    "none": (None, "none"),
    "coulomb": (ss.CoulombFriction, 'kind = "coulomb"\nstatic = 6.0\nkinetic = 4.2'),
    "hyperbolic": (ss.HyperbolicFriction, 'kind = "hyperbolic"\nscale = 2.0\ndecay = 6.0\nconstant = 4.0'),
    "hyperbolic that rises": (
        ss.HyperbolicFriction,
        'kind = "hyperbolic"\nscale = 2.0\ndecay = 6.0\nconstant = 4.0\nquadratic = 0.1',
    ),
}


# with the scatter of slips, which takes long, where the kind is chosen by it or the law that acts is of another one
KINDS = {
    "none, coulomb acts": ("none", LAW, True),
    "none, falling acts": ("none", FALLING, True),
    "coulomb": ("coulomb", LAW, False),
    "coulomb, falling acts": ("coulomb", FALLING, True),
    "hyperbolic": ("hyperbolic", FALLING, False),
    "hyperbolic, coulomb acts": ("hyperbolic", LAW, False),
    "rises": ("hyperbolic that rises", FALLING, False),
    "rises, coulomb acts": ("hyperbolic that rises", LAW, False),
}


@pytest.mark.parametrize("which", few(KINDS, [one for one in KINDS if " acts" not in one]))
def test_identify_keeps_the_kind_that_is_declared(tmp_path: Path, which: str) -> None:
    declared, truth, scatter = KINDS[which]
    kind, text = DECLARED[declared]
    case = case_of(rig_of(0.01), tmp_path, friction=text, law=truth, length=4.0, step=2e-3)
    found = ss.identify(case, scatter=scatter)
    assert isinstance(found.law, kind or type(truth))
    assert found.law.static_limits[0] == pytest.approx(STATIC, rel=0.1)
    if declared == "coulomb" and truth is FALLING:
        assert any("a hyperbolic law fits better" in words for words in found.messages)


@pytest.mark.study
def test_discover_keeps_the_kind_that_is_declared_and_forecasts_with_it(tmp_path: Path) -> None:
    """A hyperbolic law was replaced by a Coulomb law, whose forecasts missed by half the motion."""
    rig = rig_of(0.01)
    case = case_of(rig, tmp_path, friction=DECLARED["hyperbolic"][1], law=FALLING, length=5.0, step=2e-3)
    found = ss.discover(case)
    t = np.arange(0, 10, 1e-3)
    truth = ss.simulate(
        ss.Model(rig, friction=FALLING), belt_speed=0.02, initial=(0, 0), t_end=10, t_eval=t
    ).state[:, 0]
    past = pd.DataFrame(
        {"t": t[:8000], "x1": truth[:8000] + NOISE * np.random.default_rng(1).standard_normal(8000)}
    )
    record = ss.load_recording(past, rig, belt_speed=0.02, name="past")
    off = {}
    for name, model in (("before", found.before), ("after", found.after)):
        assert isinstance(model.friction, ss.HyperbolicFriction)
        ahead = ss.forecast(model, record, belt_speed=0.02, horizon=1.0).x1.to_numpy()
        off[name] = float(np.sqrt(np.mean((ahead - truth[8000 : 8000 + len(ahead)]) ** 2)))
    assert max(off.values()) < 0.05 * truth.std()
