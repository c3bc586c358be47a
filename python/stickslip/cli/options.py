"""What the commands share of their options: paths with a name, folders for results, the belt's speed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click


class Named(click.Path):
    """A path with a name: an empty one, as an unset shell variable leaves it, would be the working folder."""

    def __init__(self, **limits: Any) -> None:
        super().__init__(path_type=Path, **limits)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path.

        Raises
        ------
        click.BadParameter
            Of an empty one.
        """
        if not str(value).strip():
            self.fail("is empty; give a path", param, ctx)
        return super().convert(value, param, ctx)


class Output(Named):
    """The path of what a command writes."""


force_option = click.option(
    "--force", is_flag=True, help="Replace files that no former result put there, too."
)


files_from_option = click.option(
    "--files-from",
    type=Named(exists=True, file_okay=False),
    default=None,
    help="Folder that CASE may read recordings from, and below; its own, if absent.",
)

belt_option = click.option(
    "--belt-speed-from",
    "belt",
    type=click.Choice(["set-point", "plateau"]),
    default="set-point",
    show_default=True,
    help="Take v_b as set, or as the block rides in its sticks.",
)

out_option = click.option(
    "--out", type=Output(file_okay=False), required=True, help="Folder for the results."
)
