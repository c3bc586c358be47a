"""The derivative of a formula, again a formula."""

from __future__ import annotations

from stickslip.declared.formula.tree import Apply, Name, Number, Tree, names


def derivative(tree: Tree, by: str) -> Tree:
    """Return d tree / d by; of abs, sign, min and max that of the side they are on."""
    if isinstance(tree, Name):
        return Number(1.0 if tree.name == by else 0.0)
    if isinstance(tree, Number) or by not in names(tree):
        return Number(0.0)
    a = tree.operands[0]
    da = derivative(a, by)
    if len(tree.operands) == 2:
        b = tree.operands[1]
        return _of_two(tree, a, b, da, derivative(b, by), by)
    match tree.operation:
        case "negate":
            return Apply("negate", (da,))
        case "abs":
            outer: Tree = Apply("sign", (a,))
        case "sign":
            return Number(0.0)
        case "exp":
            outer = tree
        case "log":
            outer = _divided(Number(1.0), a)
        case "sqrt":
            outer = _divided(Number(0.5), tree)
        case "sin":
            outer = Apply("cos", (a,))
        case "cos":
            outer = Apply("negate", (Apply("sin", (a,)),))
        case "tan":
            outer = _sum(Number(1.0), _times(tree, tree))
        case "tanh":
            outer = Apply("subtract", (Number(1.0), _times(tree, tree)))
        case _:  # asinh
            outer = _divided(Number(1.0), Apply("sqrt", (_sum(Number(1.0), _times(a, a)),)))
    return _times(outer, da)


def _of_two(tree: Apply, a: Tree, b: Tree, da: Tree, db: Tree, by: str) -> Tree:
    match tree.operation:
        case "add" | "subtract":
            return Apply(tree.operation, (da, db))
        case "multiply":
            return _sum(_times(da, b), _times(a, db))
        case "divide":
            return Apply("subtract", (_divided(da, b), _divided(_times(tree, db), b)))
        case "power":
            lower = Apply("power", (a, Apply("subtract", (b, Number(1.0)))))
            first = _times(_times(b, lower), da)
            if by not in names(b):
                return first
            return _sum(first, _times(_times(tree, Apply("log", (a,))), db))
    # min and max: the mean of the two, and half their difference with a sign
    sign: Tree = Apply("sign", (Apply("subtract", (a, b)),))
    if tree.operation == "min":
        sign = Apply("negate", (sign,))
    half = Number(0.5)
    return _sum(_times(half, _sum(da, db)), _times(_times(half, sign), Apply("subtract", (da, db))))


def _times(a: Tree, b: Tree) -> Tree:
    return Apply("multiply", (a, b))


def _divided(a: Tree, b: Tree) -> Tree:
    return Apply("divide", (a, b))


def _sum(a: Tree, b: Tree) -> Tree:
    return Apply("add", (a, b))
