"""Sweeps: every result against single runs of `simulate`, lanes against the scalar kernel, whatever the threads."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import stickslip as ss
from stickslip.simulated.sweep.observables import OBSERVABLES, periodicity
from stickslip.simulated.sweep.request import GridBlock, Request

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
PAPER = ss.Model(RIG, friction=ss.PaperFriction())
DAMPED = ss.Model(RIG, friction=ss.PaperFriction(), effects=[ss.effect("block_viscous_damping", c=0.5)])
LEINE = ss.Model(ss.BlockOnBelt(), friction=ss.HyperbolicFriction(scale=1, decay=3))
COULOMB = ss.Model(ss.BlockOnBelt(damping=0.05), friction=ss.CoulombFriction(static=1, kinetic=0.5))
ALL = tuple(OBSERVABLES)
T_END, AFTER = 90.0, 40.0
GRIDS: dict[str, tuple[ss.Model, dict[str, Any], tuple[float, ...]]] = {
    "paper": (
        PAPER,
        {"belt_speed": np.linspace(-0.2, 0.3, 5), "alpha1": np.linspace(8, 40, 4)},
        (0.1, 0.1, 0, 0),
    ),
    "effect": (
        DAMPED,
        {"block_viscous_damping.c": [0.0, 0.4, 0.9], "belt_speed": [0.05, 0.15]},
        (0.1, 0.1, 0, 0),
    ),
    "hyperbolic": (LEINE, {"belt_speed": [0.1, 0.5, 0.9, 1.4], "initial.x1": [0.5, 2.0]}, (0, 0.3)),
    "coulomb": (COULOMB, {"static": [0.8, 1.0, 1.6], "belt_speed": [-0.3, 0.2]}, (1.5, 0.0)),
}


def swept(kind: str, **settings: Any) -> xr.Dataset:
    model, over, initial = GRIDS[kind]
    given = {"t_end": T_END, "after": AFTER, "initial": initial, "observe": ALL, "rtol": 1e-10, "atol": 1e-10}
    return ss.sweep(model, over, **(given | settings))


def alone(kind: str, place: dict[str, float]) -> ss.Trajectory:
    """The run of one member, densely sampled from `after` on."""
    model, _, initial = GRIDS[kind]
    start = list(initial)
    numbers = dict(place)
    speed = numbers.pop("belt_speed")
    for name in [name for name in numbers if name.startswith("initial.")]:
        start[model.rig.state_names.index(name.removeprefix("initial."))] = numbers.pop(name)
    return ss.simulate(
        model.replace(numbers),
        belt_speed=speed,
        initial=start,
        t_end=T_END,
        t_eval=np.linspace(AFTER, T_END, 20001),
    )


def friction_force(model: ss.Model, run: ss.Trajectory, place: dict[str, float]) -> np.ndarray:
    law = model.replace({k: v for k, v in place.items() if k in model.parameters}).friction
    return np.asarray(law.force(run.state[:, 1] - place["belt_speed"]))


@pytest.fixture(scope="module", params=list(GRIDS))
def case(request: pytest.FixtureRequest) -> tuple[str, xr.Dataset]:
    return request.param, swept(request.param)


def members(ds: xr.Dataset, kind: str) -> list[tuple[xr.Dataset, dict[str, float]]]:
    names = list(GRIDS[kind][1])
    places = itertools.product(*(ds[name].values.tolist() for name in names))
    named = [dict(zip(names, at, strict=True)) for at in places]
    return [(ds.sel(place), place) for place in named]


def test_every_result_is_that_of_a_single_run(case: tuple[str, xr.Dataset]) -> None:
    kind, ds = case
    assert (ds.status == 0).all()
    for one, place in members(ds, kind):
        run = alone(kind, place)
        tr = run.transitions
        seen = tr.t >= AFTER
        away = seen & (tr.after != 0)
        assert np.abs(one.final_state.values - run.state[-1]).max() < 2e-7, place
        assert int(one.transitions) == int(seen.sum()), place
        assert int(one.releases) == int(away.sum()), place
        assert int(one.slips) == int((away & (tr.before == 0)).sum()), place
        assert abs(float(one.stick_fraction) - np.mean(run.mode == 0)) < 2e-4 * (1 + seen.sum()), place
        assert abs(float(one.stick_fraction) - stick_share(run)) < 1e-7, place
        assert np.allclose(one.state_min.values, run.state.min(axis=0), rtol=0, atol=3e-5), place
        assert np.allclose(one.state_max.values, run.state.max(axis=0), rtol=0, atol=3e-5), place
        assert (one.state_max.values >= run.state.max(axis=0) - 2e-7).all(), place
        assert (one.state_min.values <= run.state.min(axis=0) + 2e-7).all(), place
        releases = tr.t[away]
        if len(releases) > 1:
            assert abs(float(one.period) - np.diff(releases).mean()) < 1e-6
            assert abs(float(one.period_spread) - np.diff(releases).std()) < 1e-5
        else:
            assert np.isnan(float(one.period))
        kept = min(len(releases), one.sizes["point"])
        assert np.allclose(one.point_time.values[:kept], releases[::-1][:kept], rtol=0, atol=1e-6)
        assert np.allclose(one.points.values[:kept], tr.state[away][::-1][:kept], rtol=0, atol=1e-6)
        assert np.isnan(one.points.values[kept:]).all()


def stick_share(run: ss.Trajectory) -> float:
    """Stuck part of AFTER..T_END from the transitions' times."""
    edges = np.concatenate([[AFTER], run.transitions.t[run.transitions.t >= AFTER], [T_END]])
    modes = np.concatenate([[run.mode[0]], run.transitions.after[run.transitions.t >= AFTER]])
    return float(np.diff(edges)[modes == 0].sum() / (T_END - AFTER))


@pytest.mark.parametrize("kind", GRIDS)
def test_dissipated_is_the_integral_of_the_friction_power(kind: str) -> None:
    ds = swept(kind, observe="dissipated")
    for one, place in members(ds, kind):
        run = alone(kind, place)
        power = friction_force(GRIDS[kind][0], run, place) * (run.state[:, 1] - place["belt_speed"])
        power[run.mode == 0] = 0.0
        told = np.trapezoid(power, run.t)
        assert abs(float(one.dissipated) - told) < 2e-4 * max(1.0, abs(told)), place


@pytest.mark.parametrize("kind", GRIDS)
def test_lanes_are_the_scalar_kernel_within_rounding(kind: str) -> None:
    lanes, scalar = swept(kind), swept(kind, lanes=False)
    for name in ALL:
        # the spread is the root of a difference of squares: of rounding, sqrt(1e-16) of the period is left
        atol = 1e-6 if name == "period_spread" else 1e-7
        assert np.allclose(lanes[name], scalar[name], rtol=1e-9, atol=atol, equal_nan=True), name


def many(**settings: Any) -> xr.Dataset:
    over = {"belt_speed": np.linspace(0.02, 0.3, 40), "alpha1": np.linspace(8, 40, 30)}
    given = {"t_end": 60, "after": 20, "initial": (0.1, 0.1, 0, 0), "observe": ALL}
    return ss.sweep(PAPER, over, **(given | settings))


def test_threads_do_not_change_a_bit() -> None:
    one = many(threads=1)
    for threads in (2, 3):
        assert one.identical(many(threads=threads))


def test_a_subset_observes_the_same() -> None:
    every = many(threads=2)
    for name in ("transitions", "final_state", "stick_fraction"):
        assert np.allclose(many(observe=name)[name], every[name], rtol=0, atol=1e-9)


def test_shared_dimension_and_coordinates() -> None:
    a = np.linspace(8, 40, 6)
    ds = ss.sweep(
        PAPER,
        {"alpha1": ("member", a), "alpha2": ("member", a / 2), "belt_speed": [0.1, 0.2]},
        t_end=50,
        initial=(0.1, 0.1, 0, 0),
    )
    assert ds.final_state.dims == ("member", "belt_speed", "state")
    assert "alpha1" not in ds.indexes
    assert "belt_speed" in ds.indexes
    for i in range(6):
        rig = ss.Rig(alpha1=a[i], alpha2=a[i] / 2, beta3=4, eta1=0.1, eta12=0.2)
        run = ss.simulate(
            ss.Model(rig, friction=ss.PaperFriction()),
            belt_speed=0.2,
            initial=(0.1, 0.1, 0, 0),
            t_end=50,
            t_eval=[50],
        )
        assert np.abs(ds.final_state[i, 1].values - run.state[-1]).max() < 1e-6


def test_a_name_for_both_directions_moves_both() -> None:
    law = {"static": [1.3], "belt_speed": [-0.2, 0.2]}
    ds = ss.sweep(COULOMB, law, t_end=40, initial=(0, 0), observe=("state_max", "state_min"))
    # mirror images: had only one direction moved, they would not be
    assert np.allclose(ds.state_max[0, 1], -ds.state_min[0, 0], atol=1e-6)
    assert abs(float(ds.state_max[0, 1, 0]) - 1.3) < 0.2


def test_attributes_tell_where_it_comes_from() -> None:
    ds = many(observe="final_state")
    assert ds.attrs["version"] == ss.__version__
    assert "compiler" in ds.attrs["build_config"]
    assert "T_s_minus = 5.94" in ds.attrs["model"]
    assert (ds.attrs["rtol"], ds.attrs["t_end"], ds.attrs["after"]) == (1e-8, 60.0, 20.0)
    assert len(ds.status.flag_values) == len(ds.status.flag_meanings.split())
    assert ds.final_state.units == "1"
    assert "alpha1" in ds.coords


def test_a_failing_member_does_not_stop_the_others() -> None:
    runaway = ss.Model(RIG, friction=ss.PaperFriction(), effects=[ss.effect("spring_cubic_k1", k=1.0)])
    over = {"spring_cubic_k1.k": [0.5, -400.0, 1.0], "belt_speed": [0.1]}
    ds = ss.sweep(runaway, over, t_end=40, initial=(0.5, 0.1, 0, 0), observe=ALL)
    meanings = dict(zip(ds.status.flag_values, ds.status.flag_meanings.split(), strict=True))
    told = [meanings[int(flag)] for flag in ds.status[:, 0]]
    assert told[0] == told[2] == "finished"
    assert told[1] in ("not_finite", "step_too_small")
    assert np.isnan(ds.stick_fraction[1, 0])
    assert int(ds.transitions[1, 0]) == -1
    assert (ds.transitions[[0, 2], 0] > 0).all()


def test_too_many_transitions_is_a_status() -> None:
    ds = many(max_transitions=5)
    assert "too_many_transitions" in ds.status.flag_meanings
    assert (ds.status == 4).any()


def test_periodicity_of_made_up_points() -> None:
    def sequence(k: int, n: int = 12) -> np.ndarray:
        out = np.full((12, 2), np.nan)
        out[:n, 0] = 1 + np.arange(n) % k
        out[:n, 1] = 0.3
        return out

    noisy = sequence(1)
    noisy[:, 0] += np.linspace(0, 1e-3, 12)
    cases = [sequence(1), sequence(2), sequence(3), sequence(6), sequence(7), sequence(2, 3), noisy]
    cases.append(np.full((12, 2), np.nan))
    assert periodicity(np.array(cases)).tolist() == [1, 2, 3, 6, 0, 0, 0, 0]


def test_periodicity_of_a_cycle() -> None:
    ds = ss.sweep(LEINE, {"belt_speed": [0.1, 0.3]}, t_end=300, after=150, initial=(0, 0.3), observe=ALL)
    assert ds.periodicity.values.tolist() == [1, 1]
    cycle = ss.limit_cycle(LEINE, belt_speed=0.1, guess=ds.points[0, 0].values)
    assert abs(float(ds.period[0]) - cycle.period) < 1e-5


def test_a_forbidden_combination_is_found_among_many() -> None:
    model = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.6), friction=ss.PaperFriction())
    over = {"alpha1": (12, 20), "alpha2": (6, 10), "eta1": (0.1, 0.3), "eta12": (0.6, 0.2)}
    grid = {name: np.linspace(*ends, 8) for name, ends in over.items()}
    with pytest.raises(ss.InputError, match="eta12"):
        ss.sweep(model, grid, belt_speed=0.1, t_end=1)


def test_batches_cover_a_chunk_and_grow_smaller_at_the_very_end_alone():
    request = SimpleNamespace(batch=256, grid=SimpleNamespace(members=4096))
    cuts = {stop: Request.batches(request, GridBlock(stop - 512, stop, ())) for stop in (512, 4096)}
    assert cuts[512] == [(0, 256), (256, 512)]
    assert cuts[4096] == [(3584, 3840), (3840, 3968), (3968, 4032), (4032, 4096)]
    request.grid.members = 10
    assert Request.batches(request, GridBlock(0, 10, ())) == [(0, 10)]
