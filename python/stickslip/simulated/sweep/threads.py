"""The chunks of a sweep computed by threads of this machine."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor

from stickslip.simulated.sweep.observables import Arrays
from stickslip.simulated.sweep.request import GridBlock, Request, joined

Deliver = Callable[[GridBlock, Arrays], None]
AHEAD = 2  # chunks handed out beyond the one being waited for


def run_local(request: Request, blocks: Iterable[GridBlock], threads: int, deliver: Deliver) -> None:
    """Compute chunks in threads and deliver them in order.

    On an interrupt it returns at once; a batch that a thread is at ends by itself and is forgotten.
    """
    if threads == 1:
        for block in blocks:
            deliver(block, request.compute_block(block))
        return
    pool = ThreadPoolExecutor(threads, thread_name_prefix="sweep")
    under_way: deque[tuple[GridBlock, list[Future[Arrays]]]] = deque()

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
