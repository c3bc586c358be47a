"""What the report says in words: headlines, how sure, numbers for a person."""

from __future__ import annotations

import dataclasses
import io
import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from rich.console import Console

import found_by_hand
import stickslip as ss
from found_by_hand import SCHEMA, made
from stickslip.cli.running.discover import effects_table
from stickslip.declared.catalogue import KINDS
from stickslip.discovery.carry_over import carries_over, instead
from stickslip.discovery.laboratory.block_words import absorbed
from stickslip.discovery.messages import unseen
from stickslip.discovery.result import Alternative, Curve, Likelihood, Part, Verdict
from stickslip.likelihoods.interval import Interval
from stickslip.shown.pages import skeleton
from stickslip.shown.pages.filters import error, interval, percent, span, valued
from stickslip.shown.report import words
from stickslip.shown.report.contents import contents
from stickslip.shown.report.page import page
from stickslip.shown.report.units import axes_of


def test_the_commands_table_of_a_wrong_number_says_what_it_is(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    console = Console(width=80, record=True, file=io.StringIO())
    wrong = found_by_hand.with_effect(found, found_by_hand.of_rig({"eta1": 0.08, "eta12": 0.2}))
    console.print(effects_table(wrong, case))
    text = console.export_text()
    assert "wrong in the declared rig" in text
    assert "unlisted" not in text
    assert "c1 = 2.318 N s/m" in text
    assert "c2 = 3.477 N s/m" in text
    console.print(effects_table(found, case))
    text = console.export_text()
    assert "what the declared model lacks" in text
    assert "sensor_lag" in text
    assert "│ 0.009603 s │" in text


@pytest.mark.parametrize("never", ["slips", "sticks"])
def test_a_block_that_never_slips_or_never_sticks_has_not_all_explained(tmp_path: Path, never: str) -> None:
    """Runs of rest or of steady slip were called explained, with most of the law unidentified."""
    case = ss.load_case(found_by_hand.write_case(tmp_path))
    found = found_by_hand.found(case, verdict="no_effect")
    assert found.never is None
    assert unseen(found) == ()
    assert words.headline(found).startswith("Nothing is missing")
    runs = []
    for run in found.runs:
        mode = np.full_like(run.mode_after, never == "sticks")
        mode[:3] = 1  # the start of a window
        x1 = run.measured["x1"] if never == "sticks" else run.belt_speed * run.t
        runs.append(dataclasses.replace(run, mode_after=mode, measured={**run.measured, "x1": x1}))
    law = {name: dataclasses.replace(one, low=None) for name, one in found.law.items()}
    few = dataclasses.replace(found, runs=tuple(runs), law=law)
    assert few.never == never
    assert f"the block never {never} in these runs" in words.headline(few)
    assert "Nothing is missing" not in words.headline(few)
    (said,) = unseen(few)
    assert f"never {never} in these runs: {len(law)} of {len(law)} numbers of the friction law" in said


def test_a_guessed_place_shows_no_evidence(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    found = found_by_hand.with_effect(found, found_by_hand.guessed())
    report = json.loads(json.dumps(contents(found, case)))
    jsonschema.validate(report, SCHEMA)
    proof = report["effects"][0]["evidence"]
    assert [proof[k] for k in ("delta_chi2", "delta_bic", "held_out_ratio", "control")] == [None] * 4
    text = re.sub(r"\s+", " ", page(found, case, report, {}))
    assert "It lowers chi-squared" not in text
    assert "kept out of every fit" not in text
    assert "Where it acts is a guess: on the angle body and depending on y1 is the likeliest." in text
    assert "acts, most likely on the angle body, as a function of y1." in words.headline(found)
    assert words.sureness(found)[-1].startswith("Where it acts and on what is the likeliest guess")
    assert not any("stands" in line for line in words.sureness(found))


def test_what_was_compared_with_nothing_is_not_said_to_stand(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    bare = found_by_hand.with_effect(found, found_by_hand.of_rig({"eta1": 0.08, "eta12": 0.2}))
    said = words.sureness(bare)[-1]
    assert said == (
        "That it is eta1 and eta12 was held against no rival of its kind; of all that was tried sensor_delay comes "
        "nearest, its -2 log evidence higher by 3.1."
    )
    close = tuple(dataclasses.replace(one, bic=0.0) for one in bare.ranking)
    assert "NOT settled" in words.sureness(dataclasses.replace(bare, ranking=close))[-1]
    assert words.sureness(dataclasses.replace(bare, ranking=()))[-1].endswith("held against no rival.")
    assert contents(bare, case)["effects"][0]["evidence"]["control"] is None  # type: ignore[index, call-overload]
    held = found_by_hand.with_effect(found, found_by_hand.of_rig({"alpha2": 7.5}, "spring_gap_k3"))
    assert words.sureness(held)[-1] == "That it is alpha2 stands: no rival comes near."


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (99.7, 2, "100"),
        (100.0, 2, "100"),
        (9999.6, 4, "10\u202f000"),
        (12345.6, 4, "12\u202f350"),
        (0.05, 2, "0.05"),
        (2e7, 3, "2·10⁷"),
        (-99.96, 3, "−100"),
    ],
)
def test_numbers_have_no_exponent_where_a_person_needs_none(value: float, digits: int, text: str) -> None:
    assert words.short(value, digits) == text


def test_shares_and_rounding_residue() -> None:
    assert percent(1.0) == percent(0.997) == "100\u00a0%"
    assert percent(0.028) == "2.8\u00a0%"
    assert percent(float("nan")) == "–"
    assert error(2.21e-16) == "0"
    assert error(2.21e-3) == "0.00221"
    assert error(float("nan")) == "–"


def test_a_residual_that_grows_is_remarked_on(tmp_path: Path) -> None:
    found, _ = made(tmp_path)
    after = dataclasses.replace(found.residual_before, chi2=found.residual_before.chi2 + 8, clean=False)
    grown = dataclasses.replace(found, residual_after=after)
    said = words.clean_sentence(grown)
    assert said.startswith("Reading by reading more is left than before: chi-squared per reading is ")
    assert "not what was fitted" not in said
    block = dataclasses.replace(found.before, rig=ss.BlockOnBelt(), effects=(), channels=None, noise=None)
    assert "not what was fitted" in words.clean_sentence(dataclasses.replace(grown, before=block))


def test_a_single_belt_speed_is_said_once_in_the_readings_unit(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    size = case.rig.scales.velocity * 1e3
    low, high = (words.short(size * one, 3) for one in (0.08, 0.1))
    assert f"Trained at |belt speed| from {low} to {high} mm/s; " in words.caveats(found, axes_of(case))[-1]
    runs = tuple(dataclasses.replace(run, belt_speed=0.08) for run in found.runs)
    one_speed = dataclasses.replace(found, runs=runs)
    assert f"Trained at |belt speed| {low} mm/s only; " in words.caveats(one_speed, axes_of(case))[-1]
    assert "|belt speed| 0.08 (model units) only; " in words.caveats(one_speed)[-1]


def test_headlines() -> None:
    assert set(words.PLAIN) == {*KINDS, "unlisted"}


def test_no_effect_is_not_called_complete_where_something_is_left(tmp_path: Path) -> None:
    found, _ = made(tmp_path, verdict="no_effect")
    clean, dirty = (
        dataclasses.replace(
            found, residual_after=dataclasses.replace(found.residual_after, clean=is_clean, chi2=1.3)
        )
        for is_clean in (True, False)
    )
    assert words.headline(clean).startswith("Nothing is missing: ")
    assert words.headline(dirty).startswith("Nothing can be named: a little is left above the noise")
    assert words.clean_sentence(clean).startswith("What is left is noise: chi-squared per reading is 1.3 ± ")
    assert words.clean_sentence(dirty).startswith(
        "Not all is explained: chi-squared per reading is still 1.3 ± "
    )
    small = "An effect too small to show above the noise of these runs is not excluded."
    assert words.sureness(clean)[-1] == small
    assert small not in words.sureness(dirty)


def test_a_block_whose_events_repeat_down_to_the_noise_lacks_nothing(tmp_path: Path) -> None:
    found, _ = made(tmp_path, verdict="no_effect")
    law = ss.CoulombFriction(static=0.4, kinetic=0.25)
    block = dataclasses.replace(found, before=ss.Model(ss.BlockOnBelt(), friction=law), scatter={})
    left = dataclasses.replace(found.residual_after, chi2=1.3, clean=False)
    assert words.headline(block).startswith("Nothing is missing: ")
    for one in (
        dataclasses.replace(block, scatter={"static": Interval(0.02, 0.01, 0.03)}),
        dataclasses.replace(block, residual_after=left),
    ):
        assert words.headline(one).startswith("Nothing can be named: no cause stands out from friction")


@pytest.mark.parametrize("verdict", ["effect_found", "unlisted_effect"])
def test_a_candidate_below_the_threshold_is_not_called_sure(tmp_path: Path, verdict: str) -> None:
    found, _ = made(tmp_path, verdict=verdict)
    assert words.sureness(found)[0].startswith("Something is missing, that is sure: ")
    for observed in (0.5 * found.gate.threshold, found.gate.threshold):
        below = dataclasses.replace(found, gate=dataclasses.replace(found.gate, observed=observed))
        assert words.sureness(below)[0] == (
            "Something is missing, though no effect of the list lowers chi-squared by more than noise may."
        )
        far = "13.7 standard uncertainties from what is declared"
        evidence = dataclasses.replace(found.effects[0].evidence, sentence=far)
        mass = dataclasses.replace(found.effects[0], name="rig_mass", evidence=evidence)
        assert words.sureness(dataclasses.replace(below, effects=(mass,)))[0] == (
            f"A number of the rig is not as declared: rig_mass is {far}."
        )
    # three simulated records of a hundred reach as much as the readings show
    draws = np.array([0.1, 0.2] * 48 + [0.3, 1.1, 1.2, 1.3])
    reached = dataclasses.replace(found.gate, observed=1.05, threshold=1.0, draws=draws)
    assert words.sureness(dataclasses.replace(found, gate=reached))[0] == (
        "Something is missing, in all likelihood: the best single candidate lowers chi-squared by 1.05; "
        "noise alone does that in 3 % of 100 records."
    )


def test_a_rival_that_scatter_may_have_made_has_no_odds(tmp_path: Path) -> None:
    """A seam could not be told from a peak at "odds 1.5·10¹²³ to 1"."""
    found, _ = made(tmp_path)
    rival = Alternative("belt_seam", 1e123, -566.0, True, False, "fits these runs better", {})
    tied = dataclasses.replace(found.effects[0], alternatives=(rival,))
    lines = words.sureness(dataclasses.replace(found, effects=(tied,)))
    assert any("belt_seam (it fits better, but as scatter might)" in line for line in lines)
    near = dataclasses.replace(tied, alternatives=(dataclasses.replace(rival, odds=1.2, delta=-0.4),))
    lines = words.sureness(dataclasses.replace(found, effects=(near,)))
    assert any("belt_seam (odds 1.2 to 1)" in line for line in lines)


def test_what_does_not_carry_over_is_in_the_headline(tmp_path: Path) -> None:
    """Two names stood where nothing acted; that the error rose with them was the fourth line below the table."""
    found, _ = made(tmp_path)
    fell = dataclasses.replace(found, error=dataclasses.replace(found.error, before=0.02, after=0.0201))
    rose = dataclasses.replace(found, error=dataclasses.replace(found.error, before=0.02, after=0.0277))
    assert not fell.error.rises
    assert rose.error.rises
    told = "It does not carry over to runs that were not used: the error on them rises from 0.02 to 0.0277."
    assert words.headline(rose) == f"{words.headline(fell)} {told}"
    assert "carry over" not in words.headline(dataclasses.replace(rose, effects=()))


def test_the_likelihood_of_runs_never_used_decides_before_their_error(tmp_path: Path) -> None:
    """An error is mostly friction of events to come: a right name was not claimed, as it rose by chance."""
    found, _ = made(tmp_path)
    rose = dataclasses.replace(found.error, before=0.02, after=0.0277, floor=0.03)
    likelier = dataclasses.replace(
        found, error=dataclasses.replace(rose, likelihood=Likelihood(40.0, 9, 0.98))
    )
    assert carries_over(likelier)
    assert words.headline(likelier).endswith(
        "The error on runs that were not used rises from 0.02 to 0.0277 (friction of events to come alone makes 0.03), "
        "but they do not speak against it."
    )
    fell = dataclasses.replace(rose, after=0.0199, likelihood=Likelihood(-12.0, 9, 0.01))
    refused = dataclasses.replace(found, error=fell)
    assert not carries_over(refused)
    silent = instead(refused, dataclasses.replace(refused, verdict=Verdict.no_effect, effects=()))
    assert (
        "runs never used are less likely with it, by 12 in -2 log likelihood over 9 events (p = 0.01)"
        in silent.messages[0]
    )
    weak = dataclasses.replace(fell, likelihood=Likelihood(-12.0, 9, 0.3, spare=7.0))
    assert not carries_over(dataclasses.replace(found, error=weak))
    assert carries_over(
        dataclasses.replace(
            found, error=dataclasses.replace(fell, likelihood=Likelihood(-12.0, 9, 0.3, spare=13.0))
        )
    )
    unproven = instead(dataclasses.replace(found, error=weak), silent)
    assert (
        "by 12 in -2 log likelihood: more than the 7 by which the train runs pass the gate"
        in unproven.messages[0]
    )
    curve = dataclasses.replace(refused, verdict=Verdict.unlisted_effect)
    assert words.headline(curve).endswith(
        "It does not carry over to runs that were not used: they are less likely with it."
    )


def test_names_that_runs_never_used_refuse_are_in_the_headline(tmp_path: Path) -> None:
    found, _ = made(tmp_path)
    rose = dataclasses.replace(found, error=dataclasses.replace(found.error, before=0.02, after=0.0277))
    assert carries_over(found)
    assert not carries_over(rose)
    silent = instead(rose, dataclasses.replace(rose, verdict=Verdict.no_effect, effects=()))
    name = found.effects[0].name
    assert silent.messages[0].startswith(
        f"{name} would be named by the train runs, but the error on runs never used "
    )
    assert words.headline(silent) == (
        f"Nothing is claimed: the train runs name {words.called(found.effects[0])}, but runs not used speak "
        "against it."
    )
    assert words.headline(dataclasses.replace(silent, unclaimed=2 * silent.unclaimed)).endswith(
        "speak against them."
    )
    x = np.linspace(0.0, 1.0, 5)
    curve = Curve("block", "x1", "force on the block", x, x, x - 0.1, x + 0.1, x, None)
    unnamed = dataclasses.replace(found.effects[0], name="unlisted", where="block", curve=curve)
    told = dataclasses.replace(rose, verdict=Verdict.unlisted_effect, effects=(unnamed,))
    assert not carries_over(told)
    assert (
        instead(told, silent)
        .messages[0]
        .startswith("a curve in x1 of no name (block) would be told by the train runs, but the error")
    )


def test_a_tie_among_two_effects_is_numbered(tmp_path: Path) -> None:
    found, _ = made(tmp_path)
    tied = found.effects[0]
    other = dataclasses.replace(tied, name="harmonic_forcing", alternatives=())
    line = words.headline(dataclasses.replace(found, effects=(tied, other)))
    assert re.match(
        r"The declared model lacks 2 things: \(1\) .+ or .+; \(2\) .+; where it says \"or\"", line
    )
    apart = words.headline(
        dataclasses.replace(found, effects=(dataclasses.replace(tied, alternatives=()), other))
    )
    assert " and " in apart
    assert "(1)" not in apart


def test_the_table_of_all_numbers_keeps_the_digits_of_an_interval() -> None:
    row = interval({"value": 6.30004, "low": 6.29998, "high": 6.3001})
    assert valued(row) == "6.30004"
    assert span(row) == "6.29998 … 6.3001"
    assert span(interval({"value": 6.3, "low": None, "high": None})) == "–"


def test_what_explains_nothing_is_no_finding(tmp_path: Path) -> None:
    found, _ = made(tmp_path)
    far = dataclasses.replace(found.residual_after, chi2=6037.0, clean=False)
    worse = dataclasses.replace(found.error, before=0.96, after=2.3)
    lost = dataclasses.replace(found, residual_after=far, error=worse)
    assert words.headline(lost).startswith(
        "No explanation found: the best of all that was tried is still off by 78 times the noise"
    )
    said = " ".join(words.sureness(lost))
    assert "That is no finding" in said
    assert "stands" not in said
    helps = dataclasses.replace(lost, error=dataclasses.replace(worse, after=0.3))
    assert not words.hopeless(helps)
    assert words.headline(helps).startswith("Not explained: of all that was tried ")
    assert words.headline(helps).endswith("comes nearest, and leaves 78 times the noise.")
    said = " ".join(words.sureness(helps))
    assert "does not stand: with so much left it may stand in for something else" in said
    assert " stands:" not in said


def test_what_is_beyond_its_gate_and_not_named_is_no_contradiction(tmp_path: Path) -> None:
    found, _ = made(tmp_path)
    gate = dataclasses.replace(found.gate, observed=120.0, threshold=7.0)
    silent = dataclasses.replace(found, verdict=Verdict.no_effect, effects=(), gate=gate)
    assert "It is not believed: its own size is not told" in words.sureness(silent)[0]
    assert "To be believed" not in words.sureness(silent)[0]
    below = dataclasses.replace(silent, gate=dataclasses.replace(gate, observed=3.0))
    assert "To be believed it must lower it by 7." in words.sureness(below)[0]


def test_a_drive_s_ripple_is_not_the_belt_s(tmp_path: Path) -> None:
    found, _ = made(tmp_path)
    ripple = dataclasses.replace(found.effects[0], name="belt_speed_ripple", where="drive")
    assert words.called(ripple) == "a ripple of the drive's speed"
    assert "belt" in words.called(dataclasses.replace(ripple, where="belt"))


@pytest.mark.parametrize("si", [True, False])
def test_a_rig_without_units_has_no_column_of_them(tmp_path: Path, si: bool) -> None:
    found, case = made(tmp_path, si=si)
    table = effects_table(found, case)
    assert [column.header for column in table.columns][3:] == (["in SI"] if si else [])
    assert len({len(list(column.cells)) for column in table.columns}) == 1


def test_a_channel_above_its_noise_is_not_hidden_by_another_below_it(tmp_path: Path) -> None:
    """The noise of y1 was taken too large: all readings together looked clean, and x1 was not."""
    found, _ = made(tmp_path)
    parts = (Part("channel", "x1", 1.2, 0.02, 5000), Part("channel", "y1", 0.75, 0.02, 5000))
    after = dataclasses.replace(found.residual_after, chi2=0.98, error=0.015, clean=True, parts=parts)
    said = words.clean_sentence(dataclasses.replace(found, residual_after=after))
    assert said.startswith("Not all is noise")
    assert "channel x1 (1.2)" in said
    even = dataclasses.replace(after, parts=(dataclasses.replace(parts[0], chi2=1.0), parts[1]))
    assert words.clean_sentence(dataclasses.replace(found, residual_after=even)).startswith(
        "What is left is noise"
    )


def test_a_rig_of_coordinates_is_said_by_their_names() -> None:
    matrices = ss.MatricesRig(M=[[1.0]], K=[[4.0]], C=[[0.1]], contact=[1.0], names=["x"])
    assert skeleton.rig(matrices) == "a rig of 1 coordinate: x"
    assert skeleton.rig(ss.BlockOnBelt()) == "a block on a belt, held by a spring"


def test_a_load_that_each_way_of_slip_takes_up_is_said_by_the_ways_of_the_runs() -> None:
    assert absorbed([1.0, 1.0]).endswith("every run slips one way only")
    assert "one way" not in absorbed([1.0, -1.0]).replace("up one way", "")
