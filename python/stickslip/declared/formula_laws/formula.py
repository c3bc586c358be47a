"""A law of one's own, written as formulas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from stickslip.arguments import must_be
from stickslip.declared.dimensions import Dimension
from stickslip.declared.formula.parse import CONSTANTS, FUNCTIONS, fit, parse
from stickslip.declared.formula.range import check_range
from stickslip.declared.formula.tree import Number, Tree, names, substituted
from stickslip.declared.formula.value import value
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.law_form import READS, VARIABLES, BranchForm, LawForm, StateForm
from stickslip.declared.quantity import quantity
from stickslip.errors import InputError, did_you_mean
from stickslip.objects import Displayed, as_call, one_line

FORMULAS = ("kinetic", "static", "force", "kinetic_plus", "static_plus", "force_plus")


@dataclass(frozen=True)
class LawState(Displayed):
    """A state of a law of one's own.

    Parameters
    ----------
    rate
        Its time derivative, a formula of u, v, t, states and numbers.
    start
        What it begins with where a run does not say: a formula of u and v at the start.
    unit
        What it is measured in, "m" or "s"; "1" is a pure number.

    Examples
    --------
    >>> import stickslip as ss
    >>> bristle = ss.LawState(rate="v - s0*u*z/F", unit="m")
    >>> law = ss.FormulaFriction(force="s0*z", states={"z": bristle}, s0="1e4 N/m", F="5 N")
    >>> [*law.states]
    [('z', LawState(rate='v - s0*u*z/F', unit='m'))]
    """

    __repr__ = as_call

    rate: str
    start: str = "0"
    unit: str = "1"


@dataclass(frozen=True, init=False)
class FormulaFriction(LawByFormula):
    """A law of one's own: T = sgn(v) kinetic and stick up to static, or T = force without stick.

    Formulas are made of numbers, names, + - * / ** and abs, min, max, sign, exp, log, sqrt, sin, cos, tan, tanh,
    asinh, pow. They read u = abs(v), the time t, and the law's numbers and states; `static` reads the time at rest,
    dwell, instead of u; `force` reads v, and `<state>_rate` of a state.

    Parameters
    ----------
    kinetic, static
        Magnitude in sliding and at rest; static is kinetic at u = 0 where it is absent.
    force
        Instead of the two: the force at every v, for a contact that never sticks.
    kinetic_plus, static_plus, force_plus
        For v > 0, where it differs.
    define
        Formulas by name that the others may use.
    states
        `LawState`, or a table of its parts, by name.
    **numbers
        The law's numbers, bare or with a unit ("4 N").

    Raises
    ------
    InputError
        A formula that cannot be read, a name that is unknown or taken, a number that no formula reads, a division by
        zero at some speed, friction that is negative at rest or lower there than in sliding.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.FormulaFriction(
    ...     kinetic="F_k + c*u", static="F_k + F_b*log(1 + dwell/tau)",
    ...     F_k="1.2 N", c="2 N s/m", F_b="0.2 N", tau="10 ms",
    ... )
    >>> print(law.magnitude([0.0, 0.1]).round(4))
    [1.2 1.4]
    """

    kind: ClassVar[str] = "formula"
    rank: ClassVar[int] = 90
    dimensions: ClassVar[Mapping[str, Dimension]] = {}

    formulas: tuple[tuple[str, str], ...]
    define: tuple[tuple[str, str], ...]
    states: tuple[tuple[str, LawState], ...]
    given: tuple[tuple[str, float, str | None], ...]

    def __init__(
        self,
        *,
        kinetic: str | None = None,
        static: str | None = None,
        force: str | None = None,
        kinetic_plus: str | None = None,
        static_plus: str | None = None,
        force_plus: str | None = None,
        define: Mapping[str, str] | None = None,
        states: Mapping[str, LawState | Mapping[str, str]] | None = None,
        **numbers: float | str,
    ) -> None:
        texts = (kinetic, static, force, kinetic_plus, static_plus, force_plus)
        formulas = tuple((key, str(one)) for key, one in zip(FORMULAS, texts, strict=True) if one is not None)
        read = tuple((name, *quantity(name, one)) for name, one in numbers.items())
        for key, one in zip(FORMULAS, texts, strict=True):
            must_be(key, "" if one is None else one, str, "a formula is text like 'F_c + c*u'")
        object.__setattr__(self, "formulas", formulas)
        object.__setattr__(self, "define", tuple(must_be("define", define or {}, Mapping).items()))
        kept = {name: _state(name, one) for name, one in must_be("states", states or {}, Mapping).items()}
        object.__setattr__(self, "states", tuple(kept.items()))
        object.__setattr__(self, "given", read)
        object.__setattr__(self, "_units", {name: unit for name, _, unit in read if unit is not None})
        self._checked()

    @property
    def numbers(self) -> dict[str, float]:
        """The law's numbers by name."""
        return {name: size for name, size, _ in self.given}

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        """Return the law with some numbers changed, in SI."""
        own = {name: (size, unit) for name, size, unit in self.given}
        for name, size in values.items():
            own[name] = (quantity(name, size)[0], own[name][1])
        changed: dict[str, Any] = {name: _with_unit(*one) for name, one in own.items()}
        return type(self)(**self._words(), **changed)

    def table(self) -> dict[str, object]:
        """Return the keywords that make this law, and a file's table [law]."""
        words = {name: one for name, one in self._words().items() if one}
        if self.states:
            words["states"] = {
                name: {"rate": one.rate, "start": one.start, "unit": one.unit} for name, one in self.states
            }
        return {**words, **{name: _with_unit(size, unit) for name, size, unit in self.given}}

    def _words(self) -> dict[str, Any]:
        return {**dict(self.formulas), "define": dict(self.define), "states": dict(self.states)}

    def __repr__(self) -> str:
        given = [f"{name}={one!r}" for name, one in self.table().items()]
        return one_line(f"FormulaFriction({', '.join(given)})")

    # -- reading -----------------------------------------------------------------------------------------------

    def _checked(self) -> None:
        texts = dict(self.formulas)
        if ("kinetic" in texts) == ("force" in texts):
            words = "give 'kinetic' (and 'static') of a contact that sticks, or 'force' of one that does not"
            raise InputError(words, key="kinetic" if "kinetic" in texts else None)
        stray = {"static", "kinetic_plus", "static_plus"} if "force" in texts else {"force_plus"}
        for key in stray & texts.keys():
            raise InputError("has no place beside 'force'" if "force" in texts else "needs 'force'", key=key)
        self._check_names()
        form = self.form()
        used = set().union(*(names(one) for one in (*form.minus.trees(), *form.plus.trees())))
        used |= set().union(*(names(one.start) for one in form.states)) if form.states else set()
        for name, _, _ in self.given:
            if name not in used:
                hint = did_you_mean(name, [*FORMULAS, "define", "states"])
                raise InputError(f"no formula of the law reads it; {hint}", key=name)
        self._check_ranges(form)

    def _check_names(self) -> None:
        taken = {*VARIABLES, *FUNCTIONS, *CONSTANTS}
        groups = ((name for name, *_ in self.given), dict(self.define), dict(self.states))
        for name in (one for group in groups for one in group):
            if not name.isidentifier():
                raise InputError("is no name; letters, digits and _ make one", key=str(name))
            if name in taken or name.endswith("_rate"):
                words = "is taken" if name not in VARIABLES else "is a variable of every formula"
                raise InputError(f"{words}; name it otherwise", key=name)
            taken.add(name)

    def _make_form(self) -> LawForm:
        texts, numbers = dict(self.formulas), self.numbers
        own = [*numbers, *dict(self.states)]
        defined: dict[str, Tree] = {}
        for name, text in self.define:
            # a definition may read what stands before it
            tree = _read(f"define.{name}", text, [*own, *VARIABLES, *defined])
            defined[name] = _fit(f"define.{name}", substituted(tree, defined))

        def read(key: str, text: str, reads: str) -> Tree:
            known = [*own, *READS[reads], *defined]
            rates = {f"{name}_rate": tree for name, tree in by_rate.items()} if reads == "force" else {}
            tree = _fit(key, substituted(_read(key, text, [*known, *rates]), {**defined, **rates}))
            if wrong := names(tree) & (set(VARIABLES) - set(READS[reads])):
                words = f"uses '{min(wrong)}' through a definition; it may read {', '.join(READS[reads])}"
                raise InputError(words, key=key)
            return tree

        by_rate: dict[str, Tree] = {}
        by_rate = {name: read(f"states.{name}.rate", one.rate, "rate") for name, one in self.states}
        starts = {name: read(f"states.{name}.start", one.start, "start") for name, one in self.states}
        trees = {key: read(key, text, key.removesuffix("_plus")) for key, text in texts.items()}
        branches = []
        for twin in ("", "_plus"):
            kinetic, static, force = (trees.get(f"{key}{twin}", trees.get(key)) for key in FORMULAS[:3])
            if static is None and kinetic is not None:
                static = substituted(kinetic, {"u": Number(0.0)})
            branches.append(BranchForm(kinetic, static, force, tuple(by_rate.values())))
        kept = tuple(StateForm(name, starts[name], one.unit) for name, one in self.states)
        return LawForm(branches[0], branches[1], numbers, kept)

    def _check_ranges(self, form: LawForm) -> None:
        of: dict[str, float] = {**form.numbers, "t": 0.0, "dwell": 0.0, "u": 0.0, "v": 0.0}
        for one in form.states:
            size = float(value(one.start, {**of, "u": 1.0, "v": 1.0}))
            of[one.name] = size if size else 1.0
        for twin, branch in (("", form.minus), ("_plus", form.plus)):
            for key, tree, over in (("kinetic", branch.kinetic, "u"), ("static", branch.static, "dwell")):
                if tree is not None:
                    name = f"{key}{twin}" if f"{key}{twin}" in dict(self.formulas) else key
                    check_range(name, tree, over, of)
                    check_range(name, tree, "t", of)
            if branch.force is not None:
                check_range("force", branch.force, "u", of)
            for state, tree in zip(form.states, branch.rates, strict=True):
                check_range(f"states.{state.name}.rate", tree, "u", of)
            if branch.kinetic is not None and branch.static is not None and not form.states:
                at_rest = float(value(branch.kinetic, of))
                limit = float(value(branch.static, of))
                if min(at_rest, limit) < 0:
                    raise InputError(
                        "is negative at rest; friction must oppose sliding", key=f"kinetic{twin}"
                    )
                if limit < at_rest * (1 - 1e-12):
                    words = f"is {at_rest:.6g} at u = 0, above static = {limit:.6g} at dwell = 0"
                    raise InputError(f"{words}; it must not exceed it", key=f"kinetic{twin}")


def _state(name: str, given: object) -> LawState:
    if isinstance(given, LawState):
        return given
    table = must_be(f"states.{name}", given, Mapping, 'like {rate = "v - z", unit = "m"}')
    for key in table:
        if key not in ("rate", "start", "unit"):
            raise InputError(
                f"unknown; {did_you_mean(str(key), ('rate', 'start', 'unit'))}", key=f"states.{name}.{key}"
            )
    if "rate" not in table:
        raise InputError("lacks its rate", key=f"states.{name}")
    return LawState(**{key: str(one) for key, one in table.items()})


def _read(key: str, text: object, known: list[str]) -> Tree:
    try:
        return parse(text, known)
    except InputError as error:
        raise InputError(error.what, key=key, value=error.value) from None


def _fit(key: str, tree: Tree) -> Tree:
    try:
        return fit(tree)
    except InputError as error:
        raise InputError(error.what, key=key) from None


def _with_unit(size: float, unit: str | None) -> float | str:
    return size if unit is None else f"{size!r} {unit}"


LAW = FormulaFriction
