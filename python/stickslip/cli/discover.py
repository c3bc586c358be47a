"""The commands that close the loop: `stickslip discover` and `stickslip forecast`."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table

from stickslip.cli.path_type import Named, files_from_option, force_option
from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.model import Model, load_model, model_file
from stickslip.declared.rig import Rig
from stickslip.declared.scale import read_quantity, scales
from stickslip.declared.units import Channel
from stickslip.discovery.result import Found
from stickslip.errors import InputError, ModelWarning, Place
from stickslip.files import apart, folder, time_digits, write_csv
from stickslip.measured.case import Case, load_case
from stickslip.measured.readers.tables import column_names
from stickslip.measured.recording import Recording, load_recording
from stickslip.shown.progress import telling
from stickslip.shown.report import words
from stickslip.shown.report.contents import si_text
from stickslip.shown.report.units import axes_of

console = Console(highlight=False)


@click.command(short_help="What the declared model lacks: an effect, and how sure.")
@click.argument("case", type=Named())
@click.option("--out", type=Named(), required=True, help="Folder for the results.")
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Of the bootstrap's random numbers.",
)
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    default=None,
    help="Fits side by side; as many as there are cores, if absent. The result is the same.",
)
@files_from_option
@force_option
def discover(
    case: Path, out: Path, seed: int, threads: int | None, files_from: Path | None, force: bool
) -> None:
    """Find what the declared model of CASE (rig.toml or its folder) lacks, and add it.

    Writes report.html, report.json, model_before.toml, model_after.toml and the figures. The exit status is 0 with
    any verdict, "no_effect" included.

    \b
    Example:
      stickslip discover CASE/rig.toml --out found
    """
    from stickslip.discovery.discover import discover as search
    from stickslip.shown.report.write import NAMES, fill, written

    loaded = load_case(case, files_from=files_from)
    effects = len(CATALOGUE) if isinstance(loaded.rig, Rig) else 0  # the other rigs' are weighed all at once
    with (
        folder(out, NAMES, force=force, inputs=loaded.files) as temporary,
        telling("discovering", effects) as tell,
    ):
        for finding in folded(loaded.findings):
            tell(f"note: {finding}")
        found = search(loaded, progress=tell, seed=seed, threads=threads)
        tell("drawing the report")
        fill(temporary, found, loaded)
    say(found, loaded, console)
    console.print("written:")
    for path in written(out):
        console.print(f"  {path}", soft_wrap=True, markup=False)


def folded(findings: Iterable[str]) -> list[str]:
    """Findings, the first of those that differ only in their run and their numbers for all of these."""
    alike: dict[str, list[str]] = {}
    for one in findings:
        alike.setdefault(re.sub(r"\d[\d.e+-]*", "0", one.partition(": ")[2]), []).append(one)
    return [
        first if not more else f"{first} (and alike in {len(more)} other run{'s' if more[1:] else ''})"
        for first, *more in alike.values()
    ]


def say(found: Found, case: Case, to: Console) -> None:
    """Print the verdict, how sure it is, the errors, and what to do next."""
    to.print(f"[bold]{words.headline(found)}[/bold]")
    for line in (*words.sureness(found), words.clean_sentence(found)):
        to.print(f"- {line}", markup=False)
    if found.effects:
        to.print(effects_table(found, case))
    to.print(errors_table(found))
    for line in found.messages:
        to.print(f"- {line}", markup=False)
    if found.experiments:
        best = found.experiments[0]
        enough = "" if best.sufficient else " (not enough by itself)"
        axis = axes_of(case).x2
        unit = "" if axis.unit == "1" else f" {axis.unit}"
        at = "" if best.belt_speed is None else f" at belt speed {axis.size * best.belt_speed:.3g}{unit}"
        to.print(
            f"Next experiment: {best.what}{at}, to tell {' from '.join(best.between)}{enough}.", markup=False
        )


def effects_table(found: Found, case: Case) -> Table:
    """The effects found, with their numbers and intervals."""
    wrong = any(effect.of_rig for effect in found.effects)
    table = Table(title="wrong in the declared rig" if wrong else "what the declared model lacks")
    table.add_column("number", no_wrap=True)
    si = case.rig.scales is not None if isinstance(case.rig, Rig) else True
    for name in ("value", "95 % interval", *(("in SI",) if si else ())):
        table.add_column(name, justify="right", no_wrap=True)
    for effect in found.effects:
        if not effect.of_rig:
            table.add_row(f"[bold]{effect.name}[/bold]")
        for parameter, one in effect.parameters.items():
            own = (si_text(effect, parameter, case.rig),) if si else ()
            table.add_row(f"  {parameter}", *words.spanned(one), *own)
        if effect.curve is not None:
            table.add_row("  a curve", effect.curve.guess or "-")
    return table


def errors_table(found: Found) -> Table:
    """Error on the validate runs, before and after, with its floor."""
    table = Table(title="error on runs never fitted", caption=found.error.metric)
    table.add_column("run")
    for name in ("before", "after", "floor"):
        table.add_column(name, justify="right")
    for run in found.error.runs:
        table.add_row(run.run, *(words.short(run.one_cycle[k], 3) for k in ("before", "after", "floor")))
    e = found.error
    table.add_row("all", *(words.short(v, 3) for v in (e.before, e.after, e.floor)), style="bold")
    return table


@click.command(short_help="The readings that follow a recording.")
@click.argument("model", type=Named())
@click.argument("run", type=Named())
@click.option(
    "--belt-speed",
    required=True,
    help="v_b of RUN and of what follows it, in the belt channel's unit, or with one: '12 mm/s'.",
)
@click.option("--horizon", required=True, help="How far ahead, in the unit of the run's time, or '20 s'.")
@click.option("--out", type=Named(dir_okay=False), required=True, help="CSV file to write.")
@click.option("--figure", is_flag=True, help="Also draw the forecast after the end of the run, beside OUT.")
def forecast(model: Path, run: Path, belt_speed: str, horizon: str, out: Path, figure: bool) -> None:
    """Forecast the readings that follow RUN (a CSV of the past) by MODEL (model_after.toml).

    Writes t, x1, y1 in the run's units and at its sampling rate, from the next sample on.

    \b
    Example:
      stickslip forecast found/model_after.toml CASE/run_07.csv --belt-speed 0.0140 --horizon 20 --out next.csv
    """
    from stickslip.fitted.forecast import MOST
    from stickslip.fitted.forecast import forecast as predict

    apart(out, figure, {"MODEL": model_file(model), "RUN": run})
    loaded = load_model(model)
    if loaded.channels is None and isinstance(loaded.rig, Rig) and loaded.rig.scales is not None:
        words = "the rig is in SI and the units of the readings are not given; add [channels], as in rig.toml"
        raise InputError(words, place=Place(str(model)))
    units = scales(loaded.rig, loaded.channels)
    v_b = read_quantity(belt_speed, "belt", units["belt"], loaded.rig, "--belt-speed")
    ahead = read_quantity(horizon, "t", units["t"], loaded.rig, "--horizon")
    if ahead <= 0:
        raise InputError("must be a finite number above 0", key="--horizon", value=horizon)
    channels, noise = _recorded(loaded, run)
    set_point = f"{v_b * units['belt'].size!r} {units['belt'].unit}"  # a belt left out takes its unit along
    past = load_recording(run, loaded.rig, channels=channels, belt_speed=set_point, noise=noise)
    step = float(np.median(np.diff(past.t)))
    if ahead < step * (1 - 1e-9):
        words = f"shorter than the run's sampling interval {units['t'].of(step)}"
        raise InputError(words, key="--horizon", value=horizon)
    if ahead > MOST * step:
        words = (
            f"{ahead / step:.3g} samples; {MOST} are the most, {units['t'].of(MOST * step, 4)} of this run"
        )
        raise InputError(words, key="--horizon", value=horizon)
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", ModelWarning)
        frame = predict(loaded, past, belt_speed=v_b, horizon=ahead)
    write_csv(frame, out, 10)
    written = [out]
    if figure:
        from stickslip.shown.plot import curves as plot

        written += plot.save_figure(plot.forecast(past, frame), out.with_suffix(""))
    for doubt in doubts:
        console.print(f"- {doubt.message}", markup=False, soft_wrap=True)
    t, own = units["t"].unit, "" if units["belt"].size == 1 else f" ({v_b:.5g} in the model)"
    digits = time_digits(frame["t"], 6, finer=1.0)
    first, last = (f"{x:.{digits}g}" for x in (frame["t"].iloc[0], frame["t"].iloc[-1]))
    console.print(
        f"belt speed {units['belt'].of(v_b)}{own}; {len(frame)} samples, t = {first} to {last}"
        f"{'' if t == '1' else f' {t}'}; "
        + ", ".join(_column(past, str(name)) for name in frame if name != "t"),
        markup=False,
        soft_wrap=True,
    )
    console.print("written:")
    for path in written:
        console.print(f"  {path}", soft_wrap=True, markup=False)


def _column(past: Recording, name: str) -> str:
    """A column and its unit; where the column is a multiple of it, what 1 in it is."""
    channel = past.channels[name]
    if channel.scale != 1:
        return f"{name} [{channel.scale:.4g} {channel.unit}]"
    return name if channel.unit == "1" else f"{name} [{channel.unit}]"


def _recorded(model: Model, run: Path) -> tuple[dict[str, Channel] | None, dict[str, float]]:
    """The model's channels and noise, without those of a belt that this run did not record."""
    channels = None if model.channels is None else dict(model.channels)
    noise = dict(model.noise or {})
    column = channels["belt"].column if channels and "belt" in channels else "belt"
    if not any(head == column or head.startswith(f"{column} [") for head in column_names(run)):
        noise.pop("belt", None)
        if channels is not None:
            channels.pop("belt", None)
    return channels, noise
