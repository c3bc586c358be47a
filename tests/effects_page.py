"""The catalogue as a page: `python tests/effects_page.py` writes docs/effects.md, a test holds it to the code."""

from __future__ import annotations

from pathlib import Path

from stickslip.declared.catalogue import CATALOGUE, CONSTANTS, DRIVEN, KINDS
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.laws import FORMULA_LAWS, LAWS

PAGE = Path(__file__).parent.parent / "docs" / "effects.md"

HEAD = """# Effects: what a model may have beyond (2.1) and its friction law

Made from the code by `python tests/effects_page.py`. Declare one with `ss.effect(name, **parameters)`; `stickslip
discover` tries them all. Forces are in the bracket's units of (2.1): block terms are divided by alpha1, angle-body
terms by alpha2. v is v_w, u = |v|, R the kinetic magnitude; parameters are nondimensional, or have a unit
(`tau="20 ms"`), which the scales of a rig in SI turn. A phase `phi` differs from run to run.

| name | where | what it adds | depends on | parameters |
|---|---|---|---|---|
"""

CONSTANTS_HEAD = """
Several effects of the x1 channel act in this order: crosstalk, the lag of what it makes, the curvature of that (with
`sensor_gain` m (1 + e) + q m^2 for q of the true deflection), drift; learned curves, functions of the true state or of
t, are added last. What is read of a simulated run is in `run.readings["x1"]` and `["y1"]`; in the file of `stickslip
simulate` in the columns x1_read and y1_read, beside the true x1 and y1. The lagged deflection is the hidden state m.
`simulate` starts it at 0 unless `initial` names it: let a run begin a few tau before what is looked at, or give
`initial` an m of x1 + c y1 - tau (x2 + c y2).

With `contact_compliance` the bristle's rate is k |v| z/R: where a `normal_force_feedback` beside it takes the load
off the contact, R goes to 0 and the equation is singular. Such runs end with `step_too_small` or `not_finite`; one
that goes past the singular point has no converged end, whatever the tolerance.

## Declared numbers that are wrong

For a block on a belt, whose declared constants are taken at their word unless the runs speak against them:

| name | where | what is true instead | parameters |
|---|---|---|---|
"""

DRIVEN_HEAD = """
## A driven slider

No belt, no spring; SI. F is the drive, T the friction of the law. Beside these: SHARED.

| name | where | what it adds | depends on | parameters |
|---|---|---|---|---|
"""

TAIL = """
What has no name is a `tabulated` term, a smooth curve of one variable on block, angle body or contact:
`ss.tabulated(where, depends_on, knots, values)`, two of a motion at most. In t it may repeat, with a `period`; its
angular frequency `w` and phase `phi` are then parameters like those at the knots (`value_0`, ...), for sweeps,
sensitivities and `Model.replace`.

Numbers may be such that friction turns negative: a `friction_drift` beyond 1 + r t = 0, a `stribeck_peak` or
`static_aging` that takes more than there is, a curve below -1 at the contact. The model is then simulated as declared,
with friction that drives the block, and `simulate` gives a `ModelWarning` that says from where on (the command prints
it). `normal_force_feedback` alone stops at zero: a contact does not pull.

## On rigs of bodies and matrices

An effect of the catalogue acts where `where` puts it ([rigs.md](rigs.md#effects)); numbers in SI, R the law's. `other`
is the coordinate that `by` names, and T_s the law's static limit for v < 0.

| name | put to | what it does there |
|---|---|---|
ANYWHERE

The others act on no such rig:

| name | instead |
|---|---|
NOWHERE

## Friction laws

| law | R(u), u = \\|v_w\\| | at rest |
|---|---|---|
LAWS

`..._plus` parameters are those of slip with v_w > 0; left out, both directions share a number.

These laws are simulated on every rig. On rigs of bodies and of matrices, `identify` fits those that have no state
of their own, and those whose one state carries the load at rest, as a bristle does:

| law | what it says |
|---|---|
FORMULAS
"""


PUT_TO = {"force": "a body or link", "factor": "a contact", "contact": "a contact", "reading": "a channel"}
ADDS = {
    "force": "force {}",
    "factor": "friction times {}",
    "peak": "R and the static limits plus {}",
    "aging": "static limits plus {}",
    "bristle": "T = {}, without stick",
    "reading": "reads {}",
}


def anywhere(kind: EffectKind) -> str:
    """Return one line of the table of effects on any rig."""
    acts = kind.anywhere
    assert acts.place is not None
    place = "belt or drive" if acts.of_belt else PUT_TO[acts.place]
    said = "; ".join(words.format(f"`{text}`") for key, words in ADDS.items() if (text := getattr(acts, key)))
    said = said.replace("friction times", "speed times") if acts.of_belt else said
    if acts.sharp:
        said += f"; with {acts.sharp[0]} = 0 the dry friction {acts.sharp[1]} of a contact of its own, which sticks"
    said += "".join(f", {name}' = `{rate}`" for name, (rate, _) in acts.states.items())
    return f"| `{kind.name}` | {place} | {said} |"


def row(kind: EffectKind) -> str:
    """Return one line of the catalogue's table."""
    formula = kind.formula.replace("|", "\\|")
    return f"| `{kind.name}` | {kind.where} | {formula} | {', '.join(kind.depends_on)} | {numbers(kind)} |"


def numbers(kind: EffectKind) -> str:
    """Return the parameters of an effect with their meanings."""
    return "; ".join(f"`{info.name}` {info.meaning}" for info in kind.parameters)


def said_of(law: type[LawByFormula]) -> str:
    """Return a law's formulas, or the first sentence of its docstring where they are the user's own."""
    parts = {"R(u)": law.kinetic_text, "at rest": law.static_text, "T": law.force_text}
    rates = {f"{name}'": rate for name, (rate, _, _) in law.state_texts.items()}
    told = "; ".join(f"{name} = `{text}`" for name, text in {**parts, **rates}.items() if text)
    return told.replace("|", "\\|") or (law.__doc__ or "").strip().splitlines()[0]


def page() -> str:
    """Return the page as the code says it."""
    rows = [row(kind) for kind in CATALOGUE.values()]
    wrong = [f"| `{k.name}` | {k.where} | {k.formula} | {numbers(k)} |" for k in CONSTANTS.values()]
    others = [
        row(kind) for kind in DRIVEN.values() if kind.name not in CATALOGUE and kind.name not in CONSTANTS
    ]
    shared = ", ".join(f"`{name}`" for name in DRIVEN if name in CATALOGUE or name in CONSTANTS)
    driven = DRIVEN_HEAD.replace("SHARED", shared) + "\n".join(others)
    laws = [f"| `{law.__name__}` | {law.formula} | {law.at_rest} |" for law in LAWS.values()]
    formulas = [f"| `{law.__name__}` | {said_of(law)} |" for law in FORMULA_LAWS.values()]
    every = KINDS.values()
    acting = [anywhere(kind) for kind in every if not kind.anywhere.refused]
    idle = [f"| `{kind.name}` | {kind.anywhere.refused} |" for kind in every if kind.anywhere.refused]
    tables = {"FORMULAS": formulas, "LAWS": laws, "ANYWHERE": acting, "NOWHERE": idle}
    tail = TAIL
    for mark, lines in tables.items():
        tail = tail.replace(mark, "\n".join(lines))
    parts = (HEAD + "\n".join(rows), CONSTANTS_HEAD + "\n".join(wrong), driven, tail)
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page())
