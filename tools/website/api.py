"""The reference of the Python names and of the command line, from docstrings and help texts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import click

from stickslip.cli.commands import main
from stickslip.declared.laws import ALL_LAWS

GROUPS: Mapping[str, tuple[str, tuple[str, ...]]] = {  # page: title, names of `stickslip.__all__`
    "models": (
        "Models",
        (
            "Model",
            "load_model",
            "Rig",
            "Scales",
            "BlockOnBelt",
            "DrivenSlider",
            "BodiesRig",
            "Body",
            "Link",
            "Contact",
            "MatricesRig",
            "Speed",
            "EventScatter",
        ),
    ),
    "friction": (
        "Friction laws",
        (*(law.__name__ for law in ALL_LAWS.values()), "LawState"),
    ),
    "effects": ("Effects", ("effect", "Effect", "candidate", "tabulated", "Tabulated", "CATALOGUE")),
    "simulation": ("Simulation", ("simulate", "Trajectory", "Transitions", "Status", "sweep", "reference")),
    "orbits": (
        "Cycles, branches, exponents",
        (
            "limit_cycle",
            "LimitCycle",
            "cycle_sensitivity",
            "CycleSensitivity",
            "steady_sliding",
            "SteadySliding",
            "NoLimitCycleError",
            "continuation",
            "Branch",
            "SpecialPoint",
            "lyapunov",
            "LyapunovSpectrum",
        ),
    ),
    "recordings": (
        "Recordings",
        ("load_case", "Case", "load_recording", "Recording", "Channel", "signals"),
    ),
    "fits": (
        "Identification, discovery, forecasts",
        (
            "identify",
            "Identified",
            "IdentifiedRig",
            "compare",
            "Comparison",
            "RigComparison",
            "discover",
            "Found",
            "forecast",
        ),
    ),
    "errors": ("Errors and the build", ("StickslipError", "InputError", "ModelWarning", "build_config")),
}
CONSTANTS = {
    "CATALOGUE": """\
Every effect of a rig on a belt by its name: see the pages of [effects](../effects_of/index.md).

```pycon
>>> import stickslip as ss
>>> lag = ss.CATALOGUE["sensor_lag"]
>>> lag.where, [one.name for one in lag.parameters]
('x1 channel', ['tau'])

```""",
}
MODULES = {
    "reference": "The model again in plain Python, slow and obviously right.",
    "signals": "Filters and derivatives.",
}


def write(folder: Path) -> list[str]:
    """Write the pages into the folder; return their names, the list first."""
    folder.mkdir(parents=True, exist_ok=True)
    for page, (title, names) in GROUPS.items():
        text = f"# {title}\n\n" + "\n\n".join(directive(name) for name in names) + "\n"
        (folder / f"{page}.md").write_text(text, encoding="utf-8")
    (folder / "cli.md").write_text(commands(), encoding="utf-8")
    rows = "\n".join(
        f"| [{title}]({page}.md) | {', '.join(f'`{name}`' for name in names)} |"
        for page, (title, names) in GROUPS.items()
    )
    toc = "\n".join([*GROUPS, "cli"])
    text = (
        "# Reference\n\nAll public names, `import stickslip as ss`. Arguments are given by name. Bad input raises "
        "`StickslipError` with one line that says what is wrong, where, and what would be right.\n\n"
        f"| page | names |\n|---|---|\n{rows}\n| [The command line](cli.md) | `stickslip ...` |\n\n"
        f"```{{toctree}}\n:hidden:\n\n{toc}\n```\n"
    )
    (folder / "index.md").write_text(text, encoding="utf-8")
    return ["index", *GROUPS, "cli"]


def directive(name: str) -> str:
    """Return the autodoc directive of a public name."""
    import stickslip

    if name in CONSTANTS:
        return f"## {name}\n\n```{{py:data}} stickslip.{name}\n```\n\n{CONSTANTS[name]}"
    found = getattr(stickslip, name)
    if name in MODULES:
        inner = "\n\n".join(_auto(getattr(found, one), f"{found.__name__}.{one}") for one in found.__all__)
        return f"## {name}\n\n{MODULES[name]}\n\n{inner}"
    return f"## {name}\n\n{_auto(found, f'stickslip.{name}')}"


def _auto(what: object, path: str) -> str:
    kind, members = ("class", "\n   :members:") if isinstance(what, type) else ("function", "")
    return f"```{{eval-rst}}\n.. auto{kind}:: {path}{members}\n```"


def commands() -> str:
    """Return the page of the command line: the help of every command."""
    top = click.Context(main, info_name="stickslip")
    parts = ["# The command line", "Each command says the same with `--help`."]
    for name in main.list_commands(top):
        command = main.get_command(top, name)
        if command is not None:
            context = click.Context(
                command, info_name=name, parent=top, max_content_width=100, terminal_width=100
            )
            parts += [f"## stickslip {name}", f"```text\n{command.get_help(context)}\n```"]
    return "\n\n".join(parts) + "\n"
