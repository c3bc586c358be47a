"""Twelve laboratory cases of rigs that are not the named ones, drawn, searched and scored.

    python bench/discovery/general.py OUT --seed 1 [--others | --unlisted]

draws two cases with an effect and two without of each rig, runs `stickslip discover` on each, and writes OUT/table.md.
Cases and reports that are there already are kept. With `--others` three cases of each of their other effects are drawn
instead, with `--unlisted` one of each of theirs that is on no list.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
from general_draw import PLANS, write_case

from run import discover

OTHERS = 3  # cases of each other effect
EACH = 2  # cases with an effect, and as many without, of each rig
HEAD = "| case | acts | found | exact | interval covers | error before, after, floor | seconds |"


def draw(cases: Path, seed: int, *, others: bool = False, unlisted: bool = False) -> list[dict[str, Any]]:
    """Draw what is not there yet; with `others` or `unlisted` cases of these effects instead."""
    answers = cases / "answers.json"
    if answers.exists():
        return list(json.loads(answers.read_text())["cases"])
    truths = []
    if others:
        for k, (name, plan) in enumerate(PLANS.items()):
            for i in range(OTHERS * len(plan().others)):
                folder, own = cases / f"{name}_other_{i + 1}", 1000 * seed + 700 + 10 * k + i
                truths.append(write_case(folder, plan(), own, effect=True, other=i // OTHERS))
        answers.write_text(json.dumps({"cases": truths}, indent=1))
        return truths
    if unlisted:
        for k, (name, plan) in enumerate(PLANS.items()):
            for i in range(len(plan().unlisted)):
                folder, own = cases / f"{name}_unlisted_{i + 1}", 1000 * seed + 500 + 10 * k + i
                truths.append(write_case(folder, plan(), own, effect=False, unlisted=i))
        answers.write_text(json.dumps({"cases": truths}, indent=1))
        return truths
    for i in (0, EACH, *range(1, EACH), *range(EACH + 1, 2 * EACH)):
        for k, (name, plan) in enumerate(PLANS.items()):
            folder = cases / f"{name}_{i + 1}"
            truths.append(write_case(folder, plan(), 1000 * seed + 10 * k + i, effect=i < EACH))
    answers.write_text(json.dumps({"cases": truths}, indent=1))
    return truths


def scored(truth: dict[str, Any], report: Path) -> dict[str, Any]:
    """Hold a report against the truth."""
    told = json.loads((report / "outcome.json").read_text())
    acts = [(one["name"], one["where"]) for one in truth["effects"]]
    if told["exit"] != 0:
        return {"acts": acts, "found": told["said"], "exact": False, "false": False, "covers": None, **told}
    found = json.loads((report / "report.json").read_text())
    names = [(one["name"], one["where"].removesuffix(" channel")) for one in found["effects"]]
    covers = []
    for one in truth["effects"]:
        for own in found["effects"]:
            if own["name"] != one["name"]:
                continue
            for name, size in one["parameters"].items():
                at = own["parameters"].get(name)
                if at is not None and at["low"] is not None:
                    covers.append(at["low"] <= size <= at["high"])
    error = [found["error"][who] for who in ("before", "after", "floor")]
    wrong = [one for one in names if one not in acts]
    return {
        "acts": acts, "found": names, "exact": sorted(names) == sorted(acts), "false": bool(wrong),
        "covers": covers, "error": error, **told,
    }  # fmt: skip


def said(pairs: object) -> str:
    """Effects and places in a cell."""
    if isinstance(pairs, str):
        return pairs
    return ", ".join(f"{name} of {where}" for name, where in pairs) or "nothing"  # type: ignore[attr-defined]


def row(name: str, one: dict[str, Any]) -> str:
    """A line of the table."""
    covers = "" if not one["covers"] else f"{sum(one['covers'])} of {len(one['covers'])}"
    error = ", ".join(f"{x:.3g}" for x in one.get("error", []))
    cells = [name, said(one["acts"]), said(one["found"]), "yes" if one["exact"] else "no", covers, error]
    return "| " + " | ".join([*cells, f"{one['seconds']:.0f}"]) + " |"


@click.command()
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option("--seed", default=1, show_default=True)
@click.option("--others", is_flag=True, help="Draw their other effects instead.")
@click.option("--unlisted", is_flag=True, help="Draw effects that are on no list instead.")
@click.option("--limit", default=3000.0, show_default=True, help="Seconds after which a case is stopped.")
def main(out: Path, seed: int, others: bool, unlisted: bool, limit: float) -> None:
    """Draw, discover, score; everything is left in OUT."""
    (out / "cases").mkdir(parents=True, exist_ok=True)
    truths = draw(out / "cases", seed, others=others, unlisted=unlisted)
    rows, lines = [], [HEAD, "|---|---|---|---|---|---|---|"]
    for truth in truths:
        name = truth["case"]
        discover(out / "cases" / name, out / "reports" / name, limit, 1)
        one = scored(truth, out / "reports" / name)
        rows.append(one)
        lines.append(row(name, one))
        click.echo(lines[-1])
    lines.append(
        f"\n{sum(r['exact'] for r in rows)} of {len(rows)} right; {sum(r['false'] for r in rows)} with a false name."
    )
    click.echo(lines[-1])
    (out / "table.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
