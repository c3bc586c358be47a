"""Simulated against measured, of any rig: `compare`."""

from __future__ import annotations

from collections.abc import Callable

from stickslip.arguments import explained, must_be
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError
from stickslip.fitted import compare as named
from stickslip.fitted.compare import Comparison
from stickslip.fitted.identify import BeltSpeed
from stickslip.likelihoods.bodies_compare import RigComparison, compare_bodies
from stickslip.likelihoods.driven_compare import compare_driven
from stickslip.likelihoods.one_thread import one_thread
from stickslip.measured.recording import Recording


@one_thread
@explained
def compare(
    model: Model,
    recording: Recording,
    *,
    belt_speed: BeltSpeed = "set-point",
    progress: Callable[[str, float], None] | None = None,
) -> Comparison | RigComparison:
    """Simulate the model with the run's prescribed speed from the run's estimated start, and measure both alike.

    Parameters
    ----------
    model : Model
        Complete model of the recording's rig.
    recording : Recording
        A run, of a cycle at least.
    belt_speed : "set-point" or "plateau"
        As in `identify`; of a rig of bodies or matrices the set-point.
    progress : callable, optional
        Called with what is being done and the share done.

    Returns
    -------
    Comparison
        With the rows period, stick fraction, slip amplitude, largest slip speed, small slips left out, release and
        capture time errors, missed transitions, phase-portrait distance and forecast error. Forecasts are those of
        `forecast`, from the readings before each window of one cycle or more. Period, amplitude and speed are means
        over the dominant cycle, from release to release of slips at least 0.3 times as large as the typical one
        (`stickslip.fitted.dominant_cycle`), of measurement and simulation alike; the time of smaller slips counts as
        stick.
    RigComparison
        Of a rig of bodies or matrices: of each contact stick fraction, time between slips and fastest slip, the error
        of forecasts one event ahead, and what is left of the readings with friction of each event its own. Of a driven
        slider: the error of forecasts a fortieth of the record ahead, and its largest speed.

    Raises
    ------
    InputError
        If the model does not belong to the recording's rig, or cannot be simulated from the estimated start.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)  # kg, N/m
    >>> law = ss.CoulombFriction(static=2.0, kinetic=1.2)  # N
    >>> t = np.arange(0, 6, 0.002)
    >>> run = ss.simulate(ss.Model(rig, friction=law), belt_speed=0.01, t_end=6, t_eval=t)
    >>> x = 1e3 * run.x1 + 1e-3 * np.random.default_rng(0).standard_normal(t.size)  # mm
    >>> channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}
    >>> recording = ss.load_recording({"t": t, "x1": x}, rig, channels=channels, belt_speed=0.01)
    >>> compared = ss.compare(ss.Model(rig, friction=law), recording)
    >>> print(f"forecast NRMSE {compared.rows[-1].simulated:.3f}")
    forecast NRMSE 0.001
    >>> len(compared.rows)
    10
    """
    must_be("model", model, Model, "load_model(file) or identify(case).model give one")
    if isinstance(model.rig, DrivenSlider):
        must_be("recording", recording, Recording, "one of a case's runs, like case.validate[0]")
        return compare_driven(model, recording, progress)
    if not isinstance(model.rig, GeneralRig):
        return named.compare(model, recording, belt_speed=belt_speed, progress=progress)
    must_be("recording", recording, Recording, "one of a case's runs, like case.validate[0]")
    if belt_speed != "set-point":
        raise InputError("is for a named rig; leave it out for a rig of bodies or matrices", key="belt_speed")
    return compare_bodies(model, recording, progress)
