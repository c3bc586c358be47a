"""Friction laws: the branches of (4.1)-(4.3) as they are to be read, and the other laws."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.errors import InputError

LAWS = [
    PaperFriction(),
    CoulombFriction(static=1, kinetic=0.5),
    CoulombFriction(static=2, kinetic=0.5, static_plus=1, kinetic_plus=0.25),
    HyperbolicFriction(),
    HyperbolicFriction(scale=0.3, decay=1.42, constant=0.1, quadratic=0.01, scale_plus=0.2),
]


def test_paper_law_has_table_1() -> None:
    law = PaperFriction()
    assert law.static_limits == (5.94, 3.63)
    # the onset of slip is below the static limit, and the branches saturate where they were read to
    assert float(law.magnitude(-1e-300)) == pytest.approx(4.7906, abs=5e-5)
    assert float(law.magnitude(1e-300)) == 3.63
    assert law.kinks[0] == pytest.approx(0.2604, abs=5e-5)
    assert law.kinks[1] == 0.27
    np.testing.assert_allclose(law.magnitude([-0.3, -5.0, 0.3, 5.0]), [1.42, 1.42, 0.86, 0.86])
    # unclamped, T_minus would change sign at 0.2783
    assert float(PaperFriction(T_min_minus=0.0).kinks[0] or 0) == pytest.approx(0.2783, abs=5e-5)


def test_paper_law_meets_its_floor_at_the_kink() -> None:
    law = PaperFriction()
    kink = law.kinks[0]
    assert kink is not None
    below, above = law.magnitude([-kink * (1 - 1e-9), -kink * (1 + 1e-9)])
    assert below == pytest.approx(law.T_min_minus, abs=1e-7)
    assert below > law.T_min_minus
    assert above == law.T_min_minus
    slope = (PaperFriction().magnitude(-0.1 - 1e-6) - law.magnitude(-0.1 + 1e-6)) / 2e-6
    printed = -3.2345 / 0.0342 * np.exp(-0.18 / 0.0342) - 2.8736 / 0.3053 * np.exp(-0.18 / 0.3053)
    assert slope == pytest.approx(printed, rel=1e-6)


def test_paper_law_that_never_saturates_has_no_kink() -> None:
    assert PaperFriction(A1=0, A2=0).kinks[0] is None
    assert PaperFriction(T_s_plus=0.86).kinks[1] is None
    assert PaperFriction(A1=5.0).kinks[0] is not None
    flat = PaperFriction(A2=50.0)  # below its floor from the start
    assert flat.kinks[0] is None
    np.testing.assert_allclose(flat.magnitude([-0.01, -0.2, -3.0]), 1.42)


@pytest.mark.parametrize("law", LAWS, ids=repr)
@settings(deadline=None)  # a busy machine is not a fault
@given(v=st.floats(-10, 10))
def test_friction_dissipates_and_stays_below_static(law: PaperFriction, v: float) -> None:
    force = float(law.force(v))
    assert force * v >= 0
    if v != 0:
        assert abs(force) == float(law.magnitude(v))
    if not isinstance(law, HyperbolicFriction) or law.quadratic == 0:
        assert abs(force) <= law.static_limits[0 if v < 0 else 1] + 1e-12


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_arrays_keep_their_shape(law: PaperFriction) -> None:
    v = np.linspace(-1, 1, 12).reshape(3, 4)
    assert law.magnitude(v).shape == law.force(v).shape == (3, 4)
    assert law.force(v)[1, 2] == law.force(v[1, 2])
    assert pickle.loads(pickle.dumps(law)) == law


def test_directions_of_the_other_laws() -> None:
    law = CoulombFriction(static=2, kinetic=0.5, static_plus=1, kinetic_plus=0.25)
    assert law.static_limits == (2, 1)
    np.testing.assert_array_equal(law.force([-3, 3]), [-0.5, 0.25])
    hyperbolic = HyperbolicFriction(scale=1, decay=3, constant=0.1, quadratic=0.2, decay_plus=1)
    assert hyperbolic.static_limits == (1.1, 1.1)
    np.testing.assert_allclose(hyperbolic.magnitude([-2, 2]), [1 / 7 + 0.1 + 0.8, 1 / 3 + 0.1 + 0.8])


def test_hyperbola_may_dip_but_not_below_zero() -> None:
    HyperbolicFriction(scale=1, decay=3, constant=-0.05, quadratic=0.1)
    with pytest.raises(InputError, match=r"for v_w < 0 from u = 0\.35 on"):
        HyperbolicFriction(scale=1, decay=3, constant=-0.5, quadratic=0.1)
    with pytest.raises(InputError, match="for v_w > 0"):
        HyperbolicFriction(quadratic_plus=-1e-3)
