"""The comparison's numbers against motions whose numbers are known, and the figures."""

import numpy as np
import pytest

import stickslip as ss
from recorded import recording
from slider import coulomb_record
from stickslip.fitted.compare import matched, portrait_distance
from stickslip.fitted.comparison_rows import Row, judged, verdict
from stickslip.fitted.dominant_cycle import cycles, dominant, typical
from stickslip.measured.sticks import track
from stickslip.shown.plot import curves as plot
from test_identify import DT, RIG, TRUE, noisy, truth

V, STATIC, KINETIC = 0.2, 1.0, 0.5  # period and stick time: closed form
SLIP = 2 * (np.pi - np.arctan((STATIC - KINETIC) / V))
STICK = 2 * (STATIC - KINETIC) / V


@pytest.fixture(scope="module")
def slider(tmp_path_factory):
    t, x, *_ = coulomb_record([STATIC] * 12, [KINETIC] * 12, V, 0.01)
    x = x + 3e-4 * np.random.default_rng(0).standard_normal(len(t))
    return recording(tmp_path_factory.mktemp("slider"), ss.BlockOnBelt(), t, x, None, V, "slider", 3e-4)


def test_cycle_numbers_of_a_closed_form(slider):
    seen = cycles(track(slider.t, slider.x1, belt_speed=V, noise=3e-4, period=2 * np.pi))
    assert len(seen.period) == 11
    np.testing.assert_allclose(seen.period, SLIP + STICK, atol=0.05)
    np.testing.assert_allclose(seen.stick, STICK / (SLIP + STICK), atol=0.02)
    np.testing.assert_allclose(seen.amplitude, 2 * np.hypot(STATIC - KINETIC, V), atol=0.01)
    np.testing.assert_allclose(
        seen.speed, V + np.hypot(STATIC - KINETIC, V), atol=0.02
    )  # the largest, noise too


def test_a_model_compared_with_its_own_motion_differs_by_nothing(slider):
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=STATIC, kinetic=KINETIC))
    c = ss.compare(model, slider)
    for name in ("period", "stick fraction", "slip amplitude", "largest slip speed"):
        row = c.row(name)
        assert row.simulated == pytest.approx(row.measured, rel=0.01)
    assert c.row("release time error").simulated < 0.05
    assert c.row("capture time error").simulated < 0.05
    assert c.row("transitions missed").simulated == 0
    assert c.row("phase-portrait distance").simulated < 0.01
    assert c.row("forecast NRMSE").simulated < 0.01


def test_a_wrong_law_is_seen_in_every_row_it_touches(slider):
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1.3, kinetic=KINETIC))
    c = ss.compare(model, slider)
    expected = 2 * (np.pi - np.arctan(0.8 / V)) + 2 * 0.8 / V
    assert c.row("period").simulated == pytest.approx(expected, rel=0.02)
    assert c.row("period").difference == pytest.approx(expected - SLIP - STICK, rel=0.05)
    assert c.row("phase-portrait distance").simulated > 0.03
    assert c.row("release time error").simulated > 0.5
    assert "phase-portrait distance" in c.table()


def test_two_degrees_of_freedom_run_freely_from_the_estimated_start(tmp_path):
    run = noisy(tmp_path, [truth(0.1, 80.0)], 4, (0.1,))[0]
    c = ss.compare(ss.Model(RIG, friction=TRUE), run)
    rms = np.sqrt(np.mean((c.simulated_readings - c.readings) ** 2, axis=0))
    np.testing.assert_allclose(rms, 8e-4, rtol=0.1)  # the noise alone, over the whole run
    assert c.row("phase-portrait distance").simulated < 0.02
    assert len(c.measured.t) == round(80 / DT)


def test_portrait_distance_of_shifted_lines_is_their_distance():
    s = np.linspace(0, 1, 2001)
    a, b = np.column_stack([s, 0 * s]), np.column_stack([s, 0 * s + 0.3])
    assert portrait_distance(a, b, np.array([1.0, 1.0])) == pytest.approx(0.3)
    assert portrait_distance(a, b, np.array([1.0, 3.0])) == pytest.approx(0.1)
    assert portrait_distance(a, a[::2], np.array([1.0, 1.0])) < 5e-4


def test_events_are_matched_to_the_nearest_within_reach():
    error, missed = matched(np.array([1.0, 2.0, 3.0]), np.array([1.1, 2.95]), 0.5)
    np.testing.assert_allclose(error, [0.1, -0.05])
    assert missed == 1
    assert matched(np.array([1.0]), np.array([]), 0.5)[1] == 1


def test_figures_are_written_twice_and_say_symbol_and_unit(tmp_path, slider):
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=STATIC, kinetic=KINETIC))
    c = ss.compare(model, slider)
    svg, png = plot.save_figure(plot.phase_portrait(c), tmp_path / "new" / "portrait")
    text = svg.read_text()
    assert "measured" in text
    assert "simulated" in text
    assert png.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert [p.suffix for p in sorted((tmp_path / "new").iterdir())] == [".png", ".svg"]  # no temporary left
    assert plot.label("$x_1$", "mm") == "$x_1$ [mm]"
    assert plot.label("$x_1$", "1") == "$x_1$"
    again, _ = plot.save_figure(plot.phase_portrait(c), tmp_path / "again")
    assert again.read_bytes() == svg.read_bytes()  # the same figure is the same file
    for figure in (
        plot.time_series(c),
        plot.friction_characteristic(ss.identify(slider, rig=ss.BlockOnBelt())),
    ):
        for ax in figure.axes:
            assert len(ax.lines) > 0


def test_a_verdict_holds_each_row_against_its_yardstick(slider):
    compared = [
        ss.compare(ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(**law)), slider)
        for law in ({"kinetic": KINETIC}, {"static": 1.3, "kinetic": KINETIC})
    ]
    good, bad = (one.verdict() for one in compared)
    assert good[0].startswith("forecast from cycle to cycle: good; NRMSE 0.0")
    assert bad[0].startswith("forecast from cycle to cycle: ")
    assert (
        judged(float(bad[0].split("NRMSE ")[1].split(" (")[0]))
        == bad[0].split(": ")[1].split(",")[0].split(";")[0]
    )
    assert "good;" not in bad[0]
    for one, said in zip(compared, (good, bad), strict=True):
        less, _, more = said[1].rpartition("off by less than single measured cycles scatter")
        for name in ("period", "stick fraction", "slip amplitude", "largest slip speed"):
            row = one.row(name)
            assert name in (less if abs(row.difference) <= row.scatter else more)
    assert "off by more than single measured cycles scatter" in bad[1]
    assert "transitions missed" in bad[2]
    assert "sampling interval" in good[2]
    assert not any("left out" in line for line in good + bad)


def test_a_forecast_as_bad_as_the_mean_is_called_useless():
    assert [judged(nrmse) for nrmse in (0.05, 0.2, 0.21, 0.7, 0.71, 1.07)] == [
        "good", "good", "poor", "poor", "useless", "useless"
    ]  # fmt: skip
    row = Row("forecast NRMSE", "1", None, 1.07, 0.02, "")
    said = verdict({"forecast NRMSE": row}, None)
    assert said[0].startswith(
        "forecast from cycle to cycle: useless, no better than forecasting the mean; NRMSE 1.07"
    )


def test_small_slips_between_large_ones_do_not_halve_the_period(tmp_path):
    v, large, small = 0.02, (1.0, 0.5), (0.3, 0.27)
    t, x, releases, _ = coulomb_record([large[0], small[0]] * 8, [large[1], small[1]] * 8, v, 0.02)
    x = x + 3e-4 * np.random.default_rng(0).standard_normal(len(t))
    seen = track(t, x, belt_speed=v, noise=3e-4, period=2 * np.pi)
    assert len(seen.releases) == 16
    kept = dominant(seen)
    assert (kept.slips, kept.left_out) == (16, 8)
    np.testing.assert_allclose(kept.track.releases, releases[::2], atol=0.15)
    apart = float(np.diff(releases[::2]).mean())
    np.testing.assert_allclose(cycles(kept.track).period, apart, rtol=0.01)
    assert float(np.mean(kept.track.mode == 0)) > float(np.mean(seen.mode == 0))
    run = recording(tmp_path, ss.BlockOnBelt(), t, x, None, v, "trembling", 3e-4)
    c = ss.compare(ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1.0, kinetic=0.5)), run)
    assert c.row("period").measured == pytest.approx(apart, rel=0.01)
    assert c.row("small slips left out").measured == kept.left_out
    assert c.row("small slips left out").simulated == 0
    assert any(f"{kept.left_out} of {kept.slips} measured slips" in line for line in c.verdict())
    marked = plot.time_series(c).axes[0].lines[2].get_xdata()
    np.testing.assert_allclose(marked, releases[::2], atol=0.15)


@pytest.mark.parametrize(("shown", "counts"), [(0.3, False), (3.3, True)])
def test_a_slip_cut_off_by_the_end_counts_if_enough_of_it_is_seen(shown, counts):
    t, x, releases, _ = coulomb_record([STATIC] * 6, [KINETIC] * 6, V, 0.01)
    n = int(np.searchsorted(t, releases[-1] + shown))
    x = x[:n] + 3e-4 * np.random.default_rng(0).standard_normal(n)
    kept = dominant(track(t[:n], x, belt_speed=V, noise=3e-4, period=2 * np.pi))
    assert (kept.slips, kept.left_out) == (5, 0)
    assert len(cycles(kept.track).period) == 4 + counts
    np.testing.assert_allclose(cycles(kept.track).period, SLIP + STICK, atol=0.05)


def test_the_amplitude_of_a_cycle_is_its_own_slip():
    sizes = (1.0, 0.5), (0.66, 0.5)  # large and small in turn, all of them counted
    t, x, *_ = coulomb_record([sizes[0][0], sizes[1][0]] * 5, [sizes[0][1], sizes[1][1]] * 5, 0.02, 0.02)
    x = x + 1e-4 * np.random.default_rng(0).standard_normal(len(t))
    seen = cycles(dominant(track(t, x, belt_speed=0.02, noise=1e-4, period=2 * np.pi)).track)
    np.testing.assert_allclose(seen.amplitude[::2], 2 * np.hypot(0.5, 0.02), atol=0.01)
    np.testing.assert_allclose(seen.amplitude[1::2], 2 * np.hypot(0.16, 0.02), atol=0.01)


def test_a_block_that_comes_to_rest_on_a_belt_that_stands_still_is_seen_to_stick(tmp_path):
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=0.3, kinetic=0.25))
    t = np.arange(0, 60, 0.01)
    run = ss.simulate(model, belt_speed=0.0, initial=(1.7, 0), t_end=60, t_eval=t)
    resting = 1 - run.transitions.t[-1] / 60
    assert 0.5 < resting < 0.9
    c = ss.compare(model, recording(tmp_path, ss.BlockOnBelt(), t, run.state[:, 0], None, 0.0, "decay", 1e-9))
    assert c.row("stick fraction").measured == pytest.approx(resting, abs=0.02)
    assert c.row("stick fraction").simulated == pytest.approx(resting, abs=0.02)


def test_many_tiny_slips_do_not_change_what_is_typical():
    assert typical(np.array([1.0, 1.1, 0.9, *[0.001] * 500])) >= 0.9
    assert typical(np.array([2.0])) == 2.0
