"""Sweeps of the reference rig: rate against rivals at equal error, threads, instruction sets, cost, memory.

Usage: python bench/bench_sweep.py [--peers DIR] [--repeats 7] [--large 1000000] [--out FILE] [--require R]

P2 is 4096 members (64 belt speeds x 64 alpha1, alpha2 = alpha1/2) to t = 200 at tolerance 1e-8; P2eq 64 of them on
one thread, 16 times over, the rival at the loosest tolerance that leaves a median error of the final state of at most
1e-8, ours at the loosest that leaves no more than the rival's.
The rivals, with --peers, are the jitted DOP853 mode machine `ensemble` of DIR/peer_numba.py, timed in turn with ours,
and the batched Taylor integrator of DIR/peer_heyoka.py where heyoka is installed.
Every answer is held to the truth (tests/data/truth_p2.json) before a time is taken. Measure on a quiet machine.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import stickslip
from stickslip import _core
from stickslip.simulated.lowering import lower

TRUTH = json.loads((Path(__file__).parents[1] / "tests/data/truth_p2.json").read_text())
MODEL = stickslip.Model(
    stickslip.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=stickslip.PaperFriction()
)
START, T_END = (0.1, 0.1, 0.0, 0.0), 200.0
SPEEDS, ALPHAS = np.linspace(0.02, 0.3, 64), np.linspace(8, 40, 64)
BAR = 1e-8
TOLERANCES = (1e-8, 5e-9, 2e-9, 1e-9, 1e-10, 1e-11, 1e-12)


def members(index: np.ndarray) -> dict[str, Any]:
    """The members of P2 of these numbers, along one dimension."""
    a = ALPHAS[index % 64]
    return {
        "belt_speed": ("member", SPEEDS[index // 64]),
        "alpha1": ("member", a),
        "alpha2": ("member", a / 2),
    }


def sweep(index: np.ndarray, tolerance: float = 1e-8, **settings: Any) -> Any:
    observe = ("final_state", "stick_fraction", "transitions")
    given = {"t_end": T_END, "initial": START, "observe": observe, "after": T_END / 2, "threads": 1}
    return stickslip.sweep(MODEL, members(index), rtol=tolerance, atol=tolerance, **(given | settings))


def error(final: np.ndarray, index: np.ndarray) -> float:
    """Median error of the final state over the members whose truth is known."""
    place = {int(member): i for i, member in enumerate(index)}
    known = [(place[m], k) for k, m in enumerate(TRUTH["index"]) if m in place]
    return float(np.median([np.abs(final[i] - TRUTH["final"][k]).max() for i, k in known]))


def in_turn(calls: dict[str, Callable[[], object]], repeats: int) -> dict[str, list[float]]:
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            begin = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - begin)
    return times


def rates_of(times: dict[str, list[float]], count: int) -> dict[str, float]:
    return {name: count / statistics.median(t) for name, t in times.items()}


def rates(calls: dict[str, Callable[[], object]], count: int, repeats: int) -> dict[str, float]:
    return rates_of(in_turn(calls, repeats), count)


def ratio(times: dict[str, list[float]], fast: str, slow: str) -> float:
    """Median over pairs measured one after the other."""
    return statistics.median(b / a for a, b in zip(times[fast], times[slow], strict=True))


def loosest(run: Callable[[float], np.ndarray], index: np.ndarray, bar: float = BAR) -> tuple[float, float]:
    """Tolerance and error of the loosest run that is good enough."""
    for tolerance in TOLERANCES:
        e = error(run(tolerance), index)
        if e <= bar:
            break
    return tolerance, e


def against_rivals(folder: Path, repeats: int) -> dict[str, object]:
    """P2eq and P2 beside the jitted DOP853."""
    sys.path.insert(0, str(folder))
    peer = importlib.import_module("peer_numba")
    grid = np.ascontiguousarray(
        np.stack([np.repeat(SPEEDS, 64), np.tile(ALPHAS, 64), np.tile(ALPHAS, 64) / 2], 1)
    )
    set_threads = importlib.import_module("numba").set_num_threads
    set_threads(1)

    def rival(index: np.ndarray, tolerance: float) -> np.ndarray:
        out = np.zeros((len(index), 7))
        peer.ensemble(grid[index], T_END, tolerance, out)
        return out[:, :4]

    few, every = np.array(sorted(TRUTH["index"])), np.arange(4096)
    theirs = loosest(lambda tolerance: rival(few, tolerance), few)
    ours = loosest(lambda tolerance: sweep(few, tolerance).final_state.values, few, theirs[1])
    often = np.tile(few, 16)  # so that what a call costs beside its trajectories does not count
    equal = in_turn(
        {"stickslip": lambda: sweep(often, ours[0]), "jitted DOP853": lambda: rival(often, theirs[0])},
        repeats,
    )
    call = in_turn({"stickslip": lambda: sweep(few, ours[0])}, 5 * repeats)
    full = in_turn(
        {"stickslip": lambda: sweep(every, ours[0]), "jitted DOP853": lambda: rival(every, theirs[0])},
        max(3, repeats // 2),
    )
    taylor = heyoka_batch(few)
    return {
        **({"P2eq_heyoka_batch": taylor} if taylor else {}),
        "tolerance": {"stickslip": ours[0], "jitted DOP853": theirs[0]},
        "error": {"stickslip": ours[1], "jitted DOP853": theirs[1]},
        "P2eq_per_s": {name: len(often) / statistics.median(t) for name, t in equal.items()},
        "P2eq_one_call_ms": 1e3 * statistics.median(call["stickslip"]),
        "P2eq_ratio": ratio(equal, "stickslip", "jitted DOP853"),
        "P2_at_equal_error_per_s": {name: 4096 / statistics.median(t) for name, t in full.items()},
        "P2_at_equal_error_ratio": ratio(full, "stickslip", "jitted DOP853"),
    }


def heyoka_batch(index: np.ndarray) -> dict[str, float]:
    """Rate of the folder's batched Taylor integrator at the loosest tolerance that is good enough, if it is there."""
    if not importlib.util.find_spec("heyoka") or not importlib.util.find_spec("peer_heyoka"):
        return {}
    peer, heyoka = importlib.import_module("peer_heyoka"), importlib.import_module("heyoka")
    lanes = int(heyoka.recommended_simd_size())
    grid = np.stack([SPEEDS[index // 64], ALPHAS[index % 64], ALPHAS[index % 64] / 2], 1)

    def run(batch: Any) -> np.ndarray:
        return np.concatenate([batch.run(grid[k : k + lanes], T_END) for k in range(0, len(grid), lanes)])

    def final(tolerance: float) -> np.ndarray:
        return run(peer.Batch(tolerance, lanes))[:, :4]

    tolerance, e = loosest(final, index)
    batch = peer.Batch(tolerance, lanes)
    times = in_turn({"heyoka": lambda: run(batch)}, 3)["heyoka"]
    return {"tolerance": tolerance, "error": e, "per_s": len(index) / statistics.median(times)}


def counts() -> dict[str, object]:
    """All 4096 numbers of slips, which the truth counts from the start."""
    every = np.arange(4096)
    ds = sweep(every, observe=("slips", "final_state"), after=0.0)
    wrong = int((ds.slips.values != np.asarray(TRUTH["slips_all"])).sum())
    return {
        "slips": int(ds.slips.sum()),
        "wrong_slip_counts": wrong,
        "median_error": error(ds.final_state.values, every),
    }


CHILD = """
import json, sys; sys.path.insert(0, {folder!r})
import numpy as np, bench_sweep as b
every = np.arange(4096)
b.sweep(every[:256])
calls = {{"": lambda: b.sweep(every), ", scalar kernel": lambda: b.sweep(every, lanes=False)}}
times = b.in_turn(calls, {repeats})
print(json.dumps([b.rates_of(times, 4096), b.ratio(times, "", ", scalar kernel")]))
"""


def instruction_sets(repeats: int) -> tuple[dict[str, float], dict[str, float]]:
    """P2 on one thread by instruction set, each in a process of its own: rates, and lanes over the scalar kernel."""
    rates, ratios = {}, {}
    for isa in ("baseline", "avx2", "avx512"):
        code = CHILD.format(folder=str(Path(__file__).parent), repeats=repeats)
        env = {**os.environ, "STICKSLIP_ISA": isa}
        run = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True)
        if run.returncode == 0:
            found, ratios[isa] = json.loads(run.stdout)
            rates |= {f"{isa}{kernel}": rate for kernel, rate in found.items()}
    return rates, ratios


APART = """
import sys, time; sys.path.insert(0, {folder!r})
import numpy as np, bench_sweep as b
every = np.arange(4096)
b.sweep(every[:256])
print(flush=True); sys.stdin.readline()
begin = time.perf_counter()
for _ in range({repeats}): b.sweep(every)
print(time.perf_counter() - begin)
"""


def two_processes(repeats: int) -> float:
    """What two processes of one thread each do against one: all that this machine lets two threads gain."""
    code = APART.format(folder=str(Path(__file__).parent), repeats=repeats)

    def together(count: int) -> float:
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        running = [subprocess.Popen([sys.executable, "-c", code], **pipes) for _ in range(count)]
        for one in running:
            one.stdout.readline()
        for one in running:
            one.stdin.write("\n")
            one.stdin.flush()
        return statistics.mean(float(one.communicate()[0]) for one in running)

    return statistics.median(2 * together(1) / together(2) for _ in range(5))


def cost(largest: int) -> dict[str, float]:
    """Microseconds a member of sweeps of growing size, two threads."""
    out, count = {}, 1000
    while count <= largest:
        side = round(count**0.5)
        over = {"belt_speed": np.linspace(0.02, 0.3, side), "alpha1": np.linspace(8, 40, count // side)}
        begin = time.perf_counter()
        stickslip.sweep(MODEL, over, t_end=T_END / 4, initial=START, after=T_END / 8)
        out[str(side * (count // side))] = 1e6 * (time.perf_counter() - begin) / (side * (count // side))
        count *= 10
    return out


MEMORY = """
import resource, sys; sys.path.insert(0, {folder!r})
import numpy as np, bench_sweep as b
over = {{"belt_speed": np.linspace(0.02, 0.3, {n} // 1000), "alpha1": np.linspace(8, 40, 1000)}}
b.stickslip.sweep(b.MODEL, over, t_end=20, initial=b.START, out={out!r}, observe=b.EVERY, points=4)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""
EVERY = (
    "final_state",
    "stick_fraction",
    "transitions",
    "period",
    "state_min",
    "state_max",
    "dissipated",
    "points",
)


def memory(count: int) -> float:
    """Peak memory in MiB of a process that sweeps into a store."""
    with tempfile.TemporaryDirectory() as folder:
        code = MEMORY.format(folder=str(Path(__file__).parent), n=count, out=f"{folder}/r.zarr")
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(run.stdout.split()[-1])


def arithmetic() -> dict[str, float]:
    """What P2 asks of the arithmetic units, counted, against what they give in a product of large matrices.

    Counted are the expansions alone, each step as one along the exponentials at the order of tolerance 1e-8: for each
    order k the two convolutions of k - 1 products and 33 other operations.
    """
    order = 12
    a_step = sum(4 * (k - 1) + 33 for k in range(1, order + 1))
    lowered = lower(MODEL, 0.1)
    every = members(np.arange(4096))
    slots = [lowered.slots[name][0] for name in every]
    rows, _ = _core.sweep(
        structure=lowered.structure,
        base=np.concatenate([lowered.parameters, lowered.initial(START)]),
        varied=np.array(slots, dtype=np.int32),
        values=np.ascontiguousarray(np.stack([column for _, column in every.values()], axis=1)),
        t_end=T_END, after=T_END / 2, rtol=1e-8, atol=1e-8, observe=0, points=0, lanes=True,
        max_transitions=10**6,
    )  # fmt: skip
    steps = float(np.asarray(rows)[:, _core.SWEEP_ROW.index("steps")].mean())
    return {"steps_per_trajectory": steps, "operations_per_step": a_step, "peak_Gflop_per_s": peak() / 1e9}


def peak() -> float:
    """Floating-point operations a second of one core, by a product of matrices on one thread."""
    code = (
        "import numpy as np, time; a = np.ones((1536, 1536)); a @ a; t = []\n"
        "for _ in range(5):\n b = time.perf_counter(); a @ a; t.append(time.perf_counter() - b)\n"
        "print(2 * 1536**3 / min(t))"
    )
    one = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    run = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **one}, capture_output=True, text=True
    )
    return float(run.stdout)


def clock() -> float:
    """Clock in Hz as the system tells it (a virtual machine tells the nominal one); 0 if it does not."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    speeds = [float(line.split(":")[1]) for line in lines if line.startswith("cpu MHz")]
    return 1e6 * max(speeds, default=0.0)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--peers", type=Path, help="folder that holds peer_numba.py")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--large", type=int, default=1_000_000, help="members of the largest sweep")
    parser.add_argument("--out", type=Path, help="also write the results here, as JSON")
    parser.add_argument(
        "--require", type=float, default=0.0, help="fail below this ratio to the rival on P2eq"
    )
    options = parser.parse_args()
    every = np.arange(4096)
    results: dict[str, Any] = {"build": stickslip.build_config(), "P2": counts()}
    if results["P2"]["wrong_slip_counts"] or results["P2"]["median_error"] > BAR:
        sys.exit(f"wrong answer: {results['P2']}")
    if options.peers:
        results["rivals"] = against_rivals(options.peers, options.repeats)
    threads = in_turn({"1": lambda: sweep(every), "2": lambda: sweep(every, threads=2)}, options.repeats)
    results["P2_per_s"] = rates_of(threads, 4096)
    results["two_threads_over_one"] = {"P2": ratio(threads, "2", "1")}
    often = np.tile(every, 16)  # so that what a call costs beside its trajectories does not count
    threads = in_turn({"1": lambda: sweep(often), "2": lambda: sweep(often, threads=2)}, options.repeats)
    results["two_threads_over_one"]["P2 16 times over"] = ratio(threads, "2", "1")
    results["two_processes_over_one"] = two_processes(2 * options.repeats)
    results["cycles_per_trajectory"] = clock() / results["P2_per_s"]["1"]
    work = results["arithmetic"] = arithmetic()
    asked = work["steps_per_trajectory"] * work["operations_per_step"] * results["P2_per_s"]["1"]
    work["share_of_peak"] = asked / 1e9 / work["peak_Gflop_per_s"]
    rates, ratios = instruction_sets(options.repeats)
    results["P2_per_s_by_instruction_set"] = rates
    plain = rates["baseline, scalar kernel"]  # what a build without vectors and without dispatch would do
    results["lanes_over_portable_scalar"] = {isa: rates[isa] / plain for isa in ratios}
    results["lanes_over_scalar_of_the_same_set"] = ratios
    results["microseconds_a_member"] = cost(options.large)
    results["peak_memory_MiB"] = {str(options.large): memory(options.large)}
    print(json.dumps(results, indent=2))
    if options.out:
        options.out.write_text(json.dumps(results, indent=2) + "\n")
    if options.peers and results["rivals"]["P2eq_ratio"] < options.require:
        sys.exit(f"ratio {results['rivals']['P2eq_ratio']:.2f} is below the {options.require:g} required")


if __name__ == "__main__":
    main()
