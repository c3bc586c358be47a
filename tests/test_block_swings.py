"""A block that never sticks is searched all the same: its swings tell what takes their energy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from scattering import FORCE_NOISE, KINETIC, MASS, STATIC, STIFFNESS

SPEEDS = {"a": 0.25, "b": 0.3, "c": 0.35}
END, STEP = 3.0, 1.5e-3


def swings(folder: Path, damping: float, seed: int, speeds: dict[str, float]) -> Path:
    """Runs that begin in a swing below the belt's speed, on a surface that differs along the belt."""
    rng = np.random.default_rng(seed)
    lines = ['[rig]\nkind = "block_on_belt"', f"m = {MASS}\nk = {STIFFNESS}"]
    t = np.arange(0, END, STEP)
    for name, speed in speeds.items():
        effects = [ss.effect("block_viscous_damping", c=damping)] if damping else []
        wanders = 0.02 * rng.standard_normal(24)
        effects.append(ss.tabulated("contact", "t", np.linspace(0, END, 24), wanders))
        model = ss.Model(
            ss.BlockOnBelt(mass=MASS, stiffness=STIFFNESS),
            friction=ss.CoulombFriction(static=STATIC, kinetic=KINETIC),
            effects=effects,
        )
        start = (KINETIC / STIFFNESS, 0.8 * speed)
        made = ss.simulate(model, belt_speed=speed, initial=start, t_end=END, t_eval=t)
        assert (made.mode != 0).all()
        force = STIFFNESS * made.state[:, 0] + FORCE_NOISE * rng.standard_normal(len(t))
        np.savetxt(
            folder / f"{name}.csv", np.column_stack([t, force]), delimiter=",", header="t,F", comments=""
        )
        role = "validate" if name == "c" else "train"
        lines.append(f'[[run]]\nfile = "{name}.csv"\nrole = "{role}"\nbelt_speed = {speed}')
    lines.append(f'[friction]\nkind = "coulomb"\nstatic = {STATIC}\nkinetic = {KINETIC}')
    lines.append('[channels]\nt = { column = "t", unit = "s" }\nspring_force = { column = "F", unit = "N" }')
    lines.append(f"[noise]\nspring_force = {FORCE_NOISE}")
    (folder / "rig.toml").write_text("\n".join(lines))
    return folder / "rig.toml"


@pytest.mark.parametrize("damping", [0.0, 0.15])
def test_swings_alone_tell_a_damping(damping: float, tmp_path: Path) -> None:
    """Runs without a stick were refused."""
    found = ss.discover(ss.load_case(swings(tmp_path, damping, 4, SPEEDS)), threads=1)
    assert [one.name for one in found.effects] == (["block_viscous_damping"] if damping else [])
    for one in found.effects:
        number = one.parameters["c"]
        assert number.low is not None
        assert number.high is not None
        assert number.low < damping < number.high
    assert any(
        one.startswith("a: no stick is found in it: it is fitted from slip to slip") for one in found.messages
    )


def test_few_swings_are_refused(tmp_path: Path) -> None:
    path = swings(tmp_path, 0.0, 4, {"a": 0.25, "c": 0.35})
    short = tmp_path / "a.csv"
    short.write_text("\n".join(short.read_text().splitlines()[:500]))
    with pytest.raises(
        ss.InputError, match=r"no slip between two sticks.*, and \d swings of 12 that would do without"
    ):
        ss.discover(ss.load_case(path))
