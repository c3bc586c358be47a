"""How often the search for a block on a belt names what is not there, and finds what is.

Usage: python bench/bench_slider.py [--draws 100] [--case RIG.toml] [--planted gain=0.1] [--out FILE.json]

Records are drawn from the declared model with the process noise of a case (the recording shipped with the package, if
none is given), sampled, quantised and glitched as the original. Without a planted effect every name is a false alarm.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from importlib.resources import as_file, files
from pathlib import Path

from threadpoolctl import threadpool_limits

from stickslip import build_config
from stickslip.discovery.slider.choose import choose
from stickslip.discovery.slider.surrogate import NOTHING, Planted, source, surrogate
from stickslip.fitted.block_events.table import measure, prepare
from stickslip.measured.case import Case, load_case

GATE = 60


def main() -> None:
    """Draw, search, count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--case", type=Path)
    parser.add_argument("--planted", nargs="*", default=[], help="name=value of Planted")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    planted = Planted(**{name: float(value) for name, value in (one.split("=") for one in given.planted)})
    with threadpool_limits(1):
        result = count(_case(given.case), given.draws, planted)
    print(json.dumps(result, indent=1))
    if given.out:
        given.out.write_text(json.dumps(result | {"build": build_config()}, indent=1, default=str) + "\n")


def _case(path: Path | None) -> Case:
    if path is not None:
        return load_case(path)
    with as_file(files("stickslip") / "data" / "paper_slider") as folder:
        return load_case(folder / "rig.toml")


def count(case: Case, draws: int, planted: Planted) -> dict[str, object]:
    """Names found over surrogates, how many of these had none, and the processor time of one."""
    origin = source(case)
    names: Counter[str] = Counter()
    silent, began = 0, time.process_time()
    for seed in range(draws):
        drawn = surrogate(origin, seed, planted)
        found = choose([measure(prepare(one)) for one in drawn.train], 0, lambda _: None, GATE)
        silent += not found.chosen
        names.update(one.candidate.name for one in found.chosen)
    seconds = (time.process_time() - began) / max(draws, 1)
    said = "nothing" if planted == NOTHING else str(planted)
    return {"planted": said, "draws": draws, "silent": silent, "named": dict(names), "seconds each": seconds}


if __name__ == "__main__":
    main()
