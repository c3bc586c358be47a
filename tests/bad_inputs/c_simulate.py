"""Simulations that cannot be run, and signals that cannot be filtered."""

from pathlib import Path

import numpy as np

from bad_input import bad_input
from stickslip import signals
from stickslip.friction import PaperFriction
from stickslip.model import Model
from stickslip.rig import Rig
from stickslip.simulate import simulate

MODEL = Model(Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=PaperFriction())
GIVEN = {"belt_speed": 0.1, "initial": (0.1, 0.1, 0.0, 0.0), "t_end": 1.0}
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
    ("a start that is none", {"sensitivity": ("initial.z1",)}),
    ("a locator that is none", {"locator": "henn"}),
):
    bad_input("Simulation", tried)(lambda _folder, changed=changed: simulate(MODEL, **{**GIVEN, **changed}))


@bad_input("Signals", "an unstable recursion")
def unstable(_folder: Path) -> None:
    signals.first_order(np.ones(9), a=1.5, k0=1.0, k1=-1.0)


@bad_input("Signals", "NaN in a channel")
def not_finite(_folder: Path) -> None:
    signals.first_order(np.array([0.0, NAN, 1.0]), a=0.5, k0=1.0, k1=-1.0)


@bad_input("Signals", "a rule that is none")
def unknown_rule(_folder: Path) -> None:
    signals.differentiate(np.ones(9), 0.1, 0.2, rule="tustn")  # type: ignore[arg-type]


@bad_input("Signals", "a sampling interval of 0")
def no_interval(_folder: Path) -> None:
    signals.differentiate(np.ones(9), 0.0, 0.2)
