"""What no name explains on a rig of bodies: curves at every place, and one that is told where it acts."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES, recorded, recording
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of
from stickslip.discovery.general_rig.curve_kinds import CurveKind
from stickslip.discovery.general_rig.curve_told import standing
from stickslip.discovery.general_rig.outcome import effects
from stickslip.discovery.laboratory import trials
from stickslip.discovery.laboratory.gate import SearchGate
from stickslip.discovery.laboratory.hypothesis import Term, label, term
from stickslip.discovery.laboratory.screen import Candidate, Screen, columns
from stickslip.discovery.laboratory.search import Searched, SearchStep
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.result import Curve, Evidence, FoundEffect
from stickslip.discovery.workers import ALONE
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit, begin
from test_candidates_general import LAWS, RIG, chain

Floats = NDArray[np.float64]
SCHEMA = Path(ss.__file__).parent / "shown" / "report" / "report.schema.json"
DRAG = 3.0  # N s/m


def bench() -> GeneralBench:
    known = Uncertainty.usual(RIG, channels=("a", "b"))
    return bench_of(ss.Model(RIG, friction=LAWS), [chain(20, 6.0)], known)


def curves(own: GeneralBench) -> dict[tuple[str, str], CurveKind]:
    return {(one.where, one.variable): one for one in own.kinds() if isinstance(one, CurveKind)}


def test_curves_are_at_every_place_that_has_what_they_are_of() -> None:
    links = {(f"link_{i}", of) for i in (1, 2, 3) for of in ("deflection", "deflection_rate")}
    assert set(curves(bench())) == links | {(one, "u") for one in "ab"} | {
        (f"{one} channel", "reading") for one in "ab"
    }


def test_a_rig_of_matrices_has_curves_of_its_coordinates() -> None:
    case = CASES["pin"]()
    run = recording(case, *recorded(case, 40, level=0.02, static=0.02, lasts=2.0))
    own = bench_of(case.model, [run], Uncertainty.usual(case.model.rig, channels=case.channels))
    names = case.model.rig.equations.names
    rubs = [any(c.direction[i] for c in case.model.rig.equations.contacts) for i in range(len(names))]
    found = set(curves(own))
    assert {(name, "deflection") for name in names} < found
    assert {name for name, of in found if of == "deflection_rate"} == {
        name for name, at in zip(names, rubs, strict=True) if not at
    }


def test_a_curve_s_shapes_together_are_the_effect_that_they_make() -> None:
    """A cubic spring is made of two of its shapes to within a hundredth over what the runs reach."""
    own = bench()
    fit = begin(own.windows())
    kind = curves(own)["link_1", "deflection"]
    cubic = next(one for one in own.kinds() if (one.name, one.where) == ("spring_cubic_k1", "link_1"))
    none = {one.name: 0.0 for one in kind.parameters}
    sizes = tuple(f"{kind.name}.{one.name}" for one in kind.parameters)
    ours = columns(own, fit, (), term(kind, none), sizes)
    theirs = columns(own, fit, (), term(cubic, {"k": 0.0}), ("spring_cubic_k1@link_1.k",))
    a, b = (np.concatenate([one[:, :, :] for one in each if one is not None]) for each in (ours, theirs))
    a, b = a.reshape(-1, a.shape[2]), b.ravel()
    size, *_ = np.linalg.lstsq(a, b, rcond=None)
    assert np.sqrt(np.mean((a @ size - b) ** 2)) < 0.01 * np.sqrt(np.mean(b**2))
    x, shapes = kind.shapes()
    force = shapes @ size
    assert np.sqrt(np.mean((force + x**3) ** 2)) < 0.02 * np.sqrt(np.mean(x**6))


@pytest.fixture(scope="module")
def found() -> ss.Found:
    def dragged(_: float, z: Floats) -> Floats:
        return np.array([-DRAG * max(z[2], 0.0), 0.0])

    runs = [chain(seed, 7.0, dragged) for seed in (30, 31)] + [chain(32, 5.0, dragged, role="validate")]
    return ss.discover(runs, friction=LAWS, threads=1)


@pytest.mark.study
def test_what_is_on_no_list_is_told_where_it_acts_and_on_what(found: ss.Found) -> None:
    (one,) = found.effects
    assert found.verdict.value == "unlisted_effect"
    assert (one.name, one.where, one.depends_on) == ("unlisted", "link_1", ("deflection_rate",))
    assert one.curve is not None
    x, true = one.curve.x, -DRAG * np.maximum(one.curve.x, 0.0)
    seen = np.abs(x) < 0.8 * np.abs(x).max()
    # to what is straight: a damping is known to 15 % alone
    line = np.polynomial.polynomial.Polynomial.fit(x[seen], (one.curve.value - true)[seen], 1)
    off = (one.curve.value - true - line(x))[seen]
    assert np.sqrt(np.mean(off**2)) < 0.15 * np.ptp(true[seen])
    assert found.error.after < 0.8 * found.error.before


@pytest.mark.study
def test_its_report_and_its_model_have_it(found: ss.Found, tmp_path: Path) -> None:
    found.write_report(tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    jsonschema.validate(report, json.loads(SCHEMA.read_text()))
    assert report["effects"][0]["curve"]["variable"] == "deflection_rate"
    assert "acts at link_1, as a function of deflection_rate" in report["summary"][0]
    assert (tmp_path / "out" / "figures" / "learned_curve.svg").exists()
    after = ss.load_model(tmp_path / "out" / "model_after.toml")
    assert [one.name for one in after.effects] == ["curve_of_deflection_rate_at_link_1"]


def test_a_curve_has_what_a_name_does_at_its_place() -> None:
    """The cubic part of a spring that is a curve and a cubic spring was in the model, and not in what was told."""
    own = bench()
    kinds = {label(one): one for one in own.kinds()}
    curve = curves(own)["link_1", "deflection"]
    terms = (
        term(curve, {one.name: 0.3 * (-1) ** i for i, one in enumerate(curve.parameters)}),
        term(kinds["spring_cubic_k1@link_1"], {"k": 70.0}),
    )
    fit = null(own.windows(terms), replace(own.policy, most_steps=1))
    base = Trial((), fit)
    told = effects(
        own,
        Searched(
            base, Trial(terms, fit), [SearchStep(base, Screen((), ()), [], SearchGate(np.zeros(0), 0.0))]
        ),
    )
    (one,) = told
    assert one.curve is not None
    values = fit.values()
    x, shapes = curve.shapes()
    sizes = np.array([values[f"{curve.name}.{i.name}"] for i in curve.parameters])
    cubic = values["spring_cubic_k1@link_1.k"]
    assert abs(cubic) > 1
    np.testing.assert_allclose(one.curve.value, shapes @ sizes - cubic * x**3, atol=1e-12)
    assert one.formula.endswith("in the model spring_cubic_k1 does a part of it")
    assert (one.curve.low < one.curve.value)[np.abs(x) > 0.2 * np.abs(x).max()].all()


@pytest.mark.parametrize("steps", [9, 16])
def test_where_a_curve_leads_names_whose_steps_ran_out_are_fitted_anew(
    monkeypatch: pytest.MonkeyPatch, steps: int
) -> None:
    """A cubic spring that acts stopped 105 short of a curve, which can be it, and 14 ahead of it when fitted anew."""
    own = bench()
    fit = begin(own.windows())
    fit.deviance = 1000.0
    kinds, curve = {label(one): one for one in own.kinds()}, curves(own)["link_1", "deflection"]
    every = [
        Candidate(term(curve, {one.name: 0.1 for one in curve.parameters}), 200.0, 4, np.zeros(len(fit.at))),
        Candidate(term(kinds["spring_cubic_k1@link_1"], {"k": 70.0}), 200.0, 1, np.zeros(len(fit.at))),
    ]
    asked: list[str] = []

    def from_near(_: GeneralBench, start: Fit) -> Fit:
        whole = len(start.windows.numbers) > len(fit.at) + 1
        return replace(start, deviance=500.0 if whole else 605.0, steps=5 if whole else steps)

    def sought(_: GeneralBench, __: Trial, found: tuple[Fit, Term], *___: object) -> Fit:
        asked.append(found[1].name)
        return replace(found[0], deviance=486.0)

    monkeypatch.setattr(trials, "from_near", from_near)
    monkeypatch.setattr(trials, "_sought", sought)
    made, done = trials.all_full(own, Trial((), fit), every, ALONE)
    assert asked == list(done) == (["spring_cubic_k1@link_1"] if steps == 16 else [])
    assert min(made, key=lambda one: one.deviance).names == ((asked or [curve.name])[0],)


@pytest.mark.parametrize(("gain", "starts"), [(300.0, 1), (600.0, 3)])
@pytest.mark.parametrize("kind", ["spring_gap_k3@link_1", "curve"])
def test_what_promises_less_than_another_reaches_is_fitted_once(
    monkeypatch: pytest.MonkeyPatch, gain: float, starts: int, kind: str
) -> None:
    """A contact that yields was fitted from three starts, a minute each, while a ripple explained twice its score."""
    own = bench()
    fit = replace(null(own.windows(), replace(own.policy, most_steps=1)), deviance=1000.0)
    kinds, curve = {label(one): one for one in own.kinds()}, curves(own)["link_1", "deflection"]
    none = np.zeros(len(fit.at))
    other = (
        term(curve, {one.name: 0.1 for one in curve.parameters})
        if kind == "curve"
        else term(kinds[kind], {"k": 2.0, "d": 0.05})
    )
    every = [
        Candidate(term(kinds["spring_cubic_k1@link_1"], {"k": 70.0}), 500.0, 1, none),
        Candidate(other, gain, 2, none),
    ]
    begun = list[str]()

    def from_near(_: GeneralBench, start: Fit) -> Fit:
        name = start.windows.numbers[-1].name.rpartition(".")[0]
        begun.append(name)
        leads = name == "spring_cubic_k1@link_1"
        return replace(start, deviance=500.0 if leads else 1100.0, steps=5 if leads else 16)

    monkeypatch.setattr(trials, "from_near", from_near)
    monkeypatch.setattr(trials, "_sought", lambda _, __, found, *___: found[0])
    trials.all_full(own, Trial((), fit), every, ALONE)
    assert begun.count(other.name) == starts
    assert begun.count("spring_cubic_k1@link_1") == 1


@pytest.mark.parametrize(("short", "told"), [(90.0, True), (200.0, False)])
def test_names_that_only_together_do_what_a_curve_does_are_told_as_one(
    monkeypatch: pytest.MonkeyPatch, short: float, told: bool
) -> None:
    """A spring by k d abs(d) was told as a cubic spring and a gap of one link, which explained 80 of 2640 more."""
    own = bench()
    kinds, curve = {label(one): one for one in own.kinds()}, curves(own)["link_1", "deflection"]
    terms = (
        term(kinds["spring_cubic_k1@link_1"], {"k": 70.0}),
        term(kinds["spring_gap_k3@link_1"], {"k": 2.0, "d": 0.05}),
    )
    fit = replace(null(own.windows(terms), replace(own.policy, most_steps=1)), deviance=1000.0)
    plain = replace(null(own.windows(), replace(own.policy, most_steps=1)), deviance=2000.0)
    monkeypatch.setattr(Trial, "whole", lambda self: self.deviance)
    base = Trial((), plain)
    alone = Trial(
        (term(curve, {one.name: 0.1 for one in curve.parameters}),), replace(plain, deviance=1000.0 + short)
    )
    each = [Trial((one,), replace(plain, deviance=1500.0)) for one in terms]
    step = SearchStep(base, Screen((), ()), [alone, *each], SearchGate(np.zeros(0), 5.0))
    without = {one.name: other for one, other in zip(terms, each[::-1], strict=True)}
    found = effects(own, Searched(base, Trial(terms, fit), [step], without))
    if not told:
        assert {one.name for one in found} == {"spring_cubic_k1", "spring_gap_k3"}
        return
    (one,) = found
    assert (one.name, one.where, one.depends_on) == ("unlisted", "link_1", ("deflection",))
    assert one.formula.endswith("in the model made of spring_cubic_k1 and spring_gap_k3")
    assert {each.name for each in one.alternatives} == {"spring_cubic_k1", "spring_gap_k3"}
    assert one.evidence.delta_chi2 == pytest.approx(1000.0)
    assert "curve_of" not in one.evidence.sentence
    values = fit.values()
    assert one.curve is not None
    x = one.curve.x
    over = np.maximum(np.abs(x) - values["spring_gap_k3@link_1.d"], 0.0) * np.sign(x)
    made = -values["spring_cubic_k1@link_1.k"] * x**3 - values["spring_gap_k3@link_1.k"] * over
    np.testing.assert_allclose(one.curve.value, made, atol=1e-12)


def test_names_at_the_place_of_a_curve_are_told_with_it() -> None:
    def effect(name: str, where: str, curve: Curve | None = None) -> FoundEffect:
        proof = Evidence(10.0, 5.0, None, None, "", 1.0, "")
        return FoundEffect(name, where, (), {}, proof, (), "force on link_1", curve)

    x = np.zeros(3)
    curve = Curve("link_1", "deflection", "force on link_1", x, x, x, x, x, None)
    every = [
        effect("spring_cubic_k1", "link_1"),
        effect("unlisted", "link_1", curve),
        effect("sensor_lag", "a channel"),
    ]
    first, second = standing(every)
    assert (first.name, second.name) == ("unlisted", "sensor_lag")
    assert first.formula == "force on link_1; in the model spring_cubic_k1 does a part of it"
    assert standing(every[::2]) == (every[0], every[2])
