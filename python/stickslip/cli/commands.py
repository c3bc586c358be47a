"""The command line: `stickslip simulate | identify | compare | discover | forecast | demo`."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

import stickslip
from stickslip.cli.path_type import Named, files_from_option, force_option
from stickslip.errors import InputError, StickslipError, quoted
from stickslip.files import folder

if TYPE_CHECKING:  # slow to import, and `--help` needs none of it
    from stickslip.fitted.compare import Comparison
    from stickslip.fitted.identified import Identified
    from stickslip.fitted.identify import BeltSpeed

BAD_INPUT = 2
IDENTIFY = ("model.toml", "identified.json", "friction_characteristic.svg", "friction_characteristic.png")
COMPARE = (
    "compare.json",
    *(f"{figure}.{kind}" for figure in ("phase_portrait", "time_series") for kind in ("svg", "png")),
)
console = Console(highlight=False)


@contextmanager
def ended_cleanly() -> Iterator[None]:
    """SIGTERM and SIGHUP end the program as Ctrl-C does: nothing half-written stays, nor a process of ours."""

    def end(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_DFL)  # a second one does not wait
        sys.exit(128 + number)

    taken = []
    if threading.current_thread() is threading.main_thread():  # no other may take a signal
        known = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
        taken = [one for one in known if signal.getsignal(one) is signal.SIG_DFL]  # nohup ignores SIGHUP
    for one in taken:
        signal.signal(one, end)
    try:
        yield
    finally:
        for one in taken:
            signal.signal(one, signal.SIG_DFL)


ELSEWHERE = {  # commands in modules of their own, imported when they are asked for, and what the list says of them
    "discover": ("stickslip.cli.discover", "What the declared model lacks: an effect, and how sure."),
    "forecast": ("stickslip.cli.discover", "The readings that follow a recording."),
    "simulate": ("stickslip.cli.simulate", "One run of a model, as CSV and a figure."),
    "sweep": ("stickslip.cli.sweep", "A model over a grid of its numbers, into a Zarr store."),
}


class OneLine(click.Group):
    """Errors of ours are one line on standard error and exit status 2; a traceback is a bug."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands, of those elsewhere too."""
        return sorted([*super().list_commands(ctx), *ELSEWHERE])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command, imported if it is elsewhere."""
        if cmd_name not in ELSEWHERE:
            return super().get_command(ctx, cmd_name)
        command: click.Command = getattr(import_module(ELSEWHERE[cmd_name][0]), cmd_name)
        return command

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        said = {name: one.get_short_help_str(100) for name, one in self.commands.items()}
        said |= {name: words for name, (_, words) in ELSEWHERE.items()}
        with formatter.section("Commands"):
            formatter.write_dl(sorted(said.items()))

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run the program, without an output where it was given none."""
        for name in ("stdout", "stderr"):
            if getattr(sys, name) is None:  # closed by who called; the next file opened would take its place
                setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        with ended_cleanly():
            return super().main(*args, **extra)

    def invoke(self, ctx: click.Context) -> object:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except StickslipError as error:
            click.echo(f"stickslip: {error}", err=True)
        except click.UsageError as error:
            words = error.format_message().rstrip(".")
            where = error.ctx.command_path if error.ctx else "stickslip"
            click.echo(f"stickslip: {words[:1].lower()}{words[1:]} (see {where} --help)", err=True)
        except BrokenPipeError:  # who reads us has gone: click's to end quietly
            raise
        except OSError as error:
            about = f"{quoted(error.filename)}: " if error.filename else ""
            click.echo(f"stickslip: {about}{(error.strerror or str(error)).lower()}", err=True)
            sys.exit(1)
        sys.exit(BAD_INPUT)


@click.group(cls=OneLine, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="stickslip", prog_name="stickslip")
def main() -> None:
    """Stick-slip friction rigs: simulate, identify from recordings, compare, find what the model lacks.

    Each command shows an example: stickslip identify --help
    """


@contextmanager
def progress(title: str) -> Iterator[Callable[[str, float], None]]:
    """A progress bar on the terminal; nothing where the output is not one."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    to = Console(stderr=True)
    # without a terminal it would leave an empty line before an error
    with Progress(*columns, console=to, transient=True, disable=not to.is_terminal) as bar:
        task = bar.add_task(title, total=1.0)

        def tell(what: str, share: float) -> None:
            bar.update(task, description=f"{title}: {what}", completed=share)

        yield tell


belt_option = click.option(
    "--belt-speed-from",
    "belt",
    type=click.Choice(["set-point", "plateau"]),
    default="set-point",
    show_default=True,
    help="Take v_b as set, or as the block rides in its sticks.",
)
out_option = click.option("--out", type=Named(file_okay=False), required=True, help="Folder for the results.")


@main.command(short_help="The friction law, from the recordings of a case.")
@click.argument("case", type=Named())
@out_option
@belt_option
@files_from_option
@force_option
def identify(case: Path, out: Path, belt: BeltSpeed, files_from: Path | None, force: bool) -> None:
    """Identify the friction law from the train runs of CASE (rig.toml or its folder).

    Writes model.toml, identified.json and the friction characteristic as SVG and PNG.

    \b
    Example:
      stickslip identify CASE/rig.toml --out identified
    """
    loaded = stickslip.load_case(case, files_from=files_from)
    _say_findings(loaded.findings)
    with folder(out, IDENTIFY, force=force, inputs=loaded.files) as temporary:
        with progress("identifying") as tell:
            found = stickslip.identify(loaded, belt_speed=belt, progress=tell)
        _fill_identified(found, temporary)
    console.print(estimates_table(found))
    for message in found.messages:
        console.print(f"- {message}", markup=False)
    _say_written([out / name for name in IDENTIFY])


@main.command(short_help="A model against a recording: one table, two figures.")
@click.argument("model", type=Named())
@click.argument("case", type=Named())
@out_option
@belt_option
@click.option(
    "--run", "name", default=None, help="Name of the run; the first validate run, else the first, if absent."
)
@files_from_option
@force_option
def compare(
    model: Path,
    case: Path,
    out: Path,
    belt: BeltSpeed,
    name: str | None,
    files_from: Path | None,
    force: bool,
) -> None:
    """Simulate MODEL (a TOML file, or the folder of identify) with the belt speed of a run of CASE; compare the two.

    Writes compare.json, the phase portrait and the time series as SVG and PNG.

    \b
    Example:
      stickslip compare identified/model.toml CASE/rig.toml --out compared
    """
    if _is_case(model) and not _is_case(case):
        words = f"the model comes first: stickslip compare {case} {model} --out {out}"
        raise InputError(words, key="MODEL", value=str(model))
    law, loaded = stickslip.load_model(model), stickslip.load_case(case, files_from=files_from)
    first = next((r for r in loaded.runs if r.role == "validate"), loaded.runs[0])
    recording = first if name is None else loaded.run(name)
    _say_findings(tuple(f"{recording.name}: {finding}" for finding in recording.findings))
    others = sum(r.role == "validate" for r in loaded.runs) - 1
    if name is None and others > 0:
        console.print(f"{recording.name}, the first of {others + 1} validate runs; --run names another")
    with folder(out, COMPARE, force=force, inputs=(*loaded.files, model)) as temporary:
        with progress("comparing") as tell:
            result = stickslip.compare(law, recording, belt_speed=belt, progress=tell)
        _fill_comparison(result, temporary)
    console.print(comparison_table(result))
    _say_verdict(result)
    _say_written([out / name for name in COMPARE])


@main.command(short_help="All of it on a real recording, then a story of discovery.")
@click.option(
    "--out",
    type=Named(file_okay=False),
    default=Path("demo"),
    show_default=True,
    help="Folder for the results.",
)
@click.option("--first-half", is_flag=True, help="Stop after the slider.")
@force_option
def demo(out: Path, first_half: bool, force: bool) -> None:
    """Do the whole job on a recording that comes with the package: a slider of paper on paper.

    Then tell the paper's own story: a rig whose measured portrait is rotated, its stick phase irregular, and why.

    \b
    Example:
      stickslip demo --out demo
    """
    from stickslip.cli.demo import run

    with folder(out, (*IDENTIFY, *COMPARE), force=force) as temporary:
        with progress("demo") as tell:
            result = run(tell)
        _fill_identified(result.found, temporary)
        _fill_comparison(result.comparison, temporary)
    written = [out / name for name in (*IDENTIFY, *COMPARE)]
    for paragraph in result.before:
        console.print(paragraph + "\n")
    console.print(estimates_table(result.found))
    console.print(comparison_table(result.comparison))
    _say_verdict(result.comparison)
    for paragraph in result.after:
        console.print(paragraph + "\n")
    if not first_half:
        from stickslip.cli.story import story

        written += story(out, console).paths
    _say_written(written)


def estimates_table(found: Identified) -> Table:
    """The identified law."""
    table = Table(title=f"identified law: {found.law.kind}", box=SIMPLE, pad_edge=False)
    rows = found.table()
    for name in rows[0]:
        table.add_column(
            name, justify="left" if name in ("parameter", "unit", "status") else "right", no_wrap=True
        )
    for row in rows:
        table.add_row(*row.values())
    return table


def comparison_table(c: Comparison) -> Table:
    """Simulated against measured."""
    table = Table(
        title=f"simulated against measured: {c.recording.name}",
        box=SIMPLE,
        pad_edge=False,
        collapse_padding=True,  # 80 columns are enough
        show_edge=False,
    )
    table.add_column("quantity", no_wrap=True)
    for name in ("measured", "simulated", "off by", "scatter"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for r in c.rows:
        table.add_row(r.quantity, *r.cells, "" if r.unit == "1" else r.unit)
    return table


def _say_verdict(c: Comparison) -> None:
    console.print()
    for line in c.verdict():
        console.print(f"- {line}", markup=False)


def _fill_identified(found: Identified, into: Path) -> None:
    from stickslip.shown.plot import curves as plot

    found.fill(into)
    plot.save_figure(plot.friction_characteristic(found), into / "friction_characteristic")


def _fill_comparison(c: Comparison, into: Path) -> None:
    from stickslip.declared.toml_file import write_text
    from stickslip.shown.plot import curves as plot

    write_text(into / "compare.json", json.dumps(c.to_dict(), indent=1))
    plot.save_figure(plot.phase_portrait(c), into / "phase_portrait")
    plot.save_figure(plot.time_series(c), into / "time_series")


def _is_case(path: Path) -> bool:
    """Is it a case's folder or its rig.toml, by the look of it?"""
    if path.is_dir():
        return (path / "rig.toml").is_file()
    return path.is_file() and "[[run]]" in path.read_text(encoding="utf-8", errors="replace")


def _say_findings(findings: tuple[str, ...]) -> None:
    """What is odd about the readings, before anything is made of them."""
    if findings:
        console.print("What the check of the recordings says:")
    for finding in findings:
        console.print(f"- {finding}", soft_wrap=True, markup=False)


def _say_written(paths: list[Path]) -> None:
    console.print("written:")
    for path in paths:
        console.print(f"  {path}", soft_wrap=True)
