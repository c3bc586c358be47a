"""A rig of (2.1) whose unit of time is not the declared one: its springs are other ones beside alpha1, the mass."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import stickslip as ss
from scattering import case
from stickslip.declared.catalogue import KINDS
from stickslip.declared.effect import effect
from stickslip.discovery import rig_numbers
from stickslip.discovery.laboratory import outcome, two_degree
from stickslip.discovery.laboratory.constants import freed
from stickslip.discovery.laboratory.hypothesis import term
from stickslip.discovery.laboratory.said_of_constants import said_of_constants
from stickslip.discovery.laboratory.trials import Trial
from stickslip.errors import InputError
from stickslip.fitted.data import prepare
from stickslip.likelihoods.fit import closed, null
from stickslip.likelihoods.fit_state import begin
from stickslip.likelihoods.policy import POLICY
from stickslip.measured.case import Case
from stickslip.shown.report.declared import declared as declared_table

E = 0.02
S = np.sqrt(1 + E)  # what the unit's inverse is over the declared one
LAW = ss.PaperFriction()
RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
START = {"belt_speed": 0.1, "initial": (0.1, 0.1, 0, 0), "t_end": 60.0, "rtol": 1e-11, "atol": 1e-13}


def stiff(e: float = E, alpha1: float = 16.0, *more: object) -> ss.Model:
    rig = ss.Rig(alpha1=alpha1, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    return ss.Model(rig, friction=LAW, effects=[effect("rig_stiffness", e=e), *more])


def test_it_is_the_rig_of_another_unit_of_time() -> None:
    # the same masses, springs and dampers, counted in the unit in which omega^2 = (k1 + k2)/m
    own = ss.Rig(alpha1=16 * S**2, alpha2=8 * S**2, beta3=4, eta1=0.1 * S, eta12=0.2 * S)
    speeds = {name: getattr(LAW, name) / S for name in ("t1", "t2", "v_w_min", "v_w_max")}
    law = ss.PaperFriction(**{**LAW.numbers, **speeds})
    there = ss.simulate(
        ss.Model(own, friction=law),
        **{**START, "belt_speed": 0.1 / S, "initial": (0.1, 0.1 / S, 0, 0), "t_end": 60.0 * S},
    )
    here = ss.simulate(stiff(), **START)
    assert len(here.transitions.t) > 8
    np.testing.assert_allclose(here.transitions.t, there.transitions.t / S, rtol=1e-9)
    np.testing.assert_allclose(here.state[-1], there.state[-1] * [1, S, 1, S], atol=1e-8)


def test_the_reference_has_it() -> None:
    slow = ss.reference.simulate(stiff(), belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=60)
    core = ss.simulate(stiff(), **START)
    assert np.abs(slow.transitions.t - core.transitions.t).max() < 1e-8
    plain = ss.simulate(ss.Model(RIG, friction=LAW), **START)
    assert np.abs(plain.state[-1] - core.state[-1]).max() > 0.01


def test_it_acts_beside_a_formula() -> None:
    # a formula goes the way of the general core
    formula = ss.effect("formula", where="block", force="-c*x1", c=0.5)
    beside = ss.simulate(stiff(E, 16.0, formula), **START)
    alone = ss.simulate(stiff(E + 0.5 / 16), **START)
    np.testing.assert_allclose(beside.transitions.t, alone.transitions.t, rtol=1e-8)


@pytest.mark.parametrize("name", ["alpha1", "rig_stiffness.e"])
def test_derivatives(name: str) -> None:
    h = 1e-6
    given = {"alpha1": 16.0, "rig_stiffness.e": E}

    def at(value: float) -> np.ndarray:
        numbers = {**given, name: value}
        return ss.simulate(stiff(numbers["rig_stiffness.e"], numbers["alpha1"]), **START).state[-1]

    run = ss.simulate(stiff(), sensitivity=[name], **START)
    step = h * given[name]
    slope = (at(given[name] + step) - at(given[name] - step)) / (2 * step)
    np.testing.assert_allclose(run.sensitivity[-1, :, 0], slope, rtol=1e-5, atol=1e-7)


def test_alpha1_is_swept_with_its_springs() -> None:
    """Mass and springs move together, as in a model of its own."""
    given = {"belt_speed": 0.1, "initial": (0.1, 0.1, 0, 0), "t_end": 30.0}
    swept = ss.sweep(stiff(), {"alpha1": [15.0, 17.0]}, **given).final_state
    each = [ss.simulate(stiff(E, a), **given, rtol=1e-11, atol=1e-13).state[-1] for a in (15.0, 17.0)]
    np.testing.assert_allclose(swept.values, each, atol=1e-6)


def test_a_rig_without_a_unit_of_time_has_none_in_doubt(tmp_path: Path) -> None:
    read = ss.load_case(case(tmp_path, (), 0.01, 0.0, 4))
    numbers = two_degree.bench_of(read, prepare(read.train)).windows().numbers
    assert {"alpha1", "alpha2"} <= {n.name for n in numbers}
    assert {"stiffness", "v_w_max"}.isdisjoint(n.name for n in numbers)


def test_other_constants_are_numbers_of_the_rig() -> None:
    with pytest.raises(
        InputError, match="'rig_mass' is for a BlockOnBelt; change the rig's own numbers instead"
    ):
        ss.Model(RIG, friction=LAW, effects=[effect("rig_mass", e=0.1)])


SI = {
    "m": 8.4,
    "J": 0.08,
    "r": 0.14,
    "k1": 3700.0,
    "k2": 260.0,
    "k3": 580.0,
    "c1": 1.1,
    "c2": 1.2,
    "length": 0.028,
}


def runs_of(true: ss.Rig, declared: ss.Rig) -> Case:
    """Runs of one rig in SI, declared as another; nothing scatters."""
    rng, runs = np.random.default_rng(1), []
    known = {"x1": 2e-5, "y1": 2e-5}
    units = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "m"), "y1": ss.Channel("y1", "m")}
    for v_b in (0.1, -0.12):
        t = np.arange(0.0, 120.0, 0.05)  # in 1/omega of the true rig
        run = ss.simulate(
            ss.Model(true, friction=LAW), belt_speed=v_b, initial=(0.1, v_b, 0, 0), t_end=t[-1], t_eval=t
        )
        read = run.state[:, [0, 2]] * true.scales.length + 2e-5 * rng.standard_normal((t.size, 2))
        columns = {"t": t / true.scales.omega, "x1": read[:, 0], "y1": read[:, 1]}
        speed = v_b * true.scales.length * true.scales.omega
        runs.append(ss.load_recording(columns, declared, channels=units, belt_speed=speed, noise=known))
    return Case("", declared, LAW, known, tuple(runs), units, Path("rig.toml"))


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["m", "k1"])
def test_a_mass_and_a_spring_that_are_wrong_are_told_apart(name: str) -> None:
    """The unit of time is off by as much for one as for the other, and what else is off tells them."""
    off = 1.08
    read = runs_of(ss.Rig.from_si(**SI), ss.Rig.from_si(**(SI | {name: off * SI[name]})))
    bench = two_degree.bench_of(read, prepare(read.train))
    first, *others = freed(bench, null(bench.windows(), POLICY), read.uncertainty)
    assert first.name == name
    assert first.beyond
    assert abs(math.log1p(first.off) + math.log(off)) < 3 * first.sd < 0.05
    assert all(one.gain < first.gain - 5 for one in others)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("more", [0.0, 0.006])
def test_what_the_runs_say_of_it(more: float) -> None:
    """A mass that is nearly right: the declared unit of time is held against the one that the runs have."""
    true, declared = ss.Rig.from_si(**SI), ss.Rig.from_si(**(SI | {"m": SI["m"] * (1 + more)}))
    read = runs_of(true, declared)
    bench = two_degree.bench_of(read, prepare(read.train))
    fit = null(bench.windows(), POLICY)
    # a speed at which the law bends is counted in the unit of time, too, and is as much in doubt
    speed = next(n for n in fit.windows.numbers if n.name == "v_w_max")
    assert speed.sd == pytest.approx(read.uncertainty.relative("omega"))
    said = said_of_constants(bench, fit)
    assert "alpha1" not in said
    for name, constant in (("inertia", "m"), ("stiffness", "k1")):
        of = rig_numbers.constant(declared, name, said).of
        low, high = of(said[name].low), of(said[name].high)
        assert low < SI[constant] < high
        assert high - low < 0.05 * SI[constant]
    # c2 is what eta12 has beside eta1: as sure as their errors go together
    i, j = (
        next(k for k, n in enumerate(fit.windows.numbers) if n.name == name) for name in ("eta12", "eta1")
    )
    covariance = fit.solution.covariance.copy()
    covariance[i, j] = covariance[j, i] = math.sqrt(covariance[i, i] * covariance[j, j])
    alike = replace(fit, solution=replace(fit.solution, covariance=covariance))
    one = said_of_constants(bench, alike)
    halves = [one[name].high - one[name].value for name in ("eta2", "eta12", "eta1")]
    assert halves[0] == pytest.approx(abs(halves[1] - halves[2]), rel=0.02)  # logarithms are not quite even
    table = declared_table(SimpleNamespace(constants=said, effects=()), read)
    for name in ("m", "k1", "J", "k3"):
        assert table[name]["runs"]["low"] < SI[name] < table[name]["runs"]["high"]
    # and the model that it makes moves as the true one
    made = outcome.model(bench, Trial((), fit), read.model())
    off = next(one for one in made.effects if one.name == "rig_stiffness").parameters["e"]
    omega = declared.scales.omega * np.sqrt(1 + off)
    assert omega == pytest.approx(true.scales.omega, rel=1e-3)
    assert outcome.per_reading(fit) == pytest.approx(1.0, abs=0.1)
    # a phase of each run is a number each
    wave = term(KINDS["harmonic_forcing"], {"a": 1e-6, "w": 1.0, "phi": 0.0}, (0.1, 0.2))
    beside = closed(begin(bench.windows((wave,))), POLICY)
    assert said_of_constants(bench, beside).keys() == said.keys()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("share", [0.6, 0.45])
def test_a_damping_that_is_far_off_is_as_far_off_as_it_is(share: float) -> None:
    """Of two that add up the logarithm of the sum is not linear: 1.72 times the declared one was told as 2.06 times."""
    wrong = {"c1": 1.2 * SI["c1"], "c2": share * SI["c2"]}
    read = runs_of(ss.Rig.from_si(**SI), ss.Rig.from_si(**(SI | wrong)))
    bench = two_degree.bench_of(read, prepare(read.train))
    found = {one.name: one for one in freed(bench, null(bench.windows(), POLICY), read.uncertainty)}
    own = found["c2"]
    assert own.beyond
    at = own.interval(wrong["c2"])
    assert at.low is not None
    assert at.high is not None
    assert at.low < SI["c2"] < at.high
    assert at.high - at.low < 0.2 * SI["c2"]


@pytest.mark.sampled(1)
def test_a_damping_that_is_none_is_told_as_next_to_none() -> None:
    """An estimate below nothing has no logarithm."""
    none = SI | {"c2": 1e-4 * SI["c2"]}
    read = runs_of(ss.Rig.from_si(**none), ss.Rig.from_si(**SI))
    bench = two_degree.bench_of(read, prepare(read.train))
    fit = null(bench.windows(), POLICY)
    i = [n.name for n in fit.windows.numbers].index("eta12")
    for less in (0.0, 0.3):  # an error may have it below c1
        fit.at[i] -= less
        own = next(one for one in freed(bench, fit, read.uncertainty) if one.name == "c2")
        assert own.beyond
        at = own.interval(SI["c2"])
        assert at.low is not None
        assert 0 < at.low < at.value < 0.2 * SI["c2"]
