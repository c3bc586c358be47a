"""A mass in g, a stiffness in N/mm: one line that names the number, the factor, and what would be right."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import found_by_hand
import stickslip as ss
from every_effect import made
from slider import coulomb_record
from slider_cases import MASS, STATIC, STIFFNESS, case_of, rig_of
from stickslip.declared.catalogue import CATALOGUE
from stickslip.fitted.identify_check import checked
from stickslip.measured.constants import block_constants, swing_rate
from stickslip.measured.findings import drive_findings
from stickslip.measured.prefixes import GIVEN_IN, power, put_right
from test_acts import LAWS


def rewritten(path: Path, factors: dict[str, float]) -> ss.Case:
    """The case of a rig.toml with numbers of its rig multiplied."""
    text = path.read_text(encoding="utf-8")
    for name, factor in factors.items():
        text, count = re.subn(
            rf"(?m)^({name} = )([\d.e+-]+)$", lambda m, f=factor: f"{m[1]}{float(m[2]) * f!r}", text
        )
        assert count == 1
    path.write_text(text, encoding="utf-8")
    return ss.load_case(path)


GRAMS = "m = 1200 kg is 1,000 times too much, as if it were in g: write 1.2"
N_PER_MM = "k = 0.85 N/m is 1,000 times too little, as if it were in N/mm: write 850"


@pytest.mark.parametrize(
    ("factors", "told", "law"),
    [
        ({"m": 1e3}, GRAMS, "kind = 'coulomb'\nstatic = 6.0\nkinetic = 4.2"),
        ({"k": 1e-3}, N_PER_MM, "kind = 'coulomb'\nstatic = 6.0\nkinetic = 4.2"),
        ({"m": 1e3, "k": 1e-3}, f"{N_PER_MM} and {GRAMS}", "kind = 'coulomb'\nstatic = 6.0\nkinetic = 4.2"),
        ({"m": 1e3}, f"{GRAMS}; or k = 850 N/m is 1,000 times too little", "none"),
        ({"k": 1e-3}, f"m = 1.2 kg is 1,000 times too much, as if it were in g: write 0.0012; or {N_PER_MM}", "none"),
    ],
)  # fmt: skip
def test_a_block_s_constant_is_named(tmp_path: Path, factors: dict[str, float], told: str, law: str) -> None:
    """Where no law says how large forces are, displacements tell k/m alone: both are named."""
    block_constants(case_of(rig_of(0.01), tmp_path, friction=law, length=4.0))  # right as it is
    case = rewritten(tmp_path / "rig.toml", factors)
    for command in (ss.identify, ss.discover):
        with pytest.raises(ss.InputError) as refused:
            command(case)
        assert "swing with" in str(refused.value)
        assert told in str(refused.value)


def test_times_in_another_unit_are_named_as_such(tmp_path: Path) -> None:
    case_of(rig_of(0.01), tmp_path, friction="none", length=4.0)
    for file in tmp_path.glob("*.csv"):
        head, *rows = file.read_text().splitlines()
        cells = [row.split(",") for row in rows]
        file.write_text("\n".join([head, *(f"{1e3 * float(t):.6f},{x}" for t, x in cells)]) + "\n")
    with pytest.raises(
        ss.InputError, match=r"channel t is in 's' by .channels.; with 'ms' it would be right"
    ):
        block_constants(ss.load_case(tmp_path / "rig.toml"))


@pytest.mark.parametrize(
    ("factors", "told"),
    [
        ({"m": 1e3}, "m = 42300 kg is 1,000 times too much, as if it were in g: write 42.3"),
        (
            {"k1": 1e-3, "k2": 1e-3, "k3": 1e-3},
            "k1, k2, k3 = 6.243, 0.3621, 1.234 N/m are 1,000 times too little, as if they were in N/mm: "
            "write 6243, 362.1, 1234",
        ),
        ({"J": 1e6}, "J = 277000 kg m^2 is 1,000,000 times too much, as if it were in kg mm^2: write 0.277"),
        ({"r": 1e3}, "r = 125.6 m is 1,000 times too much, as if it were in mm: write 0.1256"),
        (
            {"m": 1e3, "J": 1e3},
            "or m = 42300 kg is 1,000 times too much, as if it were in g: write 42.3 and J =",
        ),
    ],
)
def test_a_constant_of_the_rig_of_two_degrees_is_named(
    tmp_path: Path, factors: dict[str, float], told: str
) -> None:
    path = found_by_hand.write_case(tmp_path, si=True)
    case = ss.load_case(path)
    checked(case, case.train)  # right as it is
    wrong = rewritten(path, factors)
    with pytest.raises(ss.InputError) as refused:
        checked(wrong, wrong.train)
    assert told in str(refused.value)


def test_a_driven_slider_s_mass_is_named() -> None:
    t = np.arange(0, 4, 1e-3)
    force = 40 * np.sin(6 * t)
    x = -force / (95.1 * 36)
    assert drive_findings(t, x, force, 95.1) == []
    words = str(drive_findings(t, x, force, 95100.0)[0])
    assert "declared; mass = 95100 kg is 1,000 times too much, as if it were in g: write 95.1" in words


@pytest.mark.parametrize("speed", [0.05, 0.2, 0.8])
def test_the_swing_of_a_slip_is_the_block_s_own(speed: float) -> None:
    """Of slips in closed form, m = k = 1, whatever the belt's speed; the other way round and with gaps, too."""
    t, x, _, _ = coulomb_record(np.full(12, 1.0), np.full(12, 0.5), speed, 0.02)
    for read in (x, -x, np.where(np.arange(len(x)) % 50 == 0, np.nan, x)):
        assert swing_rate(t, read) == pytest.approx(1.0, rel=0.03)
    assert swing_rate(t, np.zeros_like(t)) is None
    assert swing_rate(t[:10], x[:10]) is None


BLOCK = [name for name, kind in CATALOGUE.items() if not kind.two_degree and kind.where != "belt"]


@pytest.mark.parametrize("name", BLOCK)
def test_no_effect_is_taken_for_another_unit(name: str) -> None:
    law = LAWS["hyperbolic" if name == "friction_memory" else "coulomb"]
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=1, damping=0.02), friction=law, effects=[made(name)])
    t = np.arange(0, 120, 0.02)
    run = ss.simulate(model, belt_speed=0.2, initial=(0.1, 0.1), t_end=120, t_eval=t)
    rate = swing_rate(t, run.state[:, 0])
    assert rate is None or power(rate**2) == 0


def test_only_a_power_of_a_thousand_is_one() -> None:
    assert [power(ratio) for ratio in (1.0, 1.5, 31.6, 9.81, 1000.0, 700.0, 1e-3, 2e-6, 0.9e6)] == [
        0, 0, 0, 0, 1, 1, -1, 0, 2
    ]  # fmt: skip
    assert [power(bad) for bad in (0.0, -1.0, math.nan, math.inf)] == [0, 0, 0, 0]
    assert power(1000 * 1.7, 0.0) == 0
    assert power(1000 * 1.7, 0.05) == 1  # a number that is known to 5 % may be off by three times that


@pytest.mark.parametrize("unit", GIVEN_IN)
def test_the_unit_that_is_named_is_the_one_off_by_that_power(unit: str) -> None:
    """By a library of units: a number in it, read as one in the unit it is taken in, is off by this power of 1000."""
    import pint

    units = pint.UnitRegistry()
    for n, given in GIVEN_IN[unit].items():
        size = units.Quantity(1.0, given.replace(" ", "*")).to(unit.replace(" ", "*")).magnitude
        assert size == pytest.approx(1000.0**n)
        assert f"in {given}: write {1000.0**n:.6g}" in put_right({"m": 1.0}, unit, n)


def test_a_nondimensional_block_has_no_units(tmp_path: Path) -> None:
    case_of(
        rig_of(0.01), tmp_path, friction=f"kind = 'coulomb'\nstatic = {STATIC}\nkinetic = 4.0", length=4.0
    )
    text = (tmp_path / "rig.toml").read_text()
    text = re.sub(r'unit = "\w+"', 'unit = "1"', text).replace(" mm/s", "").replace('"10"', "0.01")
    text = text.replace('"20"', "0.02").replace('"30"', "0.03")
    (tmp_path / "rig.toml").write_text(text)
    block_constants(rewritten(tmp_path / "rig.toml", {"m": 1e3}))
    assert (MASS, STIFFNESS) == (1.2, 850.0)
