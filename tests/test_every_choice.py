"""Every choice that the command line offers works; the choices are read off the commands themselves."""

from __future__ import annotations

from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

import stickslip as ss
from stickslip.cli.commands import COMMANDS, main

BELT = "run_01.csv"


def chosen() -> list[tuple[str, str, str]]:
    """Command, option or argument, choice."""
    context = click.Context(main)
    found = []
    for name in COMMANDS:
        command = main.get_command(context, name)
        assert command is not None
        for one in command.params:
            if isinstance(one.type, click.Choice):
                found += [(name, one.opts[-1], str(choice)) for choice in one.type.choices]
    return found


def run(*words: object) -> Result:
    return CliRunner().invoke(main, [str(one) for one in words])


def of_init(option: str, choice: str, folder: Path) -> Result:
    constants = {
        "two_degree": ["alpha1=16", "alpha2=8", "beta3=4", "eta1=0.1", "eta12=0.2"],
        "block_on_belt": ["m=0.0307", "k=168"],
        "driven_slider": ["m=2.0"],
    }[choice]
    if choice == "driven_slider":
        rows = [f"{0.002 * i:.3f},{1e-3 * i:.6f},{1.0 + i % 2}" for i in range(200)]
        (folder / BELT).write_text("\n".join(["t [s],x [m],drive [N]", *rows, ""]))
    elif choice == "two_degree":
        rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
        made = ss.simulate(ss.Model(rig, friction=ss.PaperFriction()), belt_speed=0.1, t_end=40)
        rows = [f"{t:.9g},{x[0]:.9g},{x[2]:.9g}" for t, x in zip(made.t, made.state, strict=True)]
        (folder / BELT).write_text("\n".join(["t,x1,y1", *rows, ""]))
    else:
        assert run("example", "practice", "--out", folder / "made").exit_code == 0
        (folder / BELT).write_bytes((folder / "made/RUN.csv").read_bytes())
    words = [word for one in constants for word in ("--constant", one)]
    more = (
        []
        if choice == "driven_slider"
        else ["--belt-speed", "12 mm/s" if choice == "block_on_belt" else "0.1"]
    )
    result = run("init", folder / BELT, option, choice, *words, *more)
    assert ss.load_case(folder).runs
    assert f'kind = "{choice}"' in (folder / "rig.toml").read_text(encoding="utf-8")
    return result


def of_case(command: str, option: str, choice: str, folder: Path) -> Result:
    assert run("example", "practice", "--out", folder).exit_code == 0
    if command == "identify":
        return run("identify", folder / "CASE", option, choice, "--out", folder / "out")
    rig = ss.BlockOnBelt(mass=0.0307, stiffness=168.0)
    model = ss.Model(rig, friction=ss.CoulombFriction(static=0.111, kinetic=0.07))
    model.save(folder / "model.toml")
    return run("compare", folder / "model.toml", folder / "CASE", option, choice, "--out", folder / "out")


@pytest.mark.parametrize(("command", "option", "choice"), chosen())
def test_what_is_offered_works(command: str, option: str, choice: str, tmp_path: Path) -> None:
    if command == "init":
        result = of_init(option, choice, tmp_path)
    elif command in ("identify", "compare"):
        result = of_case(command, option, choice, tmp_path)
    elif command == "example":
        result = run("example", choice, "--out", tmp_path / "new")
    else:
        assert command == "completion", f"nobody tries {command} {option}"
        result = run(command, choice)
    assert result.exit_code == 0, result.output


def test_a_kind_of_rig_that_is_not_offered_says_what_to_do_instead(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,x\n0,0\n1,1\n")
    result = run("init", tmp_path / "a.csv", "--rig", "bodies")
    assert result.exit_code == 2
    assert "stickslip example bodies" in result.output
