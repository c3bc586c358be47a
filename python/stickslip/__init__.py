"""Stick-slip friction rigs: simulate them, identify them from recordings, find what the model lacks."""

from stickslip import signals
from stickslip._core import build_config
from stickslip.branch import Branch, SpecialPoint
from stickslip.compare import Comparison, compare
from stickslip.continuation import continuation
from stickslip.cycle_sensitivity import CycleSensitivity, cycle_sensitivity
from stickslip.cycles import LimitCycle, limit_cycle
from stickslip.discover import Found, discover
from stickslip.effects import CATALOGUE, Effect, Tabulated, effect, tabulated
from stickslip.errors import InputError, ModelWarning, StickslipError
from stickslip.forecast import forecast
from stickslip.friction import CoulombFriction, HyperbolicFriction, PaperFriction
from stickslip.identified import Identified
from stickslip.identify import identify
from stickslip.instruction_set import check_instruction_set
from stickslip.lyapunov import LyapunovSpectrum, lyapunov
from stickslip.model import Model, load_model
from stickslip.recording import Recording, load_recording
from stickslip.records import Case, load_case
from stickslip.rig import BlockOnBelt, DrivenSlider, Rig, Scales
from stickslip.simulate import Status, Trajectory, Transitions, simulate
from stickslip.sliding import NoLimitCycleError, SteadySliding, steady_sliding
from stickslip.sweep import sweep
from stickslip.units import Channel

check_instruction_set()  # before anything is computed with another one than was asked for


def __getattr__(name: str) -> str:
    if name == "__version__":
        from importlib.metadata import version  # slow to import, and seldom asked for

        globals()[name] = found = version("stickslip")
        return found
    raise AttributeError(f"module 'stickslip' has no attribute '{name}'")


__all__ = [
    "CATALOGUE",
    "BlockOnBelt",
    "Branch",
    "Case",
    "Channel",
    "Comparison",
    "CoulombFriction",
    "CycleSensitivity",
    "DrivenSlider",
    "Effect",
    "Found",
    "HyperbolicFriction",
    "Identified",
    "InputError",
    "LimitCycle",
    "LyapunovSpectrum",
    "Model",
    "ModelWarning",
    "NoLimitCycleError",
    "PaperFriction",
    "Recording",
    "Rig",
    "Scales",
    "SpecialPoint",
    "Status",
    "SteadySliding",
    "StickslipError",
    "Tabulated",
    "Trajectory",
    "Transitions",
    "__version__",
    "build_config",
    "compare",
    "continuation",
    "cycle_sensitivity",
    "discover",
    "effect",
    "forecast",
    "identify",
    "limit_cycle",
    "load_case",
    "load_model",
    "load_recording",
    "lyapunov",
    "signals",
    "simulate",
    "steady_sliding",
    "sweep",
    "tabulated",
]
