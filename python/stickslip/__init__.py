"""Stick-slip friction rigs: simulate them, identify them from recordings, find what the model lacks."""

from importlib.metadata import version

from stickslip import signals
from stickslip._core import build_config
from stickslip.compare import Comparison, compare
from stickslip.effects import CATALOGUE, Effect, Tabulated, effect, tabulated
from stickslip.errors import InputError, StickslipError
from stickslip.friction import CoulombFriction, HyperbolicFriction, PaperFriction
from stickslip.identified import Identified
from stickslip.identify import identify
from stickslip.model import Model, load_model
from stickslip.recording import Recording, load_recording
from stickslip.records import Case, load_case
from stickslip.rig import BlockOnBelt, Rig, Scales
from stickslip.simulate import Status, Trajectory, Transitions, simulate

__version__ = version("stickslip")

__all__ = [
    "CATALOGUE",
    "BlockOnBelt",
    "Case",
    "Comparison",
    "CoulombFriction",
    "Effect",
    "HyperbolicFriction",
    "Identified",
    "InputError",
    "Model",
    "PaperFriction",
    "Recording",
    "Rig",
    "Scales",
    "Status",
    "StickslipError",
    "Tabulated",
    "Trajectory",
    "Transitions",
    "__version__",
    "build_config",
    "compare",
    "effect",
    "identify",
    "load_case",
    "load_model",
    "load_recording",
    "signals",
    "simulate",
    "tabulated",
]
