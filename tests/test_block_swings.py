"""A block that never sticks is searched all the same: its swings tell what takes their energy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from recorded import recording
from scattering import KINETIC, STIFFNESS, Acting, block_runs
from stickslip.fitted.data import prepare
from stickslip.likelihoods.stretches import stretches

SPEEDS = {"a": 0.25, "b": 0.3, "c": 0.35}
END = 3.0


def swings(folder: Path, damping: float, seed: int, speeds: dict[str, float]) -> Path:
    """Runs that begin in a swing below the belt's speed, on a surface that differs along the belt."""
    rng = np.random.default_rng(seed)
    damped: list[Acting] = [ss.effect("block_viscous_damping", c=damping)] if damping else []

    def runs() -> Iterator[tuple[str, float, list[Acting], tuple[float, float]]]:
        for name, speed in speeds.items():
            wanders = ss.tabulated("contact", "t", np.linspace(0, END, 24), 0.02 * rng.standard_normal(24))
            yield name, speed, [*damped, wanders], (KINETIC / STIFFNESS, 0.8 * speed)

    return block_runs(folder, runs(), END, rng)


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


def test_no_window_is_from_swing_to_swing_where_they_have_died_away(tmp_path: Path) -> None:
    """The last one was as long as six others: no friction of one event fits it, and a damping was not found."""
    rig = ss.BlockOnBelt(damping=0.05)
    model = ss.Model(rig, friction=ss.CoulombFriction(static=1.0, kinetic=0.5))
    t = np.arange(0, 200, 0.02)
    first = ss.simulate(model, belt_speed=1.0, initial=(0.5, 0.8), t_end=200, t_eval=t)
    assert (first.mode[1:] != 0).all()
    x1 = np.concatenate([first.state[:, 0], first.state[:1500, 0]])  # pushed once more
    x1 += 1e-3 * np.random.default_rng(3).standard_normal(len(x1))
    run = prepare([recording(tmp_path, rig, 0.02 * np.arange(len(x1)), x1, None, 1.0, "run", 1e-3)])[0]
    every = stretches([run])
    assert len(every) > 5
    assert max(np.diff(run.slips)) * 0.02 > 5 * run.cycle
    assert all(run.t[one.stop] - run.t[one.start] < 2 * run.cycle for one in every)
    assert any(one.start * 0.02 > 200 for one in every)
