"""Draw cases, run the discovery loop on them, score it, and set rivals beside it.

    python bench/discovery/run.py OUT --seed 1 --single 2 --none 40 --pairs 40 --unlisted 1 --rivals

writes OUT/cases, OUT/reports, OUT/table.json and OUT/table.md. Cases and reports that are there already are kept, so
a stopped run goes on where it was; ``--cases FOLDER`` takes cases from elsewhere (answers.json beside them).
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import click
import numpy as np
from generate import generate
from records import UNITS, Array, Record, nondimensional, read_case
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from score import HEAD, WRONG_HEAD, Scored, rows_of, score, show, table, write, wrong

METHOD_HEAD = ["method", "one cycle", "two cycles", "names the effect", "n"]


def command() -> list[str]:
    """How to call the command line: the script beside this Python, else whatever the path has."""
    beside = Path(sys.executable).with_name("stickslip")
    found = str(beside) if beside.exists() else shutil.which("stickslip")
    if found is None:
        raise click.ClickException("no `stickslip` command here: install the package in this environment.")
    return [found]


def discover(case: Path, out: Path, limit: float, threads: int) -> None:
    """Run the loop on one case; outcome.json says how long it took and how it ended."""
    if (out / "outcome.json").exists():
        return
    out.mkdir(parents=True, exist_ok=True)
    threaded = {name: str(threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
    start = time.perf_counter()
    try:
        done = subprocess.run(
            [*command(), "discover", str(case / "rig.toml"), "--out", str(out)],
            capture_output=True, text=True, timeout=limit, env=os.environ | threaded, check=False,
        )  # fmt: skip
        code, said = done.returncode, (done.stderr.strip().splitlines() or [""])[-1]
    except subprocess.TimeoutExpired:
        code, said = -1, f"stopped after {limit:g} s"
    seconds = time.perf_counter() - start
    (out / "outcome.json").write_text(json.dumps({"seconds": seconds, "exit": code, "said": said}))


def discover_all(cases: Path, reports: Path, limit: float, jobs: int) -> None:
    """Every case, with a bar."""
    names = [a["case"] for a in json.loads((cases / "answers.json").read_text())["cases"]]
    columns = (TextColumn("discover"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    threads = max(1, (os.cpu_count() or 2) // jobs)
    with Progress(*columns) as bar, ThreadPoolExecutor(jobs) as pool:
        task = bar.add_task("", total=len(names))
        for future in [pool.submit(discover, cases / n, reports / n, limit, threads) for n in names]:
            future.result()
            bar.advance(task)


def forecast_ours(case: Path, report: Path, work: Path) -> list[Any]:
    """Our own models by the rivals' metric, through `stickslip forecast` and the files alone."""
    import rivals

    told = tomllib.loads((case / "rig.toml").read_text())
    _, length, w = nondimensional(told["rig"])
    unit = UNITS[told["channels"]["x1"]["unit"]] / length
    speeds = {r["file"]: r["belt_speed"] for r in told["run"]}
    to_time = 1.0 / (w * UNITS[told["channels"]["t"]["unit"]])
    work.mkdir(parents=True, exist_ok=True)

    def through(model: Path, run: Record, first: int, samples: int) -> Array:
        rows = (case / run.file).read_text().splitlines(keepends=True)
        past, out = work / "past.csv", work / "forecast.csv"
        past.write_text("".join(rows[: first + 1]))
        horizon = (run.t[first + samples - 1] - run.t[first - 1]) * to_time * (1 + 1e-9)
        done = subprocess.run(
            [*command(), "forecast", str(model), str(past), "--belt-speed", str(speeds[run.file]),
             "--horizon", f"{horizon:.12g}", "--out", str(out)], capture_output=True, text=True, check=False,
        )  # fmt: skip
        made = np.full((samples, 2), np.nan)
        if done.returncode == 0:
            read = np.loadtxt(out, delimiter=",", skiprows=1, ndmin=2)[:samples, 1:3] * unit
            made[: read.shape[0]] = read
        return made

    recorded, found = read_case(case), []
    for label, name in (("stickslip, before", "model_before.toml"), ("stickslip, after", "model_after.toml")):
        if (report / name).exists():

            def forecast(run: Record, first: int, samples: int, model: Path = report / name) -> Array:
                return through(model, run, first, samples)

            one, two = (rivals.forecast_error(recorded, forecast, cycles, windows=3) for cycles in (1, 2))
            found.append(rivals.Judged(label, "", one, two))
    return found


def compare(
    cases: Path, reports: Path, scored: Sequence[Scored], most: int, console: Console
) -> list[list[str]]:
    """Rivals' errors and names on up to ``most`` cases in which something listed acts."""
    import rivals

    chosen = [s for s in scored if s.truth and s.group in ("single", "pair")]
    chosen = chosen[:: max(1, len(chosen) // max(most, 1))][:most]
    judged: dict[str, list[tuple[float, float, bool | None]]] = {}
    for s in chosen:
        console.print(f"rivals on {s.case} ({'+'.join(s.truth)})")
        lines = rivals.judge(cases / s.case, reports / s.case)
        lines += forecast_ours(cases / s.case, reports / s.case, reports / s.case / "forecasts")
        for line in lines:
            right = line.named in s.truth if line.named else None
            if line.method == "stickslip, after":
                right = s.first(ties=False)
            judged.setdefault(line.method, []).append((line.one_cycle, line.two_cycles, right))
    rows = []
    for method, values in judged.items():
        one, two = (float(np.nanmedian([v[i] for v in values])) for i in (0, 1))
        names = [v[2] for v in values if v[2] is not None]
        rows.append(
            [method, f"{one:.4f}", f"{two:.4f}", f"{np.mean(names):.0%}" if names else "", str(len(values))]
        )
    return rows


@click.command()
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option("--cases", type=click.Path(exists=True, file_okay=False, path_type=Path), help="Cases to use.")
@click.option("--seed", default=1, show_default=True)
@click.option("--single", default=1, show_default=True, help="Cases of every listed effect.")
@click.option("--none", "none_", default=20, show_default=True, help="Cases without any effect.")
@click.option("--pairs", default=20, show_default=True, help="Cases with two effects.")
@click.option("--unlisted", default=1, show_default=True, help="Cases of every effect outside the list.")
@click.option("--odd", default=0, show_default=True, help="Cases under unusual conditions.")
@click.option("--only", multiple=True, help="Limit to these effects.")
@click.option("--laboratory", default=0.0, help="Size of a laboratory's imperfections; 1 is the usual one.")
@click.option("--rig", type=click.Choice(["two_degree", "block"]), default="two_degree", show_default=True)
@click.option("--limit", default=300.0, show_default=True, help="Seconds after which a case is stopped.")
@click.option("--jobs", default=1, show_default=True, help="Cases at once; times hold for 1.")
@click.option("--rivals", "most", default=0, show_default=True, help="Cases on which rivals are run too.")
def main(
    out: Path, cases: Path | None, seed: int, single: int, none_: int, pairs: int, unlisted: int, odd: int,
    only: tuple[str, ...], laboratory: float, rig: str, limit: float, jobs: int, most: int,
) -> None:  # fmt: skip
    """Draw, discover, score; everything is left in OUT."""
    console = Console(width=None if sys.stdout.isatty() else 150)
    if cases is None:
        cases = out / "cases"
        if not (cases / "answers.json").exists():
            shutil.rmtree(cases, ignore_errors=True)  # a drawing that was stopped half way
            counts = {"single": single, "none": none_, "pairs": pairs, "unlisted": unlisted, "odd": odd}
            with console.status("drawing cases"):
                generate(cases, seed, counts, only, laboratory=laboratory, rig=rig)
    reports = out / "reports"
    discover_all(cases, reports, limit, jobs)
    scored = score(cases, reports)
    lines = table(scored)
    show(console, "Discovery", HEAD, rows_of(lines))
    show(console, "Not exact", WRONG_HEAD, wrong(scored))
    methods = compare(cases, reports, scored, most, console) if most else []
    if methods:
        show(console, "Forecast error on the validate runs, median", METHOD_HEAD, methods)
    write(lines, scored, out / "table.json", out / "table.md", (METHOD_HEAD, methods))


if __name__ == "__main__":
    main()
