"""The forces of a tabulated law are numbers of it: they move, have derivatives, and are identified."""

import numpy as np
import pytest
import scipy

import stickslip as ss
from bodies_lab import Laboratory, riding
from stickslip.declared.formula.tree import Name
from stickslip.declared.formula.value import value
from stickslip.declared.formula_law import monotone_cubic

SPEEDS, FORCES = (0.0, 0.05, 0.15, 0.4, 0.8), (4.6, 3.6, 3.0, 3.2, 3.8)
LAW = ss.TabulatedFriction(speeds=SPEEDS, forces=FORCES, static=5.0)
RIG = ss.BodiesRig(
    body={"block": ss.Body(mass=1.0)},
    link=[ss.Link(between=("block", "ground"), stiffness=40.0, damping=0.3)],
    contact=[ss.Contact(body="block", against="belt")],
)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("kind", ["any", "flat in a part", "flat", "micro"])
def test_the_curve_is_that_of_scipy(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 9))
    x, y = np.cumsum(rng.uniform(0.01, 1.0, n)), rng.uniform(0.0, 5.0, n)
    if kind == "flat in a part":
        y[-2:] = y[-1]
    elif kind == "flat":
        y[:] = y[0]
    elif kind == "micro":
        x, y = 1e-6 * x, 1e-9 * y
    tree = monotone_cubic("u", x.tolist(), [Name(f"y{i}") for i in range(n)])
    of = {f"y{i}": one for i, one in enumerate(y)}
    at = np.linspace(x[0], x[-1], 40)
    found = np.array([value(tree, {**of, "u": u}) for u in at])
    assert found == pytest.approx(
        scipy.interpolate.PchipInterpolator(x, y)(at), rel=1e-12, abs=1e-14 * y.max()
    )
    ends = [value(tree, {**of, "u": u}) for u in (0.5 * x[0], 2 * x[-1])]
    assert ends == pytest.approx([y[0], y[-1]], rel=1e-12)


@pytest.mark.parametrize("name", ["forces[0]", "forces[1]", "forces[2]", "static"])
def test_derivatives_are_those_of_differences(name: str) -> None:
    model, t = ss.Model(RIG, friction=LAW), [3.3, 5.0]

    def run(change: float, *asked: str) -> ss.Trajectory:
        moved = model.replace({name: model.parameters[name] + change})
        return ss.simulate(
            moved, belt_speed=0.1, initial=(0.0, 0.1), t_end=5.0, t_eval=t, rtol=1e-12, sensitivity=asked
        )

    slope = (run(1e-5).state - run(-1e-5).state) / 2e-5
    assert run(0.0, name).sensitivity[:, :, 0] == pytest.approx(slope, rel=1e-6, abs=1e-7)


def test_a_law_keeps_what_is_not_changed() -> None:
    two_ways = ss.TabulatedFriction(speeds=SPEEDS, forces=FORCES, forces_plus=[1.1 * one for one in FORCES])
    moved = two_ways.with_numbers({"forces_plus[2]": 3.5, "forces[0]": 4.7})
    assert moved.forces == (4.7, *FORCES[1:])
    assert moved.forces_plus == pytest.approx([5.06, 3.96, 3.5, 3.52, 4.18])
    assert moved.static_limits == pytest.approx((4.7, 5.06))
    assert set(two_ways.numbers) == {f"{of}[{i}]" for of in ("forces", "forces_plus") for i in range(5)}


def test_a_force_can_be_swept() -> None:
    found = ss.sweep(
        ss.Model(RIG, friction=LAW), {"forces[2]": [2.8, 3.0]}, belt_speed=0.1, initial=(0.0, 0.1), t_end=5.0,
        observe=["state_max"],
    )  # fmt: skip
    for force, most in zip((2.8, 3.0), np.asarray(found["state_max"])[:, 0], strict=True):
        model = ss.Model(RIG, friction=LAW.with_numbers({"forces[2]": force}))
        run = ss.simulate(
            model, belt_speed=0.1, initial=(0.0, 0.1), t_end=5.0, t_eval=np.linspace(0, 5, 20_001)
        )
        assert most == pytest.approx(run.state[:, 0].max(), rel=1e-5)


def recorded(seed: int, speed: float) -> ss.Recording:
    """A block on a belt under the curve of scipy, by SciPy, whose friction scatters by 2 %."""
    curve = scipy.interpolate.PchipInterpolator(SPEEDS, FORCES)

    def tabulated(level: float, own: float) -> tuple[object, float]:
        return lambda u: (1 + level) * float(curve(np.clip(u, 0.0, 0.8))), (1 + level) * (1 + own) * 5.0

    laboratory = Laboratory(
        M=np.array([[1.0]]), C=np.array([[0.3]]), K=np.array([[40.0]]), D=np.array([[1.0]]),
        laws=[tabulated], level_sd=0.02, static_sd=0.02, kinetic=[], static=[], V=[riding(speed)],  # type: ignore[list-item]
        force=np.zeros(1), rng=np.random.default_rng(seed),
    )  # fmt: skip
    t = np.arange(0.0, 18.0, 0.01)
    x = laboratory.record(np.array([0.0, speed]), t)[:, 0]
    return ss.load_recording({"t": t, "block": x + 1e-4 * np.random.default_rng([seed, 1]).normal(size=len(t))},
                             RIG, belt_speed=speed)  # fmt: skip


def test_a_curve_is_identified_under_scatter() -> None:
    """The forces stayed as declared once, and mass and stiffness took what was wrong with them."""
    declared = ss.TabulatedFriction(speeds=SPEEDS, forces=(4.2, 3.9, 3.3, 3.3, 3.5), static=4.7)
    found = ss.identify([recorded(0, 0.1), recorded(1, 0.13)], rig=RIG, friction=declared)
    assert isinstance(found, ss.IdentifiedRig)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    assert found.wrong == ()
    for name, true in zip((f"forces[{i}]" for i in range(4)), FORCES, strict=False):
        one = found.estimates[name]
        assert one.low < true < one.high, name
        assert one.high - one.low < 0.15 * true, name
