"""The formulas of laws as TeX: they are written in Python's syntax, and read by Python's own parser."""

from __future__ import annotations

import ast
import re

GREEK = ("alpha", "beta", "delta", "eta", "mu", "sigma", "tau", "theta", "omega", "phi", "pi")
BINDS = {ast.Add: 1, ast.Sub: 1, ast.Mult: 2, ast.Div: 4, ast.Pow: 4}
WORDS = {"log": r"\ln", "sin": r"\sin", "cos": r"\cos", "tanh": r"\tanh", "asinh": r"\operatorname{arsinh}"}
WORDS |= {"min": r"\min", "max": r"\max", "sign": r"\operatorname{sgn}"}


def name(text: str) -> str:
    """Return a name as TeX: `F_c`, `sigma0`, `T_s_minus`, `z_rate`."""
    if text.endswith("_rate"):
        return rf"\dot{{{name(text.removesuffix('_rate'))}}}"
    head, *below = re.split(r"_|(?<=[A-Za-z])(?=\d)", text)
    shown = f"\\{head}" if head in GREEK else head if len(head) == 1 else rf"\mathrm{{{head}}}"
    marks = [one if one.isdigit() or len(one) == 1 else rf"\mathrm{{{one}}}" for one in below]
    return f"{shown}_{{{','.join(marks)}}}" if marks else shown


def tex(formula: str) -> str:
    """Return a formula as TeX.

    Raises
    ------
    ValueError
        It has a part that no law has.
    """
    return _of(ast.parse(formula, mode="eval").body)[0]


def _of(node: ast.expr) -> tuple[str, int]:
    """TeX, and how tightly it binds: 1 a sum, 2 a product, 3 a sign, 4 a unit."""
    if isinstance(node, ast.Name):
        return name(node.id), 4
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return f"{node.value:g}", 4
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return "-" + _bound(node.operand, 2), 1
    if isinstance(node, ast.BinOp):
        return _pair(node)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        return _call(node.func.id, node.args)
    raise ValueError(f"no TeX for {ast.unparse(node)}")


def _pair(node: ast.BinOp) -> tuple[str, int]:
    if isinstance(node.op, ast.Div):
        return rf"\frac{{{_of(node.left)[0]}}}{{{_of(node.right)[0]}}}", 4
    if isinstance(node.op, ast.Pow):
        return rf"{_bound(node.left, 4, fractions=False)}^{{{_of(node.right)[0]}}}", 4
    if isinstance(node.op, ast.Mult):
        return rf"{_bound(node.left, 2)}\,{_bound(node.right, 2)}", 2
    sign = "+" if isinstance(node.op, ast.Add) else "-"
    return f"{_of(node.left)[0]} {sign} {_bound(node.right, 1 if sign == '+' else 2)}", 1


def _call(function: str, arguments: list[ast.expr]) -> tuple[str, int]:
    inside = ", ".join(_of(one)[0] for one in arguments)
    if function == "exp":
        return (rf"\exp\left({inside}\right)" if r"\frac" in inside else rf"e^{{{inside}}}"), 4
    if function == "abs":
        return f"|{inside}|", 4
    if function == "sqrt":
        return rf"\sqrt{{{inside}}}", 4
    return rf"{WORDS[function]}\left({inside}\right)", 4


def _bound(node: ast.expr, least: int, *, fractions: bool = True) -> str:
    shown, binds = _of(node)
    bare = binds >= least and (fractions or not isinstance(node, ast.BinOp))
    return shown if bare else rf"\left({shown}\right)"
