"""The chunks of a sweep computed by the workers of a dask cluster, which may die, or be built another way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stickslip import _core
from stickslip.errors import InputError, StickslipError
from stickslip.simulated.instruction_set import NAMES
from stickslip.simulated.sweep.observables import Arrays
from stickslip.simulated.sweep.request import GridBlock, Request
from stickslip.simulated.sweep.threads import AHEAD, Deliver

if TYPE_CHECKING:
    from distributed import Client

TRIES = 3  # times in a row that all workers may be lost before a chunk is computed
Build = tuple[str, str]  # what the last bits depend on: instruction set, version


class WorkersLostError(StickslipError):
    """The cluster loses its workers faster than they compute."""


@dataclass
class _Work:
    """Chunks still to be handed out: those that were lost before the others."""

    todo: Iterator[GridBlock]
    lost: list[GridBlock] = field(default_factory=list)
    delivered: int = 0

    def following(self) -> GridBlock | None:
        return self.lost.pop() if self.lost else next(self.todo, None)


def usable(client: Client) -> None:
    """Refuse what is no client, and one that cannot be waited for."""
    if not hasattr(client, "scatter"):
        raise InputError(f"must be a dask.distributed.Client, not {type(client).__name__}", key="client")
    status = getattr(client, "status", "running")
    if getattr(client, "asynchronous", False) or status == "newly-created":
        raise InputError("is asynchronous; give one made without asynchronous=True", key="client")
    if status in ("closing", "closed"):
        raise InputError("is closed; give one that is open", key="client")


def run_dask(request: Request, blocks: Iterable[GridBlock], client: Client, deliver: Deliver) -> None:
    """Compute chunks on a cluster; one whose worker dies is computed by another.

    What the workers share is lost with the last of them: it is sent anew, with the chunks that were on the way.

    Raises
    ------
    WorkersLostError
        The workers were lost several times in a row, or a chunk ended each worker it was given to.
    InputError
        A worker would compute other last bits than this machine: its instruction set or version is another.
    """
    work, fruitless = _Work(iter(blocks)), 0
    while fruitless < TRIES:
        before = work.delivered
        if _round(request, work, client, deliver):
            return
        fruitless = fruitless + 1 if work.delivered == before else 0
    raise WorkersLostError(f"the cluster lost its workers {TRIES} times in a row")


def _round(request: Request, work: _Work, client: Client, deliver: Deliver) -> bool:
    """Hand chunks out until all are delivered, or until the workers that hold the request are lost (False).

    Chunks are few at a time on the way, so that a large sweep does not wait in the scheduler's memory.
    """
    from distributed import as_completed

    cluster: Any = client  # distributed declares few types
    completed: Any = as_completed
    try:
        # the same for every chunk: sent once, and under a new name, since the scheduler may still know a lost one
        shared = cluster.scatter(request, broadcast=True, hash=False)
    except OSError:  # no worker came in time, or the scheduler is gone
        return False
    where: dict[str, GridBlock] = {}
    flow = completed([])

    def submit() -> None:
        block = work.following()
        if block is not None:
            future = cluster.submit(computed_here, shared, block, build(), pure=False, retries=3)
            where[future.key] = block
            flow.add(future)

    try:
        for _ in range(2 * max(1, sum(cluster.nthreads().values())) + AHEAD):
            submit()
        for future in flow:
            try:
                computed = _result(future)
            except CancelledError:
                work.lost += where.values()
                cluster.cancel(list(flow.futures))
                return False
            deliver(where.pop(future.key), computed)
            work.delivered += 1
            future.release()
            submit()
    except BaseException:
        cluster.cancel(list(flow.futures))
        raise
    return True


def _result(future: Any) -> Arrays:
    from distributed import KilledWorker

    try:
        computed: Arrays | str = future.result()
    except KilledWorker as error:
        raise WorkersLostError("a chunk of the sweep ended each worker that computed it") from error
    if isinstance(computed, str):
        raise InputError(computed, key="client")
    return computed


def build() -> Build:
    """Instruction set and version of this process."""
    config = _core.build_config()
    return str(config["isa"]), str(config["version"])


def computed_here(request: Request, block: GridBlock, asked: Build) -> Arrays | str:
    """Compute a chunk; or say, in a sentence and not as an error that dask would try again, why this worker may not."""
    here = build()
    return request.compute_block(block) if here == asked else _differs(here, asked)


def _differs(there: Build, here: Build) -> str:
    if there[1] != here[1]:
        return f"a worker has stickslip {there[1]}, this process {here[1]}; install the same version on both"
    narrower = min(there[0], here[0], key=NAMES.index)
    return (
        f"a worker computes with {there[0]} instructions, this process with {here[0]}, and their last bits differ; "
        f"STICKSLIP_ISA={narrower} in the environment of both pins one"
    )
