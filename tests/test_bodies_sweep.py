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
    "state_min",
    "state_max",
    "dissipated",
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
    for name in ("state_min", "state_max"):
        np.testing.assert_allclose(ours[name].sel(state=order), named[name], atol=1e-7)
    np.testing.assert_allclose(ours.dissipated, named.dissipated, rtol=1e-7)
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


def _moving_chain() -> tuple[ss.Model, dict[str, object]]:
    """Three blocks whose contacts all rub on a belt that changes its speed, and how they are run."""
    model = chain(ss.CoulombFriction(static=1, kinetic=0.6))
    return model, {"belt_speed": "0.2 + 0.15*sin(0.7*t)", "rtol": 1e-10, "atol": 1e-10}


def test_extremes_are_those_of_a_fine_trajectory_from_after_on() -> None:
    model, settings = _moving_chain()
    ds = ss.sweep(
        model, {"kinetic": [0.5, 0.6]}, t_end=30, after=11.3, observe=("state_min", "state_max"), **settings
    )  # type: ignore[arg-type]
    fine = ss.simulate(model, t_end=30, t_eval=np.linspace(11.3, 30, 200_001), **settings)  # type: ignore[arg-type]
    for name, there in (("state_min", fine.state.min(axis=0)), ("state_max", fine.state.max(axis=0))):
        np.testing.assert_allclose(ds[name][1], there, atol=1e-7)
    alone = ss.sweep(model, {"kinetic": [0.5, 0.6]}, t_end=30, after=11.3, **settings)  # type: ignore[arg-type]
    both = ss.sweep(
        model,
        {"kinetic": [0.5, 0.6]},
        t_end=30,
        after=11.3,
        observe=("final_state", "transitions", "state_max"),
        **settings,
    )  # type: ignore[arg-type]
    np.testing.assert_allclose(both.final_state, alone.final_state, atol=1e-8)
    np.testing.assert_array_equal(both.transitions, alone.transitions)


def test_the_work_of_friction_closes_the_balance_of_energy() -> None:
    """Drill string: the drive's work goes into the two inertias, the shafts, their damping, and friction."""
    model = drill(ss.CoulombFriction(static=2, kinetic=1.2))
    settings = {"drive_speed": 0.5, "rtol": 1e-11, "atol": 1e-11}
    for after in (0.0, 1.7):
        ds = ss.sweep(model, {"kinetic": [1.2]}, t_end=4, after=after, observe="dissipated", **settings)  # type: ignore[arg-type]
        run = ss.simulate(model, t_end=4, t_eval=np.linspace(after, 4, 400_001), **settings)  # type: ignore[arg-type]
        names = list(model.rig.state_names)
        v = run.state[:, names.index("v_bit")]
        # the bit rubs on the ground: what it loses is kinetic friction times the way it slips
        way = np.trapezoid(np.abs(v), run.t)
        np.testing.assert_allclose(ds.dissipated[0], 1.2 * way, rtol=1e-6)
        assert float(ds.dissipated[0]) > 0.1


def test_long_slips_of_a_linear_rig_keep_their_extremes() -> None:
    """A stretch that is crossed in one go where nobody looks is looked at step by step where somebody does."""
    rig = ss.MatricesRig(M=[[1.0]], C=[[0.0]], K=[[1.0]], contact=[1.0], names=["x"])
    model = ss.Model(rig, friction=ss.CoulombFriction(static=0.1, kinetic=0.1))
    over = {"initial.v_x": [0.5]}
    ds = ss.sweep(
        model,
        over,
        belt_speed=5.0,
        t_end=5000,
        after=4000.2,
        observe=("state_min", "state_max", "dissipated"),
        rtol=1e-10,
        atol=1e-10,
    )
    # about x = 0.1 with the amplitude of the start, always slower than the belt
    amplitude = np.hypot(0.1, 0.5)
    np.testing.assert_allclose(ds.state_max[0], [0.1 + amplitude, amplitude], rtol=1e-7)
    np.testing.assert_allclose(ds.state_min[0], [0.1 - amplitude, -amplitude], rtol=1e-7)
    x = 0.1 + amplitude * np.sin(np.array([4000.2, 5000.0]) + np.arctan2(-0.1, 0.5))
    np.testing.assert_allclose(ds.dissipated[0], 0.1 * (5.0 * 999.8 - (x[1] - x[0])), rtol=1e-8)


def test_compliant_contacts_lose_energy_too() -> None:
    law = ss.LuGreFriction(sigma0=1e3, sigma1=30, sigma2=0.4, F_c=1, F_s=1.5, v_s=0.01)
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=2), friction=law)
    settings = {"belt_speed": 0.1, "t_end": 20, "rtol": 1e-10, "atol": 1e-10}
    ds = ss.sweep(
        model, {"sigma2": [0.4]}, after=3.0, observe=("dissipated", "state_max", "state_min"), **settings
    )  # type: ignore[arg-type]
    fine = ss.simulate(model, t_eval=np.linspace(3.0, 20, 300_001), **settings)  # type: ignore[arg-type]
    x, v = fine.state.T
    # the belt's work, its speed times the impulse of friction, less what spring and mass keep of it
    impulse = -(v[-1] - v[0]) - 2 * np.trapezoid(x, fine.t)
    kept = np.diff((0.5 * v**2 + x**2)[[0, -1]])[0]
    np.testing.assert_allclose(ds.dissipated[0], -kept - 0.1 * impulse, rtol=1e-6)
    np.testing.assert_allclose(ds.state_max[0], [x.max(), v.max()], atol=1e-7)


def test_what_a_sweep_cannot_do_with_such_a_model_is_said_in_a_line() -> None:
    model = drill(ss.CoulombFriction(static=2, kinetic=1.2))
    for over, more, words in [
        ({"kinetic": [1.0]}, {}, "drive_speed: missing"),
        ({"drive_speed": [1.0]}, {"drive_speed": 1.0}, "varies in `over`"),
        ({"kinetik": [1.0]}, {"drive_speed": 0.5}, "did you mean 'kinetic'"),
        ({"kinetic": [1.0, 3.0]}, {"drive_speed": 0.5}, "above the static limit"),
        ({"belt_speed": [1.0]}, {"drive_speed": 0.5}, "belt_speed"),
    ]:
        with pytest.raises(InputError, match=words):
            ss.sweep(model, over, t_end=1, **more)  # type: ignore[arg-type]
