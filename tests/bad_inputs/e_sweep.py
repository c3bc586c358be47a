"""Sweeps that cannot be: said before any work starts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import stickslip as ss
from bad_input import bad_input
from stickslip.cli import sweep as cli_sweep
from stickslip.shown.plot import sweep as plot_sweep

SWEEPS = "Sweeps"
MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
SENSED = MODEL.with_effects([ss.effect("sensor_delay", delay=0.1)])
BLOCK = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())
SPEEDS = np.linspace(0.05, 0.3, 4)


def attempt(over: object, model: ss.Model = MODEL, **settings: Any) -> None:
    ss.sweep(model, over, **({"t_end": 10.0} | settings))  # type: ignore[arg-type]


HUGE = np.linspace(1.0, 2.0, 5_000_000)
MANY = {f"initial.{name}": np.linspace(-1, 1, 1000) for name in ("x1", "x2", "y1", "y2")}

for tried, over, settings in (
    ("an unknown parameter", {"alpa1": [8.0, 9.0]}, {"belt_speed": 0.1}),
    ("an unknown initial value", {"initial.x3": [0.0]}, {"belt_speed": 0.1}),
    ("a state that no effect has", {"initial.w": [0.0]}, {"belt_speed": 0.1}),
    (
        "a parameter of an effect that the model has not",
        {"block_viscous_damping.c": [0.1]},
        {"belt_speed": 0.1},
    ),
    ("the other direction's number, not set", {"static_plus": [1.0]}, {"belt_speed": 0.1, "model": BLOCK}),
    ("a parameter of a reading", {"sensor_delay.delay": [0.1]}, {"belt_speed": 0.1, "model": SENSED}),
    ("the same by its short name", {"effect.delay": [0.1]}, {"belt_speed": 0.1, "model": SENSED}),
    ("a state without `initial.`", {"x1": [0.0, 1.0]}, {"belt_speed": 0.1}),
    ("whole starts", {"initial": [(0, 0, 0, 0), (1, 0, 0, 0)]}, {"belt_speed": 0.1}),
    ("nothing to vary", {}, {"belt_speed": 0.1}),
    ("None to vary", None, {"belt_speed": 0.1}),
    ("pairs in a list", [("alpha1", [16.0])], {"belt_speed": 0.1}),
    ("a client that is none", {"belt_speed": SPEEDS}, {"client": 3}),
    ("an empty grid", {"belt_speed": []}, {}),
    ("a NaN in a coordinate", {"belt_speed": [0.1, np.nan]}, {}),
    ("text as values", {"belt_speed": "fast"}, {}),
    ("a truth value among values", {"belt_speed": [True, 0.1]}, {}),
    ("masked values", {"belt_speed": np.ma.masked_less([0.1, -1.0], 0)}, {}),
    ("complex values", {"belt_speed": np.array([0.1j])}, {}),
    ("a word for `lanes`", {"belt_speed": SPEEDS}, {"lanes": "no"}),
    (
        "more members than can be counted",
        {"alpha1": HUGE, "alpha2": HUGE, "belt_speed": HUGE},
        {"out": "a.zarr"},
    ),
    ("an empty path", {"belt_speed": SPEEDS}, {"out": ""}),
    ("a path too long", {"belt_speed": SPEEDS}, {"out": "a" * 300}),
    ("a single number as values", {"belt_speed": 0.1}, {}),
    ("values with two dimensions", {"belt_speed": [[0.1, 0.2]]}, {}),
    ("a negative mass", {"mass": [1.0, -1.0]}, {"belt_speed": 0.1, "model": BLOCK}),
    ("eta12 below eta1 in part of a grid", {"eta1": [0.1, 0.3], "eta12": [0.2, 0.4]}, {"belt_speed": 0.1}),
    (
        "lengths that differ on a shared dimension",
        {"alpha1": ("member", [8.0, 9.0]), "alpha2": ("member", [4.0])},
        {"belt_speed": 0.1},
    ),
    ("a dimension named like a result", {"alpha1": ("state", [8.0, 9.0])}, {"belt_speed": 0.1}),
    ("1e12 members without `out`", MANY, {"belt_speed": 0.1}),
    ("no belt speed", {"alpha1": [8.0]}, {}),
    ("a belt speed given twice", {"belt_speed": [0.1]}, {"belt_speed": 0.1}),
    ("an unknown observable", {"belt_speed": SPEEDS}, {"observe": ("stick_fractoin",)}),
    ("more points than are kept", {"belt_speed": SPEEDS}, {"points": 1000}),
    ("counting from after the end", {"belt_speed": SPEEDS}, {"after": 20.0}),
    ("no threads", {"belt_speed": SPEEDS}, {"threads": 0}),
):
    bad_input(SWEEPS, tried)(lambda _folder, over=over, settings=settings: attempt(over, **settings))


@bad_input(SWEEPS, "a store of a sweep with other settings")
def other_settings(folder: Path) -> None:
    attempt({"belt_speed": SPEEDS}, out=folder / "result.zarr")
    attempt({"belt_speed": SPEEDS}, out=folder / "result.zarr", t_end=20.0)


@bad_input(SWEEPS, "a store of a sweep over other values")
def other_values(folder: Path) -> None:
    attempt({"belt_speed": SPEEDS}, out=folder / "result.zarr")
    attempt({"belt_speed": 2 * SPEEDS}, out=folder / "result.zarr")


@bad_input(SWEEPS, "a result path that is another thing")
def not_a_store(folder: Path) -> None:
    (folder / "result.zarr").mkdir()
    attempt({"belt_speed": SPEEDS}, out=folder / "result.zarr")


@bad_input(SWEEPS, "a bifurcation diagram without points")
def no_points(_folder: Path) -> None:
    plot_sweep.bifurcation_diagram(ss.sweep(MODEL, {"belt_speed": SPEEDS}, t_end=10))


@bad_input(SWEEPS, "a map of a sweep over one parameter")
def one_parameter(_folder: Path) -> None:
    plot_sweep.parameter_map(ss.sweep(MODEL, {"belt_speed": SPEEDS}, t_end=10))


@bad_input(SWEEPS, "a bifurcation diagram of a grid of parameters")
def two_parameters(_folder: Path) -> None:
    over = {"belt_speed": SPEEDS, "alpha1": np.linspace(8, 40, 12)}
    plot_sweep.bifurcation_diagram(ss.sweep(MODEL, over, t_end=10, observe="points"))


@bad_input(SWEEPS, "a basin over anything but initial values")
def no_starts(_folder: Path) -> None:
    over = {"belt_speed": SPEEDS, "initial.x1": SPEEDS}
    plot_sweep.basin(ss.sweep(MODEL, over, t_end=10, observe=("state_min", "state_max")))


def command(folder: Path, text: str) -> None:
    (folder / "sweep.toml").write_text(text, encoding="utf-8")
    try:
        cli_sweep.sweep.main(
            [str(folder / "sweep.toml"), "--out", str(folder / "result.zarr")], standalone_mode=False
        )
    finally:
        assert not (folder / "result.zarr").exists()


HEAD = "[rig]\nalpha1 = 16\nalpha2 = 8\nbeta3 = 4\neta1 = 0.1\neta12 = 0.2\n[sweep]\nt_end = 10\n"
for tried, text in (
    ("sweep.toml: a misspelt setting", HEAD + "aftr = 5\n[over]\nbelt_speed = { values = [0.1] }\n"),
    ("sweep.toml: a setting out of bounds", HEAD + "rtol = 2\n[over]\nbelt_speed = { values = [0.1] }\n"),
    ("sweep.toml: half a range", HEAD + "[over]\nbelt_speed = { start = 0.1, stop = 0.2 }\n"),
    ("sweep.toml: a single number to vary", HEAD + "[over]\nalpha1 = 8\n"),
    ("sweep.toml: a name twice", HEAD + '[over]\n"initial.x1" = [0, 1]\ninitial.x1 = [2, 3]\n'),
    ("sweep.toml: nothing to vary", HEAD + "[over]\n"),
    ("sweep.toml: a word for `lanes`", HEAD + 'lanes = "no"\n[over]\nalpha1 = [8]\n'),
    ("sweep.toml: no model", "[sweep]\nt_end = 10\n[over]\nbelt_speed = { values = [0.1] }\n"),
    ("sweep.toml: a model's file that is missing", 'model = "m.toml"\n[sweep]\nt_end = 10\n[over]\n'),
):
    bad_input(SWEEPS, tried)(lambda folder, text=text: command(folder, text))
