"""A number of a rig has the same names in a file and in Python, with a unit or bare."""

from __future__ import annotations

from pathlib import Path

import pytest

import stickslip as ss
from every_object import bodies
from stickslip.errors import CallError

SI = {
    "m": "42.3 kg",
    "J": "0.277 kg m^2",
    "r": "125.6 mm",
    "k1": "6.243 N/mm",
    "k2": "362.1 N/m",
    "k3": "1234 N/m",
    "c1": "2.48 N s/m",
    "c2": "2.94 N s/m",
    "length": "8.9 mm",
}
BARE = {"alpha1": 16, "alpha2": 8, "beta3": 4, "eta1": 0.1, "eta12": 0.2}
TABLES = [
    ("block_on_belt", ss.BlockOnBelt, {"m": "30.7 g", "k": "168 N/m", "c": "0.2 N s/m"}),
    ("block_on_belt", ss.BlockOnBelt, {"mass": 0.0307, "stiffness": "168 N/m", "damping": 0.2}),
    ("driven_slider", ss.DrivenSlider, {"m": "95.1 kg", "c": 200}),
    ("driven_slider", ss.DrivenSlider, {"mass": 95.1, "damping": "200 N s/m"}),
    ("two_degree", ss.Rig.from_si, SI),
    ("two_degree", ss.Rig, BARE),
]


@pytest.mark.parametrize(("kind", "make", "numbers"), TABLES)
def test_a_rig_in_python_takes_what_its_table_takes(kind, make, numbers, tmp_path: Path) -> None:
    rows = "\n".join(
        f'{name} = "{x}"' if isinstance(x, str) else f"{name} = {x}" for name, x in numbers.items()
    )
    law = "" if kind == "two_degree" else "[friction]\nkind = 'coulomb'\nstatic = 2\nkinetic = 1\n"
    (tmp_path / "model.toml").write_text(f'[rig]\nkind = "{kind}"\n{rows}\n{law}', encoding="utf-8")
    assert ss.load_model(tmp_path / "model.toml").rig == make(**numbers)


@pytest.mark.parametrize("rig", [bodies(), ss.MatricesRig(M=[[1.0]], K=[[4.0]], contact=[1.0])])
def test_the_table_of_a_general_rig_is_a_call(rig) -> None:
    table = {name: value for name, value in rig.table().items() if name != "kind"}
    assert type(rig)(**table) == rig


def test_one_number_by_two_names_is_refused() -> None:
    with pytest.raises(CallError, match="'m' and 'mass' are the same number"):
        ss.BlockOnBelt(m=1, mass=2)


def test_constants_in_si_are_sent_to_where_they_are_taken() -> None:
    with pytest.raises(CallError, match=r"unknown name 'm'; Rig\.from_si takes constants in SI"):
        ss.Rig(**SI)
    with pytest.raises(CallError, match="unknown name 'inertia'; it must be one of mass, damping"):
        ss.DrivenSlider(inertia=1)
