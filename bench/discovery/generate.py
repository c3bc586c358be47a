"""Draw test cases for the discovery loop: folders with rig.toml and runs, and answers.json with the truth.

    python bench/discovery/generate.py OUT --seed 1 --single 1 --none 10 --pairs 10 --unlisted 1 --odd 5

writes OUT/case_0000 ... and OUT/answers.json. ``--single K`` draws K cases of every listed effect,
``--unlisted K`` of every effect outside the list; ``--only NAME`` (repeatable) limits both. ``--odd`` draws
single effects and none under unusual conditions (`ODD`). Nothing here imports the package.
"""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import block_draw
import click
import numpy as np
from draw import Case, Conditions, draw_case
from strength import surviving
from truths import FORBIDDEN_PAIRS, LISTED, MISDECLARED, UNLISTED

ORDINARY = Conditions()
ODD = {
    "irregular": replace(ORDINARY, jitter=0.2),
    "outliers": replace(ORDINARY, outliers=0.01),
    "short": replace(ORDINARY, samples=1001),
    "long_coarse": replace(ORDINARY, samples=2001, dt=0.08),
    "fine": replace(ORDINARY, samples=4001, dt=0.02),
    "few_runs": replace(ORDINARY, train=(0.06, 0.14, -0.1), validate=(0.1,)),
    "many_runs": replace(ORDINARY, train=(0.05, 0.07, 0.1, 0.13, 0.17, -0.05, -0.08, -0.12, -0.16)),
    "one_direction": replace(ORDINARY, train=(0.05, 0.07, 0.1, 0.12, 0.14, 0.17), validate=(0.13, 0.08)),
    "one_speed": replace(ORDINARY, train=(0.1,) * 4, validate=(0.1,), speed_spread=0.0),
    "fast": replace(ORDINARY, train=(0.12, 0.18, 0.24, -0.1, -0.15, -0.2), validate=(0.2, -0.12)),
    "slow": replace(ORDINARY, train=(0.03, 0.05, 0.08, -0.03, -0.05, -0.08), validate=(0.06, -0.04)),
    "wide_rig": replace(ORDINARY, spread=0.4),
    "quiet": replace(ORDINARY, noise=(0.0001, 0.0003)),
    "loud": replace(ORDINARY, noise=(0.003, 0.005)),
    "odd_units": replace(ORDINARY, odd_units=True, si=True),
}
"""Conditions out of the ordinary, by name."""
# what contradicts a declared constant, and how well it is known unsaid
BEYOND, STIFF, DAMPING = 3.0, 0.015, 0.15
DAMPINGS = ("c1", "c2", "eta1", "eta12")
LENGTH_UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "cm": 1e-2, "1": 1.0}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "1": 1.0}
SPEED_UNITS = {"m/s": 1.0, "mm/s": 1e-3, "1": 1.0}
LAW_NAMES = {
    "Ts_m": "T_s_minus", "A1": "A1", "A2": "A2", "t1": "t1", "t2": "t2", "Tmin_m": "T_min_minus",
    "Ts_p": "T_s_plus",
    "Tmin_p": "T_min_plus",
}  # fmt: skip
RIG_NAMES = {"alpha1": "a1", "alpha2": "a2", "beta3": "b3", "eta1": "e1", "eta12": "e12", "s": "coup"}


def rig_lines(values: dict[str, float], scales: dict[str, Any], time: float = 1.0) -> list[str]:
    """The [rig] table, nondimensional or in SI with another omega by a factor."""
    if not scales["on"]:
        names = ("alpha1", "alpha2", "beta3", "eta1", "eta12")
        return [f"{n} = {values[n]:.10g}" for n in names] + ['coupling = "reciprocal"']
    k2, w, r = scales["k2"], scales["w"] * time, scales["r"]
    k1, k3 = k2 * (values["alpha1"] - 1.0), k2 * (values["beta3"] - 1.0)
    c1 = values["eta1"] * k2 / w
    si = {
        "k1": k1, "k2": k2, "k3": k3, "m": (k1 + k2) / w**2, "J": values["alpha2"] * r**2 * k2 / w**2, "r": r,
        "c1": c1, "c2": values["eta12"] * k2 / w - c1, "length": scales["L"],
    }  # fmt: skip
    return [f"{n} = {v:.10g}" for n, v in si.items()] + ['coupling = "reciprocal"']


def choose_units(rng: np.random.Generator, si: bool, odd: bool) -> tuple[str, str, str]:
    """Units of time, displacements and belt."""
    if not si:
        return "1", "1", "1"
    if not odd:
        return "s", "mm", "m/s"
    return (
        str(rng.choice(["s", "ms"])),
        str(rng.choice(["m", "mm", "um", "cm"])),
        str(rng.choice(["m/s", "mm/s"])),
    )


def write_case(folder: Path, case: Case, rng: np.random.Generator) -> None:
    """Write rig.toml and the runs of one case."""
    folder.mkdir(parents=True)
    s = case.scales
    time, length, speed = choose_units(rng, s["on"], case.conditions.odd_units)
    has_belt = case.runs[0].belt is not None
    to_t = 1.0 / (s["w"] * TIME_UNITS[time]) if s["on"] else 1.0
    to_x = s["L"] / LENGTH_UNITS[length] if s["on"] else 1.0
    to_v = s["L"] * s["w"] / (SPEED_UNITS[speed] if has_belt else 1.0) if s["on"] else 1.0
    lab = case.imperfections
    off, clock = ({}, 1.0) if lab is None else (lab.constants, lab.time)
    stated = {name: value * off.get(name, 1.0) for name, value in case.values.items()}
    lines = [f'title = "{folder.name}"', "", "[rig]", *rig_lines(stated, s, clock)]
    if case.declared is not None:
        lines += [
            "",
            "[friction]",
            'kind = "paper"',
            *(f"{LAW_NAMES[k]} = {v}" for k, v in case.declared.items()),
        ]
    if case.declare_noise:
        lines += ["", "[noise]", *(f"{c} = {case.noise * to_x:.4g}" for c in ("x1", "y1"))]
    for i, run in enumerate(case.runs, 1):
        file = f"run_{i:02d}.csv"
        lines += [
            "",
            "[[run]]",
            f'file = "{file}"',
            f'role = "{run.role}"',
            f"belt_speed = {run.belt_speed * to_v:.8g}",
        ]
        columns = [run.t * to_t, run.x1 * to_x, run.y1 * to_x]
        if run.belt is not None:
            columns.append(run.belt * to_v)
        header = "t,x1,y1" + (",belt" if has_belt else "")
        np.savetxt(folder / file, np.column_stack(columns), "%.8g", ",", header=header, comments="")
    channels = [("t", time), ("x1", length), ("y1", length)] + ([("belt", speed)] if has_belt else [])
    lines += ["", "[channels]", *(f'{n} = {{ column = "{n}", unit = "{u}" }}' for n, u in channels), ""]
    (folder / "rig.toml").write_text("\n".join(lines))


def beyond(case: Case) -> list[str]:
    """What reports call the declared constants that are off by more than three of the usual standard uncertainties."""
    lab = case.imperfections
    if lab is None:
        return []
    stated = {name: value * lab.constants.get(name, 1.0) for name, value in case.values.items()}
    true, said = (
        {
            name: float(value)
            for name, value in (line.split(" = ") for line in lines if not line.startswith("coup"))
        }
        for lines in (rig_lines(case.values, case.scales), rig_lines(stated, case.scales, lab.time))
    )
    usual = {name: DAMPING if name in DAMPINGS else STIFF for name in said}
    return [f"rig_{n}" for n, size in said.items() if size and abs(true[n] / size - 1) > BEYOND * usual[n]]


def answer_of(name: str, group: str, case: Case, seen: tuple[float, float] | None) -> dict[str, Any]:
    """The truth about one case, in the order a scorer wants it."""
    law = {RIG_NAMES.get(k, k): case.values[k] for k in (*RIG_NAMES, *LAW_NAMES)}
    return {
        "case": name,
        "class": group,
        "conditions": case.conditions.name,
        "effects": case.effects,
        "rig": law,
        "noise": case.noise,
        "scales": case.scales,
        "belt_recorded": case.runs[0].belt is not None,
        "phases": [r.phases for r in case.runs],
        "laboratory": None if case.imperfections is None else case.imperfections.told(),
        "beyond": beyond(case),
        "surviving_chi2": seen and seen[0],
        "refit_chi2_per_sample": seen and seen[1],
    }


def plan(
    rng: np.random.Generator,
    counts: dict[str, int],
    only: tuple[str, ...],
    laboratory: float = 0.0,
    rig: str = "two_degree",
) -> list[tuple[str, list[str], Conditions]]:
    """What to draw: class, effects and conditions of every case."""
    block = rig == "block"
    ordinary = block_draw.CONDITIONS if block else ORDINARY
    if laboratory:
        ordinary = replace(ordinary, laboratory=laboratory, name="laboratory")
    told = [*block_draw.LISTED] if block else [n for n in LISTED if not LISTED[n].absorbed]
    listed = [n for n in told if not only or n in only]
    unlisted = [n for n in (block_draw.UNLISTED if block else UNLISTED) if not only or n in only]
    drawn: list[tuple[str, list[str], Conditions]] = [("single", [n], ordinary) for n in listed] * counts[
        "single"
    ]
    drawn += [("unlisted", [n], ordinary) for n in unlisted] * counts["unlisted"]
    drawn += [("none", [], ordinary)] * counts["none"]
    pairs = [
        list(p)
        for p in combinations(told, 2)
        if frozenset(p) not in FORBIDDEN_PAIRS and (not only or set(p) & set(only))
    ]
    order = rng.permutation(len(pairs))
    drawn += [("pair", pairs[order[i % len(pairs)]], ordinary) for i in range(counts["pairs"])]
    odd = [(name, replace(one, laboratory=laboratory)) for name, one in ODD.items()]
    for i in range(counts["odd"]):
        name, conditions = odd[i % len(odd)]
        effects = [] if rng.random() < 0.25 else [str(rng.choice(listed))]
        drawn.append(("odd", effects, replace(conditions, name=name)))
    return drawn


def generate(
    out: Path,
    seed: int,
    counts: dict[str, int],
    only: tuple[str, ...] = (),
    *,
    strength: bool = False,
    laboratory: float = 0.0,
    rig: str = "two_degree",
) -> list[dict[str, Any]]:
    """Write the cases and answers.json below ``out``; returns the answers."""
    rng = np.random.default_rng(seed)
    answers = []
    for i, (group, names, conditions) in enumerate(plan(rng, counts, only, laboratory, rig)):
        own = np.random.default_rng([seed, i])
        if rig == "block":
            block = block_draw.draw_case(own, names, conditions)
            block_draw.write_case(out / f"case_{i:04d}", block)
            answers.append(block_draw.answer_of(f"case_{i:04d}", group, block))
            continue
        case = draw_case(own, names, conditions)
        seen = surviving(case) if strength and names else None
        write_case(out / f"case_{i:04d}", case, own)
        answers.append(answer_of(f"case_{i:04d}", group, case, seen))
    (out / "answers.json").write_text(json.dumps({"seed": seed, "cases": answers}, indent=1))
    return answers


@click.command()
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option("--seed", default=1, show_default=True)
@click.option("--single", default=0, help="Cases of every listed effect.")
@click.option("--none", "none_", default=0, help="Cases without any effect.")
@click.option("--pairs", default=0, help="Cases with two listed effects, pairs by lot.")
@click.option("--unlisted", default=0, help="Cases of every effect outside the list.")
@click.option("--odd", default=0, help="Cases under unusual conditions.")
@click.option("--only", multiple=True, help="Limit to these effects.")
@click.option("--laboratory", default=0.0, help="Size of a laboratory's imperfections; 1 is the usual one.")
@click.option("--rig", type=click.Choice(["two_degree", "block"]), default="two_degree", show_default=True)
@click.option("--strength", is_flag=True, help="Also compute what survives a refit (seconds a case).")
def main(
    out: Path,
    seed: int,
    single: int,
    none_: int,
    pairs: int,
    unlisted: int,
    odd: int,
    only: tuple[str, ...],
    laboratory: float,
    rig: str,
    strength: bool,
) -> None:
    """Draw cases into OUT, which must not hold any yet."""
    if out.exists() and any(out.iterdir()):
        raise click.ClickException(f"{out} is not empty; name a new folder.")
    out.mkdir(parents=True, exist_ok=True)
    if unknown := [n for n in only if n not in LISTED | MISDECLARED | UNLISTED]:
        raise click.ClickException(f"no such effect: {', '.join(unknown)}")
    if rig == "block" and (odd or strength or not laboratory):
        raise click.ClickException(
            "a block is drawn in a laboratory (--laboratory 1), without --odd and --strength."
        )
    counts = {"single": single, "none": none_, "pairs": pairs, "unlisted": unlisted, "odd": odd}
    answers = generate(out, seed, counts, only, strength=strength, laboratory=laboratory, rig=rig)
    click.echo(f"{len(answers)} cases in {out}")


if __name__ == "__main__":
    main()
