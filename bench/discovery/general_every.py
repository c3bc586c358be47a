"""Every effect of the catalogue on rigs that are not the named ones, at sizes that it has in a laboratory.

    python bench/discovery/general_every.py OUT --seed 1 [--rig chain]

draws a case of every effect at one of its places on a drill string, a chain and a pin on a disc, searches each, and
writes OUT/table.md. Sizes are those of laboratory cases of (2.1), in units of the place: of what moves there without
it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from general import HEAD, row, scored
from general_draw import PLANS, TURN, Plan, write_case

import stickslip as ss
from run import discover
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import bench_of
from stickslip.discovery.general_rig.kinds import placed_kinds

SIZES: Mapping[str, Mapping[str, float]] = {  # in numbers like those of (2.1)
    "block_viscous_damping": {"c": 1.0},
    "block_quadratic_damping": {"c": 3.4},
    "spring_cubic_k1": {"k": 13.0},
    "spring_gap_k3": {"k": 8.0, "d": 0.06},
    "harmonic_forcing": {"a": 0.5, "w": 3.0},
    "pivot_dry_friction": {"f": 0.1},
    "normal_force_feedback": {"beta2": 1.9, "eta2": 0.3},
    "stribeck_peak": {"dT": 0.6, "v_s": 0.03},
    "static_aging": {"dT": 1.2, "tau": 1.8},
    "friction_drift": {"r": -0.0025},
    "belt_seam": {"a": 0.09, "L": 4.0},
    "belt_speed_ripple": {"a": 0.16, "w": 4.0},
    "sensor_lag": {"tau": 0.15},
    "sensor_crosstalk": {"c": 0.18},
    "sensor_nonlinearity": {"q": 0.15},
    "sensor_drift": {"r": 0.001},
}
SPREAD = 0.25  # of a size, to either side


def kinds_of(plan: Plan, folder: Path, seed: int) -> list[EffectKind]:
    """Effects at their places, by a record of the rig without any."""
    write_case(folder, plan, seed, effect=False)
    case = ss.load_case(folder / "rig.toml")
    known = Uncertainty.usual(case.rig, channels=list(plan.channels))
    bench = bench_of(case.model(), case.train, known)
    return placed_kinds(bench.model, bench.data, one_way=bench.one_way)


def with_effect(plan: Plan, name: str, kinds: list[EffectKind], rng: np.random.Generator) -> Plan | None:
    """The plan with an effect as its one other, None where it has no place."""
    places = [one for one in kinds if one.name == name]
    if not places:
        return None
    kind = places[int(rng.integers(len(places)))]
    numbers: dict[str, Any] = {
        key: size * kind.parameter(key).unit * float(rng.uniform(1 - SPREAD, 1 + SPREAD))
        for key, size in SIZES[name].items()
    }
    if "phi" in kind.parameter_names:
        numbers["phi"] = float(rng.uniform(*TURN))
    called = f"{name}:{kind.by}" if kind.by else name
    return replace(plan, others=((called, kind.where, lambda _: numbers),))


@click.command()
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option("--seed", default=1, show_default=True)
@click.option("--rig", type=click.Choice([*PLANS]), multiple=True, help="These alone.")
@click.option("--limit", default=3000.0, show_default=True, help="Seconds after which a case is stopped.")
@click.option("--draw", is_flag=True, help="Draw the cases, and no more.")
def main(out: Path, seed: int, rig: tuple[str, ...], limit: float, draw: bool) -> None:
    """Draw, discover, score; everything is left in OUT."""
    rows, lines, truths = [], [HEAD, "|---|---|---|---|---|---|---|"], []
    for k, name in enumerate(PLANS):
        if rig and name not in rig:
            continue
        plan = PLANS[name]()
        kinds = kinds_of(plan, out / "plain" / name, 1000 * seed + 900 + k)
        for i, effect in enumerate(SIZES):
            own = 1000 * seed + 100 * k + i
            acting = with_effect(plan, effect, kinds, np.random.default_rng([own, 5]))
            if acting is None:
                continue
            truths.append(write_case(out / "cases" / f"{name}_{effect}", acting, own, effect=True, other=0))
    (out / "cases" / "answers.json").write_text(json.dumps({"cases": truths}, indent=1))
    for truth in [] if draw else truths:
        discover(out / "cases" / truth["case"], out / "reports" / truth["case"], limit, 1)
        rows.append(scored(truth, out / "reports" / truth["case"]))
        lines.append(row(truth["case"], rows[-1]))
        click.echo(lines[-1])
    right, false = sum(r["exact"] for r in rows), sum(r["false"] for r in rows)
    lines.append(f"\n{right} of {len(rows)} right; {false} with a false name.")
    click.echo(lines[-1])
    (out / "table.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
