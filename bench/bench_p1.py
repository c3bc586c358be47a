"""One trajectory of the reference rig to t = 1000 at tolerance 1e-10, against other integrators, in turn.

Usage: python bench/bench_p1.py [--peers DIR] [--repeats 31] [--out FILE] [--require R]

Rivals: scipy's DOP853 with events, heyoka's Taylor integrator with events where it is installed, and with
--peers the jitted DOP853 mode machine `run` of DIR/peer_numba.py. Every answer is held to the truth before a
time is taken: 191 transitions, final state and transition times within 1e-9, no worse than the jitted rival's.
Times are those of the calling thread on its processor (every call runs in one), so that other load counts little;
ratios are medians over pairs measured one after the other. Measure on a plain install.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import math
import statistics
import sys
import time
from collections.abc import Callable
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import stickslip
from stickslip import Model, PaperFriction, Rig

T_END, TOLERANCE, BELT, START = 1000.0, 1e-10, 0.1, (0.1, 0.1, 0.0, 0.0)
ALPHA1, ALPHA2, BETA3, ETA1, ETA12 = 16.0, 8.0, 4.0, 0.1, 0.2
TRUTH = json.loads((Path(__file__).parents[1] / "tests/data/truth_p1.json").read_text())
MODEL = Model(
    Rig(alpha1=ALPHA1, alpha2=ALPHA2, beta3=BETA3, eta1=ETA1, eta12=ETA12), friction=PaperFriction()
)
Answer = tuple[list[float], list[float]]  # final state, times of the changes of contact
Call = Callable[[], Answer]


def ours() -> Answer:
    run = stickslip.simulate(
        MODEL, belt_speed=BELT, initial=START, t_end=T_END, t_eval=[T_END], rtol=TOLERANCE, atol=TOLERANCE
    )
    return run.state[-1].tolist(), run.transitions.t.tolist()


# --- scipy: pieces as functions, terminal events ------------------------------------------------------------


def minus(u: float) -> float:
    return 5.94 - 3.2345 * math.exp(-(0.28 - u) / 0.0342) - 2.8736 * math.exp(-(0.28 - u) / 0.3053)


KINK = float(brentq(lambda u: minus(u) - 1.42, 0.2, 0.28, xtol=1e-15))
# mode: friction T(v_w), and the surfaces that end it as (function of z, next mode or None where q decides)
FRICTION: dict[str, Callable[[float], float]] = {
    "minus": lambda v: -minus(-v),
    "minus floor": lambda _: -1.42,
    "plus": lambda v: 3.63 - v * (3.63 - 0.86) / 0.27,
    "plus floor": lambda _: 0.86,
}


def field(mode: str) -> Callable[[float, list[float]], tuple[float, float, float, float]]:
    def f(_: float, z: list[float]) -> tuple[float, float, float, float]:
        x1, x2, y1, y2 = z
        leg = (-BETA3 * y1 - ETA12 * y2 - x1 - ETA1 * x2) / ALPHA2
        if mode == "stick":
            return x2, 0.0, y2, leg
        return x2, -x1 - (ETA1 * (x2 + y2) + y1 + FRICTION[mode](x2 - BELT)) / ALPHA1, y2, leg

    return f


def demand(z: list[float]) -> float:
    return ALPHA1 * z[0] + ETA1 * (BELT + z[3]) + z[2]


def surface(level: Callable[[list[float]], float]) -> Callable[[float, list[float]], float]:
    def g(_: float, z: list[float]) -> float:
        return level(z)

    g.terminal, g.direction = True, -1.0  # type: ignore[attr-defined]
    return g


ENDS: dict[str, list[tuple[Callable[[list[float]], float], str | None]]] = {
    "stick": [(lambda z: 5.94 - demand(z), "minus"), (lambda z: demand(z) + 3.63, "plus")],
    "minus": [(lambda z: BELT - z[1], None), (lambda z: z[1] - BELT + KINK, "minus floor")],
    "minus floor": [(lambda z: BELT - KINK - z[1], "minus")],
    "plus": [(lambda z: z[1] - BELT, None), (lambda z: 0.27 - z[1] + BELT, "plus floor")],
    "plus floor": [(lambda z: z[1] - BELT - 0.27, "plus")],
}


def scipy_dop853() -> Answer:
    t, z, mode = 0.0, list(START), "stick"
    changes: list[float] = []
    while True:
        ends = ENDS[mode]
        run = solve_ivp(
            field(mode), (t, T_END), z, "DOP853", rtol=TOLERANCE, atol=TOLERANCE,
            events=[surface(level) for level, _ in ends],
        )  # fmt: skip
        t, z = float(run.t[-1]), run.y[:, -1].tolist()
        if run.status == 0:
            return z, changes
        after = next(name for (_, name), hits in zip(ends, run.t_events, strict=True) if hits.size)
        if after is None:
            q = demand([z[0], BELT, z[2], z[3]])
            after = "minus" if q > 5.94 else "plus" if q < -3.63 else "stick"
        if after.split()[0] != mode.split()[0]:
            changes.append(t)
        if after.split()[0] != mode.split()[0] or after == "stick":
            z[1] = BELT
        mode = after


# --- heyoka: the same pieces as expressions -----------------------------------------------------------------


def heyoka_taylor() -> Call:
    hy = importlib.import_module("heyoka")
    x1, x2, y1, y2 = hy.make_vars("x1", "x2", "y1", "y2")
    v = x2 - BELT
    curve = 5.94 - 3.2345 * hy.exp(-(0.28 + v) / 0.0342) - 2.8736 * hy.exp(-(0.28 + v) / 0.3053)
    friction = {
        "minus": -curve,
        "minus floor": -1.42,
        "plus": 3.63 - v * ((3.63 - 0.86) / 0.27),
        "plus floor": 0.86,
    }
    q = ALPHA1 * x1 + ETA1 * (BELT + y2) + y1
    surfaces = {
        "stick": [5.94 - q, q + 3.63],
        "minus": [-v, v + KINK],
        "minus floor": [-KINK - v],
        "plus": [v, 0.27 - v],
        "plus floor": [v - 0.27],
    }
    pieces = {}
    for mode, levels in surfaces.items():
        force = friction.get(mode)
        block = 0.0 * x1 if force is None else -x1 - (ETA1 * (x2 + y2) + y1 + force) / ALPHA1
        leg = (-BETA3 * y1 - ETA12 * y2 - x1 - ETA1 * x2) / ALPHA2
        pieces[mode] = hy.taylor_adaptive(
            [(x1, x2), (x2, block), (y1, y2), (y2, leg)],
            list(START),
            tol=TOLERANCE,
            t_events=[hy.t_event(level, direction=hy.event_direction.negative) for level in levels],
        )

    def run() -> Answer:
        t, z, mode = 0.0, list(START), "stick"
        changes: list[float] = []
        while True:
            piece = pieces[mode]
            piece.time = t
            piece.state[:] = z
            piece.reset_cooldowns()
            outcome = int(piece.propagate_until(T_END)[0])
            t, z = piece.time, piece.state.tolist()
            if outcome == int(hy.taylor_outcome.time_limit):
                return z, changes
            after = ENDS[mode][-outcome - 1][1]
            if after is None:
                held = demand([z[0], BELT, z[2], z[3]])
                after = "minus" if held > 5.94 else "plus" if held < -3.63 else "stick"
            if after.split()[0] != mode.split()[0]:
                changes.append(t)
                z[1] = BELT
            mode = after

    return run


# --- the jitted DOP853 of a folder of peers -----------------------------------------------------------------


def jitted_dop853(folder: Path) -> Call:
    sys.path.insert(0, str(folder))
    peer = importlib.import_module("peer_numba")
    record = np.zeros((1000, 3))

    def run() -> Answer:
        out = peer.run(BELT, ALPHA1, ALPHA2, T_END, TOLERANCE, record)
        rows = record[: out[4]]
        contact = np.array([0, -1, -1, 1, 1])[rows[:, 1:].astype(int)]
        return list(out[:4]), rows[contact[:, 0] != contact[:, 1], 0].tolist()

    return run


def errors(answer: Answer) -> dict[str, float]:
    final, times = answer
    told = [row[0] for row in TRUTH["transitions"]]
    same = len(times) == len(told)
    return {
        "transitions": len(times),
        "final": float(np.abs(np.subtract(final, TRUTH["final"])).max()),
        "times": float(np.abs(np.subtract(times, told)).max()) if same else math.inf,
    }


def medians(calls: dict[str, Call], repeats: int) -> dict[str, list[float]]:
    times: dict[str, list[float]] = {name: [] for name in calls}
    for turn in range(repeats):
        for name, call in calls.items():
            if name.startswith("scipy") and turn % 10:
                continue  # seconds a run: a few are enough
            calls_a_turn = 1 if name.startswith("scipy") else 5  # the rival before leaves cold caches
            begin = time.thread_time()
            for _ in range(calls_a_turn):
                call()
            times[name].append((time.thread_time() - begin) / calls_a_turn)
    return times


def is_editable() -> bool:
    text = distribution("stickslip").read_text("direct_url.json")
    return bool(text and json.loads(text).get("dir_info", {}).get("editable"))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--peers", type=Path, help="folder that holds peer_numba.py")
    parser.add_argument("--repeats", type=int, default=31)
    parser.add_argument("--out", type=Path, help="also write the results here, as JSON")
    parser.add_argument(
        "--require", type=float, default=0.0, help="fail below this ratio to the jitted rival"
    )
    options = parser.parse_args()
    if is_editable():
        print("note: this is an editable install; times that count are those of a plain one (pip install .)")
    calls: dict[str, Call] = {"stickslip": ours}
    if options.peers:
        calls["jitted DOP853"] = jitted_dop853(options.peers)
    if importlib.util.find_spec("heyoka"):
        calls["heyoka"] = heyoka_taylor()
    calls["scipy DOP853"] = scipy_dop853
    error = {name: errors(call()) for name, call in calls.items()}
    mine, jitted = error["stickslip"], error.get("jitted DOP853")
    if mine["transitions"] != 191 or mine["final"] > 1e-9 or mine["times"] > 1e-9:
        sys.exit(f"wrong answer: {mine}")
    if jitted and (mine["final"] > jitted["final"] or mine["times"] > jitted["times"]):
        sys.exit(f"less accurate than the jitted rival: {mine} against {jitted}")
    times = medians(calls, options.repeats)
    results = {}
    print(f"{'':15} {'median':>11} {'ratio':>7} {'final state':>12} {'transitions':>12}")
    for name, t in times.items():
        paired = zip(times["stickslip"][:: 10 if name.startswith("scipy") else 1], t, strict=True)
        ratio = statistics.median(b / a for a, b in paired)
        results[name] = {
            "median_s": statistics.median(t),
            "ratio": ratio,
            "error": error[name],
            "runs": len(t),
        }
        e = error[name]
        print(
            f"{name:15} {1e3 * statistics.median(t):8.3f} ms {ratio:7.2f} {e['final']:12.1e} {e['times']:12.1e}"
        )
    print(json.dumps(stickslip.build_config()))
    if options.out:
        record = {"build": stickslip.build_config(), "editable": is_editable(), "results": results}
        options.out.write_text(json.dumps(record, indent=2) + "\n")
    if jitted and results["jitted DOP853"]["ratio"] < options.require:
        sys.exit(f"ratio {results['jitted DOP853']['ratio']:.2f} is below the {options.require:g} required")


if __name__ == "__main__":
    main()
