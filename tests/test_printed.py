"""What cycles, branches and simulated tables say of themselves where they are printed."""

import io
import re
import time

import pytest
from click.testing import CliRunner
from rich.console import Console
from rich.table import Table

import stickslip as ss
from stickslip.cli.commands import main
from stickslip.cli.printed import say_table
from stickslip.progress import shares
from test_continuation import leine  # noqa: F401

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
MODEL = ss.Model(RIG, friction=ss.PaperFriction())


def test_a_cycle_is_one_line_with_its_period():
    cycle = ss.limit_cycle(MODEL, belt_speed=0.1)
    assert repr(cycle).startswith(f"<LimitCycle: period {cycle.period:.9g}, stable, sticks; x1 = ")
    assert "\n" not in repr(cycle)


def test_a_branch_is_its_span_and_a_line_for_each_bifurcation(leine):  # noqa: F811
    first, *rest = str(leine).splitlines()
    assert "\n" not in repr(leine)
    assert first.startswith(
        f"<Branch: {leine.parameter} {leine.values.min():.6g} to {leine.values.max():.6g}; "
    )
    assert [line.split()[0] for line in rest] == [f"<{one.kind}" for one in leine.special]
    for line, one in zip(rest, leine.special, strict=True):
        assert f"at {one.value:.9g}: period {one.cycle.period:.6g}" in line


def rows(tmp_path, *more):
    MODEL.save(tmp_path / "model.toml")
    asked = [
        "simulate",
        tmp_path / "model.toml",
        "--belt-speed",
        0.1,
        "--t-end",
        20000,
        "--out",
        tmp_path / "r.csv",
    ]
    result = CliRunner().invoke(main, [str(one) for one in [*asked, *more]])
    assert result.exit_code == 0, result.output
    return result.output


def test_rows_too_far_apart_for_the_motion_are_said_with_a_step_that_is_not(tmp_path):
    said = rows(tmp_path)
    found = re.search(
        r"rows are 10 apart and the contact changes every (\S+) on average: .* --dt '(\S+)' would", said
    )
    assert found, said
    run = ss.simulate(MODEL, belt_speed=0.1, t_end=20000, t_eval=[20000])
    apart = (run.transitions.t[-1] - run.transitions.t[0]) / (len(run.transitions) - 1)
    assert abs(float(found[1]) - apart) < 1e-3 * apart
    assert "does not show" not in rows(tmp_path, "--dt", found[2])


def test_a_branch_that_is_cut_off_names_no_argument_that_nobody_gave():
    branch = ss.continuation(MODEL, span=(0.1, 0.14), max_points=3)
    assert "max_points" not in repr(branch)
    assert "most points" in repr(branch)


def test_a_log_hears_of_a_fit_that_lasts(capfd: pytest.CaptureFixture[str]) -> None:
    with shares("identify", every=0.05) as tell:
        tell("fitting windows", 0.25)
        time.sleep(0.2)
    said = capfd.readouterr().err
    assert "identify: fitting windows, 25% done" in said


def test_a_log_hears_nothing_of_a_quick_fit(capfd: pytest.CaptureFixture[str]) -> None:
    with shares("identify") as tell:
        tell("fitting windows", 0.25)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("terminal", [False, True])
def test_a_table_is_not_cut(terminal):
    """That of `identify`, of a rig of bodies, was cut at 80 columns."""
    cells = [f"{'word ' * 12}{i}" for i in range(3)]
    table = Table(title="what is found")
    for name in "abc":
        table.add_column(name, no_wrap=True, overflow="fold")
    table.add_column("status")
    table.add_row(*cells, "of many words " * 9)
    to = Console(file=io.StringIO(), force_terminal=terminal, width=80)
    say_table(table, to)
    printed = to.file.getvalue()
    assert all(cell in printed for cell in cells)
    assert (printed.count("of many words ") == 9) != terminal  # on a terminal these wrap
