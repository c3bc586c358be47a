"""What a long computation is doing, said on standard error while it runs.

A share done and a count have a bar on a terminal. A search has stages: a line that changes on a terminal, a line now
and then in a log.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

EVERY = 10.0  # seconds after which a log hears of a stage that lasts


class StageStep(str):
    """What is being done, in words, where it is one of a stage's steps: a text like any other to who prints it.

    Parameters
    ----------
    words : str
        "trying sensor_lag + belt_seam".
    stage : str
        What all its steps are called together: "trying sensor_lag + each other effect".
    beside : int, optional
        Where every effect is tried, one a step: how many are there already and so are not tried.
    """

    __slots__ = ("beside", "stage")
    stage: str
    beside: int | None

    def __new__(cls, words: str, stage: str, beside: int | None = None) -> Self:
        """Make the text, which cannot be changed any more."""
        step = super().__new__(cls, words)
        step.stage, step.beside = stage, beside
        return step

    def __reduce__(self) -> tuple[type[StageStep], tuple[str, str, int | None]]:
        return type(self), (str(self), self.stage, self.beside)  # a caller may send it to another process


def trying(base: Sequence[str], name: str) -> StageStep:
    """StageStep of the stage in which each effect is tried beside those of `base`."""
    stage = f"trying {' + '.join(base)} + each other effect" if base else "trying each effect"
    return StageStep(f"trying {' + '.join([*base, name])}", stage, len(base))


@contextmanager
def shares(title: str, *, every: float = EVERY) -> Iterator[Callable[[str, float], None]]:
    """Yield what is to be told what is being done and the share done: a bar on a terminal, else a line now and then.

    A log hears nothing of what takes less than `every` seconds.
    """
    to = Console(stderr=True, highlight=False)
    if not to.is_terminal:
        with _Log(to, 0, every, quiet=True).beating() as log:
            yield lambda what, share: log.tell(f"{title}: {what}, {share:.0%} done")
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=to, transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda what, share: bar.update(task, description=f"{title}: {what}", completed=share)


@contextmanager
def counts(title: str, most: int, shown: bool) -> Iterator[Callable[[int], None]]:
    """Yield what is to be told how many more are done of `most`; a bar where it is wanted."""
    left = (TextColumn("left"), TimeRemainingColumn())
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        *left,
    )
    with Progress(*columns, console=Console(stderr=True), disable=not shown) as bar:
        task = bar.add_task(title, total=most)
        yield lambda done: bar.advance(task, done)


@contextmanager
def stages(title: str, effects: int = 0, *, every: float = EVERY) -> Iterator[Callable[[str], None]]:
    """Say what is being tried.

    Parameters
    ----------
    title : str
        Of the line on a terminal.
    effects : int
        How many effects are tried at most, one after the other; 0 if that is not known.
    every : float
        Seconds after which a log hears of a stage that lasts.

    Yields
    ------
    callable
        To be told in words what is being done; a `StageStep` says of which stage it is, other words are their own.
    """
    err = Console(stderr=True, highlight=False)
    if not err.is_terminal:
        with _Log(err, effects, every).beating() as log:
            yield log.tell
        return
    began = time.monotonic()
    with err.status(title) as status:
        yield lambda what: status.update(f"{title}: {what} [dim]({time.monotonic() - began:.0f} s)[/dim]")


class _Log:
    """Lines for a log: one for each stage, if not quiet, and one every so many seconds of a stage that lasts."""

    def __init__(self, to: Console, effects: int, every: float, *, quiet: bool = False) -> None:
        self.to, self.effects, self.every, self.quiet = to, effects, every, quiet
        self.began = self.said = time.monotonic()
        self.stage = self.now = ""
        self.most = 0  # steps that the stage has at most; 0 if that is not known
        self.seen: list[str] = []  # what was begun in the stage, the present one last
        self.over = threading.Event()
        self.lock = threading.Lock()

    def tell(self, what: str) -> None:
        """Take note of what is being done; a new stage is said at once."""
        with self.lock:
            self.now = what
            if self.quiet:
                return
            stage, beside = (what.stage, what.beside) if isinstance(what, StageStep) else (what, None)
            if stage != self.stage:
                self.stage, self.seen = stage, [what]
                self.most = 0 if beside is None or not self.effects else self.effects - beside
                self._say(stage)
            elif what not in self.seen:
                self.seen.append(what)

    @contextmanager
    def beating(self) -> Iterator[_Log]:
        """Say what goes on meanwhile; a thread does, for a single fit may take minutes without a word."""
        thread = threading.Thread(target=self._beat, daemon=True)
        thread.start()
        try:
            yield self
        finally:
            self.over.set()
            thread.join()

    def _beat(self) -> None:
        while not self.over.wait(max(0.0, self.said + self.every - time.monotonic())):
            with self.lock:
                if time.monotonic() - self.said >= self.every:
                    self._say(self._meanwhile())

    def _meanwhile(self) -> str:
        if self.quiet and self.now:
            return self.now
        if not self.stage:
            return "still at the start"
        if self.stage == self.now:
            return f"still {self.stage}"
        done = len(self.seen) - 1
        of = f" of at most {self.most}" if self.most > done else ""
        return f"{self.stage}: {done}{of} done, now {self.now}"

    def _say(self, line: str) -> None:
        self.said = time.monotonic()
        self.to.print(f"[{self.said - self.began:5.1f} s] {line}", markup=False, soft_wrap=True)
