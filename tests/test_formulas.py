"""Formulas: read without being run, evaluated, differentiated, measured in units, defined where they are asked."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.dimension import dimensions, measures, said, to_si
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import Apply, names, switches, written
from stickslip.declared.formula.value import side_of, surface, value
from stickslip.errors import InputError

PYTHON = {
    "abs": abs, "min": min, "max": max, "exp": math.exp, "log": math.log, "sqrt": math.sqrt, "sin": math.sin,
    "cos": math.cos, "tan": math.tan, "tanh": math.tanh, "asinh": math.asinh, "pow": math.pow, "pi": math.pi,
    "sign": lambda x: math.copysign(1.0, x),
}  # fmt: skip
TEXTS = [
    "a + b*c - a/b",
    "-a**2 + (-a)**2",
    "2**-b",
    "exp(-(a/b)**c)*sin(pi*a)",
    "max(a, b, c) + min(a, b - c)",
    "abs(a - b)*sign(c - a) + sqrt(b)*tanh(a)",
    "asinh(a)/cos(b/9) + tan(a/7) + log(1 + c)",
    "pow(b, c) - +a",
    "1e-3*a + .5",
]


@pytest.mark.parametrize("text", TEXTS)
@given(a=st.floats(0.1, 3), b=st.floats(0.1, 3), c=st.floats(0.1, 3))
def test_a_formula_is_worth_what_python_says(text: str, a: float, b: float, c: float) -> None:
    of = {"a": a, "b": b, "c": c}
    tree = parse(text, of)
    assume(all(abs(surface(one, of)) > 1e-6 for one in switches(tree)))  # on one side of every kink
    assert value(tree, of) == pytest.approx(eval(text, {"__builtins__": {}}, {**PYTHON, **of}), rel=1e-13)
    again = parse(written(tree), of)
    assert value(again, of) == value(tree, of)


@pytest.mark.parametrize("text", TEXTS)
@given(a=st.floats(0.1, 3), b=st.floats(0.1, 3), c=st.floats(0.1, 3))
def test_its_derivative_is_that_of_a_complex_step(text: str, a: float, b: float, c: float) -> None:
    of = {"a": a, "b": b, "c": c}
    tree = parse(text, of)
    assume(all(abs(surface(one, of)) > 1e-6 for one in switches(tree)))
    for name in of:
        step = value(tree, {**of, name: complex(of[name], 1e-30)})
        assert value(derivative(tree, name), of) == pytest.approx(np.imag(step) / 1e-30, rel=1e-9, abs=1e-9)


def test_a_side_can_be_frozen_beyond_its_surface() -> None:
    tree = parse("max(a, 1) + abs(b)")
    found = {one: side_of(one, {"a": 2.0, "b": -1.0}) for one in switches(tree)}
    assert [found[one] for one in switches(tree)] == [1, -1]
    assert value(tree, {"a": 0.5, "b": 3.0}, found) == 0.5 - 3.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("__import__('os')", "unknown function '__import__'"),
        ("a.__class__", "Attribute has no place"),
        ("(lambda: a)()", "only functions by their name"),
        ("a if b else c", "IfExp has no place"),
        ("a < b", "use min, max or sign"),
        ("[a]", "List has no place"),
        ("'a'", "is not a real number"),
        ("1j", "is not a real number"),
        ("True", "is not a real number"),
        ("a^2", r"a power is written \*\*"),
        ("a +", "not a formula"),
        ("(a", "never closed"),
        ("a + q", "column 5: unknown name 'q'"),
        ("a(b)", r"a product is written with \*"),
        ("max(a)", "takes two or more arguments, not 1"),
        ("exp(a, b)", "exp takes 1 argument, not 2"),
        ("exp", "'exp' is a function"),
        ("", "empty"),
        ("1e999", "not finite"),
        ("(" * 300 + "a" + ")" * 300, "not a formula|too deep"),
        ("a+" * 1200 + "a", "characters"),
        ("a+" * 150 + "a", "operations within each other; 100 are the most"),
        ("-" * 900 + "a", "operations within each other|too deep"),
        ("a**" * 600 + "a", "operations within each other|too deep"),
    ],
)
def test_what_is_no_formula_is_refused_in_a_line(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        parse(text, ["a", "b", "c"])
    assert "\n" not in str(caught.value)


def test_an_angle_is_no_pure_number() -> None:
    assert said(dimensions("N m")) == "a torque (N m)"
    assert said(dimensions("N m/rad")) == "a stiffness of a rotation (N m/rad)"
    assert dimensions("rad") != dimensions("")
    size, unit = to_si(30.0, "rpm")
    assert (unit, size) == ("rad/s", pytest.approx(np.pi))
    assert to_si(12.0, "N m/deg")[0] == pytest.approx(12 * 180 / np.pi)
    assert to_si(2.0, "mm/s") == (0.002, "m/s")


def test_units_go_through_a_formula() -> None:
    of = {"F": dimensions("N"), "v": dimensions("m/s"), "c": dimensions("N s/m"), "d": dimensions("")}
    assert measures(parse("F + c*v*max(0, d) - F*exp(-d**2)"), of, {}) == dimensions("N")
    assert measures(parse("sqrt(F*F)"), of, {}) == dimensions("N")
    assert measures(parse("v**k"), {**of, "k": dimensions("")}, {"k": 2.0}) == dimensions("m^2/s^2")
    for text, words in [
        ("F + v", r"'v', a speed \(m/s\), is added to 'F', a force \(N\)"),
        ("exp(v)", "exp of a speed"),
        ("max(F, 1)", "is compared with"),
        ("d**v", "the exponent 'v' is a speed"),
        ("v**d", "an exponent that is not constant"),
    ]:
        with pytest.raises(InputError, match=words):
            measures(parse(text), of, {})


STRIBECK = {
    "kinetic": "F_c + (F_s - F_c)*exp(-(u/v_s)**delta) + c*u",
    "static": "F_s*(1 + b*log(1 + dwell/tau))",
    "F_c": "4 N",
    "F_s": "6 N",
    "v_s": "2 mm/s",
    "delta": 1.3,
    "c": "0.1 N s/m",
    "b": 0.02,
    "tau": "1 s",
}
BRISTLE = {
    "force": "s0*z + s1*z_rate + s2*v",
    "define": {"g": "Fc + (Fs - Fc)*exp(-(u/vs)**2)"},
    "states": {"z": {"rate": "v - s0*u*z/g", "unit": "m"}},
    "s0": "1e5 N/m",
    "s1": "300 N s/m",
    "s2": "0.4 N s/m",
    "Fc": "1 N",
    "Fs": "1.5 N",
    "vs": "1 mm/s",
}


@pytest.mark.parametrize("table", [STRIBECK, BRISTLE], ids=["rigid", "compliant"])
def test_a_law_of_ones_own_comes_back_from_its_table_and_from_a_pickle(table: dict[str, object]) -> None:
    law = ss.FormulaFriction(**table)  # type: ignore[arg-type]
    assert ss.FormulaFriction(**law.table()) == law  # type: ignore[arg-type]
    assert pickle.loads(pickle.dumps(law)) == law
    assert repr(law).startswith("FormulaFriction(")  # a line of it: the whole is in table()
    assert law.with_numbers({next(iter(law.numbers)): 7.0}) != law


def test_laws_written_as_formulas_have_the_force_of_the_built_in_ones() -> None:
    v = np.array([-0.3, -1e-3, 2e-4, 0.05])
    own = ss.FormulaFriction(**STRIBECK)  # type: ignore[arg-type]
    law = ss.StribeckFriction(F_c=4, F_s=6, v_s=2e-3, delta=1.3, c=0.1)
    np.testing.assert_allclose(own.force(v), law.force(v), rtol=1e-15)
    bristle = ss.FormulaFriction(**BRISTLE)  # type: ignore[arg-type]
    lugre = ss.LuGreFriction(sigma0=1e5, sigma1=300, sigma2=0.4, F_c=1, F_s=1.5, v_s=1e-3)
    np.testing.assert_allclose(bristle.force(v), lugre.force(v), rtol=1e-12)


def test_the_built_in_laws_slide_steadily_as_published() -> None:
    v = np.array([-0.2, -1e-3, 5e-4, 0.01, 0.3])
    u, sign = np.abs(v), np.sign(v)
    lugre = ss.LuGreFriction(sigma0=1e5, sigma1=300, sigma2=0.4, F_c=1, F_s=1.5, v_s=1e-3)
    expected = sign * (1 + 0.5 * np.exp(-((u / 1e-3) ** 2)) + 0.4 * u)
    np.testing.assert_allclose(lugre.force(v), expected, rtol=1e-12)
    np.testing.assert_allclose(ss.DahlFriction(sigma0=1e5, F_c=2).force(v), 2 * sign, rtol=1e-12)
    for state_law in ("aging", "slip"):
        law = ss.RateAndStateFriction(
            mu0=0.6, a=0.008, b=0.012, D_c=1e-5, V_0=1e-6, normal=100, state_law=state_law
        )  # type: ignore[arg-type]
        expected = sign * 100 * (0.6 + (0.008 - 0.012) * np.log(u / 1e-6))
        np.testing.assert_allclose(law.force(v), expected, rtol=1e-12)
    stribeck = ss.StribeckFriction(F_c=4, F_s=6, v_s=2e-3, delta=2, c=0.1, F_s_plus=7)
    assert stribeck.static_limits == (6, 7)
    minus, plus = (4 + rise * np.exp(-((u / 2e-3) ** 2)) + 0.1 * u for rise in (2, 3))
    np.testing.assert_allclose(stribeck.force(v), sign * np.where(v > 0, plus, minus), rtol=1e-15)


def test_a_tabulated_law_goes_through_its_points_and_has_no_hump_between() -> None:
    speeds, forces = [0.0, 0.01, 0.02, 0.1, 0.5], [3.0, 2.0, 2.0, 2.5, 2.5]
    law = ss.TabulatedFriction(speeds=speeds, forces=forces, static=3.2)
    np.testing.assert_allclose(law.magnitude(np.array(speeds[1:])), forces[1:], rtol=1e-15)
    assert law.static_limits == (3.2, 3.2)
    fine = law.magnitude(np.linspace(1e-6, 1, 1001))
    assert 2.0 - 1e-12 <= fine.min() <= fine.max() <= 3.0
    assert fine[-1] == 2.5


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"kinetic": "F/u", "F": 1}, "divides by 'u', which is 0 at u = 0"),
        ({"kinetic": "F/(1 - u)", "F": 1}, r"divides by '\(1.0 - u\)', which is 0 at u = 1"),
        ({"kinetic": "F*log(u)", "F": 1}, "takes the logarithm of 'u'"),
        ({"kinetic": "F*sqrt(1 - u)", "F": 1}, "takes the root of"),
        ({"kinetic": "F", "static": "S", "F": 2, "S": 1}, "above static"),
        ({"kinetic": "-F", "F": 2}, "negative at rest"),
        ({"kinetic": "F*v", "F": 2}, "unknown name 'v'"),
        ({"kinetic": "F", "F": 2, "G": 1}, "G: no formula of the law reads it"),
        ({"kinetic": "F + w*0", "F": 2, "define": {"w": "v"}}, "uses 'v' through a definition"),
        ({"kinetic": "F", "u": 2, "F": 1}, "u: is a variable"),
        ({"kinetic": "F", "force": "F", "F": 1}, "'kinetic' .* or 'force'"),
        ({"static": "F", "F": 1}, "'kinetic' .* or 'force'"),
        ({"force": "F*v", "static": "F", "F": 1}, "no place beside 'force'"),
        ({"force": "z", "states": {"z": {"rat": "v"}}}, "did you mean 'rate'"),
        ({"force": "z", "states": {"z": {"start": "0"}}}, "lacks its rate"),
        ({"kinetic": "F", "F": "4 Nn"}, "unknown unit"),
        ({"kinetic": "F", "F": "four"}, "not a number with a unit"),
        ({"kinetic": 3}, "a formula is text"),
    ],
)
def test_a_law_that_cannot_be_meant_is_refused_in_a_line(table: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        ss.FormulaFriction(**table)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_definitions_that_double_are_refused_before_they_fill_the_memory() -> None:
    define = {"g0": "a*u"} | {f"g{i + 1}": f"g{i}*g{i}" for i in range(40)}
    with pytest.raises(InputError, match=r"define\.g\d+: has \d+ operations, its definitions put in"):
        ss.FormulaFriction(kinetic="g40", a=1, define=define)


def test_prescribed_speeds_are_numbers_formulas_steps_or_measured() -> None:
    assert ss.Speed.of(0.3).constant == 0.3
    t = np.array([0.0, 0.5, 2.0, 7.0])
    np.testing.assert_allclose(ss.Speed.of("0.5*sin(1.7*t)")(t), 0.5 * np.sin(1.7 * t), rtol=1e-15)
    np.testing.assert_allclose(ss.Speed.steps([0, 2], [0.1, "0.2*t"])(t), [0.1, 0.1, 0.4, 1.4])
    measured = ss.Speed.measured([0.25, 1.0, 4.0], [1.0, 2.0, -1.0])
    np.testing.assert_allclose(measured(t), np.interp(t, [0.25, 1.0, 4.0], [1.0, 2.0, -1.0]), rtol=1e-15)
    assert measured.at(2.0, measured.piece(2.0))[1] == -1.0
    np.testing.assert_allclose(ss.Speed.of("t**2").scaled(2.0, 10.0)(t), 10 * (2 * t) ** 2)
    for wrong in ("0.5*sin(x)", "1/t", "0.1 m/s", [1, 2], float("nan")):
        with pytest.raises(InputError):
            ss.Speed.of(wrong)
    with pytest.raises(InputError, match="must increase"):
        ss.Speed.steps([0, 0], [1, 2])


def test_a_tree_knows_its_names() -> None:
    tree = parse("a*exp(b) + a")
    assert names(tree) == {"a", "b"}
    assert isinstance(tree, Apply)
