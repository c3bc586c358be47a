"""How well declared constants are known: [uncertainty], its defaults, and what they make of the numbers of (2.1)."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.declared.uncertainty import NONDIMENSIONAL, Uncertainty, numbers

SI = {"m": 42.3, "J": 0.277, "r": 0.1256, "k1": 6243.0, "k2": 362.1, "k3": 1234.0, "c1": 2.48, "c2": 2.94}
UNIT = {"length": 0.0089}
NUMBERS = {"alpha1": 16.0, "alpha2": 8.0, "beta3": 4.0, "eta1": 0.1, "eta12": 0.2}
BLOCK = {"kind": '"block_on_belt"', "m": 0.03, "k": 168.0}


def load(folder: Path, rig: dict[str, object], uncertainty: str = "", *channels: str) -> ss.Case:
    """A case of one run at rest, declared so."""
    columns = channels or (("x1",) if "kind" in rig else ("x1", "y1"))
    rows = "".join(f"{0.1 * i:.1f}" + ",0.1" * len(columns) + "\n" for i in range(50))
    (folder / "run.csv").write_text(f"t,{','.join(columns)}\n{rows}")
    units = {"t": "s", "spring_force": "N"}
    if rig.keys() & {"alpha1"}:
        units = dict.fromkeys(("t", "x1", "y1"), "1")
    lines = [
        f'{name} = {{ column = "{name}", unit = "{units.get(name, "mm")}" }}' for name in ("t", *columns)
    ]
    text = "[rig]\n" + "".join(f"{name} = {value}\n" for name, value in rig.items())
    text += f"[uncertainty]\n{uncertainty}\n" if uncertainty else ""
    text += '[[run]]\nfile = "run.csv"\nrole = "train"\nbelt_speed = 0.001\n'
    (folder / "rig.toml").write_text(text + "[channels]\n" + "\n".join(lines) + "\n")
    return ss.load_case(folder / "rig.toml")


def test_what_the_file_does_not_say_has_the_documented_defaults(tmp_path: Path) -> None:
    known = load(tmp_path, SI | UNIT).uncertainty
    assert known.constants == {
        **dict.fromkeys(("m", "J", "k1", "k2", "k3"), 0.015), "r": 0.0, "c1": 0.15, "c2": 0.15
    }  # fmt: skip
    assert known.gains == {"x1": 0.005, "y1": 0.005}
    block = load(tmp_path, BLOCK, "", "spring_force").uncertainty
    assert block.constants == {"m": 0.015, "k": 0.015, "c": 0.15}
    assert block.gains == {"spring_force": 0.005}
    assert block.relative("mass") == block.relative("m") == 0.015


def test_the_values_are_those_of_the_file_to_the_last_bit(tmp_path: Path) -> None:
    assert load(tmp_path, SI | UNIT).uncertainty.values == SI


def test_the_file_says_how_well_it_knows_its_numbers(tmp_path: Path) -> None:
    words = 'm = "0.5 %"\nk2 = 0.02\nc1 = 0\ny1 = "0.1%"'
    known = load(tmp_path, SI | UNIT, words).uncertainty
    found = [known.relative(name) for name in ("m", "k2", "c1", "y1", "x1")]
    assert found == pytest.approx([0.005, 0.02, 0.0, 0.001, 0.005])
    plain = load(tmp_path, NUMBERS, "alpha1 = 0.005").uncertainty
    assert [plain.relative(name) for name in NONDIMENSIONAL] == pytest.approx(
        [0.005, 0.015, 0.015, 0.15, 0.15]
    )
    assert np.count_nonzero(plain.covariance()) == 5  # nothing ties numbers that are declared one by one
    assert plain.relative("omega") == 0


@pytest.mark.parametrize(
    ("rig", "words", "said"),
    [
        (SI | UNIT, "k4 = 0.01", "key 'k4': neither a number of [rig] nor a recorded gain; "),
        (SI | UNIT, "alpha1 = 0.01", "key 'alpha1'"),
        (NUMBERS, "m = 0.01", "key 'm'"),
        (BLOCK, "mass = 0.01", "it must be one of m, k, c, x1"),
        (BLOCK, "spring_force = 0.01", "key 'spring_force'"),  # not recorded: it could not act
        (SI | UNIT, "length = 0.01", "a unit of measure, which is exact; leave it out"),
        (SI | UNIT, "m = -0.01", "must be at least 0"),
        (SI | UNIT, "m = 1.5", "must be at most 1 (relative: 0.015 is 1.5 %)"),
        (SI | UNIT, 'm = "150 %"', "must be at most 100"),
        (SI | UNIT, 'm = "0.2 kg"', "not a relative uncertainty; give one like 0.005 or '0.5 %'"),
        (SI | UNIT, 'm = "0,5 %"', "not a relative uncertainty"),
        (SI | UNIT, "m = true", "not a number"),
        (SI | UNIT, "m = nan", "must be finite"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_line(
    tmp_path: Path, rig: dict[str, object], words: str, said: str
) -> None:
    with pytest.raises(ss.InputError) as refused:
        load(tmp_path, rig, words)
    assert said in str(refused.value)
    assert f"rig.toml line {len(rig) + 3}, [uncertainty] key" in str(refused.value)


positive = st.floats(0.01, 100.0)


@given(
    si=st.fixed_dictionaries(dict.fromkeys((*SI, *UNIT), positive)),
    errors=st.lists(st.floats(-1e-4, 1e-4), min_size=8, max_size=8),
)
def test_numbers_of_the_model_move_with_the_constants_as_the_equations_say(
    si: dict[str, float], errors: list[float]
) -> None:
    """The formulas of (2.1) written out here; the covariance is that of their logarithms' slopes."""
    k1, k2, k3, c1, c2 = (si[name] for name in ("k1", "k2", "k3", "c1", "c2"))
    a, b, d = k1 / (k1 + k2), k3 / (k2 + k3), c1 / (c1 + c2)
    slopes = {
        "alpha1": {"k1": a, "k2": -a},
        "alpha2": {"k1": a, "k2": 1 - a - 1, "m": -1, "J": 1, "r": -2},
        "beta3": {"k3": b, "k2": -b},
        "eta1": {"c1": 1, "k1": a / 2, "k2": (1 - a) / 2 - 1, "m": -0.5},
        "eta12": {"c1": d, "c2": 1 - d, "k1": a / 2, "k2": (1 - a) / 2 - 1, "m": -0.5},
        "omega": {"k1": a / 2, "k2": (1 - a) / 2, "m": -0.5},
    }
    known = Uncertainty.usual(ss.Rig.from_si(**si)).with_table({"r": 0.003, "k3": 0.01})
    rows = np.array([[slopes[name].get(key, 0.0) for key in known.constants] for name in slopes])
    expected = rows @ np.diag(np.array(list(known.constants.values())) ** 2) @ rows.T
    assert known.covariance(list(slopes)) == pytest.approx(expected, rel=1e-7, abs=1e-12)
    # counted in the declared unit of time: a mass in N/(m/s^2), not in units that it makes itself
    timed = {
        "alpha1": {"m": 1, "k2": -1},
        "alpha2": {"J": 1, "r": -2, "k2": -1},
        "beta3": slopes["beta3"],
        "eta1": {"c1": 1, "k2": -1},
        "eta12": {"c1": d, "c2": 1 - d, "k2": -1},
        "stiffness": {"k1": a, "k2": 1 - a, "m": -1},
    }
    fixed = np.array([[timed[name].get(key, 0.0) for key in known.constants] for name in timed])
    expected = fixed @ np.diag(np.array(list(known.constants.values())) ** 2) @ fixed.T
    assert known.on_time(list(timed)) == pytest.approx(expected, rel=1e-6, abs=1e-10)
    # and against the rig itself, made of constants that are a little off
    off = {name: si[name] * (1 + e) for name, e in zip(known.constants, errors, strict=True)}
    moved, was = numbers(ss.Rig.from_si(**(si | off))), numbers(known.rig)
    predicted = rows @ np.array(errors)
    for name, change in zip(slopes, predicted, strict=True):
        assert moved[name] / was[name] - 1 == pytest.approx(change, abs=1e-6)


def test_a_damping_that_is_not_there_is_known() -> None:
    rig = ss.Rig.from_si(**(SI | UNIT | {"c1": 0.0}))
    known = Uncertainty.usual(rig)
    assert known.relative("eta1") == 0
    assert known.relative("eta12") > 0.14


def test_another_spring_is_known_as_well_as_the_first_and_processes_may_pass_it_on(tmp_path: Path) -> None:
    known = load(tmp_path, SI | UNIT, "m = 0.001").uncertainty
    softer = ss.Rig.from_si(**(SI | UNIT | {"k1": 100.0}))
    other = pickle.loads(pickle.dumps(known)).of(softer)
    assert other.relative("m") == 0.001
    assert other.values["k1"] == pytest.approx(100.0)
    assert other.relative("alpha1") < known.relative("alpha1")
    assert known.of(known.rig) is known


def test_a_name_that_no_rig_has_is_refused_with_the_nearest() -> None:
    known = Uncertainty.usual(ss.BlockOnBelt(mass=1, stiffness=2), channels=("t", "x1"))
    with pytest.raises(ss.InputError, match="did you mean 'stiffness'"):
        known.relative("stifness")
    assert known.covariance(["mass", "x1"]) == pytest.approx(np.diag([0.015**2, 0.005**2]))
