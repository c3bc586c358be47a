"""A model of a rig of bodies or matrices against a recording: rows of one table, and a free run beside the readings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import percent
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.bodies_data import BodiesData, prepare_bodies
from stickslip.fitted.comparison_rows import GOOD, POOR, Row
from stickslip.likelihoods.band import SHOWN
from stickslip.likelihoods.bodies_ahead import free_run, one_ahead
from stickslip.likelihoods.bodies_cuts import cuts, starts_of_slips
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import unexplained
from stickslip.likelihoods.own_phases import as_it_ran
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared
from stickslip.measured.recording import Recording
from stickslip.objects import Drawn, one_line

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class RigComparison(Drawn):
    """What `compare` finds on a rig of bodies or matrices, or a driven slider.

    Attributes
    ----------
    rows : tuple of Row
        The table, a row a quantity: measured, simulated, and the scatter of what was measured.
    model, recording
        What was compared.
    t : (n,)
        Times from the first window on [s].
    channels
        Names of the readings.
    readings, simulated : (n, channels)
        Measured, and a free run of the model with friction of the mean event, in SI. A driven slider is followed in
        pieces instead: nothing draws it back to where it was.
    ahead
        How far ahead the error of forecasts is.
    begins
        Samples at which these pieces begin.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> pin = ss.MatricesRig(M=[[0.5]], C=[[0.4]], K=[[800]], contact=[1], names=["x"])  # kg, N s/m, N/m
    >>> law = ss.CoulombFriction(static=4.0, kinetic=2.0)  # N
    >>> t = np.arange(0, 2, 0.002)
    >>> run = ss.simulate(ss.Model(pin, friction=law), belt_speed=0.05, initial=(0, 0.05), t_end=2, t_eval=t)
    >>> x = run.x + 1e-5 * np.random.default_rng(0).standard_normal(t.size)  # m
    >>> recording = ss.load_recording({"t": t, "x": x}, pin, belt_speed=0.05, noise={"x": 1e-5})
    >>> found = ss.identify(recording, friction=law)
    >>> compared = ss.compare(found.model, recording)
    >>> row = compared.rows[0]
    >>> print(f"{row.quantity}: {row.measured:.2f} measured, {row.simulated:.2f} simulated")
    stick fraction of contact_1: 0.50 measured, 0.50 simulated
    """

    rows: tuple[Row, ...]
    model: Model
    recording: Recording
    t: Floats
    channels: tuple[str, ...]
    readings: Floats
    simulated: Floats
    ahead: str = "one event"
    begins: tuple[int, ...] = (0,)

    def __repr__(self) -> str:
        return one_line(
            f"<RigComparison with '{self.recording.name}': {len(self.rows)} rows, {len(self.t)} samples>"
        )

    def __str__(self) -> str:
        return self.table()

    def row(self, quantity: str) -> Row:
        """The row of that name; KeyError if there is none."""
        return {r.quantity: r for r in self.rows}[quantity]

    def table(self) -> str:
        """The rows as plain text."""
        lines = [f"{'quantity':<40}{'measured':>12}{'simulated':>12}{'difference':>12}{'scatter':>11}  unit"]
        for r in self.rows:
            cells = "".join(f"{cell:>12}" for cell in r.cells[:3])
            lines.append(f"{r.quantity:<40}{cells}{r.cells[3]:>11}  {r.unit}")
        return "\n".join([*lines, *self.verdict()])

    def verdict(self) -> tuple[str, ...]:
        """Sentences that say what the rows amount to."""
        error = self.row("forecast error").simulated
        left = next((one.simulated for one in self.rows if one.quantity == "noise left"), None)
        assert error is not None
        how = "good" if error < GOOD else "of no use" if error > POOR else "fair"
        said = [f"{self.ahead} ahead the model errs by {percent(error)} of how far the readings move: {how}"]
        if left is not None and left > POLICY.noise_left:
            words = f"{left:.3g} times the noise is left with friction of each event its own"
            said.append(f"{words}: the model lacks something")
        return tuple(said)

    def to_dict(self) -> dict[str, object]:
        """The rows for JSON."""
        return {"rows": [{**vars(r), "difference": r.difference} for r in self.rows]}


def compare_bodies(
    model: Model, recording: Recording, progress: Callable[[str, float], None] | None = None
) -> RigComparison:
    """Simulate a model with a run's prescribed speeds from its estimated start, and measure both alike.

    Parameters
    ----------
    model, recording
        Of one rig of bodies or matrices.
    progress
        Called with what is being done and the share done.

    Raises
    ------
    InputError
        Another rig, or a run that is too short.
    StickslipError
        The model cannot be simulated from the estimated start.
    """
    tell = progress or (lambda _what, _share: None)
    rig = model.rig
    if not isinstance(rig, GeneralRig) or getattr(recording.rig, "state_names", ()) != rig.state_names:
        raise InputError(f"{recording.name} was recorded on another rig than the model's", key="model")
    tell("reading the motion", 0.0)
    run = prepare_bodies(rig, [recording], model.friction)[0]
    cut = cuts([run])
    if len(cut) < SHOWN:
        raise InputError(f"{recording.name} holds {len(cut)} windows; {SHOWN} are needed")
    tell("fitting the starts of windows", 0.1)
    try:
        own, run = as_it_ran(model, run, cut)
        fit = null(BodiesWindows(own, [run], cut, [], Declared()), POLICY)
    except (FloatingPointError, np.linalg.LinAlgError):
        raise StickslipError("no window of the run can be simulated with this model") from None
    tell("simulating", 0.7)
    part = slice(cut[0].start, len(run.t))
    simulated = free_run(fit, run, part)
    error = one_ahead(fit, run).error
    rows = [*_contact_rows(rig, run, part, _as_read(model, recording, run, part, simulated))]
    rows.append(
        Row("forecast error", "1", None, error, None, "one event ahead, over how far the readings move")
    )
    meaning = "chi-squared per reading, friction of each event its own"
    rows.append(Row("noise left", "1", None, unexplained(fit), None, meaning))
    tell("done", 1.0)
    return RigComparison(
        tuple(rows), model, recording, run.t[part], run.channels, run.readings[part], simulated
    )


def _as_read(
    model: Model, recording: Recording, run: BodiesData, part: slice, simulated: Floats
) -> BodiesData:
    """The free run as it would have been recorded, noise included."""
    noisy = simulated + run.noise * np.random.default_rng(0).standard_normal(simulated.shape)
    own = dict(zip(run.channels, noisy.T, strict=True))
    kept = {name: one[part] for name, one in recording.coordinates.items()} | own
    assert isinstance(model.rig, GeneralRig)
    t = recording.t[part]
    shown = replace(recording, t=t, coordinates=kept, speeds=recording.since(float(t[0])))
    return prepare_bodies(model.rig, [shown], model.friction)[0]


def _contact_rows(rig: GeneralRig, run: BodiesData, part: slice, other: BodiesData) -> list[Row]:
    out = []
    for j, one in enumerate(rig.equations.contacts):
        if not run.seen[j]:
            continue
        sides = []
        for data, own in ((run, part), (other, slice(None))):
            stuck = data.stuck[own, j]
            slip = np.abs(one.slip(data.v[own], data.belt(data.t[own])))
            gaps = np.diff(starts_of_slips(data, j, own))
            sides.append((float(stuck.mean()), gaps, float(np.quantile(slip, 0.999))))
        (stick, gaps, fast), (stick_, gaps_, fast_) = sides
        unit = "rad/s" if one.rotation else "m/s"
        out.append(
            Row(f"stick fraction of {one.name}", "1", stick, stick_, None, "share of the time at rest")
        )
        mean, mean_ = (float(g.mean()) if len(g) else np.nan for g in (gaps, gaps_))
        spread = float(gaps.std()) if len(gaps) > 1 else None
        out.append(
            Row(f"time between slips of {one.name}", "s", mean, mean_, spread, "from release to release")
        )
        out.append(
            Row(f"fastest slip of {one.name}", unit, fast, fast_, None, "exceeded by 0.1 % of the samples")
        )
    return out
