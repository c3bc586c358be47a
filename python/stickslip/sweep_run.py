"""The chunks of a sweep computed: by threads here, or by the workers of a dask cluster; with a progress bar."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from stickslip.sweep_observe import Arrays
from stickslip.sweep_request import Block, Request, joined

if TYPE_CHECKING:
    from distributed import Client

Deliver = Callable[[Block, Arrays], None]
AHEAD = 2  # chunks handed out beyond the one being waited for


def run_local(request: Request, blocks: Iterable[Block], threads: int, deliver: Deliver) -> None:
    """Compute chunks in threads and deliver them in order.

    On an interrupt it returns at once; a batch that a thread is at ends by itself and is forgotten.
    """
    if threads == 1:
        for block in blocks:
            deliver(block, request.compute_block(block))
        return
    pool = ThreadPoolExecutor(threads, thread_name_prefix="sweep")
    under_way: deque[tuple[Block, list[Future[Arrays]]]] = deque()

    def finish() -> None:
        block, parts = under_way[0]
        results = [part.result() for part in parts]
        under_way.popleft()
        deliver(block, joined(results))

    try:
        for block in blocks:
            under_way.append(
                (block, [pool.submit(request.compute, *batch) for batch in request.batches(block)])
            )
            while len(under_way) > AHEAD:
                finish()
        while under_way:
            finish()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def run_dask(request: Request, blocks: Iterable[Block], client: Client, deliver: Deliver) -> None:
    """Compute chunks on a cluster; one whose worker dies is computed by another.

    Chunks are few at a time on the way, so that a large sweep does not wait in the scheduler's memory.
    """
    from distributed import as_completed

    cluster: Any = client  # distributed declares few types
    completed: Any = as_completed
    shared = cluster.scatter(request, broadcast=True)  # the same for every chunk: sent once
    todo: Iterator[Block] = iter(blocks)
    where: dict[str, Block] = {}

    def submit(block: Block) -> Any:
        future = cluster.submit(_block, shared, block, pure=False, retries=3)
        where[future.key] = block
        return future

    at_once = 2 * max(1, sum(cluster.nthreads().values())) + AHEAD
    flow = completed([submit(block) for block in itertools.islice(todo, at_once)])
    try:
        for future in flow:
            deliver(where.pop(future.key), future.result())
            future.release()
            block = next(todo, None)
            if block is not None:
                flow.add(submit(block))
    except BaseException:
        cluster.cancel(list(flow.futures))
        raise


def _block(request: Request, block: Block) -> Arrays:
    return request.compute_block(block)


@contextmanager
def telling(members: int, shown: bool) -> Iterator[Callable[[int], None]]:
    """A progress bar over members on standard error, where it is wanted."""
    if not shown:
        yield lambda _: None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("sweep", total=members)
        yield lambda done: bar.advance(task, done)
