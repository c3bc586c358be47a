"""What each number that steers the search is worth: halved and doubled, one at a time, on cases whose truth is known.

    python bench/discovery/ablation.py CASES OUT.md [--only case_04] [--field fullest]

CASES has answers.json. A row says in how many cases the verdict changed, how many changes were for the worse, the
largest change of the chosen hypothesis' gain in units of the gate, and the time over that of the policy as it is. A
field whose rows are zeros, on cases enough, is worth nothing and should go.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import click
from threadpoolctl import threadpool_limits

import stickslip as ss
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.discovery.laboratory.verdicts import searched
from stickslip.errors import StickslipError
from stickslip.fitted.data import prepare
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.likelihoods.stretches import stretches


@dataclass(frozen=True)
class Verdict:
    """Names in order of weight, the gain of the chosen hypothesis over the gate, and processor seconds."""

    names: tuple[str, ...]
    gain: float
    seconds: float


def variants(only: tuple[str, ...]) -> Iterator[tuple[str, str, Policy]]:
    """Return (field, factor, policy), one number changed in each; a range is narrowed or widened about its middle."""
    for one in fields(POLICY):
        if only and one.name not in only:
            continue
        value = getattr(POLICY, one.name)
        for word, factor in (("half", 0.5), ("double", 2.0)):
            changed: Any
            if isinstance(value, tuple):
                low, high = value
                root = (high / low) ** (factor / 2)
                middle = (low * high) ** 0.5
                changed = (middle / root, middle * root)
            elif isinstance(value, int):
                changed = max(1, round(value * factor))
            else:
                changed = value * factor
            yield one.name, word, replace(POLICY, **{one.name: changed})


def verdict(case: ss.Case, policy: Policy) -> Verdict:
    """Search a case under a policy."""
    began = time.process_time()
    data = prepare(case.train)
    bench = replace(bench_of(case, data), policy=policy, stretches=stretches(data, policy))
    try:
        found = searched(bench, case.uncertainty, lambda _: None, 0)
    except (StickslipError, FloatingPointError):
        return Verdict(("(no model)",), 0.0, time.process_time() - began)
    names = ("unlisted",) if found.curve is not None else found.searched.chosen.names
    if found.searched.chosen.freed is not None and found.curve is None:
        names = (*names, f"rig_{found.searched.chosen.freed.name}")
    null, chosen, steps = found.searched.null, found.searched.chosen, found.searched.steps
    gain = (null.worth() - chosen.worth()) / max(steps[0].gate.threshold, 1e-9) if steps else 0.0
    return Verdict(names, gain, time.process_time() - began)


@click.command()
@click.argument("cases", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("out", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--only", multiple=True, help="Cases; all that answers.json has by default.")
@click.option("--field", "chosen", multiple=True, help="Fields; all by default.")
def main(cases: Path, out: Path, only: tuple[str, ...], chosen: tuple[str, ...]) -> None:
    """Write the table of what each field of the policy is worth on CASES to OUT."""
    answers = {one["case"]: one for one in json.loads((cases / "answers.json").read_text())["cases"]}
    kept = [name for name in answers if not only or name in only]
    loaded = {name: ss.load_case(cases / name / "rig.toml") for name in kept}
    truth = {name: tuple(e["name"] for e in answers[name]["effects"]) for name in kept}
    with threadpool_limits(1):
        plain = {name: verdict(loaded[name], POLICY) for name in kept}
        for name in kept:
            print(name, plain[name], flush=True)
        rows = [
            "| field | value | changed to | verdicts changed | for the worse | gain, largest change | time |",
            "|---|---|---|---|---|---|---|",
        ]
        for field, word, policy in variants(chosen):
            other = {name: verdict(loaded[name], policy) for name in kept}
            changed = [name for name in kept if other[name].names != plain[name].names]
            worse = [name for name in changed if plain[name].names == truth[name]]
            moved = max(abs(other[n].gain - plain[n].gain) for n in kept)
            spent = sum(other[n].seconds for n in kept) / sum(plain[n].seconds for n in kept)
            rows.append(
                f"| `{field}` | {getattr(POLICY, field)} | {word} | {len(changed)} of {len(kept)} | {len(worse)} | "
                f"{moved:.2g} | {spent:.2f} |"
            )
            print(rows[-1], flush=True)
            out.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
