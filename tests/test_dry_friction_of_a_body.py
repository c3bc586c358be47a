"""Dry friction of a body or a link that rubs on nothing declared: a contact that an effect adds."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from bodies_cases import CASES, recorded, recording
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of
from stickslip.discovery.laboratory.hypothesis import Term, term
from stickslip.discovery.laboratory.screen import screened
from stickslip.errors import InputError
from stickslip.likelihoods.fit import begun, fitted, null
from stickslip.likelihoods.fit_state import unexplained

F = 0.08  # N
T = np.linspace(0.0, 20.0, 401)
RUN = {"belt_speed": 0.1, "t_end": 20.0, "t_eval": T, "rtol": 1e-10, "atol": 1e-10}
DRY = "pivot_dry_friction@arm.f"
BODIES = {"block": ss.Body(mass=1.0), "arm": ss.Body(mass=0.5)}
LINKS = [
    ss.Link(between=("block", "ground"), stiffness=100.0, damping=0.2),
    ss.Link(between=("arm", "ground"), stiffness=60.0, damping=0.1),
    ss.Link(between=("block", "arm"), stiffness=30.0),
]
ON_BELT = ss.Contact(body="block", against="belt", law="rubber")
RUBBER = ss.CoulombFriction(static=3.0, kinetic=2.0)
PLAIN = ss.BodiesRig(body=BODIES, link=LINKS, contact=[ON_BELT])


def rubbing(f: float = F, where: str = "arm", v_c: float = 0.0) -> ss.Model:
    one = ss.effect("pivot_dry_friction", where=where, f=f, v_c=v_c)
    return ss.Model(PLAIN, friction={"rubber": RUBBER}, effects=[one])


def declared(f: float = F) -> ss.Model:
    """The same, as a contact of the rig."""
    rig = ss.BodiesRig(body=BODIES, link=LINKS, contact=[ON_BELT, ss.Contact(body="arm", law="pivot")])
    return ss.Model(rig, friction={"rubber": RUBBER, "pivot": ss.CoulombFriction(static=f, kinetic=f)})


def test_it_is_a_contact_of_the_body_that_sticks() -> None:
    ours, theirs = ss.simulate(rubbing(), **RUN), ss.simulate(declared(), **RUN)
    assert ours.contact_names == ("block", "pivot_dry_friction@arm")
    assert (ours.mode[:, 1] == 0).any()
    np.testing.assert_array_equal(ours.mode, theirs.mode)
    np.testing.assert_allclose(ours.state, theirs.state, atol=1e-12)
    early = {"belt_speed": 0.1, "t_end": 4.0, "t_eval": T[:81]}
    plain = ss.reference.simulate_bodies(rubbing(), initial=[0.0] * 4, tol=1e-11, **early)
    np.testing.assert_allclose(ours.state[:81], plain.state, atol=1e-8)


def test_a_creep_speed_rounds_it() -> None:
    sharp = ss.simulate(rubbing(), **RUN).state
    off = [np.abs(ss.simulate(rubbing(v_c=v_c), **RUN).state - sharp).max() for v_c in (1e-3, 1e-4, 1e-5)]
    assert off[0] > 3 * off[1] > 9 * off[2] > 0


def test_it_is_differentiated_and_swept() -> None:
    run, h = ss.simulate(rubbing(), **RUN, sensitivity=[DRY]), 1e-5
    moved = [ss.simulate(rubbing(F + s * h), **RUN | {"rtol": 1e-13, "atol": 1e-13}).state for s in (-1, 1)]
    np.testing.assert_allclose(run.sensitivity[:, :, 0], (moved[1] - moved[0]) / (2 * h), atol=1e-5)
    one = {"belt_speed": 0.1, "t_end": 20.0}
    swept = ss.sweep(rubbing(), {DRY: [0.02, F, 0.2]}, **one)
    for f, state, stuck in zip(
        swept[DRY].values, swept.final_state.values, swept.stick_fraction.values, strict=True
    ):
        run = ss.simulate(rubbing(float(f)), **one)
        np.testing.assert_allclose(state, run.state[-1], atol=1e-7)
        fine = ss.simulate(rubbing(float(f)), **one, t_eval=np.linspace(0, 20, 20001))
        assert stuck == pytest.approx(np.mean(fine.mode[:, 0] == 0), abs=1e-3)  # of the rig's contact alone


def test_its_cycle_is_that_of_the_declared_contact() -> None:
    ours, theirs = (ss.limit_cycle(one, belt_speed=0.1) for one in (rubbing(0.02), declared(0.02)))
    assert ours.period == pytest.approx(theirs.period, rel=1e-9)
    assert ours.stable == theirs.stable


def test_it_is_kept_in_a_file(tmp_path) -> None:
    rubbing().save(tmp_path / "model.toml")
    again = ss.load_model(tmp_path / "model.toml")
    np.testing.assert_array_equal(ss.simulate(again, **RUN).state, ss.simulate(rubbing(), **RUN).state)


@pytest.mark.parametrize("where", ["block", "link_1"])
def test_where_a_contact_rubs_already_it_is_refused(where: str) -> None:
    with pytest.raises(InputError, match=r"same direction as contact 1 \('block'\); put both into one law"):
        rubbing(where=where)


def test_modes_are_given_for_the_rig_s_contacts_or_for_all() -> None:
    one, both = (ss.simulate(rubbing(), contact=c, **RUN) for c in (["slip-"], ["slip-", "auto"]))
    np.testing.assert_array_equal(one.state, both.state)
    with pytest.raises(InputError, match="3 modes for 2 contacts"):
        ss.simulate(rubbing(), contact=["auto"] * 3, **RUN)


@pytest.fixture(scope="module")
def pin() -> GeneralBench:
    case = CASES["pin"]()
    across = ss.effect("pivot_dry_friction", where="across", f=0.06)
    true = ss.Model(case.model.rig, friction=case.model.friction, effects=[across])
    t = np.arange(0.0, case.settling + case.lasts / 4, case.dt)
    run = ss.simulate(true, **case.speeds, initial=case.initial, t_end=t[-1], t_eval=t)
    read = np.array([run.state[:, run.state_names.index(one)] for one in case.channels])
    read += case.noise * np.random.default_rng(3).standard_normal(read.shape)
    known = Uncertainty.usual(case.model.rig, channels=case.channels)
    return bench_of(case.model, [recording(case, t, read.T)], known)


def test_the_search_has_it_where_nothing_rubs_and_it_explains_the_readings(pin: GeneralBench) -> None:
    places = [one.where for one in pin.kinds() if one.name == "pivot_dry_friction"]
    assert places == ["across"]
    ranked = screened(pin, null(pin.windows(), pin.policy), ()).ranked
    found = next(one for one in ranked if one.term.name == "pivot_dry_friction@across")
    assert found.term.kind.depends_on == ("deflection_rate",)
    assert found.gain > 1000
    fit = fitted(begun(pin.windows((found.term,))), pin.policy)
    assert unexplained(fit) == pytest.approx(1.0, abs=0.1)
    assert fit.windows.values(fit.at)["pivot_dry_friction@across.f"] == pytest.approx(0.06, rel=0.05)


def test_nothing_more_is_sought_where_all_rub() -> None:
    case = CASES["drill"]()
    run = recording(case, *recorded(case, 5, level=0.02, static=0.02, lasts=5.0))
    own = bench_of(case.model, [run], Uncertainty.usual(case.model.rig, channels=case.channels))
    kinds = [one for one in own.kinds() if one.name == "pivot_dry_friction"]
    assert {one.where for one in kinds} == {"table", "link_1"}
    taken: Term = term(kinds[0], {"f": 0.1, "v_c": 0.0})
    assert own.has_room(kinds[1], ())
    assert not own.has_room(kinds[1], (taken,))  # two coordinates carry two contacts
