"""Identification, comparison and forecasts of what is no case, no recording or no model."""

from __future__ import annotations

from pathlib import Path

import stickslip as ss
from bad_input import bad_input

MEETING = "Identification and comparison"
MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())


@bad_input(MEETING, "identify None")
def identify_none(_folder: Path) -> None:
    ss.identify(None)  # type: ignore[arg-type]


@bad_input(MEETING, "identify a path")
def identify_path(_folder: Path) -> None:
    ss.identify("CASE/rig.toml")  # type: ignore[arg-type]


@bad_input(MEETING, "identify, a misspelt argument")
def identify_misspelt(_folder: Path) -> None:
    ss.identify(None, frction=ss.PaperFriction())  # type: ignore[call-arg]


@bad_input(MEETING, "compare with a path")
def compare_path(_folder: Path) -> None:
    ss.compare(MODEL, "CASE/run_01.csv")  # type: ignore[arg-type]


@bad_input(MEETING, "compare None")
def compare_none(_folder: Path) -> None:
    ss.compare(None, None)  # type: ignore[arg-type]


@bad_input(MEETING, "forecast from a path")
def forecast_path(_folder: Path) -> None:
    ss.forecast(MODEL, "CASE/run_01.csv", belt_speed=0.1, horizon=10)  # type: ignore[arg-type]
