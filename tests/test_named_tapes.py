"""A named rig on which a formula acts: the windows that fits ask for, against those of its own core."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import stickslip as ss
from every_effect import EFFECTS
from stickslip import _core
from stickslip.simulated.lowering import WIDTH, lower
from stickslip.simulated.named_places import REFUSED
from stickslip.simulated.states import COUNT, DWELL, LAGGED, X1, X2, Y1

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
BLOCK = ss.BlockOnBelt(mass=16, stiffness=16, damping=0.1)
CURVE = ss.tabulated("contact", "x1", np.linspace(-0.1, 0.4, 6), [0.01, -0.02, 0.0, 0.03, -0.01, 0.02])
NOTHING = ss.effect("formula", called="nothing", where="block", force="-c*x2", c=0.0)
KEPT = np.array([X1, Y1, LAGGED], dtype=np.int32)
T = np.linspace(3.0, 15.0, 120)


def windows(model: ss.Model, names: list[str], contact: int = 2) -> dict[str, np.ndarray]:
    """Two windows, from a slip or from a stick, with derivatives by numbers of the model and of the start."""
    lowered = lower(model, 0.1)
    start = np.zeros((2, COUNT))
    start[:, : len(model.rig.state_names)] = [[0.1, 0.1, 0.02, 0.0][: len(model.rig.state_names)]] * 2
    start[1, X1], start[:, LAGGED], start[:, DWELL] = 0.25, 0.09, 0.7
    seeds = np.zeros((len(names) + 2, WIDTH + COUNT))
    for row, name in zip(seeds, names, strict=False):
        row[list(lowered.slots[name])] = lowered.factors.get(name, 1.0)
    seeds[len(names), WIDTH + X1] = 1.0
    seeds[len(names) + 1, WIDTH + LAGGED] = 1.0
    return {
        key: np.asarray(one)
        for key, one in lowered.windows(
            parameters=lowered.parameters[None],
            set=np.zeros(2, dtype=np.int32),
            initial=start,
            contact=np.full(2, contact, dtype=np.int32),
            t=np.concatenate([T, T[:60]]),
            offset=np.array([0, 120, 180]),
            rtol=1e-11,
            atol=1e-11,
            seeds=seeds,
            column=np.arange(len(seeds), dtype=np.int32),
            columns=len(seeds),
            kept=KEPT,
            max_transitions=1000,
            max_steps=100_000,
            order=0,
            threads=1,
        ).items()
    }


def told(case: str) -> bool:
    """Whether the effects of a case act beside a formula."""
    names = {one.name for one in EFFECTS[case]}
    return not names & {*REFUSED} and "repeats" not in case and "its own phase" not in case


@pytest.mark.parametrize("case", [one for one in EFFECTS if told(one)])
def test_beside_a_formula_that_does_nothing_an_effect_acts_as_on_the_named_core(case: str) -> None:
    effects = EFFECTS[case]
    curve = () if any(isinstance(one, ss.Tabulated) for one in effects) else (CURVE,)
    plain = ss.Model(RIG, friction=ss.PaperFriction(), effects=[*effects, *curve])
    beside = ss.Model(RIG, friction=ss.PaperFriction(), effects=[NOTHING, *effects, *curve])
    own = [f"{one.name}.{name}" for one in effects for name in one.parameters]
    fewer = [name for name in own if not name.endswith((".v_c", "crosstalk.c"))]
    names = ["alpha1", "eta12", "T_s_minus", "T_min_minus", "belt_speed", *fewer]
    for contact in (2, 0):
        theirs, ours = (windows(model, names, contact) for model in (plain, beside))
        assert all(one == _core.Outcome.finished for one in ours["outcome"])
        np.testing.assert_allclose(ours["state"][:, :4], theirs["state"][:, :4], atol=2e-8)
        if "lag" in case:
            np.testing.assert_allclose(ours["state"][:, LAGGED], theirs["state"][:, LAGGED], atol=2e-8)
        assert (ours["mode"] == theirs["mode"]).mean() > 0.99
        scale = np.abs(theirs["slopes"]).max(axis=(0, 1)) + 1e-3
        kept = [0, 1, 2] if "lag" in case else [0, 1]
        difference = np.abs(ours["slopes"] - theirs["slopes"])[kept] / scale
        assert difference.max() < 1e-4, dict(zip(names, difference.max(axis=(0, 1)), strict=False))


@pytest.mark.parametrize(
    ("given", "same"),
    [
        ({"where": "block", "force": "-c*deflection_rate", "c": 0.3}, ss.effect("block_viscous_damping", c=0.3)),
        ({"where": "angle_body", "force": "-c*deflection**3", "c": 3.0}, ss.effect("spring_cubic_k3", k=3.0)),
        ({"where": "contact", "factor": "1 + c*t", "c": 0.01}, ss.effect("friction_drift", r=0.01)),
        (
            {"where": "belt", "factor": "1 + c*sin(w*t)", "c": 0.1, "w": 4.0},
            ss.effect("belt_speed_ripple", a=0.1, w=4.0),
        ),
    ],
)  # fmt: skip
@pytest.mark.parametrize("contact", [2, 0])
def test_a_formula_acts_as_the_effect_of_the_catalogue_that_it_is(
    given: dict[str, object], same: ss.Effect, contact: int
) -> None:
    formula = ss.Model(
        RIG, friction=ss.PaperFriction(), effects=[ss.effect("formula", called="f", **given), CURVE]
    )
    built = ss.Model(RIG, friction=ss.PaperFriction(), effects=[same, CURVE])
    size = next(name for name in same.parameters if name not in ("w", "phi"))
    more = ["w"] if "w" in given else []
    names = ["alpha1", "belt_speed"]
    ours = windows(formula, [*names, "f.c", *(f"f.{one}" for one in more)], contact)
    theirs = windows(built, [*names, f"{same.name}.{size}", *(f"{same.name}.{one}" for one in more)], contact)
    np.testing.assert_allclose(ours["state"][:, :4], theirs["state"][:, :4], atol=2e-8)
    scale = np.abs(theirs["slopes"]).max(axis=(0, 1)) + 1e-3
    assert np.max(np.abs(ours["slopes"] - theirs["slopes"])[:2] / scale) < 1e-4


def test_derivatives_by_the_numbers_of_a_formula_are_differences() -> None:
    def model(c: float) -> ss.Model:
        formula = ss.effect("formula", called="f", where="contact", factor="1 + c*tanh(30*u)*x1", c=c)
        return ss.Model(BLOCK, friction=ss.CoulombFriction(static=5, kinetic=3), effects=[formula, CURVE])

    low, middle, high = (windows(model(c), ["f.c"]) for c in (0.3 - 1e-5, 0.3, 0.3 + 1e-5))
    expected = (high["state"][:, X1] - low["state"][:, X1]) / 2e-5
    good = np.abs(expected) < 50  # a sample at which the one slips and the other sticks
    np.testing.assert_allclose(middle["slopes"][0, good, 0], expected[good], rtol=2e-3, atol=1e-4)


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_act_beside_a_formula_is_refused(name: str) -> None:
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=[NOTHING, *EFFECTS[name]])
    with pytest.raises(
        ss.InputError, match=f"'{name}' does not act beside an effect by a formula, 'nothing'"
    ):
        lower(model, 0.1)


def test_a_block_in_stick_moves_with_a_belt_that_a_formula_moves() -> None:
    formula = ss.effect("formula", called="f", where="belt", factor="1 + a*cos(2*t)", a=0.2)
    made = windows(
        ss.Model(BLOCK, friction=ss.CoulombFriction(static=50, kinetic=30), effects=[formula]), [], 0
    )
    np.testing.assert_allclose(made["state"][:120, X2], 0.1 * (1 + 0.2 * np.cos(2 * T)), atol=1e-9)
    assert (made["mode"] == 0).all()


def test_tapes_cross_processes() -> None:
    made = lower(ss.Model(RIG, friction=ss.PaperFriction(), effects=[NOTHING, CURVE]), 0.1).tapes
    assert made is not None
    again = pickle.loads(pickle.dumps(made))
    np.testing.assert_array_equal(again.turned, made.turned)
    np.testing.assert_array_equal(again.constant, made.constant)


@pytest.mark.parametrize("effects", [(), (NOTHING,)])
def test_what_fits_simulate_crosses_processes(effects: tuple[object, ...]) -> None:
    """A search in a laboratory hands fits, with their windows, to its workers."""
    made = lower(ss.Model(RIG, friction=ss.PaperFriction(), effects=[*effects, CURVE]), 0.1)
    again = pickle.loads(pickle.dumps(made))
    np.testing.assert_array_equal(again.parameters, made.parameters)
    assert again.slots == made.slots
