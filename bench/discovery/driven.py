"""Driven sliders of known truth: how often is something named that is not there, and is what is there found?

    python bench/discovery/driven.py OUT --seed 1 --cases 60 [--planted 16]

draws `--cases` records that the declared law explains (open and closed loop, white and coloured force noise of 0 to 3 %
of the drive, readings with white noise or an encoder's steps) and `--planted` with one effect, runs
`stickslip.discover` on each, and writes OUT/driven.json and OUT/driven.md. A stopped run goes on where it was.
"""

from __future__ import annotations

import itertools
import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np
from driven_draw import LEVELS, PLANTED, Drawn, draw, write

import stickslip as ss

DESIGN = list(itertools.product((False, True), (False, True), LEVELS))  # closed, coloured, level


def wilson(k: int, n: int) -> tuple[float, float]:
    """95 % interval of a share."""
    z, p = 1.96, k / max(n, 1)
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return (middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n)


def searched(drawn: Drawn) -> dict[str, Any]:
    """Search one case."""
    began = time.process_time()
    row: dict[str, Any] = {
        "planted": drawn.slider.name,
        "numbers": drawn.slider.numbers,
        "words": drawn.words,
    }
    row |= {"closed": drawn.closed, "coloured": drawn.coloured, "level": drawn.level}
    with tempfile.TemporaryDirectory() as folder:
        case = ss.load_case(write(drawn, Path(folder)))
        try:
            found = ss.discover(case)
        except ss.InputError as refused:
            return row | {
                "refused": str(refused),
                "found": [],
                "tied": [],
                "seconds": time.process_time() - began,
            }
    law = found.law
    mass = found.constants["mass"].value
    return row | {
        "verdict": found.verdict.value,
        "loop": any("answers to noise" in one for one in found.messages),
        "found": [e.name for e in found.effects],
        "tied": [a.name for e in found.effects for a in e.alternatives if a.tied],
        "parameters": {
            e.name: {k: [v.value, v.low, v.high] for k, v in e.parameters.items()} for e in found.effects
        },
        "gain": found.gate.observed,
        "threshold": found.gate.threshold,
        "mass": mass / drawn.slider.mass - 1,
        "damping": law["damping"].value / drawn.slider.damping - 1,
        "friction": law["kinetic_plus"].value / drawn.slider.plus - 1,
        "chi2": [found.residual_before.chi2, found.residual_after.chi2],
        "error": [found.error.before, found.error.after, found.error.floor],
        "seconds": time.process_time() - began,
    }


def right(row: dict[str, Any]) -> bool:
    """Is the planted effect named, or tied with what is?"""
    return row["planted"] in (*row["found"], *row["tied"])


def table(rows: list[dict[str, Any]]) -> str:
    """The table in Markdown."""
    out = ["| records | n | right | 95 % interval |", "|---|---|---|---|"]

    def line(name: str, some: list[dict[str, Any]], good: int) -> None:
        if some:
            low, high = wilson(good, len(some))
            out.append(f"| {name} | {len(some)} | {good} | {100 * low:.0f} to {100 * high:.0f} % |")

    plain = [row for row in rows if not row["planted"]]

    def silent(some: list[dict[str, Any]]) -> int:
        return sum(row.get("verdict") == "no_effect" for row in some)

    line("nothing to find: silent", plain, silent(plain))
    for closed, word in ((False, "open"), (True, "closed")):
        some = [row for row in plain if row["closed"] is closed]
        line(f"of these, {word} loop", some, silent(some))
    for coloured, word in ((False, "white"), (True, "coloured")):
        some = [row for row in plain if row["coloured"] is coloured and row["level"]]
        line(f"of these, {word} force noise", some, silent(some))
    some = [row for row in plain if not row["level"]]
    line("of these, no force noise", some, silent(some))
    for closed, word in ((True, "closed loop: said to be one"), (False, "open loop: not said to be closed")):
        some = [row for row in plain if row["closed"] is closed and "loop" in row]
        line(word, some, sum(row["loop"] is closed for row in some))
    planted = [row for row in rows if row["planted"]]
    line("one effect: named, or tied with what is named", planted, sum(map(right, planted)))
    line(
        "one effect: and nothing else named", planted, sum(right(r) and len(r["found"]) == 1 for r in planted)
    )
    worse = [row for row in rows if row["found"] and row["error"][1] > row["error"][0]]
    out.append("")
    out.append(f"Error on the validate run rises with what is named: {len(worse)} of {len(rows)} records.")
    off = [abs(row["mass"]) for row in plain if "mass" in row]
    out.append(f"Mass, of records with nothing to find: off by {100 * max(off, default=0):.2g} % at most.")
    seconds = [row["seconds"] for row in rows]
    out.append(
        f"Processor seconds a record: {np.median(seconds):.0f} in the median, {max(seconds):.0f} at most."
    )
    return "\n".join(out) + "\n"


@click.command(help=__doc__)
@click.argument("out", type=click.Path(path_type=Path))
@click.option("--seed", default=0)
@click.option("--cases", default=60)
@click.option("--planted", default=0)
def main(out: Path, seed: int, cases: int, planted: int) -> None:
    """Run the bench."""
    out.mkdir(parents=True, exist_ok=True)
    store = out / "driven.json"
    rows: list[dict[str, Any]] = json.loads(store.read_text()) if store.exists() else []
    names = ["" for _ in range(cases)] + [list(PLANTED)[i % len(PLANTED)] for i in range(planted)]
    for i, name in enumerate(names):
        if i < len(rows):
            continue
        closed, coloured, level = DESIGN[i % len(DESIGN)]
        if name:
            level = max(level, LEVELS[1])
        rng = np.random.default_rng([seed, i])
        row = searched(draw(rng, planted=name, closed=closed, coloured=coloured, level=level))
        rows.append(row)
        store.write_text(json.dumps(rows, indent=1) + "\n")
        said = row.get("refused") or f"{row['found']} {row['tied']}"
        gain = f"gain {row['gain']:.3g} of {row['threshold']:.3g}" if "gain" in row else ""
        print(
            f"{i:3d} {row.get('loop', '')!s:5s} {name or 'nothing':18s} {row['words']}: {said} {gain}",
            flush=True,
        )
    (out / "driven.md").write_text(table(rows))
    print(table(rows))


if __name__ == "__main__":
    main()
