"""Names of a user's own that look like those the package gives: the right answer, or one line that says so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import stickslip as ss
from bodies_cases import CASES, recorded, recording
from stickslip.cli.commands import main
from stickslip.declared.candidate import on_rig
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import bench_of
from stickslip.errors import InputError
from stickslip.shown.report.places import unit_at, unit_of

COULOMB = ss.CoulombFriction(static=1.0, kinetic=0.5)


def rig(body: str, *, law: str = "", turns: bool = False) -> ss.BodiesRig:
    one = ss.Body(inertia=2.0) if turns else ss.Body(mass=2.0)
    return ss.BodiesRig(
        body={body: one},
        link=[ss.Link(between=(body, "ground"), stiffness=3.0)],
        contact=[ss.Contact(body=body, against="belt", law=law)],
    )


@pytest.mark.parametrize("name", ["link_1", "contact_1", "initial", "gain", "offset"])
def test_a_body_called_like_what_is_no_body_is_refused(name: str) -> None:
    """The mass of "link_1" was none of the model's numbers; a sweep of "initial.mass" swept nothing."""
    with pytest.raises(InputError, match=rf"body {name}: is what .* is called; name it otherwise"):
        rig(name)


@pytest.mark.parametrize("name", ["link_arm", "contact_arm", "link_2"])
def test_a_body_that_only_looks_like_a_link_is_a_body(name: str) -> None:
    assert ss.Model(rig(name), friction=COULOMB).parameters[f"{name}.mass"] == 2.0
    assert unit_at(rig(name, turns=True), "block_viscous_damping", name, "c") == "N m s/rad"
    assert unit_of(rig(name), f"{name}.mass") == "kg"


def test_a_coordinate_called_like_a_link_moves_as_far_as_it_does() -> None:
    """`discover` took "link_x" for a link with a number, and fell."""
    case = CASES["pin"]()
    plain, odd = (
        replace(case, model=replace(case.model, rig=replace(case.model.rig, names=names)), channels=names)
        for names in (case.channels, ("link_x", "across"))
    )
    sizes = []
    for one in (plain, odd):
        run = recording(one, *recorded(case, 3, level=0.02, static=0.02, lasts=2.0))
        bench = bench_of(one.model, [run], Uncertainty.usual(one.model.rig, channels=one.channels))
        kinds = [kind for kind in bench.kinds() if kind.where == one.channels[0]]
        sizes.append([bench.size_of(kind) for kind in kinds])
    assert sizes[0]
    assert sizes[0] == sizes[1]


def test_a_derivative_by_the_mass_of_a_body_called_like_a_contact() -> None:
    """It was refused as a lever arm at which an effect acts."""
    drift = ss.effect("friction_drift", r=0.01)
    models = [ss.Model(rig(name), friction=COULOMB, effects=[drift]) for name in ("contact_a", "b")]
    ours, theirs = (
        ss.simulate(model, belt_speed=0.1, initial=(0, 0), t_end=5.0, sensitivity=[f"{name}.mass"])
        for model, name in zip(models, ("contact_a", "b"), strict=True)
    )
    np.testing.assert_array_equal(ours.sensitivity, theirs.sensitivity)


@pytest.mark.parametrize("on", [rig("a", law="a"), ss.BlockOnBelt()], ids=["bodies", "block"])
def test_a_law_whose_number_is_called_like_one_of_the_rig_is_refused(
    on: ss.BodiesRig | ss.BlockOnBelt,
) -> None:
    """Of the two one was shown, and the other was changed."""
    law = ss.FormulaFriction(kinetic="mass", static="2*mass", mass=4.0)
    friction = {"a": law} if isinstance(on, ss.BodiesRig) else law
    with pytest.raises(InputError, match=r"mass: names a number of the rig, too; call the law's number"):
        ss.Model(on, friction=friction)


def test_a_law_with_a_dot_in_its_name_is_refused() -> None:
    """`replace({"a.b.static": 9})` changed nothing."""
    with pytest.raises(InputError, match=r"'a\.b': a law's name has no dot"):
        ss.Model(rig("a", law="a.b"), friction={"a.b": COULOMB})


@pytest.mark.parametrize("name", ["gain", "offset", "initial"])
def test_a_law_called_like_what_a_sensor_or_a_start_has_is_refused(name: str) -> None:
    """`identify` fell over "offset.static", an offset of a channel that is not there."""
    with pytest.raises(InputError, match=rf"'{name}': is what .* is called; name the law otherwise"):
        ss.Model(rig("a", law=name), friction={name: COULOMB})


@pytest.mark.parametrize(("name", "what"), [("bit", "a part of the rig"), ("rock", "a law")])
def test_an_effect_called_like_a_part_or_a_law_is_refused(name: str, what: str) -> None:
    """Its numbers and those of the other had one owner: `discover` took the one out with the other."""
    model = ss.Model(rig("bit", law="rock"), friction={"rock": COULOMB})
    drag = {"where": "bit", "force": "-k*deflection_rate**3"}
    words = f"is what {what} is called; call the effect otherwise"
    with pytest.raises(InputError, match=words):
        model.with_effects([ss.effect("formula", called=name, k=1.0, **drag)])
    with pytest.raises(InputError, match=words):
        on_rig(ss.candidate(name, ranges={"k": [0, 5]}, **drag), model.rig, model.friction)


def test_a_formula_called_like_an_effect_of_the_catalogue_is_refused() -> None:
    """A force called "sensor_gain" with a number e was taken for a gain of the sensor as well."""
    force = ss.effect("formula", called="sensor_gain", where="block", force="-e*x1", e=1.0)
    with pytest.raises(InputError, match="'sensor_gain': is an effect of the catalogue"):
        ss.Model(ss.BlockOnBelt(), friction=COULOMB, effects=[force])


def test_the_band_of_a_channel_is_no_other_channel() -> None:
    """The forecast of "along_low" was written over by the lower end of the band of "along"."""
    case = CASES["pin"]()
    names = ("along", "along_low")
    odd = replace(case, model=replace(case.model, rig=replace(case.model.rig, names=names)), channels=names)
    run = recording(odd, *recorded(case, 11, level=0.02, static=0.02, lasts=3.0))
    with pytest.raises(InputError, match="'along_low' names a channel and the band of 'along'"):
        ss.forecast(odd.model, run, horizon=0.3)


def test_of_two_effects_with_a_number_of_one_name_the_wrong_one_is_named() -> None:
    """A sweep said of the amplitude of the seam, 0.1, that it must be at most 1: the ripple's was 1.5."""
    seam, ripple = ss.effect("belt_seam", a=0.1, L=1), ss.effect("belt_speed_ripple", a=0.1, w=1)
    model = ss.Model(ss.BlockOnBelt(), friction=COULOMB, effects=[seam, ripple])
    over = {"belt_seam.a": [0.1, 0.2], "belt_speed_ripple.a": [0.5, 1.5]}
    with pytest.raises(InputError, match=r"over\['belt_speed_ripple.a'\]: entry 1 is 1.5: must be at most 1"):
        ss.sweep(model, over=over, belt_speed=0.1, initial=(0, 0), t_end=5.0)


def test_a_contact_with_a_dot_in_its_name_is_a_place() -> None:
    """Its effect was sought at a contact "a" with a number "b"."""
    body = {"block": ss.Body(mass=1.0), "other": ss.Body(mass=1.0)}
    contacts = [
        ss.Contact(body="block", against="belt", name="a.b"),
        ss.Contact(body="other", against="belt"),
    ]
    links = [ss.Link(between=(one, "ground"), stiffness=3.0) for one in body]
    two = ss.BodiesRig(body=body, link=links, contact=contacts)
    law = ss.FormulaFriction(kinetic="N*0.3", static="N*0.5", N=2.0)
    drift = {"called": "drift", "factor": "1 + r*t", "r": 0.1}
    for where in ("a.b", "a.b.N"):
        model = ss.Model(two, friction={"law": law}, effects=[ss.effect("formula", where=where, **drift)])
        run = ss.simulate(model, belt_speed=0.1, initial=(0, 0, 0, 0), t_end=20.0)
        assert abs(run.state[-1, 0] - run.state[-1, 1]) > 1e-3  # the other block feels no drift


def test_what_is_odd_about_a_column_with_a_colon_in_its_name_is_said(tmp_path: Path) -> None:
    """A new case left out what was odd about "laser: near", which it took for another column's."""
    t = np.arange(0.0, 12.0, 0.002)
    run = ss.simulate(
        ss.Model(ss.BlockOnBelt(mass=0.5, stiffness=500.0), friction=ss.CoulombFriction(static=2, kinetic=1.2)),
        belt_speed=0.005, initial=(0.0, 0.005), t_end=t[-1], t_eval=t,
    )  # fmt: skip
    x = run.x1 + 1e-6 * np.random.default_rng(0).standard_normal(t.size)
    x[3000] += 1.0
    said = []
    for name in ("near", "laser: near"):
        folder = tmp_path / name.replace(": ", "-")
        folder.mkdir()
        np.savetxt(
            folder / "run.csv",
            np.column_stack([t, x]),
            delimiter=",",
            header=f"Time [s],{name} [m]",
            comments="",
            fmt="%.9g",
        )
        given = ["--constant", "m=0.5", "--constant", "k=500", "--belt-speed", "5 mm/s"]
        told = CliRunner().invoke(main, ["init", str(folder / "run.csv"), *given])
        assert told.exit_code == 0, told.output
        said.append((folder / "rig.toml").read_text().partition("# what is odd")[2].replace(name, "it"))
    assert said[0]
    assert said[0] == said[1]


@pytest.mark.parametrize("law", ["rock", ""])
def test_a_law_s_number_called_mass_is_in_no_kilograms(law: str) -> None:
    """So a table and a sweep had it; of one called stiffness they fell."""
    friction = ss.FormulaFriction(kinetic="mass", static="mass + stiffness", mass=4.0, stiffness=1.0)
    model = ss.Model(rig("a", law=law), friction={"rock": friction} if law else friction)
    names = [f"{law}.{key}" if law else key for key in ("mass", "stiffness")]
    over = {name: [4.0, 5.0] for name in names} | {"a.mass": [2.0, 3.0]}
    given = {"belt_speed": 0.1, "initial": (0, 0), "t_end": 1.0}
    swept = ss.sweep(model, over=over, observe="final_state", **given)
    assert [swept[name].attrs.get("units") for name in over] == ["1", "1", "kg"]


def test_a_formula_s_number_called_like_a_law_s_has_its_own_unit() -> None:
    """A decay in seconds was shown in s/m, as the hyperbolic law has its own."""
    law = ss.FormulaFriction(
        kinetic="scale*(1 + decay*rate)", static="2*scale", scale="4 N", decay="2 s", rate="0.1 1/s"
    )
    model = ss.Model(ss.BlockOnBelt(mass="1 kg", stiffness="3 N/m"), friction=law)
    swept = ss.sweep(model, over={"decay": [1.0, 2.0]}, belt_speed=0.1, initial=(0, 0), t_end=1.0)
    assert swept["decay"].attrs["units"] == "s"
    assert "s/m" not in model._repr_html_()
