"""From the text of a formula to its tree, by Python's own parser of expressions; nothing is executed."""

from __future__ import annotations

import ast
import math
import warnings
from collections.abc import Collection
from functools import reduce

from stickslip.declared.formula.tree import Apply, Name, Number, Operation, Tree, names
from stickslip.errors import InputError, did_you_mean

FUNCTIONS: dict[str, tuple[Operation, int]] = {  # operation and how many arguments; min and max take two or more
    "abs": ("abs", 1), "min": ("min", 2), "max": ("max", 2), "sign": ("sign", 1), "exp": ("exp", 1),
    "log": ("log", 1), "sqrt": ("sqrt", 1), "sin": ("sin", 1), "cos": ("cos", 1), "tan": ("tan", 1),
    "tanh": ("tanh", 1), "asinh": ("asinh", 1), "pow": ("power", 2),
}  # fmt: skip
CONSTANTS = {"pi": math.pi}
LONGEST, DEEPEST, LARGEST = 2000, 100, 5000  # characters; operations within each other, and in all
_BINARY: dict[type[ast.operator], Operation] = {
    ast.Add: "add",
    ast.Sub: "subtract",
    ast.Mult: "multiply",
    ast.Div: "divide",
    ast.Pow: "power",
}


def parse(text: object, known: Collection[str] | None = None) -> Tree:
    """Return the tree of a formula.

    Parameters
    ----------
    text
        As in "F_c + (F_s - F_c)*exp(-(u/v_s)**2)".
    known
        Names it may use; None: any.

    Raises
    ------
    InputError
        It is no formula, or uses a name or a function that is not known; with the column.
    """
    if not isinstance(text, str):
        raise InputError("not a formula; write it as text like '0.5*sin(1.7*t)'", value=text)
    if not text.strip():
        raise InputError("empty; write a formula like '0.5*sin(1.7*t)'")
    if len(text) > LONGEST:
        raise InputError(f"has {len(text)} characters; {LONGEST} is the most")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)  # of "2(x)": it is refused below
            parsed = ast.parse(text.strip(), mode="eval")
        tree = fit(_Reader(text, known).tree(parsed.body))
    except SyntaxError as error:
        words = f"not a formula (line {error.lineno or 1}, column {error.offset or 1}: {error.msg})"
        if "^" in text:
            words += "; a power is written **"
        raise InputError(words, value=text) from None
    except (RecursionError, MemoryError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("too deep or not text that can be read", value=text) from None
    return tree


def fit(tree: Tree) -> Tree:
    """Return a tree, or refuse one that is too deep or too large to be gone through.

    Raises
    ------
    InputError
        Operations are nested deeper than 100, or more than 5000 with all definitions put in.
    """
    depth: dict[int, int] = {}
    size: dict[int, int] = {}
    todo: list[tuple[Tree, bool]] = [(tree, False)]
    while todo:
        one, seen = todo.pop()
        if id(one) in depth:
            continue
        below = one.operands if isinstance(one, Apply) else ()
        if not seen:
            todo += [(one, True), *((each, False) for each in below)]
            continue
        depth[id(one)] = 1 + max((depth[id(each)] for each in below), default=0)
        size[id(one)] = 1 + sum(size[id(each)] for each in below)
    if depth[id(tree)] > DEEPEST:
        raise InputError(f"has {depth[id(tree)]} operations within each other; {DEEPEST} are the most")
    if size[id(tree)] > LARGEST:
        raise InputError(f"has {size[id(tree)]} operations, its definitions put in; {LARGEST} are the most")
    return tree


class _Reader:
    def __init__(self, text: str, known: Collection[str] | None) -> None:
        self.text, self.known = text, known

    def wrong(self, node: ast.expr, words: str) -> InputError:
        """Return the error of a node, with its line and column."""
        line = f"line {node.lineno}, " if node.lineno > 1 else ""
        return InputError(f"{line}column {node.col_offset + 1}: {words}", value=self.text)

    def tree(self, node: ast.expr) -> Tree:
        """Return the tree of a node of Python's."""
        match node:
            case ast.Constant(value=value):
                return self._number(node, value)
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.BinOp(left=left, op=ast.BitXor()) if left is not None:
                raise self.wrong(node, "a power is written **, not ^")
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                return Apply(_BINARY[type(op)], (self.tree(left), self.tree(right)))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self.tree(operand)
                return Number(-inner.value) if isinstance(inner, Number) else Apply("negate", (inner,))
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.tree(operand)
            case ast.Call():
                return self._call(node)
        what = "; for a choice between two, use min, max or sign" if isinstance(node, ast.Compare) else ""
        words = (
            f"{type(node).__name__} has no place in a formula; it is made of numbers, names, + - * / **, ( )"
        )
        raise self.wrong(node, f"{words} and {', '.join(FUNCTIONS)}{what}")

    def _number(self, node: ast.expr, value: object) -> Tree:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.wrong(node, f"{value!r} is not a real number")
        try:
            size = float(value)
        except OverflowError:
            size = math.inf
        if not math.isfinite(size):
            raise self.wrong(node, "a number that is not finite")
        return Number(size)

    def _name(self, node: ast.expr, name: str) -> Tree:
        if name in CONSTANTS:
            return Number(CONSTANTS[name])
        if name in FUNCTIONS:
            raise self.wrong(node, f"'{name}' is a function; write {name}(...)")
        if self.known is not None and name not in self.known:
            raise self.wrong(node, f"unknown name '{name}'; {did_you_mean(name, self.known)}")
        return Name(name)

    def _call(self, node: ast.Call) -> Tree:
        if not isinstance(node.func, ast.Name) or node.keywords:
            raise self.wrong(node, "only functions by their name, without keywords, can be called")
        name = node.func.id
        if name not in FUNCTIONS:
            hint = did_you_mean(name, FUNCTIONS)
            if self.known is not None and name in self.known:
                hint = "a product is written with *"
            raise self.wrong(node, f"unknown function '{name}'; {hint}")
        operation, count = FUNCTIONS[name]
        given = [self.tree(one) for one in node.args]
        if len(given) < count or (len(given) > count and name not in ("min", "max")):
            some = "two or more" if name in ("min", "max") else str(count)
            plural = "" if some == "1" else "s"
            raise self.wrong(node, f"{name} takes {some} argument{plural}, not {len(given)}")
        if count == 1:
            return Apply(operation, (given[0],))
        return reduce(lambda a, b: Apply(operation, (a, b)), given)


def constant(text: str) -> float | None:
    """Return the number that a formula without names is, or None."""
    from stickslip.declared.formula.value import value

    tree = parse(text)
    return None if names(tree) else float(value(tree, {}))
