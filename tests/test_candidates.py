"""Rivals of a user's own: [[candidate]] of a case, and `stickslip.candidate`."""

from __future__ import annotations

import json
import re
from importlib import resources
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import stickslip as ss
from stickslip.declared.candidate import on_rig, sizes

SI = """
[rig]
kind = "block_on_belt"
m = "1 kg"
k = "1000 N/m"

[friction]
kind = "coulomb"
static = 5
kinetic = 3

[channels]
t = { column = "t", unit = "s" }
x1 = { column = "x1", unit = "mm" }

[[run]]
file = "a.csv"
role = "train"
belt_speed = 0.005
"""
BARE = SI.replace('"1 kg"', "1").replace('"1000 N/m"', "1").replace('"s"', '"1"').replace('"mm"', '"1"')
DRAG = """
[[candidate]]
name = "drag"
where = "block"
force = "-c*deflection_rate**3"
ranges.c = ["0 N s^3/m^3", "5 N s^3/m^3"]
"""
GOOD = {"where": "block", "force": "-c*deflection_rate**3", "ranges": {"c": [0, 5]}}


def read(folder: Path, text: str) -> ss.Case:
    t = np.linspace(0, 1, 200)
    np.savetxt(
        folder / "a.csv", np.column_stack([t, np.sin(9 * t)]), delimiter=",", header="t,x1", comments=""
    )
    (folder / "rig.toml").write_text(text)
    return ss.load_case(folder)


def test_a_candidate_of_a_file_is_that_of_python(tmp_path: Path) -> None:
    (one,) = read(tmp_path, SI + DRAG).candidates
    same = ss.candidate(
        "drag", where="block", force="-c*deflection_rate**3", ranges={"c": ["0 N s^3/m^3", "5000 mN s^3/m^3"]}
    )
    assert one == same
    assert one.ranges == {"c": (0.0, 5.0)}
    assert one.parameters == {"c": 2.5}
    assert one.depends_on == ("deflection_rate",)


def test_a_number_starts_where_it_is_given_and_others_stay(tmp_path: Path) -> None:
    more = DRAG.replace("**3", "**n") + 'c = "0.5 N s^3/m^3"\nn = 3\n'
    (one,) = read(tmp_path, SI + more).candidates
    assert one.parameters == {"c": 0.5, "n": 3.0}
    assert list(one.ranges) == ["c"]


def test_a_range_above_zero_starts_at_its_geometric_middle() -> None:
    one = ss.candidate(
        "late", where="contact", factor="1 + a*exp(-u/w)", ranges={"a": [0, 1], "w": [0.01, 1]}
    )
    assert one.parameters == pytest.approx({"a": 0.5, "w": 0.1})


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"force": "-c*deflection - k*deflection**3", "ranges": {"c": [0, 1], "k": [0, 1]}}, ("c", "k")),
        ({"factor": "1 + a*sin(w*t)", "ranges": {"w": [1, 2], "a": [0, 1]}}, ("a",)),
        ({"factor": "1/(1 + a*u)", "ranges": {"a": [0, 1]}}, ()),
        ({"reading": "reading + q*reading**2", "ranges": {"q": [-1, 1]}}, ("q",)),
        ({"factor": "exp(-t/tau)", "ranges": {"tau": [1, 10]}}, ()),
        ({"force": "f*max(0, deflection - d)", "ranges": {"d": [0, 1], "f": [0, 1]}}, ("f",)),
    ],
)
def test_the_numbers_that_an_effect_is_proportional_to_are_found(
    given: dict[str, object], expected: tuple[str, ...]
) -> None:
    assert sizes(ss.candidate("mine", **given)) == expected  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('"drag"', '"constant_load"'), "is an effect of the catalogue, which is sought anyway"),
        (('"drag"', '"unlisted"'), "is what reports call something else"),
        (('"drag"', '"two words"'), "is no name; letters, digits and _ make one"),
        (('name = "drag"', ""), "lacks 'name'; it needs name, where, one of force, factor and reading, and ranges"),
        (('ranges.c = ["0 N s^3/m^3", "5 N s^3/m^3"]', "c = 1"), "lacks 'ranges'"),
        (('["0 N s^3/m^3", "5 N s^3/m^3"]', '["5 N s^3/m^3", "0 N s^3/m^3"]'), "its lower bound 5 is not below"),
        (('["0 N s^3/m^3", "5 N s^3/m^3"]', '["0 N", "5 N s^3/m^3"]'), "both bounds need a unit of the same kind"),
        (('["0 N s^3/m^3", "5 N s^3/m^3"]', '["0 N", "5 N"]'), "it must be a force (N)"),
        (("deflection_rate", "deflexion_rate"), "unknown name 'deflexion_rate'; did you mean 'deflection_rate'?"),
        (('"block"', '"bock"'), "no coordinate 'bock'; did you mean 'block'?"),
        (("-c*", "-c/t*"), "divides by 't', which is 0 at t = 0"),
        (("force", "reading"), "no channel 'block'"),
        (('force = "-c*', 'factor = "1 + c*'), "'deflection_rate'"),
        (("force =", 'kind = "curve"\nforce ='), "a rival is a formula"),
        (("force =", 'states = { z = { rate = "-z" } }\nforce ='), "a rival has none"),
        (("ranges.c", 'c = "1 N"\nranges.c'), "its range is in"),
        (("ranges.c", 'c = "9 N s^3/m^3"\nranges.c'), "is outside its range from 0 to 5"),
        (("ranges.c", 'ranges.d = [0, 1]\nranges.c'), "d"),
    ],
)  # fmt: skip
def test_what_is_no_candidate_is_one_line_with_its_place(
    tmp_path: Path, change: tuple[str, str], said: str
) -> None:
    with pytest.raises(ss.InputError, match=re.escape(said)) as caught:
        read(tmp_path, SI + DRAG.replace(*change))
    words = str(caught.value)
    assert "\n" not in words
    assert re.search(r"rig\.toml line \d+", words)
    assert "candidate" in words


def test_a_name_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ss.InputError, match="is there twice"):
        read(tmp_path, SI + DRAG + DRAG)


def test_units_need_a_rig_that_has_some(tmp_path: Path) -> None:
    with pytest.raises(ss.InputError, match="has a unit, but the rig's numbers are nondimensional"):
        read(tmp_path, BARE + DRAG)


@pytest.mark.parametrize(
    ("where", "given", "named"),
    [
        ("", {"force": "-c*x2"}, "block"),
        ("x1", {"force": "-c*x2"}, "block"),
        ("block", {"factor": "1 + c*t"}, "contact"),
        ("contact.static", {"factor": "1 + c*t"}, "contact.static"),
        ("", {"reading": "reading + c*t"}, "x1 channel"),
        ("belt", {"factor": "1 + c*t"}, "belt"),
    ],
)
def test_places_of_a_named_rig_have_one_name(where: str, given: dict[str, str], named: str) -> None:
    one = ss.candidate("mine", where=where, ranges={"c": [0, 1]}, **given)
    rig, law = ss.BlockOnBelt(mass=1, stiffness=1), ss.CoulombFriction(static=1, kinetic=0.5)
    assert on_rig(one, rig, law).where == named


@pytest.mark.parametrize(
    ("name", "where"), [("mine", "contact.static"), ("My-own", "contact"), ("a_1", "y1 channel")]
)
def test_a_report_may_have_its_name_and_its_place(name: str, where: str) -> None:
    page = (
        resources.files("stickslip.shown.report").joinpath("report.schema.json").read_text(encoding="utf-8")
    )
    known = json.loads(page)["$defs"]["effect"]["properties"]
    jsonschema.validate(name, known["name"])
    jsonschema.validate(where, known["where"])
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate("some where", known["where"])


def test_a_number_that_the_law_has_not_is_refused() -> None:
    one = ss.candidate("mine", where="contact.statik", factor="1 + c*t", ranges={"c": [0, 1]})
    rig, law = ss.BlockOnBelt(mass=1, stiffness=1), ss.CoulombFriction(static=1, kinetic=0.5)
    with pytest.raises(ss.InputError, match=r"the law has no number 'statik'; did you mean 'static'\?"):
        on_rig(one, rig, law)


def test_a_channel_that_is_not_recorded_is_refused(tmp_path: Path) -> None:
    one = '[[candidate]]\nname = "m"\nwhere = "x2"\nreading = "reading + c*t"\nranges.c = [0, 1]\n'
    with pytest.raises(ss.InputError, match="'x2' is not recorded; a rival reads one of x1"):
        read(tmp_path, SI + one)


def test_a_driven_slider_has_its_own_list() -> None:
    with pytest.raises(ss.InputError, match="a driven slider has its own list alone"):
        on_rig(ss.candidate("drag", **GOOD), ss.DrivenSlider(mass=1), ss.CoulombFriction(static=1, kinetic=1))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("drag", "must be"),
        ([ss.effect("constant_load", f=1)], "candidate(name, ...) makes one"),
        ([ss.effect("formula", where="block", force="-c*x2", c=1)], "'formula' has no ranges"),
        ([ss.candidate("drag", **GOOD)] * 2, "'drag' is there twice"),
        ([ss.candidate("drag", where="leg", force="-c*x2", ranges={"c": [0, 1]})], "candidates.drag.where"),
    ],
)
def test_what_is_no_candidate_in_python_is_one_line(tmp_path: Path, given: object, said: str) -> None:
    case = read(tmp_path, SI)
    with pytest.raises(ss.InputError, match=re.escape(said)) as caught:
        ss.discover(case, candidates=given)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_candidates_of_python_join_those_of_the_case(tmp_path: Path) -> None:
    case = read(tmp_path, SI + DRAG)
    with pytest.raises(ss.InputError, match="'drag' is there twice"):
        ss.discover(case, candidates=[ss.candidate("drag", **GOOD)])


def test_a_candidate_writes_the_table_it_is_read_from(tmp_path: Path) -> None:
    import tomlkit

    (one,) = read(tmp_path, SI + DRAG).candidates
    table = {key: size for key, size in one.table().items() if key != "kind"}
    (same,) = read(tmp_path, SI + tomlkit.dumps({"candidate": [table]})).candidates
    assert same == one


def test_the_candidates_of_the_page_act_on_the_rig_of_the_page() -> None:
    """docs/discovery.md shows candidates of a case in SI."""
    page = (Path(__file__).resolve().parent.parent / "docs" / "discovery.md").read_text(encoding="utf-8")
    (snippet,) = [
        one for one in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "ss.candidate(" in one
    ]
    given: dict[str, list[object]] = {}

    class Shown:
        candidate = staticmethod(ss.candidate)

        @staticmethod
        def load_case(_: str) -> None:
            return None

        @staticmethod
        def discover(_: None, candidates: list[object]) -> None:
            rig = ss.Rig.from_si(m=40, J=0.3, r=0.1, k1=6000, k2=400, k3=1200, c1=2, c2=3, length=0.01)
            given["acting"] = [on_rig(one, rig, ss.PaperFriction()) for one in candidates]

    exec(snippet.replace("import stickslip as ss", ""), {"ss": Shown})
    assert [(one.name, one.where) for one in given["acting"]] == [("drag", "block"), ("late", "contact")]
