"""The recording of examples/screw_drive: what it is, and that no verdict is made of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.errors import InputError

FOLDER = Path(__file__).parent.parent / "examples" / "screw_drive"


@pytest.fixture(scope="module")
def table() -> np.ndarray:
    return np.genfromtxt(FOLDER / "drive1_start_stop_50.csv", delimiter=",", names=True)


def test_angle_and_torque_follow_from_what_was_recorded(table: np.ndarray) -> None:
    rate = table["rpm"] * 2 * np.pi / 60
    np.testing.assert_allclose(np.diff(table["angle"]), rate[1:] * np.diff(table["t"]), atol=1.1e-5)
    np.testing.assert_allclose(table["torque"], table["percent"] / 100 * 9.84e-3, atol=1e-7)


def test_the_numbers_of_the_page(table: np.ndarray) -> None:
    page = (FOLDER.parents[1] / "docs" / "real.md").read_text()
    means, befores, rests = [], [], []
    for sign in (-1, 1):
        moving = table["rpm"] * sign > 40
        means.append(f"{abs(table['percent'][moving].mean()):.1f} (")
        first = np.flatnonzero(table["rpm"] * sign > 0)[0]
        befores.append(f"{abs(table['percent'][first - 1]):.1f}")
        still = np.flatnonzero(table["rpm"][:first] != 0)
        began = table["t"][still[-1]] if still.size else 0.0
        rests.append(f"{table['t'][first] - began:.1f} s")
    row = next(line for line in page.splitlines() if line.startswith("| torque while"))
    assert all(one in row for one in means)
    assert f"| the row before the first motion | {befores[0]} | {befores[1]} |" in page
    assert f"| rest before the start | {rests[0]} | {rests[1]} |" in page


def test_drive_and_acceleration_tell_of_no_mass() -> None:
    case = ss.load_case(FOLDER)
    with pytest.raises(InputError, match="tell of a mass of -"):
        ss.discover(case)
