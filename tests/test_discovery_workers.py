"""Fits in other processes: the same numbers, in order, their time counted, and what happens when a process dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from discover_cases import RIG, make_case
from stickslip.declared.effect import effect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery import trace, workers
from stickslip.discovery.loop import discover
from stickslip.discovery.search import CLEAN, LARGEST, Search
from stickslip.discovery.trace import NEARLY, _stuck, declared, screen
from stickslip.discovery.workers import Workers, each
from stickslip.fitted.data import prepare
from stickslip.fitted.unknowns import Hypothesis, law_unknowns


@pytest.fixture(scope="module")
def data():
    return prepare(make_case((effect("spring_cubic_k2", k=6.0),)).train[:2])


def search_in(data, processes, budget=1e6):
    return Search(
        data,
        Model(RIG, friction=PaperFriction()),
        processes,
        lambda _: None,
        budget,
        workers=Workers(processes),
    )


def square(_search, number):
    return number * number


def busy(_search, seconds):
    begin = time.process_time()
    while time.process_time() - begin < seconds:
        pass
    return os.getpid()


def dies_elsewhere(_search, parent):
    if os.getpid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)
    return "here"


def runs(process):
    """Is there such a process that is not over? Not every machine's first process buries the dead."""
    stat = Path(f"/proc/{process}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"


def test_a_worker_finds_the_same_numbers_on_our_data(data):
    here, there = search_in(data, 1), search_in(data, 2)
    base = [declared(search) for search in (here, there)]
    alone, beside = screen(here, base[0]), screen(there, base[1])
    assert [one.names for one in alone] == [one.names for one in beside]
    for one, other in zip(alone, beside, strict=True):
        assert np.array_equal(one.fit.vector, other.fit.vector)
        assert one.fit.cost == other.fit.cost
        assert other.fit.engine.data is there.data
        assert other.fit.engine.threads == 2
    assert alone[0].names == ("spring_cubic_k2",)
    assert there.spent > 0 == here.spent


def test_results_come_in_order_and_are_computed_elsewhere(data):
    search = search_in(data, 2)
    assert [task.result() for _, task in each(search, square, range(7))] == [k * k for k in range(7)]
    assert all(task.result() != os.getpid() for _, task in each(search, busy, [0.0, 0.0]))


def test_alone_only_what_is_asked_for_is_computed(data):
    search, done, said = search_in(data, 1), [], []
    search.progress = said.append
    for k, task in each(search, lambda _, k: done.append(k), range(5), str, ahead=3):
        if k == 2:
            break
        task.result()
    assert done == [0, 1]
    assert said == ["0", "1", "2"]


@pytest.mark.parametrize(("ahead", "begun"), [(1, [2, 3]), (2, [2, 3, 4, 5, 6])])
def test_what_is_not_needed_any_more_is_cancelled(ahead, begun):
    cancelled = []

    def submit(_function, item):
        return SimpleNamespace(result=lambda: item, cancel=lambda: cancelled.append(item))

    search = SimpleNamespace(submit=submit, at_once=3, progress=lambda _: None)
    for k, _ in each(search, square, range(9), ahead=ahead):
        if k == 1:
            break
    assert cancelled == begun


def test_the_time_of_workers_is_off_the_budget(data):
    search = search_in(data, 2, budget=100.0)
    before = search.left
    search.submit(busy, 0.5).result()
    assert 0.5 <= before - search.left < 5.0
    assert search.away().budget == LARGEST  # one process's work never takes all there is
    search.budget -= search.left - 10.0
    assert search.away().budget == pytest.approx(10.0, abs=0.5)


def test_what_is_asked_for_later_comes_out_of_the_same_time(data):
    search = search_in(data, 1, budget=10.0)
    search.most = 25.0
    search.extend(12.0)
    assert search.left == pytest.approx(12.0, abs=0.5)
    search.extend(5.0)  # there is more
    assert search.left == pytest.approx(12.0, abs=0.5)
    search.spent = 20.0
    search.extend(12.0)
    assert search.budget == 25.0
    assert search.left == pytest.approx(5.0, abs=0.5)
    again = search.afresh(data[:1])
    assert (again.budget, again.most, again.spent, again.began) == (25.0, 25.0, 20.0, search.began)
    assert len(again.data) == 1
    assert not again.tried


@pytest.mark.parametrize(("left", "anyway", "ends"), [(1e6, False, 12), (-1.0, True, 5), (-1.0, False, 0)])
def test_how_long_a_fit_may_take(data, monkeypatch, left, anyway, ends):
    search = search_in(data, 1, budget=left)
    now = [search.began]
    monkeypatch.setattr("stickslip.discovery.search.time.process_time", lambda: now[0])
    late = search._late(anyway)
    now[0] += ends - 0.01
    assert not late() or ends == 0
    now[0] += 0.02
    assert late()


@pytest.mark.parametrize("longest", [0.0, 1e6])
def test_no_fit_goes_on_for_ever_even_when_it_must_be_made(data, monkeypatch, longest):
    monkeypatch.setattr("stickslip.discovery.search.LONGEST", longest)
    search = search_in(data, 1, budget=0.0)
    law = Hypothesis(search.model, law_unknowns(search.model, search.model), {})
    found = search.run(law, cycles=1.0, iterations=12, tolerance=0.0, anyway=True, rounds=0)
    assert (found.fit.iterations == 1) == (longest == 0.0)


def test_what_a_dead_worker_was_at_is_computed_here(data):
    search = search_in(data, 2)
    assert search.submit(dies_elsewhere, os.getpid()).result() == "here"
    assert [task.result() for _, task in each(search, square, [1, 2])] == [1, 4]
    assert [task.result() for _, task in each(search_in(data, 2), square, [3, 4])] == [9, 16]


def signed_root(parent, number):
    return -(number**0.5) if os.getpid() == parent else number**0.5


def number_or_death(parent, number):
    if os.getpid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_a_map_is_in_order_and_computed_elsewhere():
    root = partial(signed_root, os.getpid())
    assert Workers(2).map(root, [9.0, 4.0, 1.0]) == [3.0, 2.0, 1.0]
    assert Workers(1).map(root, [9.0, 4.0]) == [-3.0, -2.0]


def test_a_map_is_computed_here_after_a_worker_died():
    broken = Workers(2)
    assert broken.map(partial(number_or_death, os.getpid()), [1, 2, 3]) == [1, 2, 3]
    assert broken.map(partial(signed_root, os.getpid()), [9.0]) == [-3.0]


def test_processes_that_another_search_ended_are_not_waited_for(data):
    search, other = search_in(data, 2), Workers(2)  # on the same processes
    other.stop()
    root = partial(signed_root, os.getpid())
    assert other.map(root, [9.0]) == [-3.0]
    assert search.workers.map(root, [9.0, 4.0]) == [-3.0, -2.0]
    assert search_in(data, 2).submit(square, 2).result() == 4
    ended = search_in(data, 2)
    Workers(2).stop()
    assert ended.submit(square, 3).result() == 9


def test_without_semaphores_there_are_no_workers(data, monkeypatch):
    def missing(*_, **__):
        raise OSError("no /dev/shm")

    monkeypatch.setattr("loky.get_reusable_executor", missing)
    search = search_in(data, 2)
    assert search.submit(busy, 0.0).result() == os.getpid()


def test_an_interrupt_ends_the_workers(monkeypatch):
    stopped = []
    monkeypatch.setattr(workers.Workers, "stop", lambda self: stopped.append(self))

    def interrupt(words):
        if "readings" not in words:  # before them there are no workers
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        discover(make_case(), progress=interrupt)
    assert len(stopped) == 1


def trial(chi2, excess=100.0):
    return SimpleNamespace(chi2=chi2, excess=excess)


def test_a_base_is_stuck_where_all_rivals_leave_most_of_what_it_leaves():
    assert _stuck(trial(101.0), [trial(60.0), trial(99.0)])
    assert not _stuck(trial(101.0), [trial(40.0), trial(99.0)])
    assert _stuck(trial(1.01 * NEARLY), [trial(1.0 * NEARLY)])
    assert not _stuck(trial(0.99 * NEARLY), [trial(0.98 * NEARLY)])  # above the noise, and yet near it
    assert not _stuck(trial(1.01, 0.99 * CLEAN), [trial(1.01, 0.99 * CLEAN)])


def test_rivals_that_did_not_move_from_a_stuck_base_are_tried_from_the_declared_law(data, monkeypatch):
    search, tried = search_in(data, 1), []
    base = declared(search)

    def run(_search, one, *, base, afresh=False):
        tried.append((one[0], afresh))
        moved = {"static_aging": 0.6, "sensor_lag": 0.2 if afresh else 1.0}.get(one[0], 1.0)
        fit = SimpleNamespace(cost=moved * base.fit.cost, iterations=trace.STEPS)
        mean = moved * base.mean
        return SimpleNamespace(names=(one[0],), fit=fit, chi2=moved * base.chi2, bic=moved, mean=mean)

    monkeypatch.setattr(trace, "_screened", run)
    found = screen(search, base)
    assert [one.names for one in found[:2]] == [("sensor_lag",), ("static_aging",)]
    assert ("static_aging", True) not in tried
    assert {("sensor_lag", True), ("belt_seam", False), ("belt_seam", True)} <= set(tried)


def test_rivals_are_ranked_by_where_they_end_once_they_are_shaken(data, monkeypatch):
    """One stalls at 0.8 of the base's cost and goes on to 0.3; from the declared law another, from 2.0 to 0.1."""
    search, shaken = search_in(data, 1), []
    base = declared(search)

    def ended(name, share):
        fit = SimpleNamespace(cost=share * base.fit.cost, iterations=5)
        return SimpleNamespace(
            names=(name,), fit=fit, chi2=share * base.chi2, bic=share, mean=share * base.mean
        )

    def run(_search, one, *, afresh=False, **_):
        return ended(one[0], 2.0 if afresh else 0.8 if one[0] == "static_aging" else 1.0)

    def shake(_search, one, *, afresh=False, **_):
        shaken.append((one[0], afresh))
        return ended(one[0], 0.1 if afresh else 0.3) if one[0] in ("static_aging", "sensor_lag") else one[1]

    monkeypatch.setattr(trace, "_screened", run)
    monkeypatch.setattr(trace, "_shaken", shake)
    monkeypatch.setattr(trace, "_anew", lambda _search, _base, tried, _best: [tried[0], ("sensor_lag", None)])
    found = screen(search, base)
    assert [(one.names[0], one.bic) for one in found[:2]] == [("sensor_lag", 0.1), ("static_aging", 0.3)]
    assert ("static_aging", False) in shaken
    assert ("sensor_lag", True) in shaken
    assert ("sensor_lag", False) not in shaken  # it stood where the base does


def test_what_is_computed_of_a_trial_is_computed_once(data):
    search, computed = search_in(data, 1), []
    one, same = trial(2.0), trial(2.0)

    def compute(value):
        return lambda: computed.append(value) or value

    assert [search.once("a", one, compute(k)) for k in range(2)] == [0, 0]
    assert search.once("b", one, compute(2)) == 2
    assert search.once("a", same, compute(3)) == 3  # another, though it is equal
    assert computed == [0, 2, 3]


def test_a_worker_ends_with_the_process_that_started_it(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import os, signal, sys\n"
        "from stickslip.discovery.workers import Workers\n"
        "class Search:\n"
        "    def away(self): return self\n"
        "    def back(self, value, seconds): pass\n"
        "workers = Workers(2)\n"
        "print(workers.submit(Search(), lambda _: os.getpid()).result(), flush=True)\n"
        "workers.submit(Search(), lambda _: b'x' * 10_000_000)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False)
    worker = int(done.stdout)
    assert done.returncode == -signal.SIGKILL
    end = time.monotonic() + 30
    while runs(worker) and time.monotonic() < end:
        time.sleep(0.2)
    assert not runs(worker)


def test_workers_end_without_an_outcry_where_some_of_the_work_is_cancelled(data, caplog):
    """The pool's own thread ended with a traceback of "InvalidStateError: CANCELLED"."""
    search = search_in(data, 2)
    process = search.submit(busy, 0.0).result()
    tasks = [search.submit(busy, 30.0) for _ in range(12)]
    for task in tasks[6:]:
        task.cancel()
    search.workers.stop()
    assert [one.getMessage() for one in caplog.records] == []
    end = time.monotonic() + 10
    while runs(process) and time.monotonic() < end:
        time.sleep(0.1)
    assert not runs(process)


def test_processes_at_hand_are_those_of_a_search_just_ended_in_this_process(data, monkeypatch):
    search = search_in(data, 2)
    search.submit(square, 2).result()
    assert Workers.at_hand() is search.workers
    latest = Workers._latest
    for other in (None, (search.workers, os.getpid() + 1, latest[2]), (search.workers, os.getpid(), 0.0)):
        monkeypatch.setattr(Workers, "_latest", other)
        assert Workers.at_hand().count == 1


def test_an_interrupted_map_cancels_nothing_under_way() -> None:
    """What is cancelled makes the pool's own thread cry out when it is stopped."""

    class Interrupted(Future[int]):
        def result(self, timeout: float | None = None) -> int:
            raise KeyboardInterrupt(timeout)

    handed: list[Future[int]] = [Interrupted(), Future(), Future()]
    todo, asked = iter(handed), Workers(1)
    asked._pool = SimpleNamespace(submit=lambda *_: next(todo), map=None)
    with pytest.raises(KeyboardInterrupt):
        asked.map(abs, [1, 2, 3])
    assert next(todo, None) is None
    assert not any(one.cancelled() for one in handed)
