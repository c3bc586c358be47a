"""A law identified where friction differs from event to event: with the constants, by the marginal likelihood."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.laws import LAWS
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.errors import StickslipError
from stickslip.fitted.data import Data, prepare
from stickslip.fitted.identified import Branch, Identified
from stickslip.fitted.identify import Alone, Material
from stickslip.fitted.slip_levels import DeclaredLaw, preferred
from stickslip.likelihoods import declared_numbers
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.block_windows import BlockSensors, drowned
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit, unexplained
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.repeating import lost, repeats
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.scaled import ALPHA, Scaled, scaled, start
from stickslip.likelihoods.scatter_report import of_block, of_rig, way
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.stretches import stretches
from stickslip.measured.case import Recording

DECAYS = (1.5, 12.0)  # over the speed of a slip, that the hyperbolic law is sought from


@dataclass(frozen=True)
class RunsToFit:
    """
    Runs as they are fitted.

    Parameters
    ----------
    data : in the numbers of the fit
    sensors : of the rig
    declared : what is known of constants and gains
    """

    data: Sequence[Data]
    sensors: Sensors
    declared: Declared

    def fit(self, model: Model) -> Fit | None:
        """Return the fit of a model; None where it is none of these windows."""
        numbers = [
            *declared_numbers.of_law(model, POLICY),
            *declared_numbers.of_rig(model, self.declared, self.sensors),
        ]
        cut = stretches(self.data)
        windows = BeltWindows(model, self.data, cut, numbers, self.declared, self.sensors, POLICY)
        try:
            found = null(windows, POLICY)
        except (FloatingPointError, np.linalg.LinAlgError, StickslipError):
            return None
        return None if lost(found) or unexplained(found) > POLICY.noise_left else found


def scattered(
    material: Material,
    declared: Declared,
    tell: Callable[[str, float], None],
    alone: Alone | None,
    *,
    asked: bool,
) -> Identified | None:
    """
    Return what the readings say where friction scatters; None where it does not, or where that cannot be told.

    Parameters
    ----------
    material : rig, runs and the law to start from
    declared : how well constants and gains are known
    tell : told what is being done
    alone : of a block, the law where every slip has levels of its own
    asked : whether scatter is taken for there, be it small
    """
    law = material.friction
    if law is not None and type(law) not in LAWS.values():  # the windows integrate in the core
        return None
    tell("friction of single events", 0.2)
    if any(run.belt_speed == 0 for run in material.runs):
        return None
    if isinstance(material.rig, BlockOnBelt):
        units = scaled(material.rig, material.recordings)
        bench = _of_block(material, declared, units)
        found = None if bench is None else _chosen(bench, material, units, alone)
        if bench is None or found is None or not (asked or not repeats(found[0])):
            return None
        return of_block(material, units, bench.declared, *found)
    if not isinstance(material.rig, Rig) or (data := _prepared(_as_used(material))) is None:
        return None
    fit = RunsToFit(data, RigSensors(), declared).fit(Model(material.rig, friction=law or PaperFriction()))
    return None if fit is None or not (asked or not repeats(fit)) else of_rig(material, declared, fit)


def _as_used(material: Material) -> list[Recording]:
    """The recordings with the belt's speed and the noise that were asked for."""
    out = []
    for one, run in zip(material.recordings, material.runs, strict=True):
        noise = one.noise and dict(zip(("x1", "y1"), run.noise.tolist(), strict=False))
        out.append(replace(one, rig=material.rig, belt_speed=run.belt_speed, noise=noise))
    return out


def _prepared(recordings: Sequence[Recording]) -> list[Data] | None:
    """The runs cut into windows; None where these are too few to tell scatter."""
    if any(one.belt_speed == 0 for one in recordings):
        return None
    try:
        data = prepare(recordings)
    except StickslipError:
        return None
    return data if len(stretches(data)) >= POLICY.fewest_windows else None


def _of_block(material: Material, declared: Declared, units: Scaled) -> RunsToFit | None:
    """A block's runs in scaled numbers; None where they go both ways, or one shows no slips."""
    used = _as_used(material)
    data = _prepared([units.run(one) for one in used])
    if data is None or len({run.belt_speed > 0 for run in data}) > 1:
        return None
    if any(drowned(run) for run in data) or not all(run.track.slips for run in material.runs):
        return None
    channel = used[0].channel("x1")
    force = units.block().stiffness if channel == "spring_force" else None
    return RunsToFit(data, BlockSensors((f"gain.{channel}",), force), declared)


def _chosen(
    bench: RunsToFit, material: Material, units: Scaled, alone: Alone | None
) -> tuple[Fit, float] | None:
    """A block's fit, of the kind declared or else of the likelier one; BIC(Coulomb) - BIC(hyperbolic)."""
    told = DeclaredLaw(material.told, frozenset(material.undeclared))
    if told.law is not None and told.kind is None:
        fit = bench.fit(Model(units.block(), friction=units.law(told.law)))
        return None if fit is None else (fit, 0.0)
    coulomb = start(None, units, material.recordings)
    assert isinstance(coulomb, CoulombFriction)
    plain = bench.fit(Model(units.block(), friction=coulomb))
    starts: Sequence[FrictionLaw] = _falling(coulomb.numbers if plain is None else plain.values())
    if told.kind == "hyperbolic" and not material.undeclared:
        starts = [units.law(_own_way(told.law, way(material)))]
    starts = [*starts, *_shown(material, units, alone)]
    tried = [bench.fit(Model(units.block(), friction=one)) for one in starts]
    falling = min((one for one in tried if one is not None), key=lambda one: one.deviance, default=None)
    by_kind = {"coulomb": plain, "hyperbolic": falling}
    preference = 0.0
    if plain is not None and falling is not None:
        preference = plain.deviance - falling.deviance - math.log(len(plain.own))
    chosen = by_kind[told.kind or preferred(preference)]
    return None if chosen is None else (chosen, preference)


def _shown(material: Material, units: Scaled, alone: Alone | None) -> list[FrictionLaw]:
    """Return the law that slips show one by one, where it falls with speed: without scatter it is there already."""
    if alone is None:
        return []
    try:
        law = alone().law
    except StickslipError:
        return []
    return [units.law(_own_way(law, way(material)))] if isinstance(law, HyperbolicFriction) else []


def _own_way(law: FrictionLaw | None, branch: Branch) -> FrictionLaw:
    """A hyperbolic law as it acts in one direction, for both."""
    assert isinstance(law, HyperbolicFriction)
    names = [one.name for one in fields(law) if not one.name.endswith("_plus")]
    twins = {n: getattr(law, f"{n}_plus", None) for n in names} if branch == "plus" else {}
    return HyperbolicFriction(**{n: getattr(law, n) if (t := twins.get(n)) is None else t for n in names})


def _falling(levels: Mapping[str, float]) -> list[FrictionLaw]:
    """Hyperbolic laws of the same levels as a Coulomb law's, that a fit starts from."""
    static, drop = levels["static"], levels["static"] - levels["kinetic"]
    speed = max(drop / ALPHA, 1e-6)  # largest of a slip, in scaled numbers
    laws: list[FrictionLaw] = []
    for one in DECAYS:
        scale = min(drop * (1 + 1 / (0.5 * one)), 0.9 * static)
        laws.append(HyperbolicFriction(scale=scale, decay=one / speed, constant=static - scale))
    return laws
