"""Figures of sweeps: drawn from what was observed, and refused with a sentence where that lacks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import stickslip as ss
from stickslip.errors import InputError
from stickslip.shown.plot import curves as plot
from stickslip.shown.plot import sweep as plot_sweep
from stickslip.simulated.sweep.units import unit_of

MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
LAW = ss.HyperbolicFriction(scale=0.5, decay=3, constant=0.5, quadratic=0.1)
BISTABLE = ss.Model(ss.BlockOnBelt(damping=0.0), friction=LAW)


def test_bifurcation_diagram_draws_every_point(tmp_path: Path) -> None:
    ds = ss.sweep(
        MODEL,
        {"belt_speed": np.linspace(0.1, 0.3, 6)},
        t_end=200,
        after=100,
        initial=(0.1, 0.1, 0, 0),
        observe=("points", "period"),
    )
    figure = plot_sweep.bifurcation_diagram(ds, "y1", select="period")
    drawn = figure.axes[0].collections[0].get_offsets()
    assert np.ma.count(drawn[:, 1]) == int(np.isfinite(ds.points[..., 2]).sum())
    assert "v_b" in figure.axes[0].get_xlabel()
    assert all(path.stat().st_size > 5000 for path in plot.save_figure(figure, tmp_path / "b"))
    with pytest.raises(ss.InputError, match="did you mean 'y1'"):
        plot_sweep.bifurcation_diagram(ds, "y11")


def test_parameter_map_has_the_values_in_place() -> None:
    a = np.linspace(8, 40, 5)
    over = {"belt_speed": np.linspace(0.1, 0.3, 4), "alpha1": ("a", a), "alpha2": ("a", a / 2)}
    ds = ss.sweep(MODEL, over, t_end=100, initial=(0.1, 0.1, 0, 0), observe=("stick_fraction", "releases"))
    for name in ("stick_fraction", "releases"):
        figure = plot_sweep.parameter_map(ds, name)
        drawn = figure.axes[0].collections[0].get_array()
        assert drawn is not None
        assert np.array_equal(np.asarray(drawn).ravel(), ds[name].values.astype(float).ravel())
        assert "alpha" in figure.axes[0].get_xlabel()


def in_si() -> ss.Model:
    rig = ss.BlockOnBelt(mass="1.2 kg", stiffness="2400 N/m", damping="2 N s/m")
    return ss.Model(rig, friction=ss.HyperbolicFriction(scale=3, decay=20, constant=5))


def bare(channels: dict[str, ss.Channel] | None = None) -> ss.Model:
    rig = ss.BlockOnBelt(mass=1.2, stiffness=2400, damping=2)
    return ss.Model(rig, friction=ss.HyperbolicFriction(scale=3, decay=20, constant=5), channels=channels)


def by_its_parts() -> ss.Model:
    rig = ss.BodiesRig(
        body={"b": ss.Body(mass=1.2)},
        link=[ss.Link(between=("b", "ground"), stiffness=2400, damping=2)],
        contact=[ss.Contact(body="b", against="belt")],
    )
    return ss.Model(rig, friction=ss.HyperbolicFriction(scale=3, decay=20, constant=5))


SHAFT = ss.Model(
    ss.BodiesRig(
        body={"s": ss.Body(inertia=1.0)},
        link=[ss.Link(between=("s", "ground"), stiffness=1.0)],
        contact=[ss.Contact(body="s", against="belt")],
    ),
    friction=ss.CoulombFriction(static=1.0, kinetic=0.5),
)
NAMES = ("belt_speed", "stiffness", "decay", "initial.x1", "initial.x2")
UNITS = ("m/s", "N/m", "s/m", "m", "m/s")


@pytest.mark.parametrize(
    ("model", "units"),
    [
        (in_si(), dict(zip(NAMES, UNITS, strict=True))),
        (
            bare({"t": ss.Channel("t", "s"), "x1": ss.Channel("x", "mm")}),
            {"mass": "kg", "damping": "N s/m"},
        ),
        (bare(), dict.fromkeys(NAMES, "1")),
        (
            by_its_parts(),
            {"belt_speed": "m/s", "link_1.damping": "N s/m", "decay": "s/m", "initial.v_b": "m/s"},
        ),
        (SHAFT, {"belt_speed": "rad/s", "s.inertia": "kg m^2", "initial.s": "rad", "static": "1"}),
        (MODEL, {"belt_speed": "1", "alpha1": "1", "initial.y1": "1"}),
    ],
)
def test_numbers_of_a_sweep_have_their_units(model: ss.Model, units: dict[str, str]) -> None:
    for name, unit in units.items():
        assert unit_of(model, name) == unit


def test_axes_of_a_map_have_the_units_of_a_rig_in_si() -> None:
    over = {"belt_speed": [0.05, 0.1, 0.2], "stiffness": [1200.0, 2400.0]}
    heads = {}
    for name, model in (("si", in_si()), ("bare", bare())):
        ds = ss.sweep(model, over, t_end=4, observe=("period", "final_state", "points"))
        figures = (
            plot_sweep.parameter_map(ds, "period"),
            plot_sweep.parameter_map(ds, "final_state", state="x2"),
            plot_sweep.bifurcation_diagram(ds, "x1", parameter="belt_speed"),
        )
        texts = [one.get_xlabel() + "; " + one.get_ylabel() for figure in figures for one in figure.axes]
        heads[name] = texts
    assert heads["si"] == [
        "stiffness [N/m]; $v_b$ [m/s]",
        "; mean time between releases [s]",
        "stiffness [N/m]; $v_b$ [m/s]",
        "; final_state of $x_2$ [m/s]",
        "$v_b$ [m/s]; $x_1$ at releases [m]",
    ]
    assert not any("[" in text for text in heads["bare"])


def test_basin_tells_sliding_from_stick_slip() -> None:
    over = {"initial.x2": np.linspace(-0.5, 2.0, 20), "initial.x1": np.linspace(-0.5, 2.0, 22)}
    ds = ss.sweep(BISTABLE, over, belt_speed=0.85, t_end=600, after=550, observe=("state_min", "state_max"))
    figure = plot_sweep.basin(ds, tolerance=0.05)
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert len(told) == 2
    assert any("cycle" in one for one in told)


def test_attractors_of_made_up_rows() -> None:
    rows = np.array([[0.0, 1], [0, 1.0001], [5, 6], [np.nan, 1], [0, 1], [5.0001, 6]])
    which, kinds, lumped = plot_sweep.attractors(rows)
    assert lumped is None
    assert np.array_equal(which, [0, 0, 1, np.nan, 0, 1], equal_nan=True)
    assert len(kinds) == 2
    assert plot_sweep.attractors(np.full((3, 2), np.nan))[1] == []


def test_what_is_in_no_large_group_is_not_called_an_attractor() -> None:
    rows = np.concatenate([np.zeros((30, 2)), np.ones((20, 2)), np.linspace(2, 9, 50)[:, None] * [1, 1]])
    which, kinds, lumped = plot_sweep.attractors(rows, most=4)
    assert lumped == 3
    assert len(kinds) == 4
    assert [int((which == i).sum()) for i in range(4)] == [30, 20, 1, 49]
    settled = np.concatenate([np.random.default_rng(0).normal(size=(64, 2)), np.zeros((300, 2))])
    which, _, lumped = plot_sweep.attractors(settled)
    assert int((which == 0).sum()) == 300  # wherever they stand
    assert lumped == 7
    over = {"initial.x2": np.linspace(-0.5, 2.0, 6), "initial.x1": np.linspace(-0.5, 2.0, 7)}
    ds = ss.sweep(BISTABLE, over, belt_speed=0.85, t_end=20, after=10, observe=("state_min", "state_max"))
    told = [text.get_text() for text in plot_sweep.basin(ds).legends[0].get_texts()]
    assert told[-1].startswith("others, or not settled")
    for wrong in (0, -1, np.nan):
        with pytest.raises(InputError, match="tolerance"):
            plot_sweep.basin(ds, tolerance=wrong)


def test_a_map_has_each_value_where_it_belongs() -> None:
    """Values in any order, and a single one: each has a cell of its own around it."""
    figure = Figure()
    x, y = np.array([0.3, 0.1, 0.2, 0.15]), np.array([5.0])
    mesh = plot_sweep.cells(figure.subplots(), x, y, np.array([[3.0, 1.0, 2.0, 1.5]]))
    corners = mesh.get_coordinates()
    np.testing.assert_allclose(corners[0, :, 0], [0.075, 0.125, 0.175, 0.25, 0.35])
    assert corners[0, 0, 1] < 5 < corners[1, 0, 1]
    np.testing.assert_array_equal(np.ravel(mesh.get_array()), [1.0, 1.5, 2.0, 3.0])


GRID = {"belt_speed": np.linspace(0.1, 0.3, 12), "alpha1": np.linspace(8, 40, 12)}
SEEN = ("points", "state_min", "state_max", "periodicity")


def test_a_diagram_of_a_grid_is_refused_and_says_what_to_choose() -> None:
    ds = ss.sweep(MODEL, GRID, t_end=100, initial=(0.1, 0.1, 0, 0), observe=SEEN)
    with pytest.raises(ss.InputError, match=r"cannot tell alpha1 \(12 values\) apart; .* ds\.sel\(") as told:
        plot_sweep.bifurcation_diagram(ds)
    advice = str(told.value).split("as in ")[1]
    plot_sweep.bifurcation_diagram(eval(advice, {"ds": ds}))
    with pytest.raises(ss.InputError, match="over alpha1 cannot tell belt_speed"):
        plot_sweep.bifurcation_diagram(ds, parameter="alpha1")


def test_a_second_parameter_of_few_values_has_its_colours() -> None:
    ds = ss.sweep(
        MODEL,
        GRID | {"alpha1": [8.0, 16.0]},
        t_end=100,
        initial=(0.1, 0.1, 0, 0),
        observe=("points", "period"),
    )
    figure = plot_sweep.bifurcation_diagram(ds)
    assert [one.get_text() for one in figure.legends[0].get_texts()] == [
        r"$\alpha_{1}$ = 8",
        r"$\alpha_{1}$ = 16",
    ]
    drawn = [one.get_offsets() for one in figure.axes[0].collections if len(one.get_offsets())]
    for one, alpha1 in zip(drawn, (8.0, 16.0), strict=True):
        expected = ds.points.sel(alpha1=alpha1, state="x1").values
        assert np.ma.count(one[:, 1]) == np.isfinite(expected).sum()
    with pytest.raises(ss.InputError, match="apart"):
        plot_sweep.bifurcation_diagram(ds, select="period")  # there is one colour a point


def test_a_diagram_over_many_starts_shows_all_attractors() -> None:
    over = {"belt_speed": np.linspace(0.6, 1.0, 5), "initial.x1": np.linspace(-0.5, 2.0, 12)}
    ds = ss.sweep(BISTABLE, over, t_end=100, observe="points")
    drawn = plot_sweep.bifurcation_diagram(ds).axes[0].collections[0].get_offsets()
    assert np.ma.count(drawn[:, 1]) == int(np.isfinite(ds.points[..., 0]).sum())


def test_a_basin_over_anything_but_starts_is_refused() -> None:
    ds = ss.sweep(MODEL, GRID, t_end=50, initial=(0.1, 0.1, 0, 0), observe=SEEN)
    with pytest.raises(ss.InputError, match=r"two initial values.*; belt_speed and alpha1 are not"):
        plot_sweep.basin(ds)
    over = {"initial.x1": [0.1, 0.2], "initial.x2": [0.0, 0.1, 0.2], "belt_speed": [0.1, 0.2]}
    ds = ss.sweep(MODEL, over, t_end=50, observe=SEEN)
    with pytest.raises(ss.InputError, match="belt_speed is not; choose one value") as told:
        plot_sweep.basin(ds)
    plot_sweep.basin(eval(str(told.value).split("as in ")[1], {"ds": ds}))
    ds = ss.sweep(MODEL, {"initial.x1": [0.1, 0.2]}, belt_speed=0.1, t_end=50, observe=SEEN)
    with pytest.raises(ss.InputError, match=r"needs two dimensions, has initial\.x1$"):
        plot_sweep.basin(ds)


def test_a_map_says_none_where_nothing_repeats() -> None:
    ds = ss.sweep(MODEL, GRID, t_end=100, initial=(0.1, 0.1, 0, 0), observe="periodicity")
    bar = plot_sweep.parameter_map(ds, "periodicity").axes[1]
    assert "none" in [one.get_text() for one in bar.get_yticklabels()]


def test_what_cannot_be_drawn_is_said() -> None:
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1, kinetic=0.5))
    ds = ss.sweep(model, {"belt_speed": [0.1, 0.2]}, t_end=30, observe=("points", "state_min"))
    for select in ("state_min", "points"):
        with pytest.raises(ss.InputError, match="choose a result with one for each member"):
            plot_sweep.bifurcation_diagram(ds, select=select)
    with pytest.raises(ss.InputError, match="no dimension left to draw along"):
        plot_sweep.bifurcation_diagram(ds.isel(belt_speed=0))
    with pytest.raises(ss.InputError, match="state = 0: unknown state"):
        plot_sweep.bifurcation_diagram(ds, 0)  # type: ignore[arg-type]
    with pytest.raises(ss.InputError, match="must be a Dataset, not None"):
        plot_sweep.parameter_map(None)  # type: ignore[arg-type]


def test_a_basin_is_the_same_whatever_the_order_of_the_dimensions() -> None:
    over = {"initial.x1": [0.0, 1.0], "initial.x2": [0.1, 0.2, 0.3]}
    ds = ss.sweep(BISTABLE, over, belt_speed=0.85, t_end=20, observe=("state_min", "state_max"))
    drawn = [
        np.asarray(plot_sweep.basin(one).axes[0].collections[0].get_array())
        for one in (ds, ds.transpose("state", ...))
    ]
    np.testing.assert_array_equal(*drawn)
    with pytest.raises(ss.InputError, match="one state left"):
        plot_sweep.basin(ds.isel(state=0))


def test_a_map_of_what_has_no_values_to_draw_over_is_refused() -> None:
    over = {"alpha1": [8.0, 16.0], "belt_speed": [0.1, 0.2, 0.3]}
    ds = ss.sweep(MODEL, over, t_end=20, observe=("points", "stick_fraction"))
    with pytest.raises(ss.InputError, match="no values along point; choose one value, as in ds"):
        plot_sweep.parameter_map(ds.isel(alpha1=0), "points", state="x1")
    with pytest.raises(ss.InputError, match=r"no values along alpha1; ds\.assign_coords"):
        plot_sweep.parameter_map(ds.drop_vars("alpha1"))


def test_a_map_has_no_cells_without_width() -> None:
    over = {"alpha2": ("i", [8.0, 8, 8]), "alpha1": ("i", [10.0, 12, 14]), "belt_speed": [0.1, 0.2]}
    ds = ss.sweep(MODEL, over, t_end=20)
    assert "alpha_{1}" in plot_sweep.parameter_map(ds).axes[0].get_ylabel()
    with pytest.raises(ss.InputError, match="alpha2 has the value 8 more than once"):
        plot_sweep.parameter_map(ds.drop_vars("alpha1"))


@pytest.mark.parametrize(
    ("i", "j", "turns"), [(1, 4, False), (2, 8, False), (11, 18, False), (11, 19, False), (30, 20, True)]
)
def test_where_two_releases_a_period_are_slips_that_take_turns(i: int, j: int, turns: bool) -> None:
    # the caption of the map in docs/sweeps.md
    speed, alpha1 = np.linspace(0.02, 0.3, 50)[i], np.linspace(8, 40, 50)[j]
    rig = ss.Rig(alpha1=float(alpha1), alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    model, start = ss.Model(rig, friction=ss.PaperFriction()), (0.1, 0.1, 0, 0)
    ds = ss.sweep(
        model, {"belt_speed": [speed]}, t_end=10000, after=9600, initial=start, observe=("periodicity",)
    )
    assert ds.periodicity.item() == 2
    run = ss.simulate(model, belt_speed=float(speed), initial=start, t_end=10000, max_transitions=10**6)
    late = run.transitions.t > 9600
    assert np.any(late & (run.transitions.before * run.transitions.after < 0)) == turns
