"""Rigs: (2.1)'s numbers from SI and back, checks, equality."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from known_numbers import SI
from stickslip.declared.rig import BlockOnBelt, DrivenSlider, Rig, Scales
from stickslip.errors import InputError

POSITIVE = st.floats(1e-3, 1e3)


@given(st.fixed_dictionaries(dict.fromkeys(SI, POSITIVE)), st.sampled_from(["reciprocal", "as_printed"]))
def test_si_round_trip(si: dict[str, float], coupling: str) -> None:
    rig = Rig.from_si(**si, coupling=coupling)
    back = rig.to_si()
    # k = (alpha - 1) k2 loses the digits of k/k2 beside 1
    loss = 1e-14 * (1 + max(1, si["k2"] / si["k1"], si["k2"] / si["k3"], (si["c1"] + si["c2"]) / si["c2"]))
    assert list(back) == list(SI)
    assert back == pytest.approx(si, rel=loss)
    assert rig.coupling == coupling


def test_from_si_gives_the_same_motion() -> None:
    """The nondimensional field, turned back, is Newton's law in SI (friction and belt apart)."""
    rig = Rig.from_si(**SI)
    assert rig.scales is not None
    length, velocity = rig.scales.length, rig.scales.velocity
    x, v, leg, w = (
        0.3 * length,
        -0.2 * velocity,
        0.5 * length,
        0.7 * velocity,
    )  # SI displacements and velocities
    newton = -(SI["k1"] + SI["k2"]) * x - SI["c1"] * (v + w) - SI["k2"] * leg
    euler = -(SI["k2"] + SI["k3"]) * leg - (SI["c1"] + SI["c2"]) * w - SI["k2"] * x - SI["c1"] * v
    x1, x2, y1, y2 = 0.3, -0.2, 0.5, 0.7
    a_block = -x1 - (rig.eta1 * (x2 + y2) + y1) / rig.alpha1
    a_leg = (-rig.beta3 * y1 - rig.eta12 * y2 - x1 - rig.eta1 * x2) / rig.alpha2
    acceleration = length * rig.scales.omega**2
    assert newton / SI["m"] == pytest.approx(a_block * acceleration, rel=1e-13)
    assert euler / (SI["J"] / SI["r"] ** 2) == pytest.approx(a_leg * acceleration, rel=1e-13)


def test_numbers_may_have_units() -> None:
    block = BlockOnBelt(mass="1200 g", stiffness="0.85 N/mm", damping="0.5 N s/m")
    assert block == BlockOnBelt(mass=1.2, stiffness=850.0, damping=0.5)
    assert block.mass == pytest.approx(1.2, rel=1e-15)
    assert DrivenSlider(mass="0.3 t", damping=2) == DrivenSlider(mass=300.0, damping=2.0)
    units = {"m": "kg", "J": "kg m^2", "r": "m", "length": "m", "c1": "N s/m", "c2": "N s/m"}
    text = {name: f"{size!r} {units.get(name, 'N/m')}" for name, size in SI.items()}
    assert Rig.from_si(**text) == Rig.from_si(**SI)
    assert Rig.from_si(**{**SI, "r": f"{1e3 * SI['r']!r} mm"}).alpha2 == pytest.approx(
        Rig.from_si(**SI).alpha2
    )
    with pytest.raises(InputError, match=r"mass = '3 N': is .*; it must be"):
        BlockOnBelt(mass="3 N")
    with pytest.raises(InputError, match="mass = 'heavy': not a number with a unit"):
        DrivenSlider(mass="heavy")
    with pytest.raises(InputError, match=r"k1 = '-3 N/m'|k1 = -3"):
        Rig.from_si(**{**SI, "k1": "-3 N/m"})


def test_scales() -> None:
    scales = Scales(length=0.01, omega=20.0, k2=300.0, r=0.1)
    assert (scales.time, scales.velocity, scales.force) == (0.05, 0.2, 3.0)
    with pytest.raises(InputError, match="omega = 0: must be above 0"):
        Scales(length=0.01, omega=0, k2=300.0, r=0.1)


def test_value_semantics() -> None:
    rig = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    assert rig == Rig(alpha1=np.float64(16), alpha2=np.int64(8), beta3=np.array(4.0), eta1=0.1, eta12=0.2)
    assert {rig, pickle.loads(pickle.dumps(rig))} == {rig}
    assert type(rig.alpha1) is float
    assert rig.state_names == ("x1", "x2", "y1", "y2")
    assert BlockOnBelt().state_names == ("x1", "x2")
    with pytest.raises(AttributeError):
        rig.alpha1 = 3.0  # type: ignore[misc]
