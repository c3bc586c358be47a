"""Names of runs that look like markup, and events that show no rate, are said as they are."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

import found_by_hand
import stickslip as ss
from stickslip.cli.running.check import runs_table
from stickslip.cli.running.discover import errors_table
from stickslip.discovery.slider import remarks

NAME = "run [/4] [bold]x"


def printed(table: object) -> str:
    console = Console(width=200)
    with console.capture() as read:
        console.print(table)
    return read.get()


def test_the_name_of_a_run_is_no_markup(tmp_path: Path) -> None:
    """A search of minutes ended in a traceback at its table of errors; `check` lost what stood in brackets."""
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=True))
    found = found_by_hand.found(case, verdict="effect_found")
    runs = tuple(dataclasses.replace(one, run=NAME) for one in found.error.runs)
    odd: Any = dataclasses.replace(found, error=dataclasses.replace(found.error, runs=runs))
    assert NAME in printed(errors_table(odd))
    look = SimpleNamespace(
        name=NAME, role="train", belt_speed=0.1, sticks=3, minus=2, plus=0, samples=12.0, size=30.0
    )
    told: Any = SimpleNamespace(looks=[look])
    assert NAME in printed(runs_table(told, case))


def test_events_without_a_rate_are_none_to_hold_a_wave_against(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sticks of a few samples have no rate: a seam among them ended in a traceback, and rates scattered by nan %."""
    monkeypatch.setattr(remarks, "block_of", lambda *_: ())
    seam: Any = SimpleNamespace(name="belt_seam")
    anything: Any = None
    assert remarks.of_waves(anything, [seam]) == ()
    level = SimpleNamespace(wander=(0.02, 0.01, 0.01))
    monkeypatch.setattr(remarks, "block_of", lambda _, name: _Level(level.wander) if name == "level" else ())
    events = SimpleNamespace(p=remarks.np.ones((3, 8)), arrest=remarks.np.zeros(3))
    events = _Events(events.p, events.arrest)
    scale: Any = SimpleNamespace(of=lambda *_: "3 mm")
    said = remarks.of_process(anything, [SimpleNamespace(events=events)], scale)  # type: ignore[list-item]
    assert said.endswith("from event to event")
    assert "nan" not in said
    blocks = {"level": _Level(level.wander), "rate": _Level(level.wander, spread=remarks.np.full(3, 0.02))}
    monkeypatch.setattr(remarks, "block_of", lambda _, name: blocks.get(name, ()))
    said = remarks.of_process(anything, [SimpleNamespace(events=events)], scale)  # type: ignore[list-item]
    assert said.endswith("from event to event; stick rates scatter by 2 %")


@dataclasses.dataclass
class _Level:
    wander: tuple[float, float, float]
    spread: Any = None

    def __len__(self) -> int:
        return 3


@dataclasses.dataclass
class _Events:
    p: Any
    arrest: Any

    def __len__(self) -> int:
        return len(self.arrest)
