"""Stick-slip friction rigs: simulate them, identify them from recordings, find what the model lacks."""

from importlib import import_module
from typing import TYPE_CHECKING

from stickslip.simulated.instruction_set import check_instruction_set

if TYPE_CHECKING:  # for mypy and editors, which cannot follow _HOME
    from stickslip._core import build_config
    from stickslip.declared.candidate import candidate
    from stickslip.declared.effect import CATALOGUE, Effect, Tabulated, effect, tabulated
    from stickslip.declared.formula_laws.dahl import DahlFriction
    from stickslip.declared.formula_laws.formula import FormulaFriction, LawState
    from stickslip.declared.formula_laws.lugre import LuGreFriction
    from stickslip.declared.formula_laws.rate_and_state import RateAndStateFriction
    from stickslip.declared.formula_laws.stribeck import StribeckFriction
    from stickslip.declared.formula_laws.tabulated import TabulatedFriction
    from stickslip.declared.friction.coulomb import CoulombFriction
    from stickslip.declared.friction.hyperbolic import HyperbolicFriction
    from stickslip.declared.friction.paper import PaperFriction
    from stickslip.declared.model import Model, load_model
    from stickslip.declared.rig import BlockOnBelt, DrivenSlider, Rig, Scales
    from stickslip.declared.rigs.bodies import BodiesRig
    from stickslip.declared.rigs.matrices import MatricesRig
    from stickslip.declared.rigs.parts import Body, Contact, Link
    from stickslip.declared.scatter import EventScatter
    from stickslip.declared.speeds import Speed
    from stickslip.declared.units import Channel
    from stickslip.discovery.discover import Found, discover
    from stickslip.errors import InputError, ModelWarning, StickslipError
    from stickslip.fitted.compare import Comparison
    from stickslip.fitted.identified import Identified
    from stickslip.likelihoods.bodies_compare import RigComparison
    from stickslip.likelihoods.compare import compare
    from stickslip.likelihoods.forecast import forecast
    from stickslip.likelihoods.identified_rig import IdentifiedRig
    from stickslip.likelihoods.identify import identify
    from stickslip.measured import signals
    from stickslip.measured.case import Case, load_case
    from stickslip.measured.recording import Recording, load_recording
    from stickslip.simulated import reference
    from stickslip.simulated.orbits.branch import Branch, SpecialPoint
    from stickslip.simulated.orbits.continuation import continuation
    from stickslip.simulated.orbits.cycle import LimitCycle
    from stickslip.simulated.orbits.cycle_sensitivity import CycleSensitivity, cycle_sensitivity
    from stickslip.simulated.orbits.limit_cycle import limit_cycle
    from stickslip.simulated.orbits.lyapunov import LyapunovSpectrum, lyapunov
    from stickslip.simulated.orbits.steady_sliding import NoLimitCycleError, SteadySliding, steady_sliding
    from stickslip.simulated.simulate import simulate
    from stickslip.simulated.sweep.sweep import sweep
    from stickslip.simulated.trajectory import Status, Trajectory, Transitions

    __version__: str

check_instruction_set()  # before anything is computed with another one than was asked for

_HOME = {  # where each public name lives; imported when it is first used, for a quick start
    "BlockOnBelt": "stickslip.declared.rig",
    "BodiesRig": "stickslip.declared.rigs.bodies",
    "Body": "stickslip.declared.rigs.parts",
    "Branch": "stickslip.simulated.orbits.branch",
    "CATALOGUE": "stickslip.declared.effect",
    "Case": "stickslip.measured.case",
    "Channel": "stickslip.declared.units",
    "Comparison": "stickslip.fitted.compare",
    "Contact": "stickslip.declared.rigs.parts",
    "CoulombFriction": "stickslip.declared.friction.coulomb",
    "CycleSensitivity": "stickslip.simulated.orbits.cycle_sensitivity",
    "DahlFriction": "stickslip.declared.formula_laws.dahl",
    "DrivenSlider": "stickslip.declared.rig",
    "Effect": "stickslip.declared.effect",
    "EventScatter": "stickslip.declared.scatter",
    "FormulaFriction": "stickslip.declared.formula_laws.formula",
    "Found": "stickslip.discovery.discover",
    "HyperbolicFriction": "stickslip.declared.friction.hyperbolic",
    "Identified": "stickslip.fitted.identified",
    "IdentifiedRig": "stickslip.likelihoods.identified_rig",
    "InputError": "stickslip.errors",
    "LawState": "stickslip.declared.formula_laws.formula",
    "LimitCycle": "stickslip.simulated.orbits.cycle",
    "Link": "stickslip.declared.rigs.parts",
    "LuGreFriction": "stickslip.declared.formula_laws.lugre",
    "LyapunovSpectrum": "stickslip.simulated.orbits.lyapunov",
    "MatricesRig": "stickslip.declared.rigs.matrices",
    "Model": "stickslip.declared.model",
    "ModelWarning": "stickslip.errors",
    "NoLimitCycleError": "stickslip.simulated.orbits.steady_sliding",
    "PaperFriction": "stickslip.declared.friction.paper",
    "RateAndStateFriction": "stickslip.declared.formula_laws.rate_and_state",
    "Recording": "stickslip.measured.recording",
    "Rig": "stickslip.declared.rig",
    "RigComparison": "stickslip.likelihoods.bodies_compare",
    "Scales": "stickslip.declared.rig",
    "SpecialPoint": "stickslip.simulated.orbits.branch",
    "Speed": "stickslip.declared.speeds",
    "Status": "stickslip.simulated.trajectory",
    "SteadySliding": "stickslip.simulated.orbits.steady_sliding",
    "StickslipError": "stickslip.errors",
    "StribeckFriction": "stickslip.declared.formula_laws.stribeck",
    "Tabulated": "stickslip.declared.effect",
    "TabulatedFriction": "stickslip.declared.formula_laws.tabulated",
    "Trajectory": "stickslip.simulated.trajectory",
    "Transitions": "stickslip.simulated.trajectory",
    "build_config": "stickslip._core",
    "candidate": "stickslip.declared.candidate",
    "compare": "stickslip.likelihoods.compare",
    "continuation": "stickslip.simulated.orbits.continuation",
    "cycle_sensitivity": "stickslip.simulated.orbits.cycle_sensitivity",
    "discover": "stickslip.discovery.discover",
    "effect": "stickslip.declared.effect",
    "forecast": "stickslip.likelihoods.forecast",
    "identify": "stickslip.likelihoods.identify",
    "limit_cycle": "stickslip.simulated.orbits.limit_cycle",
    "load_case": "stickslip.measured.case",
    "load_model": "stickslip.declared.model",
    "load_recording": "stickslip.measured.recording",
    "lyapunov": "stickslip.simulated.orbits.lyapunov",
    "reference": "stickslip.simulated",
    "signals": "stickslip.measured",
    "simulate": "stickslip.simulated.simulate",
    "steady_sliding": "stickslip.simulated.orbits.steady_sliding",
    "sweep": "stickslip.simulated.sweep.sweep",
    "tabulated": "stickslip.declared.effect",
}

if not TYPE_CHECKING:  # it would let every misspelt name pass

    def __getattr__(name: str) -> object:
        if name == "__version__":
            found = import_module("importlib.metadata").version("stickslip")
        elif name in _HOME:
            module = import_module(_HOME[name])
            found = getattr(module, name) if hasattr(module, name) else import_module(f"{_HOME[name]}.{name}")
        else:
            raise AttributeError(f"module 'stickslip' has no attribute '{name}'")
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ = [
    "CATALOGUE",
    "BlockOnBelt",
    "BodiesRig",
    "Body",
    "Branch",
    "Case",
    "Channel",
    "Comparison",
    "Contact",
    "CoulombFriction",
    "CycleSensitivity",
    "DahlFriction",
    "DrivenSlider",
    "Effect",
    "EventScatter",
    "FormulaFriction",
    "Found",
    "HyperbolicFriction",
    "Identified",
    "IdentifiedRig",
    "InputError",
    "LawState",
    "LimitCycle",
    "Link",
    "LuGreFriction",
    "LyapunovSpectrum",
    "MatricesRig",
    "Model",
    "ModelWarning",
    "NoLimitCycleError",
    "PaperFriction",
    "RateAndStateFriction",
    "Recording",
    "Rig",
    "RigComparison",
    "Scales",
    "SpecialPoint",
    "Speed",
    "Status",
    "SteadySliding",
    "StickslipError",
    "StribeckFriction",
    "Tabulated",
    "TabulatedFriction",
    "Trajectory",
    "Transitions",
    "__version__",
    "build_config",
    "candidate",
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
