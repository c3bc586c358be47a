"""The figures of a report say what they show: units, axes that can be read, colours that are explained."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import found_by_hand
import stickslip as ss
from stickslip.discovery.laboratory.block_errors import METRIC
from stickslip.discovery.result import ErrorBlock, Found
from stickslip.shown.report import (
    figures,
    figures_friction,
    figures_motion,
    figures_numbers,
    figures_residual,
)
from stickslip.shown.report.units import Axes, axes_of

ROOT = Path(__file__).parent.parent


def made(tmp_path: Path, verdict: str = "effect_found") -> tuple[Found, Axes]:
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=True))
    return found_by_hand.found(case, verdict=verdict), axes_of(case)


def legend(figure: figures.Figure) -> list[str]:
    return [one.get_text() for one in figure.legends[0].get_texts()]


def readable(ax: figures.Plot, least: int = 3) -> bool:
    """Whether the x axis has a few labelled ticks in sight."""
    ax.figure.draw_without_rendering()
    low, high = ax.get_xlim()
    shown = zip(ax.get_xticks(), ax.get_xticklabels(), strict=True)
    return least <= sum(low <= at <= high and bool(text.get_text()) for at, text in shown) <= 12


def test_errors_start_at_zero_and_the_floor_is_called_an_estimate(tmp_path: Path) -> None:
    found, axes = made(tmp_path, "no_effect")
    close = ErrorBlock(METRIC, 0.005107, 0.005107, 0.005144, ())
    figure = figures_numbers.errors(dataclasses.replace(found, error=close), axes)
    (ax,) = figure.axes
    assert ax.get_xlim()[0] == 0.0
    assert readable(ax)
    assert "floor: what noise alone leaves, estimated" in legend(figure)
    assert "single events" in ax.get_xlabel()


@pytest.mark.parametrize("values", [(0.96, 0.99), (0.63, 2.0), (0.8, 30.0), (0.9, 4e4)])
def test_parts_have_an_axis_that_can_be_read(tmp_path: Path, values: tuple[float, float]) -> None:
    found, axes = made(tmp_path, "no_effect")
    parts = tuple(
        dataclasses.replace(found.residual_before.parts[0], name=f"{i}", chi2=chi2, error=0.01)
        for i, chi2 in enumerate(values)
    )
    residual = dataclasses.replace(found.residual_before, parts=parts)
    (ax,) = figures_numbers.parts(dataclasses.replace(found, residual_before=residual), axes).axes
    assert readable(ax)
    low, high = ax.get_xlim()
    assert low < min(*values, 1.0) <= max(*values, 1.0) < high


def test_ranking_where_nothing_is_named_says_why_the_declared_law_stands(tmp_path: Path) -> None:
    found, axes = made(tmp_path, "no_effect")
    figure = figures_numbers.ranking(found, axes)
    assert "Nothing is named" in figure.legends[0].get_title().get_text()
    assert "kept" in legend(figure)
    assert "-2 log evidence" in figure.axes[0].get_xlabel()
    dots = [line.get_xdata()[0] for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert dots == [max(one.bic, 1.0) for one in reversed(found.ranking)]
    single = dataclasses.replace(found, error=dataclasses.replace(found.error, metric=METRIC))
    figure = figures_numbers.ranking(single, axes)
    assert "per number of the events" in figure.axes[0].get_xlabel()
    assert "what events differ by anyway" in legend(figure)


def test_ranking_fits_its_sheet_with_long_names(tmp_path: Path) -> None:
    found, axes = made(tmp_path)
    long = tuple(dataclasses.replace(one, names=(*one.names, "belt_speed_ripple")) for one in found.ranking)
    figure = figures_numbers.ranking(dataclasses.replace(found, ranking=long * 3), axes)
    figure.draw_without_rendering()
    ax = figure.axes[0]
    assert not figure.legends[0].get_title().get_text()
    for artist in (ax.xaxis.label, *ax.get_yticklabels(), *ax.texts, figure.legends[0]):
        box = artist.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.width


def test_every_panel_over_a_variable_explains_both_models(tmp_path: Path) -> None:
    found, axes = made(tmp_path)
    told = legend(figures_residual.against_variable(found, axes))
    assert [one.split(",")[0] for one in told] == ["before", "after"]
    (tmp_path / "none").mkdir()
    found, axes = made(tmp_path / "none", "no_effect")
    figure = figures_residual.against_variable(found, axes)
    assert [one.split(",")[0] for one in legend(figure)] == ["declared model"]
    assert figure.axes[0].get_title() == ""
    assert figures_residual.NOISE in legend(figures_residual.in_time(found, axes))


def test_a_portrait_names_its_run_apart_from_its_axis(tmp_path: Path) -> None:
    found, axes = made(tmp_path)
    ax = figures.portrait(found, axes).axes[0]
    run = figures.shown_runs(found)[0].name
    assert ax.get_title(loc="left") == run
    assert run not in ax.get_ylabel()


def test_the_name_of_a_run_is_clear_of_the_titles(tmp_path: Path) -> None:
    found, axes = made(tmp_path)
    long = tuple(dataclasses.replace(run, name=f"{run.name}_at_eleven_hundred") for run in found.runs)
    figure = figures.portrait(dataclasses.replace(found, runs=long), axes)
    figure.draw_without_rendering()
    ax = figure.axes[0]
    model, run = ax.title.get_window_extent(), ax._left_title.get_window_extent()
    assert model.x0 < run.x1  # side by side there is no room
    assert model.y0 + model.height / 2 >= run.y0 + 0.9 * run.height  # the lower of its two lines is empty


def forces(figure: figures.Figure) -> tuple[float, float]:
    low, high = figure.axes[0].get_ylim()
    return low, high


def test_friction_is_drawn_where_the_block_slips(tmp_path: Path) -> None:
    found, axes = made(tmp_path)
    law = found.before.friction
    unseen = dataclasses.replace(found.before, friction=dataclasses.replace(law, T_s_plus=60.0))
    no_plus = lambda run: {name: np.minimum(getattr(run, name), 0) for name in ("mode_before", "mode_after")}  # noqa: E731
    runs = tuple(dataclasses.replace(run, **no_plus(run)) for run in found.runs)
    one_way = dataclasses.replace(found, before=unseen, runs=runs)
    low, high = forces(figures_friction.friction(one_way, axes))
    assert low < -axes.force.size * law.T_s_minus
    assert high < 30.0 * axes.force.size
    told = legend(figures_friction.friction(found, axes))
    assert "limits of sticking, at $v_w$ = 0" in told
    assert "from the readings" in told


def test_friction_says_which_force_its_points_contain(tmp_path: Path) -> None:
    found, axes = made(tmp_path)
    damping = dataclasses.replace(found.effects[0], name="block_viscous_damping", where="block")
    with_force = dataclasses.replace(found, effects=(damping,))
    told = legend(figures_friction.friction(with_force, axes))
    assert "from the readings, with the force of block_viscous_damping" in told
    assert figures_friction.contained(found) == []
    of_rig = found_by_hand.with_effect(found, found_by_hand.of_rig({"alpha2": 7.0}))
    assert figures_friction.contained(of_rig) == []
    assert "law with alpha2 mended" in legend(figures_friction.friction(of_rig, axes))


def test_panels_in_time_share_a_scale_or_say_so(tmp_path: Path) -> None:
    found, axes = made(tmp_path)
    left, right = figures_residual.in_time(found, axes).axes[:2]
    assert left.get_ylim()[1] > figures_residual.ALIKE * right.get_ylim()[1]
    assert [text.get_text().startswith("scale ") for text in right.texts] == [True]
    assert not left.texts
    same = tuple(dataclasses.replace(run, after=run.before) for run in found.runs)
    left, right = figures_residual.in_time(dataclasses.replace(found, runs=same), axes).axes[:2]
    assert left.get_ylim() == right.get_ylim()
    assert not right.texts


def test_a_block_on_a_belt_declared_in_si_has_its_force_in_newtons() -> None:
    axes = axes_of(ss.load_case(ROOT / "examples" / "paper_slider"))
    assert (axes.force.size, axes.force.unit) == (1.0, "N")
    assert np.isfinite(axes.t.size)


def test_a_force_that_is_read_is_not_called_a_displacement(tmp_path: Path) -> None:
    """The axis said x1 [N]."""
    found, axes = made(tmp_path)
    assert axes.sensed == "x1"
    forced = dataclasses.replace(axes, sensed="spring force", x1=dataclasses.replace(axes.x1, unit="N"))
    read = [ax.get_ylabel() for ax in figures_motion.motion(found, forced).axes]
    assert "spring force [N]" in read
    assert not any(one.startswith("x1") for one in read)
    below = [ax.get_xlabel() for ax in figures.portrait(found, forced).axes]
    assert "reading of spring force [N]" in below
    block = axes_of(ss.load_case(ROOT / "examples" / "paper_slider"))
    assert block.sensed == "spring force"
