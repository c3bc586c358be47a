"""Simulations that cannot be run, and signals that cannot be filtered."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

import stickslip as ss
from bad_input import bad_input
from stickslip import signals
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.simulated.simulate import simulate

MODEL = Model(Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=PaperFriction())
GIVEN = {"model": MODEL, "belt_speed": 0.1, "initial": (0.1, 0.1, 0.0, 0.0), "t_end": 1.0}
NAN = float("nan")

for tried, changed in (
    ("tolerance 0", {"rtol": 0.0, "atol": 0.0}),
    ("negative tolerance", {"rtol": -1e-6}),
    ("t_end < 0", {"t_end": -1.0}),
    ("t_end = 0", {"t_end": 0.0}),
    ("a NaN start", {"initial": (NAN, 0.0, 0.0, 0.0)}),
    ("a start of the wrong length", {"initial": (0.1, 0.0)}),
    ("an infinite belt speed", {"belt_speed": float("inf")}),
    ("times that fall", {"t_eval": [0.0, 0.5, 0.2]}),
    ("times beyond the end", {"t_eval": [0.0, 2.0]}),
    ("a sensitivity nobody knows", {"sensitivity": ("alfa1",)}),
    ("a start that is none", {"sensitivity": ("initial.x3",)}),
    ("a start of a state that no effect has", {"sensitivity": ("initial.w",)}),
    ("a sensitivity that is no name", {"sensitivity": (1,)}),
    ("no sensitivities, as None", {"sensitivity": None}),
    ("a locator that is none", {"locator": "henn"}),
    ("a contact mode in a list", {"contact": ["stick"]}),
    ("times that are one number", {"t_eval": 0.5}),
    ("times that are text", {"t_eval": "0.5"}),
    ("no times", {"t_eval": []}),
    ("two starts at once", {"initial": np.zeros((2, 4))}),
    ("a complex start", {"initial": (0.1j, 0.0, 0.0, 0.0)}),
    ("a hidden state that no effect has", {"initial": (0.0, 0.0, 0.0, 0.0, 0.3)}),
    ("half a transition", {"max_transitions": 1.5}),
    ("a number of transitions beyond integers", {"max_transitions": 10**30}),
    ("None for the model", {"model": None}),
    ("a misspelt argument", {"beltspeed": 0.1}),
):
    bad_input("Simulation", tried)(lambda _folder, changed=changed: simulate(**{**GIVEN, **changed}))


@bad_input("Simulation", "an argument left out")
def lacks_its_end(_folder: Path) -> None:
    simulate(MODEL, belt_speed=0.1)  # type: ignore[call-arg]


@bad_input("Simulation", "an argument without its name")
def nameless(_folder: Path) -> None:
    simulate(MODEL, 0.1, t_end=1)  # type: ignore[misc, call-arg]


CYCLES: dict[str, Callable[[], object]] = {
    "limit cycle of None": lambda: ss.limit_cycle(None, 0.1),  # type: ignore[arg-type]
    "limit cycle, a guess that is text": lambda: ss.limit_cycle(MODEL, 0.1, guess="x"),
    "limit cycle, a guess too short": lambda: ss.limit_cycle(MODEL, 0.1, guess=(0.1, 0.0)),
    "steady sliding of None": lambda: ss.steady_sliding(None, 0.1),  # type: ignore[arg-type]
    "sensitivity of None": lambda: ss.cycle_sensitivity(None, ("alpha1",)),  # type: ignore[arg-type]
    "exponents of None": lambda: ss.lyapunov(None, belt_speed=0.1, t_end=10),  # type: ignore[arg-type]
    "branch of None": lambda: ss.continuation(None, 0.1, parameter="belt_speed", span=(0.05, 0.2)),  # type: ignore[arg-type]
}
for tried, attempt in CYCLES.items():
    bad_input("Cycles", tried)(lambda _folder, attempt=attempt: attempt())


@bad_input("Signals", "an unstable recursion")
def unstable(_folder: Path) -> None:
    signals.first_order(np.ones(9), a=1.5, k0=1.0, k1=-1.0)


@bad_input("Signals", "NaN in a channel")
def not_finite(_folder: Path) -> None:
    signals.first_order(np.array([0.0, NAN, 1.0]), a=0.5, k0=1.0, k1=-1.0)


@bad_input("Signals", "a masked sample")
def masked_sample(_folder: Path) -> None:
    signals.first_order(np.ma.masked_greater(np.arange(9.0), 7.5), a=0.5, k0=1.0, k1=-1.0)


@bad_input("Signals", "constants that overflow")
def overflow(_folder: Path) -> None:
    signals.first_order(np.arange(9.0), a=0.5, k0=1e308, k1=1e308)


@bad_input("Signals", "a rule that is none")
def unknown_rule(_folder: Path) -> None:
    signals.differentiate(np.ones(9), 0.1, 0.2, rule="tustn")  # type: ignore[arg-type]


@bad_input("Signals", "a time constant that is None")
def no_constant(_folder: Path) -> None:
    signals.differentiate(np.ones(9), 0.1, None)  # type: ignore[arg-type]


@bad_input("Signals", "a misspelt argument")
def misspelt(_folder: Path) -> None:
    signals.differentiate(np.ones(9), 0.1, 0.2, rul="tustin")  # type: ignore[call-arg]


@bad_input("Signals", "a sampling interval of 0")
def no_interval(_folder: Path) -> None:
    signals.differentiate(np.ones(9), 0.0, 0.2)
