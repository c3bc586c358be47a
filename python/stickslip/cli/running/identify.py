"""What is done by `stickslip identify`: the friction law, from the recordings of a case."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rich.box import SIMPLE
from rich.table import Table

from stickslip.cli.printed import console, say_findings, say_table, say_written
from stickslip.files import folder
from stickslip.fitted.identified import Identified
from stickslip.fitted.saved_result import IDENTIFIED
from stickslip.likelihoods.identified_rig import IdentifiedRig
from stickslip.likelihoods.identify import identify as run
from stickslip.measured.case import load_case
from stickslip.progress import shares

if TYPE_CHECKING:
    from stickslip.fitted.identify import BeltSpeed

WRITTEN = (*IDENTIFIED, "friction_characteristic.svg", "friction_characteristic.png")


def perform(case: Path, out: Path, belt: BeltSpeed, files_from: Path | None, force: bool) -> None:
    """Do what `stickslip identify` is asked for."""
    loaded = load_case(case, files_from=files_from)
    say_findings(loaded.findings)
    with folder(out, WRITTEN, force=force, inputs=loaded.files) as temporary:
        with shares("identifying") as tell:
            found = run(loaded, belt_speed=belt, progress=tell)
        fill_identified(found, temporary)
    if isinstance(found, IdentifiedRig):
        console.print(
            f"chi2 per degree of freedom {found.reduced_chi2:.3g}, {found.windows} windows", highlight=False
        )
    say_table(estimates_table(found))
    for message in found.messages:
        console.print(f"- {message}", markup=False)
    say_written([out / name for name in WRITTEN])


def estimates_table(found: Identified | IdentifiedRig) -> Table:
    """The identified law."""
    title = f"identified law: {found.law.kind}"
    if isinstance(found, IdentifiedRig):
        title = "identified: " + ", ".join(f"{name} {law.kind}".strip() for name, law in found.laws.items())
    table = Table(title=title, box=SIMPLE, pad_edge=False, collapse_padding=True)
    rows = found.table()
    for name in rows[0]:
        text = name in ("parameter", "unit", "status")
        table.add_column(name, justify="left" if text else "right", no_wrap=name != "status", overflow="fold")
    for row in rows:
        table.add_row(*row.values())
    return table


def fill_identified(found: Identified | IdentifiedRig, into: Path) -> None:
    """Write the files of an identification."""
    from stickslip.shown.plot import bodies
    from stickslip.shown.plot import curves as plot

    found.fill(into)
    if isinstance(found, IdentifiedRig):
        plot.save_figure(bodies.laws(found), into / "friction_characteristic")
        return
    plot.save_figure(plot.friction_characteristic(found), into / "friction_characteristic")
