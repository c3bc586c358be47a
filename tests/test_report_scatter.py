"""What a report says of friction that differs from event to event, or in every event alike."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from found_by_hand import made
from stickslip.declared.scatter import EventScatter
from stickslip.discovery.result import Verdict
from stickslip.likelihoods.policy import POLICY
from stickslip.shown.report import words
from stickslip.shown.report.contents import contents


def test_friction_that_is_far_off_in_every_event_is_not_nothing(tmp_path: Path) -> None:
    """A mass 23 % wrong and declared exact: "nothing is missing", it said, of friction 36 % off in every event."""
    found, case = made(tmp_path)
    silent = dataclasses.replace(found, verdict=Verdict.no_effect, effects=(), scatter={})
    for level, said in (
        (0.36, "only with friction that is 36 % off in every event"),
        (1e-4, "Nothing is missing"),
    ):
        scatter = EventScatter(level=level, along=1e-4, length=0.4, static=1e-4, belt=1e-4)
        one = dataclasses.replace(silent, after=dataclasses.replace(found.after, scatter=scatter))
        assert said in words.headline(one)
        told = contents(one, case)["scatter"]["kinetic"]
        assert told["value"] == pytest.approx(level, rel=0.5)
        assert told["high"] == max(told["value"], POLICY.repeats)
