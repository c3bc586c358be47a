"""The command line: `stickslip init | check | simulate | identify | discover | ...`, a module each."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import click
from click.shell_completion import CompletionItem

from stickslip.errors import StickslipError, quoted

BAD_INPUT = 2
COMMANDS = {  # a module of its name each, imported when it is asked for; and what the list says of it
    "check": "What the runs of a case can tell and what they cannot.",
    "compare": "A model against a recording: one table, two figures.",
    "completion": "What a shell needs to complete commands, options and files.",
    "demo": "All of it on a real recording, then a story of discovery.",
    "discover": "What the declared model lacks: an effect, and how sure.",
    "example": "Files to begin with: a recording, a case.",
    "explore": "A model with sliders, redrawn live in the browser.",
    "forecast": "The readings that follow a recording.",
    "identify": "The friction law, from the recordings of a case.",
    "init": "A first rig.toml for recorded files.",
    "inspect": "What is in a file: columns, units, rates, gaps, what is doubtful.",
    "simulate": "One run of a model, as CSV and a figure.",
    "sweep": "A model over a grid of its numbers, into a Zarr store.",
}


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


WORDS = 300  # characters of a refusal, what was given in it


def _refused(error: click.UsageError) -> None:
    """Say in one line what click refuses."""
    words = quoted(error.format_message().rstrip("."), WORDS)
    where = error.ctx.command_path if error.ctx else "stickslip"
    click.echo(f"stickslip: {words[:1].lower()}{words[1:]} (see {where} --help)", err=True)


class OneLine(click.Group):
    """Errors of ours are one line on standard error and exit status 2; a traceback is a bug."""

    def list_commands(self, _ctx: click.Context) -> list[str]:
        """Names of the commands."""
        return sorted(COMMANDS)

    def get_command(self, _ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command, from its module."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = getattr(import_module(f"stickslip.cli.{cmd_name}"), cmd_name)
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Commands that begin so, without importing them; and options."""
        commands = [
            CompletionItem(n, help=words) for n, words in COMMANDS.items() if n.startswith(incomplete)
        ]
        return [*commands, *click.Command.shell_complete(self, ctx, incomplete)]

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(sorted(COMMANDS.items()))

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run the program, without an output where it was given none."""
        for name in ("stdout", "stderr"):
            if getattr(sys, name) is None:  # closed by who called; the next file opened would take its place
                setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        with ended_cleanly():
            return super().main(*args, **extra)

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """Take the arguments before the command's name."""
        try:
            return super().make_context(*args, **extra)
        except click.NoSuchOption as error:
            _refused(error)
            sys.exit(BAD_INPUT)

    def invoke(self, ctx: click.Context) -> object:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except StickslipError as error:
            click.echo(f"stickslip: {error}", err=True)
        except click.UsageError as error:
            _refused(error)
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
