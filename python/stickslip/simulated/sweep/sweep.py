"""Many trajectories of a model: `sweep`, over any of its numbers, in memory, out of core or on a cluster."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import psutil
from numpy.typing import ArrayLike

from stickslip import _core
from stickslip.arguments import explained, whole_number
from stickslip.arguments import path as as_path
from stickslip.declared.drive import KEY, Drive, Pull, pull_or_force
from stickslip.declared.friction_sign import driving_friction
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, DrivenSlider
from stickslip.declared.scale import written_speed, written_time
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, ModelWarning, number
from stickslip.progress import counts
from stickslip.simulated.lowering import lower
from stickslip.simulated.named_places import whole
from stickslip.simulated.simulate import checked_initial, checked_tolerances
from stickslip.simulated.simulate_bodies import constant_speed, needs_bodies
from stickslip.simulated.sweep.bodies import BodiesRequest, checked_start, named, speed_names
from stickslip.simulated.sweep.cluster import WorkersLostError, run_dask, usable
from stickslip.simulated.sweep.grid import Grid, make_grid
from stickslip.simulated.sweep.observables import DEFAULT, TAKEN, Arrays, chosen
from stickslip.simulated.sweep.request import GridBlock, Request
from stickslip.simulated.sweep.store import MemorySink, Sink, ZarrSink
from stickslip.simulated.sweep.threads import run_local

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client


@explained
def sweep(
    model: Model,
    over: Mapping[str, object],
    *,
    t_end: float | str,
    initial: ArrayLike | None = None,
    belt_speed: float | str | Speed | None = None,
    drive_speed: float | str | Speed | None = None,
    drive: Drive | None = None,
    rtol: float = 1e-8,
    atol: float = 1e-8,
    observe: str | Iterable[str] = DEFAULT,
    after: float | str = 0.0,
    threads: int | None = None,
    progress: bool = False,
    client: Client | None = None,
    out: str | os.PathLike[str] | None = None,
    points: int = 32,
    lanes: bool = True,
    max_transitions: int = 1_000_000,
    max_steps: int = 5_000_000,
) -> xr.Dataset:
    """Simulate the model for every combination of some of its numbers and keep what is observed on the way.

    Parameters
    ----------
    model
        What to simulate.
    over
        What varies: name -> array of values. The name is one of `model.parameters` ("alpha1", "T_s_minus",
        "block_viscous_damping.c"), "belt_speed" or "initial.x1" ...; it becomes a dimension, and several make their
        grid. A pair (dimension, array) puts the name on a shared dimension instead:
        ``{"alpha1": ("member", a), "alpha2": ("member", a / 2)}``.
    t_end
        End of every run, in the rig's unit of time or with a unit ("60 s"); runs start at 0.
    initial
        State at the start as for `simulate`; at rest at the origin if absent.
    belt_speed, drive_speed, drive
        v_b, the drive's speed, and the force on a `DrivenSlider`, where they do not vary; as for `simulate`. In
        `over` the force is "drive".
    rtol, atol
        Error allowed to each step.
    observe
        Names of results, below.
    after
        Time from which observables count (not final_state): what is before is left out as a transient.
    threads
        Of this machine; all that the process may use if absent. Results do not depend on it.
    progress
        Show a progress bar on standard error.
    client
        A `dask.distributed` client whose workers compute instead.
    out
        Folder of a Zarr store to write chunk by chunk, in little memory. One that is there is gone on with: only
        what is missing is computed, and the result is the uninterrupted one to the last bit.
    points
        Release points kept for each member, the last ones; at most 64.
    lanes
        Several members at once in the lanes of the processor; False computes them singly, equal within rounding.
    max_transitions
        Transitions and kinks after which a member is given up.
    max_steps
        Integration steps after which a member is given up: its span is very long, or its equations are stiff.

    Returns
    -------
    xarray.Dataset
        Over the dimensions of `over` (..): final_state (.., state), stick_fraction, transitions, releases (stick to
        slip, and crossings of v_w = 0 that do not stick), slips (stick to slip alone), period and period_spread (mean
        and standard deviation of the time between releases), periodicity (least number of releases after which their
        points repeat; 0 if none does), state_min, state_max (.., state), dissipated, points (.., point, state) and
        point_time (.., point): states and times of the last releases, the last first, NaN where there was none; status
        (its flags in the attributes; the others are NaN or -1 where it is not "finished"). Attributes say the model,
        the settings and the build. Of a rig of several contacts counts and dissipated are those of all contacts,
        stick_fraction is their mean.

    Raises
    ------
    InputError
        A name, value or setting is wrong; said before any work.

    Warns
    -----
    ModelWarning
        An effect turns the sign of friction, as in `simulate`, in a member at an end of what varies.

    Notes
    -----
    An interrupt (Ctrl-C) returns what is done with a warning; the rest has status -1, "not_computed". So does a
    cluster that loses all its workers again and again; with `out` that is an error, and the same call goes on.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> over = {"belt_speed": np.linspace(0.05, 0.2, 4)}
    >>> ds = ss.sweep(model, over, t_end=400, after=300, observe=("stick_fraction", "period"))
    >>> print(ds.period.values.round(3))
    [ 8.324 10.484  4.08   3.781]
    """
    if client is not None:
        usable(client)
    asked = _SweepCall(
        t_end,
        initial,
        (belt_speed, drive_speed),
        (rtol, atol),
        observe,
        after,
        points,
        lanes,
        (max_transitions, max_steps),
        drive,
    )
    request = _request(model, over, asked)
    workers = _threads(threads)
    if model.effects:
        for said in _driving(request):
            warnings.warn(f"{said} (in some members at least)", ModelWarning, stacklevel=3)
    _fits(request, out)
    sink: Sink = MemorySink(request) if out is None else ZarrSink(request, as_path("out", out))
    _compute(request, sink, workers, progress, client)
    return sink.dataset()


def _driving(request: Request) -> list[str]:
    """What is said of effects that turn the sign of friction, each of what varies at its least and greatest."""
    model, ends = request.model, [request.model]
    for column in request.grid.columns:
        if column.full_name in model.parameters:
            for value in (column.values.min(), column.values.max()):
                with suppress(InputError):  # allowed beside another value of a shared dimension alone
                    ends.append(model.replace({column.full_name: float(value)}))
    said = [one for end in ends for one in driving_friction(end, 0.0, request.t_end)]
    return list({one.partition(":")[0].partition(".")[0]: one for one in reversed(said)}.values())


def _compute(request: Request, sink: Sink, threads: int, progress: bool, client: Client | None) -> None:
    computed, there = 0, 0
    with counts("sweep", request.grid.members, progress) as tell:

        def deliver(block: GridBlock, arrays: Arrays) -> None:
            nonlocal computed
            sink.put(block, arrays)
            computed += block.stop - block.start
            tell(block.stop - block.start)

        def missing() -> Iterable[GridBlock]:
            nonlocal there
            reached = 0
            for block in sink.missing(request.blocks()):
                tell(block.start - reached)  # those between were there already
                there += block.start - reached
                reached = block.stop
                yield block
            tell(request.grid.members - reached)
            there += request.grid.members - reached

        try:
            if client is None:
                run_local(request, missing(), threads, deliver)
            else:
                run_dask(request, missing(), client, deliver)
        except (KeyboardInterrupt, WorkersLostError) as stopped:
            done = f"{computed + there} of {request.grid.members} members"
            why = "sweep interrupted"
            if isinstance(stopped, WorkersLostError):
                why = str(stopped)
                _raise_if_kept(why, done, sink, computed)
            warnings.warn(f"{why}: {done} computed, the rest has status -1", stacklevel=3)


def _raise_if_kept(why: str, done: str, sink: Sink, computed: int) -> None:
    """A sweep whose cluster failed is an error, unless that would throw away what memory alone holds."""
    if isinstance(sink, ZarrSink):
        raise InputError(f"{why}; {done} are in the store, and the same call goes on", key="client") from None
    if not computed:
        raise InputError(f"{why} before any member was computed", key="client") from None


@dataclass(frozen=True)
class _SweepCall:
    """What a call asks of every member, as it was given; `speeds` are the belt's and the drive's."""

    t_end: float | str
    initial: ArrayLike | None
    speeds: tuple[float | str | Speed | None, float | str | Speed | None]
    tolerances: tuple[float, float]
    observe: str | Iterable[str]
    after: float | str
    points: int
    lanes: bool
    most: tuple[int, int]
    drive: Drive | None = None

    def checked(self, rig: AnyRig) -> dict[str, Any]:
        """Return the settings of every sweep."""
        end = number("t_end", written_time(self.t_end, rig, "t_end"), above=0)
        after = written_time(self.after, rig, "after")
        rtol, atol = checked_tolerances(*self.tolerances)
        return {
            "t_end": end,
            "after": number("after", after, least=0, below=end, why="it must come before t_end"),
            "rtol": rtol,
            "atol": atol,
            "observe": chosen(self.observe),
            "points": whole_number("points", self.points, least=2, most=_core.MAX_SWEEP_POINTS),
            "lanes": _yes_or_no("lanes", self.lanes),
            "max_transitions": whole_number("max_transitions", self.most[0]),
            "max_steps": whole_number("max_steps", self.most[1]),
        }


def _request(model: Model, over: Mapping[str, object], asked: _SweepCall) -> Request:
    if not isinstance(model, Model):
        raise InputError(f"must be a Model, not {type(model).__name__}", key="model")
    keys = ("belt_speed", "drive_speed")
    belt, pull = (written_speed(given, model.rig, key) for given, key in zip(asked.speeds, keys, strict=True))
    asked = replace(asked, speeds=(belt, _pull_or_force(model.rig, over, pull, asked.drive)))
    if needs_bodies(model, *asked.speeds):
        return _bodies_request(model, over, asked)
    belt_speed = asked.speeds[0]
    speed = 0.0 if belt_speed is None else constant_speed(belt_speed)
    lowered = lower(model, speed)
    grid = make_grid(over, model, lowered, TAKEN)
    _belt_speed_is_given_once(grid, belt_speed)
    start = tuple(float(x) for x in checked_initial(model, lowered, asked.initial))
    return Request(model=model, grid=grid, belt_speed=speed, initial=start, **asked.checked(model.rig))


def _bodies_request(model: Model, over: Mapping[str, object], asked: _SweepCall) -> Request:
    """Return the sweep of what only the core of general rigs simulates."""
    given: object = over
    varied = given if isinstance(given, Mapping) else {}
    speeds = dict(zip(speed_names(model.rig), asked.speeds, strict=True))
    for key, one in speeds.items():
        if key in varied and one is not None:
            raise InputError("varies in `over`; leave it out here", key=key, value=str(one))
    own = whole(model, *(0.0 if key in varied else one for key, one in speeds.items()))
    grid = make_grid(over, model, named(own, model.parameters), TAKEN)
    settings = asked.checked(model.rig)
    belt, drive = (None if one is None else Speed.of(one, key) for key, one in speeds.items())
    start = checked_start(own, asked.initial)
    return BodiesRequest(
        model=model, grid=grid, belt_speed=0.0, initial=start, speeds=(belt, drive), **settings
    )


def _pull_or_force(rig: AnyRig, over: object, pull: Pull, drive: Drive | None) -> Pull:
    """Return the speed of a drive that pulls, or the force of a driven slider's in its place."""
    if drive is None and isinstance(over, Mapping) and KEY in over and isinstance(rig, DrivenSlider):
        return pull
    return pull_or_force(rig, pull, drive)


def _yes_or_no(key: str, value: object) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise InputError("must be True or False", key=key, value=value)
    return bool(value)


def _belt_speed_is_given_once(grid: Grid, belt_speed: object) -> None:
    varies = any(column.name == "belt_speed" for column in grid.columns)
    if varies and belt_speed is not None:
        raise InputError("varies in `over`; leave it out here", key="belt_speed", value=belt_speed)
    if not varies and belt_speed is None:
        raise InputError("missing; give a number, or vary it in `over`", key="belt_speed")


def _threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return whole_number("threads", threads, most=4096)


def _fits(request: Request, out: object) -> None:
    """Refuse what memory cannot hold, before any of it is touched."""
    needed = request.grid.members * request.bytes_a_member()
    free = psutil.virtual_memory().available
    if out is None and needed > free:
        words = f"{request.grid.members} members need {_size(needed)} of memory, more than is free"
        raise InputError(f"{words}; give out='result.zarr' to write them chunk by chunk", key="over")


def _size(count: float) -> str:
    for unit in ("B", "KiB", "MiB", "GiB", "TiB"):
        if count < 1024:
            return f"{count:.3g} {unit}"
        count /= 1024
    return f"{count:.4g} PiB"
