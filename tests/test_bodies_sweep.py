"""Sweeps over models of any rig: the members of `simulate`, the named rig's own sweep, what is not observed."""

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.errors import InputError
from test_bodies_reference import LAWS, RIG, chain, drill, matrices

OBSERVED = (
    "final_state",
    "stick_fraction",
    "transitions",
    "releases",
    "slips",
    "period",
    "period_spread",
    "periodicity",
    "points",
)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_a_rebuilt_rig_sweeps_as_the_named_one(law: ss.PaperFriction) -> None:
    speeds, gains = np.array([0.08, 0.1, 0.15]), np.array([0.1, 0.2])
    settings = {"t_end": 120.0, "after": 40.0, "observe": OBSERVED, "rtol": 1e-10, "atol": 1e-10, "points": 6}
    named = ss.sweep(
        ss.Model(RIG, friction=law),
        {"belt_speed": speeds, "initial.x1": gains},
        initial=(0.1, 0.1, 0, 0),
        **settings,  # type: ignore[arg-type]
    )
    ours = ss.sweep(
        matrices(law),
        {"belt_speed": speeds, "initial.x1": gains},
        initial=(0.1, 0, 0.1, 0),
        **settings,  # type: ignore[arg-type]
    )
    order = ["x1", "v_x1", "y1", "v_y1"]
    np.testing.assert_allclose(ours.final_state.sel(state=order), named.final_state, atol=1e-6)
    np.testing.assert_allclose(ours.points.sel(state=order), named.points, atol=1e-6)
    for name in ("stick_fraction", "period", "period_spread"):
        np.testing.assert_allclose(ours[name], named[name], atol=1e-6)
    for name in ("transitions", "releases", "slips", "periodicity", "status"):
        np.testing.assert_array_equal(ours[name], named[name])


def test_members_are_those_of_simulate_whatever_varies() -> None:
    model = drill(ss.CoulombFriction(static=2, kinetic=1.2))
    over = {
        "link_1.stiffness": np.array([8.0, 12.0, 16.0]),
        "kinetic": np.array([1.0, 1.3]),
        "initial.bit": np.array([0.0, 0.05]),
    }
    ds = ss.sweep(model, over, drive_speed=0.5, t_end=4, rtol=1e-11, atol=1e-11, threads=2)
    assert ds.sizes == {"link_1.stiffness": 3, "kinetic": 2, "initial.bit": 2, "state": 4}
    for k in (0, 2):
        one = model.replace({"link_1.stiffness": over["link_1.stiffness"][k], "kinetic": 1.3})
        run = ss.simulate(one, drive_speed=0.5, initial=(0, 0.05, 0, 0), t_end=4, rtol=1e-11, atol=1e-11)
        np.testing.assert_array_equal(ds.final_state[k, 1, 1], run.state[-1])
        assert int(ds.transitions[k, 1, 1]) == len(run.transitions)
    assert '"drive_speed": 0.5' in ds.attrs["fixed"]


def test_laws_and_speeds_of_ones_own_are_swept(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    law = ss.LuGreFriction(sigma0=1e3, sigma1=30, sigma2=0.4, F_c=1, F_s=1.5, v_s=0.01)
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=2), friction=law)
    over = {"sigma2": np.array([0.2, 0.4]), "initial.z": np.array([0.0, 1e-3])}
    ds = ss.sweep(model, over, belt_speed="0.1 + 0.05*sin(t)", t_end=5, out=tmp_path / "result.zarr")
    run = ss.simulate(
        model, belt_speed="0.1 + 0.05*sin(t)", initial=(0, 0, 1e-3), t_end=5, rtol=1e-8, atol=1e-8
    )
    np.testing.assert_array_equal(ds.final_state[1, 1], run.state[-1])
    assert "0.1 + 0.05*sin(t)" in ds.attrs["fixed"]
    several = ss.sweep(
        chain(ss.CoulombFriction(static=1, kinetic=0.6)), {"belt_speed": [0.1, 0.3]}, t_end=30, after=10
    )
    assert ((several.stick_fraction > 0) & (several.stick_fraction < 1)).all()


def test_what_a_sweep_cannot_do_with_such_a_model_is_said_in_a_line() -> None:
    model = drill(ss.CoulombFriction(static=2, kinetic=1.2))
    for over, more, words in [
        (
            {"kinetic": [1.0]},
            {"drive_speed": 0.5, "observe": "state_max"},
            "'state_max' is observed of a named rig",
        ),
        ({"kinetic": [1.0]}, {}, "drive_speed: missing"),
        ({"drive_speed": [1.0]}, {"drive_speed": 1.0}, "varies in `over`"),
        ({"kinetik": [1.0]}, {"drive_speed": 0.5}, "did you mean 'kinetic'"),
        ({"kinetic": [1.0, 3.0]}, {"drive_speed": 0.5}, "above the static limit"),
        ({"belt_speed": [1.0]}, {"drive_speed": 0.5}, "belt_speed"),
    ]:
        with pytest.raises(InputError, match=words):
            ss.sweep(model, over, t_end=1, **more)  # type: ignore[arg-type]
