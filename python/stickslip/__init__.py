"""Stick-slip friction rigs: simulate them, identify them from recordings, find what the model lacks."""

from stickslip._core import build_config
from stickslip.declared.effects import CATALOGUE, Effect, Tabulated, effect, tabulated
from stickslip.declared.friction import CoulombFriction, HyperbolicFriction, PaperFriction
from stickslip.declared.model import Model, load_model
from stickslip.declared.rig import BlockOnBelt, DrivenSlider, Rig, Scales
from stickslip.declared.units import Channel
from stickslip.discovery.discover import Found, discover
from stickslip.errors import InputError, ModelWarning, StickslipError
from stickslip.fitted.compare import Comparison, compare
from stickslip.fitted.forecast import forecast
from stickslip.fitted.identified import Identified
from stickslip.fitted.identify import identify
from stickslip.measured import signals
from stickslip.measured.case import Case, load_case
from stickslip.measured.recording import Recording, load_recording
from stickslip.simulated.instruction_set import check_instruction_set
from stickslip.simulated.orbits.branch import Branch, SpecialPoint
from stickslip.simulated.orbits.continuation import continuation
from stickslip.simulated.orbits.cycle_sensitivity import CycleSensitivity, cycle_sensitivity
from stickslip.simulated.orbits.limit_cycle import LimitCycle, limit_cycle
from stickslip.simulated.orbits.lyapunov import LyapunovSpectrum, lyapunov
from stickslip.simulated.orbits.steady_sliding import NoLimitCycleError, SteadySliding, steady_sliding
from stickslip.simulated.simulate import Status, Trajectory, Transitions, simulate
from stickslip.simulated.sweep.sweep import sweep

check_instruction_set()  # before anything is computed with another one than was asked for


def __getattr__(name: str) -> object:
    if name == "reference":
        from stickslip.simulated.reference import integrate  # of use in cross-checks alone

        globals()[name] = integrate
        return integrate
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
    "reference",
    "signals",
    "simulate",
    "steady_sliding",
    "sweep",
    "tabulated",
]
