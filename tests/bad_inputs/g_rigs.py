"""Rigs of bodies and matrices, laws as formulas, prescribed speeds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import stickslip as ss
from bad_input import bad_input
from stickslip.declared.candidate import on_rig

AREA = "rigs of bodies and matrices, formulas"
HEAD = "[rig]\nkind = 'bodies'\n[rig.body.table]\ninertia = '0.35 kg m^2'\n"
LAW = "[[rig.contact]]\nbody = 'table'\n[friction]\nkind = 'coulomb'\n"
FILES = {
    "an inertia that is a mass": HEAD.replace("kg m^2", "kg") + LAW,
    "a link to no body": HEAD + "[[rig.link]]\nbetween = ['tabel', 'ground']\nstiffness = 1\n" + LAW,
    "a torque for a stiffness": HEAD
    + "[[rig.link]]\nbetween = ['table', 'ground']\nstiffness = '12 N m'\n"
    + LAW,
    "a contact on no body": HEAD + LAW.replace("'table'", "'bit'"),
    "two contacts on one direction": HEAD + "[[rig.contact]]\nbody = 'table'\n" + LAW,
    "a rig without a contact": HEAD + "[friction]\nkind = 'coulomb'\n",
    "a singular mass matrix": "[rig]\nkind = 'matrices'\nM = [[1, 0], [0, 0]]\nK = [[1, 0], [0, 1]]\n",
    "a force where the contact turns": HEAD + LAW + "static = '2 N'\n",
    "a law that nobody names": HEAD
    + LAW.replace("[friction]", "[law.other]").replace("body =", "law = 'bit'\nbody ="),
}


def file(text: str) -> Callable[[Path], object]:
    def attempt(folder: Path) -> object:
        (folder / "model.toml").write_text(text)
        return ss.load_model(folder / "model.toml")

    return attempt


for what, text in FILES.items():
    bad_input(AREA, what)(file(text))

LAWS: dict[str, dict[str, object]] = {
    "a formula that is a program": {"kinetic": "__import__('os')"},
    "a formula with a name misspelt": {"kinetic": "F_c + c*w", "F_c": 1, "c": 2},
    "a formula that divides by zero": {"kinetic": "F_c/u", "F_c": 1},
    "a formula cut short": {"kinetic": "F_c*(1 + u", "F_c": 1},
    "static friction below kinetic friction": {"kinetic": "F_c", "static": "F_s", "F_c": 2, "F_s": 1},
    "a number that no formula reads": {"kinetic": "F_c", "F_c": 2, "F_s": 3},
}
for what, law in LAWS.items():
    bad_input(AREA, what)(lambda _, law=law: ss.FormulaFriction(**law))  # type: ignore[misc]

BLOCK = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())


@bad_input(AREA, "a formula of units that do not go together")
def units(_: Path) -> object:
    return ss.Model(ss.BlockOnBelt(), friction=ss.FormulaFriction(kinetic="F_c + u", F_c="2 N"))


@bad_input(AREA, "a belt speed that is no formula of t")
def speed(_: Path) -> object:
    return ss.simulate(BLOCK, belt_speed="0.5*sin(w*t)", t_end=1)


@bad_input(AREA, "a limit cycle on a belt that goes faster and faster")
def cycle(_: Path) -> object:
    law = ss.StribeckFriction(F_c=1, F_s=2, v_s=0.1)
    return ss.limit_cycle(ss.Model(ss.BlockOnBelt(), friction=law), belt_speed="0.1 + 0.01*t")


RIVALS: dict[str, dict[str, object]] = {
    "an effect of one's own by a name of the catalogue": {"name": "constant_load"},
    "an effect of one's own without a range": {"ranges": {}},
    "an effect of one's own with a state": {"states": {"z": {"rate": "-z"}}},
    "a start outside its range": {"c": "9 N s/m"},
}
for what, changed in RIVALS.items():
    usual = {"name": "mine", "where": "block", "force": "-c*x2", "ranges": {"c": ["0 N s/m", "5 N s/m"]}}
    bad_input(AREA, what)(lambda _, given={**usual, **changed}: ss.candidate(**given))  # type: ignore[misc]


@bad_input(AREA, "an effect of one's own that a driven slider is to have")
def on_slider(_: Path) -> object:
    own = ss.candidate("mine", force="-c*x2", ranges={"c": [0, 5]})
    return on_rig(own, ss.DrivenSlider(mass=1), ss.CoulombFriction())


MOVED = """[rig]
kind = "bodies"
body.x.mass = "0.5 kg"
link = [{ between = ["x", "ground"], stiffness = "500 N/m" }]
contact = [{ body = "x", against = "belt" }]
[friction]
kind = "coulomb"
[channels]
t = { column = "t", unit = "s" }
x = { column = "x", unit = "mm" }
belt = { column = "v", unit = "mm/s" }
[[run]]
file = "run.csv"
role = "train"
"""
SPEEDS = {
    "a run without the speed of its belt, which is recorded": "",
    "a step without a value": "belt_speed = [{ from = 0, value = 3 }, { from = 2 }]",
    "a step with a key misspelt": "belt_speed = [{ from = 0, value = 3 }, { from = 2, valeu = 0 }]",
    "a step of a force": "belt_speed = [{ from = 0, value = '3 N' }]",
    "a step that begins at a length": "belt_speed = [{ from = '2 m', value = 3 }]",
    "steps that go back in time": "belt_speed = [{ from = 2, value = 3 }, { from = 0, value = 0 }]",
    "no steps at all": "belt_speed = []",
    "a measured drive that is not there": "belt_speed = 3\ndrive_speed = 'measured'",
}


def moved(line: str, change: Callable[[str], str] = str) -> Callable[[Path], object]:
    def attempt(folder: Path) -> object:
        rows = "\n".join(f"{0.01 * i},{i % 7},{5}" for i in range(100))
        (folder / "run.csv").write_text(f"t,x,v\n{rows}\n")
        (folder / "rig.toml").write_text(change(MOVED + line + "\n"))
        return ss.load_case(folder)

    return attempt


for what, line in SPEEDS.items():
    bad_input(AREA, what)(moved(line))
bad_input(AREA, "a measured belt that is not recorded")(
    moved(
        "belt_speed = 'measured'", lambda text: text.replace('belt = { column = "v", unit = "mm/s" }\n', "")
    )
)
bad_input(AREA, "a measured belt of a named rig")(
    moved(
        "belt_speed = 'measured'",
        lambda text: text.replace(
            text[: text.index("[friction]")], "[rig]\nkind = 'block_on_belt'\nm = 1\nk = 1\n"
        ).replace("x =", "x1 ="),
    )
)
