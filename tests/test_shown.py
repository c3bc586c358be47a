"""What a prompt and a figure show of a result: a line, never pages of arrays; legends that fit."""

import dataclasses
import io
import re
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

import stickslip as ss
from stickslip.cli.running.compare import comparison_table
from stickslip.declared.scale import percent, plainly
from stickslip.discovery.result import Verdict
from stickslip.fitted.identify_words import misfit_messages
from stickslip.shown.plot import curves as plot
from stickslip.shown.report.words import headline, sentence
from test_cli import folder  # noqa: F401  # a fixture

MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())


def run(**changed):
    return ss.simulate(
        MODEL,
        **{
            "belt_speed": 0.1,
            "initial": (0.1, 0.1, 0, 0),
            "t_end": 20,
            "sensitivity": ("alpha1",),
            **changed,
        },
    )


def test_a_trajectory_is_one_line_and_its_end_a_sentence():
    said = repr(run())
    assert said.endswith("t = 0 to 20; 4 transitions, 1 sensitivities; reached the end time>")
    assert "\n" not in said
    assert str(run().status) == "reached the end time"


def test_transitions_print_as_lines_with_the_modes_by_name():
    transitions = run().transitions
    lines = str(transitions).splitlines()
    assert len(lines) == len(transitions) == 4
    assert lines[0] == f"{transitions.t[0]:12.6f}  stick  -> slip -"
    assert lines[1].endswith("slip - -> stick")
    assert repr(transitions) == f"<Transitions: 4, t = {transitions.t[0]:.6g} to {transitions.t[-1]:.6g}>"
    assert repr(run(t_end=0.5).transitions) == "<Transitions: 0>"


def test_cases_and_recordings_are_one_line(folder):  # noqa: F811
    case = ss.load_case(folder)
    assert repr(case) == f"<Case 'made for a test': Rig, 2 runs (1 train, 1 validate); {folder}/rig.toml>"
    assert repr(case.runs[0]).startswith("<Recording 'a' (train): x1, y1, ")
    assert "belt speed 0.1" in repr(case.runs[0])
    assert len(repr(case.runs[0])) < 160


@pytest.mark.parametrize("branches", [("minus",), ("minus", "plus")])
@pytest.mark.parametrize("thin", [False, True])
def test_the_legend_of_the_characteristic_fits(folder, branches, thin, monkeypatch):  # noqa: F811
    monkeypatch.setattr(plot, "THIN", np.inf if thin else 0.0)
    found = ss.identify(ss.load_case(folder))
    covered = {name: (0.0, 0.2) if name in branches else None for name in ("minus", "plus")}
    figure = plot.friction_characteristic(dataclasses.replace(found, covered=covered))
    figure.draw_without_rendering()
    (legend,) = figure.legends
    names = [one.get_text() for one in legend.get_texts()]
    assert sum("band" in name for name in names) == 1
    assert any("thinner" in name for name in names) == thin
    box = legend.get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.width


def test_a_time_series_says_what_part_of_the_run_it_shows(folder):  # noqa: F811
    case = ss.load_case(folder)
    compared = ss.compare(ss.identify(case).model, case.validate[0])
    seconds = compared.measured.t[-1] - compared.measured.t[0]
    whole = plot.time_series(compared, span=float(seconds)).axes[0].get_title(loc="left")
    assert whole.endswith("left to itself")
    half = plot.time_series(compared, span=float(seconds) / 2).axes[0].get_title(loc="left")
    assert re.search(r"; the first [\d.]+ of [\d.]+ are shown$", half)


def test_the_comparison_fits_a_terminal(folder):  # noqa: F811
    case = ss.load_case(folder)
    table = comparison_table(ss.compare(ss.identify(case).model, case.validate[0]))
    table.add_row(
        "phase-portrait distance", "0.0003196", "0.0003196", "-0.0003196", "0.0003196", "of 153/144"
    )
    console = Console(width=80, file=io.StringIO())
    console.print(table)
    assert any(line.rstrip().endswith("of 153/144") for line in console.file.getvalue().splitlines())


def test_identified_and_comparison_print_as_tables(folder):  # noqa: F811
    case = ss.load_case(folder)
    found = ss.identify(case)
    assert repr(found).startswith("<Identified: paper law, 8 numbers, 2 of them unidentified; chi2")
    assert str(found) == found.summary()
    compared = ss.compare(found.model, case.validate[0])
    assert repr(compared).startswith("<Comparison with 'b': ")
    assert str(compared) == compared.table()


def test_numbers_in_sentences_have_no_powers_of_ten():
    assert [plainly(x) for x in (100.0, 167.3, 1.0, 0.0553, 2340.0)] == ["100", "170", "1", "0.055", "2300"]
    assert [percent(x) for x in (1.0, 0.123, 4.2e-7, 0.0)] == ["100 %", "12 %", "less than 0.01 %", "0 %"]


def test_a_sentence_leaves_the_names_of_runs_and_effects_as_they_are():
    assert sentence("b50: forecasts are off") == "b50: forecasts are off."
    assert sentence("rig_mass and sensor_gain are alike") == "rig_mass and sensor_gain are alike."
    assert sentence("noise is 0.1 +- 0.2.") == "Noise is 0.1 ± 0.2."
    assert sentence("chi-squared is 1") == "Chi-squared is 1."


def test_a_headline_of_many_effects_numbers_them():
    names = ["spring_cubic_k1", "harmonic_forcing", "sensor_lag", "static_aging"]

    def headline_of(found):
        effects = [SimpleNamespace(name=n, where="block", alternatives=[], of_rig=False) for n in found]
        fits = SimpleNamespace(chi2=1.0)
        rig = SimpleNamespace(
            verdict=Verdict.effect_found,
            before=MODEL,
            effects=effects,
            unclaimed=(),
            residual_after=fits,
            error=SimpleNamespace(rises=False, carries=True),
        )
        return headline(rig)

    assert "(1)" not in headline_of(names[:2])
    assert [f"({i})" in headline_of(names) for i in range(1, 6)] == [True] * 4 + [False]
    assert headline_of(names).startswith("The declared model lacks 4 things: (1) ")


def test_of_a_long_run_the_last_transitions_are_drawn_over_time():
    for t_end, part in ((100, 1.0), (1000, 0.25)):
        t = np.arange(0, t_end, 0.1)
        run = ss.simulate(MODEL, belt_speed=0.1, initial=(0, 0, 0, 0), t_end=t_end, t_eval=t)
        left, right = plot.trajectory(run, ("x1", "x2", "y1", "y2"), belt_speed=0.1).axes
        drawn = left.lines[0].get_xdata()
        assert np.ptp(drawn) == pytest.approx(part * t_end, rel=0.3)
        marks = sum(
            len(one.get_xdata())
            for one in left.lines
            if one.get_label() in ("release", "capture", "turn of the slip")
        )
        assert marks == min(len(run.transitions.t), plot.MOST_DRAWN)
        whole = [one.get_xdata() for one in right.lines if len(one.get_xdata()) > 2]
        assert sum(map(len, whole)) >= len(t)  # the portrait has all of the run
        assert left.get_title() == ("" if part == 1 else f"the last {plot.MOST_DRAWN} of 192 transitions")


def test_a_slip_that_turns_is_neither_a_release_nor_a_capture():
    model = ss.Model(ss.Rig(alpha1=10, alpha2=5, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
    run = ss.simulate(
        model, belt_speed=0.19, initial=(0.1, 0.19, 0, 0), t_end=60, t_eval=np.arange(0, 60, 0.1)
    )
    turns = run.transitions.before * run.transitions.after < 0
    assert turns.any()
    left, _ = plot.trajectory(run, ("x1", "x2", "y1", "y2"), belt_speed=0.19).axes
    drawn = {one.get_label(): len(one.get_xdata()) for one in left.lines}
    assert drawn["turn of the slip"] == turns.sum()
    assert drawn["release"] == np.sum(run.transitions.before == 0)
    assert drawn["capture"] == np.sum(run.transitions.after == 0)


def test_a_law_that_misses_by_several_times_the_noise_is_not_left_at_that():
    def said(chi2, share):
        return misfit_messages(SimpleNamespace(reduced_chi2=chi2, diagnostics={"misfit": share}))

    assert said(1.1, 0.01) == []
    assert "differ by 6.7 times the noise: more than this law explains" in said(44.9, 0.05)[0]
    assert "does NOT reproduce the readings" in said(44.9, 0.2)[0]
    assert said(44.9, 0.0) == []  # slips fitted one by one have no such number
