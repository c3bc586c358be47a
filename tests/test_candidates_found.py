"""A user's own effect in a laboratory: found where it acts, tied with what is the same."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from quick_figures import quickly
from scattering import block_case, case
from stickslip.discovery.laboratory import block_bench
from stickslip.discovery.laboratory.hypothesis import term
from stickslip.discovery.laboratory.rival_kind import rival
from stickslip.discovery.laboratory.screen import columns, screened
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.fitted.data import prepare
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import begin
from stickslip.shown.report.write import write_report

SCATTER, OFF = 0.02, 0.008
NEARLY = {"mass": 0.008, "stiffness": -0.006, "gain": 0.003}
DRAG = {"where": "angle_body", "force": "-c*deflection**2*deflection_rate"}
MINE = """
[[candidate]]
name = "mine"
where = "angle_body"
force = "-c*deflection**2*deflection_rate"
ranges.c = [0, 60]
"""


def close(one: ss.discovery.result.Interval, true: float) -> bool:
    assert one.low is not None
    assert one.high is not None
    return one.low < true < one.high


@pytest.mark.study
def test_an_effect_that_is_in_no_list_is_named_by_the_user_s_own(tmp_path: Path) -> None:
    acts = ss.effect("formula", called="true", c=10.0, **DRAG)
    path = case(tmp_path, (acts,), SCATTER, OFF, 2, few=True, more=MINE)
    read = ss.load_case(path)
    found = ss.discover(read, threads=2)
    (one,) = found.effects
    assert (one.name, one.where, one.depends_on) == ("mine", "angle_body", ("y1", "y2"))
    assert close(one.parameters["c"], 10.0)
    assert found.error.after < 0.6 * found.error.before
    write_report(found, read, tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["effects"][0]["name"] == "mine"
    assert "mine" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    model = ss.load_model(tmp_path / "out" / "model_after.toml")
    assert model == found.model
    run = read.validate[0]
    past = run.window(float(run.t[0]), float(run.t[0]) + 40)
    assert np.isfinite(ss.forecast(model, past, belt_speed=run.belt_speed, horizon=5)["x1"]).all()
    assert ss.compare(model, run).rows
    swept = ss.sweep(model, over={"mine.c": [5.0, 10.0]}, belt_speed=0.1, t_end=20, observe=("releases",))
    assert (swept["status"] == 0).all()


@pytest.mark.study
def test_one_of_a_block_is_named_in_the_units_of_the_case(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    acts = ss.effect("formula", called="true", where="block", force="-c*x1*x2", c=400.0)
    more = '[[candidate]]\nname = "mine"\nwhere = "block"\nforce = "-c*x1*x2"\n'
    more += 'ranges.c = ["0 N s/m^2", "3000 N s/m^2"]\n'
    read = ss.load_case(
        block_case(tmp_path, (acts,), few=True, more=more, seed=5, scatter=SCATTER, off=NEARLY)
    )
    found = ss.discover(read)
    assert [one.name for one in found.effects] == ["mine"]
    assert close(found.effects[0].parameters["c"], 400.0)
    assert found.model.effects[0] == read.candidates[0].replace(c=found.effects[0].parameters["c"].value)
    assert found.error.after < 1.3 * found.error.floor
    assert all(np.isfinite(run.transition_time["after"]) for run in found.error.runs)
    quickly(monkeypatch)
    write_report(found, read, tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["effects"][0]["name"] == "mine"
    assert "mine" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert ss.load_model(tmp_path / "out" / "model_after.toml") == found.model


@pytest.mark.study
def test_one_that_is_an_effect_of_the_catalogue_is_tied_with_it(tmp_path: Path) -> None:
    acts = ss.effect("block_viscous_damping", c=2.0)
    more = '[[candidate]]\nname = "mine"\nwhere = "block"\nforce = "-c*deflection_rate"\nranges.c = [0, 20]\n'
    read = ss.load_case(
        block_case(tmp_path, (acts,), few=True, more=more, seed=2, scatter=SCATTER, off=NEARLY)
    )
    found = ss.discover(read)
    (one,) = found.effects
    names = {"mine", "block_viscous_damping"}
    (other,) = [a for a in one.alternatives if a.name in names]
    assert {one.name, other.name} == names
    assert other.tied
    assert one.parameters["c"].value == pytest.approx(2.0, rel=0.1)
    assert other.parameters["c"].value == pytest.approx(one.parameters["c"].value, rel=2e-2)


def test_the_columns_of_a_formula_are_those_of_the_effect_that_it_is(tmp_path: Path) -> None:
    """Scored alike: a force, a factor and a reading, declared in SI and in a block's scaled numbers."""
    path = block_case(tmp_path, few=True, seed=3, scatter=SCATTER, off=NEARLY)
    bench, units, *_ = block_bench.bench_of(ss.load_case(path))
    fit = begin(bench.windows())
    same = ss.candidate("mine", where="block", force="-c*x2", ranges={"c": [0, 5]})
    pairs = [
        (
            rival(same, units.scales),
            "block_viscous_damping",
            {"c": 1.0 / units.size("block_viscous_damping.c")},
        )
    ]
    one = ss.candidate("mine", where="contact", factor="1 + c*t", ranges={"c": [-1, 1]})
    pairs += [(rival(one, units.scales), "friction_drift", {"r": 1.0 / units.size("friction_drift.r")})]
    one = ss.candidate("mine", where="x1", reading="reading + c*reading**2", ranges={"c": [-1, 1]})
    pairs += [
        (rival(one, units.scales), "sensor_nonlinearity", {"q": 1.0 / units.size("sensor_nonlinearity.q")})
    ]
    for kind, name, scale in pairs:
        ours = columns(bench, fit, (), term(kind, {"c": 0.0}), ("mine.c",))
        ((number, size),) = scale.items()
        theirs = columns(bench, fit, (), term(ss.CATALOGUE[name], {number: 0.0}), (f"{name}.{number}",))
        for a, b in zip(ours, theirs, strict=True):
            assert a is not None
            assert b is not None
            np.testing.assert_allclose(a, b * size, atol=2e-4 * np.abs(b * size).max())


def test_what_is_proportional_to_no_number_is_scored_as_a_whole(tmp_path: Path) -> None:
    acts = ss.effect("spring_gap_k3", k=4.0, d=0.1)
    path = case(tmp_path, (acts,), SCATTER, OFF, 3, few=True)
    read = ss.load_case(path)
    own = ss.candidate(
        "stop",
        where="angle_body",
        force="-max(0, abs(deflection) - d)*sign(deflection)*k**1.5",
        ranges={"k": [0.5, 10], "d": [0.02, 0.3]},
    )
    bench = bench_of(ss.load_case(path), prepare(read.train))
    kind = rival(own, None)
    assert kind.sizes == ("strength",)
    bench = replace(bench, rivals=(kind,))
    fit = null(bench.windows(), bench.policy)
    (found,) = [one for one in screened(bench, fit, ()).ranked if one.term.effect.name == "stop"]
    assert found.gain > 50
    assert found.count == 2
    assert found.term.effect.parameters["d"] == pytest.approx(0.1, abs=0.08)
