"""Do intervals on other rigs cover? Cases of known effect are fitted where it is true, and held against the truth.

    python bench/discovery/general_coverage.py OUT --rig chain --effect spring_cubic_k1 --seeds 12

draws cases of one rig with one effect, fits each as a search does that has found its name, and prints by how many
standard errors the effect's numbers, the constants and the gains are off: root mean square and share within two.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import general_draw
import numpy as np

import stickslip as ss
from stickslip.declared.model import Model
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of, of_single_events
from stickslip.discovery.laboratory.hypothesis import Term, label, term
from stickslip.likelihoods.fit import begun, fitted
from stickslip.likelihoods.fit_state import Fit


def fit_of(bench: GeneralBench, one: Term) -> Fit:
    """Return the fit with a term, of windows that hold one event each beside it."""
    first = fitted(begun(bench.windows((one,))), bench.policy)
    kept = of_single_events(bench, first)
    return fitted(fitted(begun(kept.windows((one,))), kept.policy), kept.policy)


def off(fit: Fit, truth: dict[str, Any], declared: dict[str, float], name: str) -> dict[str, float]:
    """Return by how many standard errors numbers are off, by what they are."""
    true = {f"gain.{channel}": gain - 1 for channel, gain in truth["gains"].items()}
    true |= {name: size / declared[name] for name, size in truth["constants"].items()}
    true |= {f"{name}.{k}": x for k, x in truth["effects"][0]["parameters"].items() if k != "phi"}
    errors = np.sqrt(np.diag(fit.solution.covariance))
    found = zip(fit.windows.numbers, fit.at, errors, strict=True)
    return {
        one.name: (x - (np.log(true[one.name]) if one.logarithmic else true[one.name])) / error
        for one, x, error in found
        if one.name in true
    }


@click.command()
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option("--rig", type=click.Choice([*general_draw.PLANS]), default="chain", show_default=True)
@click.option("--effect", default="spring_cubic_k1", show_default=True, help="One of the rig's.")
@click.option("--first", default=1, show_default=True, help="Seed of the first case.")
@click.option("--seeds", default=12, show_default=True, help="How many cases.")
def main(out: Path, rig: str, effect: str, first: int, seeds: int) -> None:
    """Draw, fit, hold against the truth; the cases are left in OUT."""
    plan = general_draw.PLANS[rig]()
    only = tuple(one for one in plan.effects if one[0] == effect)
    if not only:
        raise click.BadParameter(
            f"{rig} has {', '.join(one[0] for one in plan.effects)}", param_hint="--effect"
        )
    general_draw.PLANS = {rig: lambda: replace(plan, effects=only)}
    every: dict[str, list[float]] = {}
    for seed in range(first, first + seeds):
        folder = out / f"{rig}_{seed}"
        truth = general_draw.write_case(folder, general_draw.PLANS[rig](), seed, effect=True)
        case = ss.load_case(folder / "rig.toml")
        declared = case.model()
        plain = Model(declared.rig, friction=declared.friction)
        bench = bench_of(plain, case.train, case.uncertainty)
        (kind,) = [k for k in bench.kinds() if label(k) == f"{effect}@{only[0][1]}"]
        numbers = dict(truth["effects"][0]["parameters"])
        phases = (numbers["phi"],) * len(bench.data) if "phi" in numbers else ()
        one = term(kind, numbers, phases)
        for name, z in off(fit_of(bench, one), truth, plain.parameters, one.name).items():
            every.setdefault(name, []).append(z)
        click.echo(f"{folder.name}: {', '.join(f'{name} {zs[-1]:+.1f}' for name, zs in every.items())}")
    click.echo("| number | root mean square of error over sigma | within 2 sigma |")
    click.echo("|---|---|---|")
    for name, zs in every.items():
        size, within = np.sqrt(np.mean(np.square(zs))), np.mean(np.abs(zs) < 2)
        click.echo(f"| {name} | {size:.2f} | {100 * within:.0f} % of {len(zs)} |")


if __name__ == "__main__":
    main()
