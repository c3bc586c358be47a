"""The pages of friction laws, one a law, from the laws themselves."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.laws import ALL_LAWS, LAWS
from website.docstring import escaped, told
from website.law_figures import EXAMPLES, draw
from website.tex import tex

OPEN = ("formula",)  # whose equation is the reader's own


def write(folder: Path) -> list[str]:
    """Write every law's page and figure into the folder; return the names of the pages, the list first."""
    folder.mkdir(parents=True, exist_ok=True)
    for kind, law in ALL_LAWS.items():
        if kind not in OPEN:
            draw(kind, folder / f"{kind}.svg")
        (folder / f"{kind}.md").write_text(page(law), encoding="utf-8")
    (folder / "index.md").write_text(overview(), encoding="utf-8")
    return ["index", *ALL_LAWS]


def title(law: type[FrictionLaw]) -> str:
    """Return what a law is called on its page."""
    words = {"lugre": "LuGre", "paper": "Table 1 of the paper", "rate_and_state": "Rate and state"}
    return words.get(law.kind, law.kind.capitalize())


def overview() -> str:
    """Return the list of laws."""
    rows = [
        f"| [`{kind}`]({kind}.md) | `{law.__name__}` | {_use(kind)} | {'yes' if _sticks(law) else 'no, it creeps'} |"
        for kind, law in ALL_LAWS.items()
    ]
    toc = "\n".join(ALL_LAWS)
    return (
        "# Friction laws\n\nA law gives the magnitude of sliding friction $R(u)$, $u = |v_w|$, and what a contact at "
        "rest can carry. Each may differ with the direction of sliding. The force on the body is "
        r"$-T$, $T = \operatorname{sgn}(v_w)\,R(u)$; it dissipates, $T\,v_w \ge 0$."
        "\n\nThese pages are made from the code.\n\n| `kind` | class | used for | sticks |\n|---|---|---|---|\n"
        + "\n".join(rows)
        + f"\n\n```{{toctree}}\n:hidden:\n\n{toc}\n```\n"
    )


def _use(kind: str) -> str:
    return (
        "every rig; searched by `discover`"
        if kind in LAWS
        else "rigs of one's own; simulation of the named rigs"
    )


def _sticks(law: type[FrictionLaw]) -> bool:
    return getattr(law, "force_text", None) is None


def page(law: type[FrictionLaw]) -> str:
    """Return the page of one law."""
    said = told(law)
    parts = [f"# {title(law)}", f'`kind = "{law.kind}"`, in Python {{py:class}}`stickslip.{law.__name__}`.']
    parts += [_equations(law)] if law.kind not in OPEN else []
    parts += [escaped(said.summary)] if law.kind in OPEN or law.kind == "tabulated" else []
    parts += [escaped(one) for one in said.more if not _is_equation(one)]
    parts += ["## Parameters", _table(law)]
    if law.kind in EXAMPLES:
        parts += [
            "## Example",
            _example(law.kind),
            f"![Friction over sliding velocity]({law.kind}.svg)",
            _caption(law),
        ]
    return "\n\n".join(parts) + "\n"


def _is_equation(text: str) -> bool:
    return text.startswith(("R_minus(u)", "T = "))


def _caption(law: type[FrictionLaw]) -> str:
    if law.kind == "rate_and_state":
        return (
            "*$T$ over the distance slid while the speed steps from $V_0$ to $10\\,V_0$ and back, simulated with the "
            "numbers of the example: the direct effect $a$, then the evolution effect $b$ over $D_c$.*"
        )
    if _sticks(law):
        return (
            "*$T$ over $v_w$ with the numbers of the example; at $v_w = 0$ what a contact at rest can carry.*"
        )
    return "*$T$ over $v_w$ while the sliding velocity goes to and fro, simulated with the numbers of the example.*"


def _equations(law: type[FrictionLaw]) -> str:
    return "\n\n".join(f"$$\n{left} = {tex(right)}\n$$" for left, right in equations(law))


def equations(law: type[FrictionLaw]) -> list[tuple[str, str]]:
    """Return a law's equations: left sides in TeX, right sides as formulas in Python's syntax."""
    if law.kind in LAWS:
        marks = {
            "R": ("R(u)", r"T_\mathrm{static}"),
            "R_minus": ("R_-(u)", "R_-(0)"),
            "R_plus": ("R_+(u)", "R_+(0)"),
        }
        return [
            pair
            for name, kinetic, static in law.equations
            for pair in ((marks[name][0], kinetic), (_rest(name), static))
        ]
    if not issubclass(law, LawByFormula) or law.kind == "tabulated":
        return []
    found = [("R(u)", law.kinetic_text), (r"T_\mathrm{static}", law.static_text), ("T", law.force_text)]
    states = _states(law)
    return [(left, right) for left, right in found if right] + [
        (rf"\dot{{{tex(name)}}}", rate) for name, rate in states
    ]


def _rest(name: str) -> str:
    return {
        "R": r"T_\mathrm{static}",
        "R_minus": r"T_{\mathrm{static},-}",
        "R_plus": r"T_{\mathrm{static},+}",
    }[name]


def _states(law: type[LawByFormula]) -> list[tuple[str, str]]:
    from stickslip.declared.formula_laws.rate_and_state import RATES

    if law.kind == "rate_and_state":
        return [("theta", rate.replace(" + 1e-300", "")) for rate in RATES.values()]
    return [(name, rate) for name, (rate, _, _) in law.state_texts.items()]


def _table(law: type[FrictionLaw]) -> str:
    lines = ["| number | what | unit | default |", "|---|---|---|---|"]
    default = {one.name: one.default for one in dataclasses.fields(law)}
    for names, words in told(law).parameters:
        shown = ", ".join(f"`{name}`" for name in names)
        twins = names[0].endswith("_plus") and names[0].removesuffix("_plus") in law.each_way
        units = [] if twins else [law.dimensions[name].unit for name in names if name in law.dimensions]
        values = [default.get(name, dataclasses.MISSING) for name in names]
        given = [str(one) for one in values if one is not dataclasses.MISSING and one is not None]
        lines.append(f"| {shown} | {escaped(words)} | {_whole(_once(units))} | {', '.join(given)} |")
    return "\n".join(lines) + "\n\nAt a contact that turns, N is N m and m is rad."


def _once(words: list[str]) -> str:
    return words[0] if len(set(words)) == 1 else ", ".join(words)


def _whole(units: str) -> str:
    """Units that no line breaks within: N s/m."""
    return ", ".join(one.replace(" ", "\N{NO-BREAK SPACE}") for one in units.split(", "))


def _example(kind: str) -> str:
    numbers = EXAMPLES[kind]
    text = "\n".join(f"{key} = {_toml(value)}" for key, value in numbers.items())
    python = ", ".join(f"{key}={value!r}" for key, value in numbers.items())
    name = ALL_LAWS[kind].__name__
    return (
        f'```toml\n[friction]\nkind = "{kind}"\n{text}\n```\n\n'
        f"```python\nimport stickslip as ss\n\nlaw = ss.{name}({python})\n```"
    )


def _toml(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)
