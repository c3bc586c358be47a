"""What is known of the models apart from this package: closed forms, published numbers, runs in extended precision.

Core and reference are held to the same.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from stickslip.declared.effect import effect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig

SI = {  # a rig of a laboratory's size
    "m": 40.0,
    "J": 0.3,
    "r": 0.1,
    "k1": 6e3,
    "k2": 4e2,
    "k3": 1.2e3,
    "c1": 2.0,
    "c2": 3.0,
    "length": 0.01,
}

DATA = Path(__file__).parent / "data"
TRUTH_P1 = json.loads((DATA / "truth_p1.json").read_text())
TRUTH_P2 = json.loads((DATA / "truth_p2.json").read_text())
HARD_MEMBERS = (3382, 3505, 1489, 1871, 1929, 3316, 4001)
RIG = {"alpha1": 16.0, "alpha2": 8.0, "beta3": 4.0, "eta1": 0.1, "eta12": 0.2}
START = (0.1, 0.1, 0.0, 0.0)

# static, kinetic, v_b, then in closed form: time of slip, of stick, greatest and least x1
COULOMB = [
    (1, 0.5, 0.2, 3.902605407814523, 5, 1.0385164807134504, -0.0385164807134504),
    (1, 0.5, 0.5, 4.71238898038469, 2, 1.2071067811865475, -0.2071067811865475),
    (1, 0.25, 0.1, 3.406695718183141, 15, 1.0066372975210778, -0.5066372975210778),
]
LEINE_PERIOD, LEINE_CAPTURE, LEINE_HIGHEST = 12.00103129483057865, -0.54100635387008475, 1.13394467644165684
DEN_HARTOG = [(0.8, 0.3, 2.62610487572348), (1.5, 0.2, 0.765941686205071)]  # frequency, friction, amplitude
POPP_STELTER_TIMES = [0.155498543, 2.037675319, 4.934553429, 5.362742380, 6.697629823, 7.955663971]
POPP_STELTER_MODES = [0, -1, 0, 1, 0, -1]
POPP_STELTER_STROBE = -0.2806365463  # x1 after 75 periods
POPP_STELTER_PERIOD = 2 * math.pi / 1.067


def paper_model(*effects, **changes):
    """The reference rig under Table 1."""
    return Model(Rig(**(RIG | changes)), friction=PaperFriction(), effects=effects)


def frictionless(**changes):
    return Model(Rig(**(RIG | changes)), friction=CoulombFriction(static=0.0, kinetic=0.0))


def of_the_grid(member):
    """Model and belt speed of a member of the grid that TRUTH_P2 holds."""
    i, j = divmod(member, 64)
    alpha1 = float(np.linspace(8.0, 40.0, 64)[j])
    return paper_model(alpha1=alpha1, alpha2=alpha1 / 2), float(np.linspace(0.02, 0.3, 64)[i])


def leine():
    return Model(BlockOnBelt(), friction=HyperbolicFriction(scale=1, decay=3))


def popp_stelter():
    law = HyperbolicFriction(scale=3, decay=1.42, constant=1, quadratic=0.1)
    force = effect("harmonic_forcing", a=3.6, w=1.067, phi=math.pi / 2)
    return Model(BlockOnBelt(), friction=law, effects=[force])


def den_hartog(r, friction, phase):
    force = effect("harmonic_forcing", a=1.0, w=r, phi=phase)
    return Model(BlockOnBelt(), friction=CoulombFriction(static=friction, kinetic=friction), effects=[force])


def energy(z, s=1.0):
    x1, x2, y1, y2 = z
    return (16 * x2**2 + 8 * y2**2 + 16 * x1**2 + 4 * y1**2) / 2 + s * x1 * y1


_blocks = pytest.mark.parametrize(("static", "kinetic", "v_b", "slip", "stick", "high", "low"), COULOMB)
_directions = pytest.mark.parametrize("direction", [1, -1])


def coulomb_blocks(test):
    """Mark a test to be run with every block of COULOMB, the belt going either way."""
    return _blocks(_directions(test))


den_hartog_rigs = pytest.mark.parametrize(("r", "friction", "amplitude"), DEN_HARTOG)
hard_members = pytest.mark.parametrize("member", HARD_MEMBERS)
