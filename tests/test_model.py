"""Models: parameters by name, and files that are read back equal."""

import pickle
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from known_numbers import SI
from stickslip.declared.check_model import idle
from stickslip.declared.effect import CATALOGUE, AnyEffect, effect, tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model, load_model
from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig
from stickslip.declared.units import Channel
from stickslip.errors import InputError

RIG = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
SOME = st.floats(1e-6, 1.0)


@st.composite
def rigs(draw: st.DrawFn) -> AnyRig:
    a = [draw(SOME) for _ in range(9)]
    match draw(st.sampled_from(["nd", "si", "block"])):
        case "nd":
            coupling = draw(st.sampled_from(["reciprocal", "as_printed"]))
            return Rig(
                alpha1=1 + a[0], alpha2=a[1], beta3=1 + a[2], eta1=a[3], eta12=a[3] + a[4], coupling=coupling
            )
        case "si":
            names = ("m", "J", "r", "k1", "k2", "k3", "c1", "c2", "length")
            return Rig.from_si(**dict(zip(names, a, strict=True)))
    return BlockOnBelt(mass=a[0], stiffness=a[1], damping=a[2])


@st.composite
def laws(draw: st.DrawFn) -> FrictionLaw:
    a = [draw(SOME) for _ in range(5)]
    match draw(st.sampled_from(["paper", "coulomb", "hyperbolic"])):
        case "paper":
            return PaperFriction(T_s_minus=1 + a[0], A1=a[1], t1=a[2], T_min_minus=a[3], v_w_max=a[4])
        case "coulomb":
            plus = {"static_plus": 1 + a[2], "kinetic_plus": a[3]} if draw(st.booleans()) else {}
            return CoulombFriction(static=1 + a[0], kinetic=a[1], **plus)
    return HyperbolicFriction(scale=a[0], decay=a[1], quadratic=a[2], constant_plus=a[3])


@st.composite
def effects(draw: st.DrawFn, two_degree: bool) -> list[AnyEffect]:
    names = draw(st.sets(st.sampled_from(sorted(CATALOGUE)), max_size=4))
    found: list[AnyEffect] = []
    for name in sorted(names):
        kind = CATALOGUE[name]
        if two_degree or not kind.two_degree:
            found.append(effect(name, **{info: draw(SOME) for info in kind.parameter_names}))
    if draw(st.booleans()):
        knots = sorted(draw(st.sets(st.floats(-1, 1), min_size=3, max_size=8)))
        found.append(tabulated("contact", "v_w", knots, [draw(SOME) for _ in knots]))
    return found


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=100, deadline=None)
@given(data=st.data())
def test_file_round_trip(tmp_path: Path, data: st.DataObject) -> None:
    rig = data.draw(rigs())
    law = data.draw(laws())
    extra = data.draw(
        effects(isinstance(rig, Rig)).filter(lambda found: not idle(law, [x.name for x in found]))
    )
    channels = (
        {"t": Channel("time", "ms"), "x1": Channel("x", "mm", -2.5)} if data.draw(st.booleans()) else None
    )
    noise = {"x1": data.draw(SOME)} if channels else None
    model = Model(rig, friction=law, effects=extra, channels=channels, noise=noise)
    model.save(tmp_path / "model.toml")
    assert load_model(tmp_path / "model.toml") == model
    assert pickle.loads(pickle.dumps(model)) == model
    assert [one.name for one in tmp_path.iterdir()] == ["model.toml"]


def test_periodic_term_round_trip(tmp_path: Path) -> None:
    term = tabulated("block", "t", [0, 0.4, 1.3], [0.1, -0.2, 0.1], period=1.3, phi=0.7)
    model = Model(RIG, friction=PaperFriction(), effects=[term])
    model.save(tmp_path / "model.toml")
    assert load_model(tmp_path / "model.toml") == model


def test_saved_si_rig_turns_back_to_si(tmp_path: Path) -> None:
    Model(Rig.from_si(**SI), friction=PaperFriction()).save(tmp_path / "model.toml")
    rig = load_model(tmp_path / "model.toml").rig
    assert isinstance(rig, Rig)
    assert rig.to_si() == pytest.approx(SI, rel=1e-13)


def test_file_in_si_by_hand(tmp_path: Path) -> None:
    lines = ["[rig]", *(f"{name} = {value}" for name, value in SI.items()), "[friction]", "T_s_minus = 6.5"]
    (tmp_path / "model.toml").write_text("\n".join(lines))
    assert load_model(tmp_path / "model.toml") == Model(
        Rig.from_si(**SI), friction=PaperFriction(T_s_minus=6.5)
    )


def test_an_old_file_survives_a_failed_save(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "model.toml"
    model = Model(RIG, friction=PaperFriction())
    model.save(file)

    def full(*_paths: Path) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(InputError, match="cannot be written"):
        model.replace(alpha1=12).save(file)
    assert load_model(file) == model
    assert [one.name for one in tmp_path.iterdir()] == ["model.toml"]


def test_parameters_by_name() -> None:
    model = Model(RIG, friction=CoulombFriction(), effects=[effect("block_viscous_damping", c=0.5)])
    names = ["alpha1", "alpha2", "beta3", "eta1", "eta12", "static", "kinetic", "block_viscous_damping.c"]
    assert list(model.parameters) == names
    assert model.parameter_name("effect.c") == "block_viscous_damping.c"
    for name, value in model.parameters.items():
        changed = model.replace({name: value * 1.5 if name != "kinetic" else 0.1})
        differing = [one for one in names if changed.parameters[one] != model.parameters[one]]
        assert differing == [name]
    assert model.replace(**model.parameters) == model
    both = model.replace({"effect.c": 0.75}, alpha1=12)
    assert (both.parameters["block_viscous_damping.c"], both.parameters["alpha1"]) == (0.75, 12)
    assert model.replace(static_plus=3.0).friction == CoulombFriction(static_plus=3.0)


def test_replacing_checks_the_bounds() -> None:
    model = Model(RIG, friction=PaperFriction())
    with pytest.raises(InputError, match="alpha2 = 0: must be above 0"):
        model.replace(alpha2=0)
    with pytest.raises(InputError, match="did you mean 'T_s_minus'"):
        model.replace(T_s_mins=5)
    with pytest.raises(InputError, match="give it to simulate"):
        model.replace({"initial.x1": 0.1})


def test_wrong_kinds_of_arguments() -> None:
    with pytest.raises(InputError, match="friction: must be a FrictionLaw, not Rig"):
        Model(RIG, friction=RIG)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="effects: must be a list"):
        Model(RIG, friction=PaperFriction(), effects=effect("sensor_lag", tau=1))  # type: ignore[arg-type]
