"""The pages of effects, one a place where they act, from the catalogue."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from stickslip.declared.catalogue import CATALOGUE, CONSTANTS, DRIVEN, KINDS
from stickslip.declared.dimensions import NUMBER
from stickslip.declared.effect_kind import EffectKind, ParameterInfo
from website.docstring import escaped
from website.effect_figures import draw, numbers

PLACES: Mapping[str, tuple[str, str]] = {  # page: title, what is said first
    "block": ("On the block", "Forces on the block, in the bracket of (2.1)."),
    "angle_body": ("On the angle body", "Forces on the angle body of (2.1), and on both bodies."),
    "contact": ("In the contact", "What friction does beyond a law of the sliding velocity."),
    "belt": ("On the belt", "How the belt's speed departs from its set-point."),
    "sensors": ("In the sensors", "What is in the readings and not in the motion."),
    "constants": (
        "Declared numbers that are wrong",
        "For a block on a belt: a constant that is off by a share.",
    ),
    "driven_slider": (
        "On a driven slider",
        "An inertia with friction under a known drive: no belt, no spring, SI units. The figures show the force "
        "balance of a carriage in a position loop: drive less inertia, as a laboratory would compute it.",
    ),
}


def page_of(kind: EffectKind) -> str:
    """Return the page on which an effect stands."""
    if kind.name in CONSTANTS:
        return "constants"
    if kind.name not in CATALOGUE:
        return "driven_slider"
    places = {"both": "angle_body", "x1 channel": "sensors", "y1 channel": "sensors"}
    return places.get(kind.where, kind.where)


def write(folder: Path) -> list[str]:
    """Write every page and figure into the folder; return the names of the pages, the list first."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in KINDS:
        draw(name, folder / f"{name}.svg")
    for page, (title, words) in PLACES.items():
        kinds = [kind for kind in KINDS.values() if page_of(kind) == page]
        parts = [f"# {title}", words, *(section(kind) for kind in kinds)]
        (folder / f"{page}.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    (folder / "index.md").write_text(overview(), encoding="utf-8")
    return ["index", *PLACES]


def overview() -> str:
    """Return the list of effects."""
    lines = [
        "# Effects",
        "",
        "An effect is what a rig or an instrument does and the declared model does not say. `stickslip discover` tries "
        "each of them on the recordings. Each may be declared, simulated, swept and fitted. These pages are made from "
        "the code; [one table has them all](../effects.md).",
    ]
    for page, (title, _) in PLACES.items():
        lines += ["", f"## [{title}]({page}.md)", "", "| effect | what it is |", "|---|---|"]
        lines += [
            f"| [`{kind.name}`]({page}.md#{anchor(kind.name)}) | {escaped(kind.words)} |"
            for kind in KINDS.values()
            if page_of(kind) == page
        ]
    toc = "\n".join(PLACES)
    return "\n".join(lines) + f"\n\n```{{toctree}}\n:hidden:\n\n{toc}\n```\n"


def anchor(name: str) -> str:
    """Return the anchor of an effect's section."""
    return name


def section(kind: EffectKind) -> str:
    """Return the section of one effect."""
    declared = ", ".join(f"{key}={value:g}" for key, value in numbers(kind.name).items())
    parts = [
        f"({kind.name})=",
        f"## {kind.name}",
        f"{_sentence(kind.words)} It adds: {_code(kind.formula)}.{_rigs(kind)}",
        _table(kind.parameters, si=page_of(kind) == "driven_slider"),
        f"![Motion with and without {kind.name}]({kind.name}.svg)",
        f'```python\nss.effect("{kind.name}", {declared})\n```',
    ]
    return "\n\n".join(one for one in parts if one)


def _sentence(words: str) -> str:
    return escaped(words[:1].upper() + words[1:]) + "."


def _code(formula: str) -> str:
    return f"`{formula}`"


def _rigs(kind: EffectKind) -> str:
    both = kind.name in DRIVEN and kind.name in {**CATALOGUE, **CONSTANTS}
    told = " A driven slider may have it too." if both else ""
    if kind.two_degree:
        told += " It needs the rig of (2.1)."
    if kind.hidden:
        names = " and ".join(f"`{one}`" for one in kind.hidden)
        told += f" It has the hidden state{'s' if len(kind.hidden) > 1 else ''} {names}."
    return told


def _table(parameters: tuple[ParameterInfo, ...], *, si: bool) -> str:
    head = "unit" if si else "unit of a rig in SI"
    rows = [f"| number | what | {head} | may be |", "|---|---|---|---|"]
    for one in parameters:
        unit = "" if one.dimension == NUMBER else one.dimension.unit
        rows.append(f"| `{one.name}` | {escaped(one.meaning)} | {unit} | {_bounds(one)} |")
    return "\n".join(rows)


def _bounds(one: ParameterInfo) -> str:
    low, high = one.bounds
    words = []
    if low == 0 and high == math.inf:
        words.append("above 0" if one.open_below else "0 or more")
    elif math.isfinite(low) or math.isfinite(high):
        words.append(f"{low:g} to {high:g}" if math.isfinite(high) else f"above {low:g}")
    if one.per_run:
        words.append("differs from run to run")
    if one.optional:
        words.append("0 if left out")
    return ", ".join(words) or "any number"
