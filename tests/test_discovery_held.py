"""Channels that were held, and validate runs that were trained on: said or refused, never used."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from discover_cases import NOISE, make_case
from stickslip.fitted.data import copied_words, held, held_words, prepare

RNG = np.random.default_rng(4)


def test_noise_repeats_itself_only_as_its_grid_makes_it():
    white = NOISE * RNG.standard_normal(20_000)
    assert not held(white, NOISE).any()
    assert not held(np.round(white, 4), NOISE).any()  # printed to a tenth of the noise
    assert not held(np.round(white, 3), NOISE).any()  # to all of it: nothing can be said


def test_a_channel_held_is_without_weight_and_said():
    case = make_case(length=30.0, speeds=(0.06, 0.1))
    run = case.runs[0]
    x1 = run.x1.copy()
    x1[200:240] = x1[200]
    runs = (replace(run, x1=x1), case.runs[1])
    data = prepare(runs)
    out = set(np.flatnonzero(data[0].weight[:, 0] == 0).tolist())
    assert set(range(201, 240)) <= out <= set(range(199, 242))
    (words,) = held_words(data)
    assert words.startswith("run_0: x1 repeats one reading over 39 samples, first at t = 10.05")
    assert held_words(prepare(case.runs)) == ()


def test_a_clipped_channel_is_not_called_held():
    case = make_case(length=30.0, speeds=(0.06, 0.1))
    run = case.runs[0]
    data = prepare((replace(run, x1=np.minimum(run.x1, np.quantile(run.x1, 0.9))), case.runs[1]))
    assert (data[0].weight[:, 0] == 0).sum() > 30
    assert held_words(data) == ()


def test_outliers_side_by_side_are_all_left_out_before_any_fit():
    case = make_case(length=30.0, speeds=(0.06, 0.1))
    run = case.runs[0]
    y1 = run.y1.copy()
    y1[[200, 201, 300, 302]] += [0.2, 0.13, -0.2, -0.19]
    weight = prepare((replace(run, y1=y1), case.runs[1]))[0].weight
    assert (weight[[200, 201, 300, 302], 1] == 0).all()
    assert (weight[:, 1] == 0).sum() <= 6


def test_a_copy_of_a_train_run_is_no_test_and_said():
    case = make_case(length=30.0, speeds=(0.06, 0.1))
    copy = replace(case.runs[0], name="other", role="validate")
    assert copied_words(case.runs) == ()
    (words,) = copied_words((*case.runs, copy))
    assert words.startswith("other holds the readings of run_0, a train run: the error on it is no test")


def test_rows_of_a_train_run_are_found_wherever_they_begin():
    """A train run less its first row passed for another record."""
    case = make_case(length=30.0, speeds=(0.06, 0.1))
    run = case.runs[0]
    for part, count in ((slice(1, None), 599), (slice(200, 500), 300)):
        copy = replace(run, t=run.t[part], x1=run.x1[part], y1=run.y1[part], name="other", role="validate")
        (words,) = copied_words((*case.runs, copy))
        assert words.startswith("other holds the readings of run_0")
        longer = replace(copy, x1=np.concatenate([copy.x1, RNG.standard_normal(100)]))
        (words,) = copied_words((*case.runs, longer))
        assert words.startswith(f"other holds {count} readings in a row of run_0")
    at_rest = [replace(run, x1=np.concatenate([np.zeros(300), run.x1]), role=run.role) for run in case.runs]
    assert copied_words(at_rest) == ()
