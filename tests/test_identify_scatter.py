"""Identification where friction differs from event to event, against truths of simulators written apart."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from scattering import KINETIC, MASS, RIG, STATIC, STIFFNESS, block_case, case
from stickslip.discovery.laboratory.block_bench import bench_of
from stickslip.likelihoods import correlated
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit

BENCH = Path(__file__).parents[1] / "bench" / "discovery"
LAW = {
    "T_s_minus": "Ts_m", "A1": "A1", "A2": "A2", "t1": "t1", "t2": "t2", "T_min_minus": "Tmin_m",
    "T_s_plus": "Ts_p", "T_min_plus": "Tmin_p",
}  # fmt: skip
DISCOVER = "looks for what is missing"


def held(found: ss.Identified, true: dict[str, float]) -> list[bool]:
    """Whether the interval of each number of the law that has one holds the truth."""
    pairs = [(found.estimates[name], value) for name, value in true.items()]
    return [e.low <= value <= e.high for e, value in pairs if e.low is not None and e.high is not None]


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> ss.Identified:
    """A rig whose friction differs from event to event, identified."""
    return ss.identify(ss.load_case(case(tmp_path_factory.mktemp("rig"), (), 0.02, 0.0, 4)))


def test_law_constants_and_scatter_of_a_rig_are_found(rig: ss.Identified) -> None:
    found = rig
    true = ss.PaperFriction()
    assert sum(held(found, {name: getattr(true, name) for name in LAW})) >= 7  # of 8 at 95 %
    assert found.estimates["T_s_minus"].value == pytest.approx(true.T_s_minus, rel=0.02)
    assert 0.9 < found.reduced_chi2 < 1.1
    assert found.scatter.kinetic.low < 0.02 < found.scatter.kinetic.high
    assert found.model.scatter.level == pytest.approx(0.02, rel=0.4)
    for name, value in RIG.items():
        one = found.constants[name]
        assert one.declared == pytest.approx(value)
        assert one.value == pytest.approx(value, rel=0.03)
        assert found.model.parameters[name] == one.value
    assert "chi-squared" in found.messages[0]
    assert not [one for one in found.messages if "discover" in one]
    assert found.covered["minus"][1] == pytest.approx(0.5, abs=0.1)


def test_what_is_written_of_scatter_can_be_read_again(rig: ss.Identified, tmp_path: Path) -> None:
    found = rig
    found.save(tmp_path / "out")
    told = json.loads((tmp_path / "out" / "identified.json").read_text())
    assert told["scatter"]["kinetic"]["value"] == found.scatter.kinetic.value
    assert told["declared"]["alpha1"]["uncertainty"] == pytest.approx(0.015)
    model = ss.load_model(tmp_path / "out" / "model.toml")
    assert model.parameters["alpha1"] == pytest.approx(found.constants["alpha1"].value, rel=1e-6)
    assert set(told) >= {"law", "estimates", "covered", "names", "covariance", "noise", "events", "thinned"}


@pytest.mark.study
def test_where_nothing_scatters_the_law_alone_is_fitted(tmp_path: Path) -> None:
    made = ss.load_case(case(tmp_path, (), 0.0, 0.0, 6))
    found, alone = ss.identify(made), ss.identify(made, scatter=False)
    assert found.scatter is None
    for name, one in found.estimates.items():
        assert one == alone.estimates[name]
    # and the fit that knows of scatter finds none, and the same law to a share of its interval
    asked = ss.identify(made, scatter=True)
    assert asked.scatter.kinetic.value < 2e-3
    for name, one in asked.estimates.items():
        assert abs(one.value - alone.estimates[name].value) < 0.5 * (one.high - one.low)


@pytest.fixture(scope="module")
def block(tmp_path_factory: pytest.TempPathFactory) -> ss.Case:
    """A block whose friction differs from slip to slip."""
    return ss.load_case(block_case(tmp_path_factory.mktemp("block"), few=True, seed=3, scatter=0.02))


@pytest.fixture(scope="module")
def fit(block: ss.Case) -> Fit:
    """Its windows under its law."""
    made = bench_of(block)
    assert made is not None
    return null(made[0].windows(), made[0].policy)


@pytest.mark.study
@pytest.mark.parametrize("exact", [False, True])
def test_a_block_whose_friction_differs_from_slip_to_slip(
    tmp_path: Path, block: ss.Case, exact: bool
) -> None:
    case = block
    if exact:
        said = "[uncertainty]\nm = 0\nk = 0\nspring_force = 0\n"
        case = ss.load_case(block_case(tmp_path, few=True, seed=3, scatter=0.02, more=said))
    found = ss.identify(case)
    assert isinstance(found.law, ss.CoulombFriction)
    for name, value in (("static", STATIC), ("kinetic", KINETIC)):
        assert abs(found.estimates[name].value - value) < 3 * found.estimates[name].std
    assert found.estimates["static"].high - found.estimates["static"].low < 0.3
    assert set(found.constants) == (set() if exact else {"mass", "stiffness", "spring_force"})
    if not exact:
        assert found.constants["mass"].low < MASS < found.constants["mass"].high
        assert found.constants["stiffness"].low < STIFFNESS < found.constants["stiffness"].high
    assert found.scatter.kinetic.low < 0.02 < found.scatter.kinetic.high
    assert len(found.events.t) == 12
    assert found.unidentified == ("static_plus", "kinetic_plus")
    again = ss.load_model(_saved(found, tmp_path))
    assert again.friction == found.law
    assert again.scatter == found.model.scatter
    assert again.scatter.level == pytest.approx(0.02, rel=0.5)


def _saved(found: ss.Identified, folder: Path) -> Path:
    return next(path for path in found.save(folder / "out") if path.name == "model.toml")


@pytest.mark.parametrize("memories", [(0.0, 0.0), (0.9, 0.9), (0.95, 0.1)])
def test_events_that_are_alike_make_a_covariance_and_a_wider_one(
    fit: Fit, monkeypatch: pytest.MonkeyPatch, memories: tuple[float, float]
) -> None:
    alone = fit.solution.covariance
    monkeypatch.setattr(correlated, "memory", lambda _fit, which: (memories[which], 0.0))
    monkeypatch.setattr(correlated.np, "clip", lambda _found, _low, high: high)  # as alike as they can be
    wide = correlated.covariance(fit)
    assert wide == pytest.approx(wide.T, rel=1e-6, abs=1e-18)
    assert (np.linalg.eigvalsh(wide) > 0).all()
    levels = [i for i, one in enumerate(fit.windows.numbers) if one.name == "kinetic"]
    assert (np.diag(wide)[levels] > 1.5 * np.diag(alone)[levels]).all() == (memories[1] > 0.5)


@pytest.mark.study
def test_an_effect_under_scatter_sends_to_discover(tmp_path: Path) -> None:
    damped = (ss.effect("block_viscous_damping", c=1.5),)
    found = ss.identify(ss.load_case(case(tmp_path, damped, 0.01, 0.0, 8)))
    assert [one for one in found.messages if DISCOVER in one]


@pytest.mark.study
def test_intervals_cover_in_twenty_laboratories(tmp_path: Path) -> None:
    """Twenty rigs whose friction scatters along the belt, whose belt wobbles, whose constants and gains are off."""
    sys.path.insert(0, str(BENCH))
    from generate import generate

    answers = generate(
        tmp_path, 77, {"single": 0, "none": 20, "pairs": 0, "unlisted": 0, "odd": 0}, laboratory=1.0
    )
    law, constants, sent = [], [], 0
    for one in answers:
        found = ss.identify(ss.load_case(tmp_path / one["case"]))
        law += held(found, {name: one["rig"][key] for name, key in LAW.items()})
        known = {
            **dict(zip(("x1", "y1"), one["laboratory"]["gains"], strict=True)),
            "omega": one["scales"]["w"],
        }
        true = {"alpha1": "a1", "alpha2": "a2", "beta3": "b3", "eta1": "e1", "eta12": "e12"}
        # masses and dampings of a rig in SI are found in its declared unit of time
        unit = one["laboratory"]["time"] if one["scales"]["on"] else 1.0
        power = {"alpha1": 2, "alpha2": 2, "eta1": 1, "eta12": 1}
        for name, said in found.constants.items():
            value = known[name] if name in known else one["rig"][true[name]] * unit ** power.get(name, 0)
            constants.append(said.low <= value <= said.high)
        sent += any(DISCOVER in m for m in found.messages)
    assert len(law) >= 150
    assert 0.90 <= np.mean(law) <= 0.99
    assert 0.88 <= np.mean(constants) <= 0.99
    assert sent <= 2
