"""The command `stickslip completion`: what a shell needs to complete commands, options and files."""

from __future__ import annotations

from typing import Any

import click
from click.shell_completion import get_completion_class

VARIABLE = "_STICKSLIP_COMPLETE"
SHELLS = ("bash", "zsh", "fish")


@click.command(short_help="What a shell needs to complete commands, options and files.")
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the script that lets SHELL complete this program's commands, options and files with the tab key.

    \b
    Examples:
      stickslip completion bash >> ~/.bash_completion
      stickslip completion zsh > ~/.zfunc/_stickslip      (a folder in $fpath)
      stickslip completion fish > ~/.config/fish/completions/stickslip.fish
    """
    kind: Any = get_completion_class(shell)
    program = kind(context.find_root().command, {}, "stickslip", VARIABLE)
    # click looks for a bash that is new enough; who only wants the text need not have one
    click.echo(program.source_template % program.source_vars())
