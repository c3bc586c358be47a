"""A driven slider through `simulate` and `sweep`: closed forms, stated formulas, and the stepping that fits use."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy

import driven_truth as truth
import stickslip as ss
from stickslip.declared.effect import DRIVEN
from stickslip.errors import InputError
from stickslip.simulated.driven_slider import forecast
from test_driven_simulate import LAW, SMOOTH, model

TIGHT: dict[str, Any] = {"rtol": 1e-11, "atol": 1e-13}


def held(seconds: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """A drive that jumps to and fro, as samples that hold."""
    generator = np.random.default_rng(0)
    forces = np.repeat(generator.uniform(-15, 15, 40), 25)[: int(seconds * truth.RATE)]
    return np.arange(len(forces)) / truth.RATE, forces


def test_turns_and_rests_under_a_held_drive_are_the_closed_form() -> None:
    t, forces = held()
    run = ss.simulate(
        model(),
        drive=(t, forces),
        initial=(0.0, 0.02),
        t_end=2.0,
        t_eval=np.arange(1001) / truth.RATE,
        **TIGHT,
    )
    x, v, path = 0.0, 0.02, [0.0]
    for force in forces:
        x, v = truth.moved(x, v, float(force), 1 / truth.RATE)
        path.append(x)
    np.testing.assert_allclose(run.x1, path, atol=1e-13)
    assert len(run.transitions) > 10
    assert set(run.mode) == {-1, 0, 1}


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", SMOOTH)
def test_each_effect_moves_it_as_its_formula_says(name: str) -> None:
    numbers, force = SMOOTH[name]

    def drive(t: float) -> float:
        return 25.0 + 3.0 * np.sin(9 * t)

    def rate(t: float, state: np.ndarray) -> list[float]:
        x, v = state
        return [v, (force(x, v, t, drive(t)) - truth.DAMPING * v - truth.PLUS) / truth.MASS]

    theirs = scipy.integrate.solve_ivp(rate, (0, 0.6), [0.0, 0.05], rtol=1e-11, atol=1e-13).y[:, -1]
    ours = ss.simulate(
        model(ss.effect(name, **numbers)),
        drive="25 + 3*sin(9*t)",
        initial=(0.0, 0.05),
        t_end=0.6,
        **TIGHT,
    )
    np.testing.assert_allclose(ours.state[-1], theirs, rtol=1e-8, atol=1e-11)


BESIDE = (
    ("friction_ripple", "friction_drift", "stribeck_peak"),
    ("drive_ripple", "drive_nonlinearity", "position_load"),
    ("drive_lag", "drive_gain_drift", "viscous_asymmetry"),
    ("drive_delay", "drive_nonlinearity"),
    ("contact_compliance", "position_load", "drive_lag"),
    ("rig_mass", "viscous_saturation", "harmonic_forcing"),
)
OWN = {
    "drive_lag": {"tau": 0.02},
    "drive_delay": {"delay": 0.01},
    "contact_compliance": {"k": 2000.0, "c": 4.0},
    "rig_mass": {"e": 0.2},
}


def usual(name: str) -> ss.Effect:
    return ss.effect(name, **(OWN[name] if name in OWN else SMOOTH[name][0]))


@pytest.mark.sampled(4)
@pytest.mark.parametrize("names", [*((one,) for one in sorted(OWN)), *BESIDE], ids="-".join)
def test_it_is_what_the_fit_of_a_record_steps_through(names: tuple[str, ...]) -> None:
    """Effects beside each other, to and fro and at rest, against the time stepping of `discover`, which converges."""
    soft = "contact_compliance" in names
    law = ss.CoulombFriction(static=6.0, kinetic=6.0) if soft else LAW
    whole = ss.Model(
        ss.DrivenSlider(mass=truth.MASS, damping=truth.DAMPING), friction=law, effects=[*map(usual, names)]
    )
    t, forces = held(0.8)
    forces = 2 * forces
    ours = ss.simulate(whole, drive=(t, forces), initial=(0.0, 0.05), t_end=0.79, t_eval=t[:-4], **TIGHT).x1
    errors = []
    for fine in (2, 8):  # the record sampled more finely is stepped through more finely
        many = np.arange(len(t) * fine) / (truth.RATE * fine)
        path = forecast(
            whole,
            many,
            np.repeat(forces, fine),
            np.array([0]),
            np.zeros(1),
            np.array([0.05]),
            (len(t) - 5) * fine,
        )
        errors.append(np.max(np.abs(path[::fine, 0] - ours)))
    assert errors[1] < 5e-4 * np.ptp(ours), errors
    assert errors[1] < 0.8 * errors[0], errors


def test_derivatives_are_those_of_differences() -> None:
    law = ss.CoulombFriction(static=8.0, kinetic=7.0, static_plus=6.0, kinetic_plus=5.0)
    effects = [usual("drive_lag"), ss.effect("drive_ripple", a=0.2, L=0.03, phi=1.0), usual("rig_mass")]
    effects.append(ss.effect("viscous_asymmetry", c=8.0))
    whole = replace(model(*effects), friction=law)
    names = (
        "mass",
        "damping",
        "kinetic_plus",
        "static_plus",
        "drive_lag.tau",
        "drive_ripple.a",
        "rig_mass.e",
        "viscous_asymmetry.c",
        "drive",
        "initial.x2",
    )
    settings: dict[str, Any] = {"t_end": 0.8, "rtol": 1e-12, "atol": 1e-14}

    def end(by: str = "", step: float = 0.0) -> np.ndarray:
        moved = whole.replace({by: whole.parameters[by] + step}) if by in whole.parameters else whole
        start = (0.0, 0.05 + step * (by == "initial.x2"))
        return ss.simulate(moved, drive=25.0 + step * (by == "drive"), initial=start, **settings).state[-1]

    run = ss.simulate(whole, drive=25.0, initial=(0.0, 0.05), sensitivity=names, **settings)
    for k, name in enumerate(names):
        step = 1e-5 * abs(whole.parameters.get(name, {"drive": 25.0}.get(name, 0.05)))
        slope = (end(name, step) - end(name, -step)) / (2 * step)
        np.testing.assert_allclose(run.sensitivity[-1, :, k], slope, rtol=2e-6, atol=1e-9, err_msg=name)


def test_a_sweep_over_its_drive_is_a_loop_of_runs() -> None:
    whole = model(ss.effect("position_load", k=40.0))
    over = {"drive": np.array([4.0, 12.0, 25.0]), "mass": np.array([8.0, 12.0])}
    observe = ("final_state", "stick_fraction", "state_max", "dissipated")
    ds = ss.sweep(whole, over, t_end=3.0, initial=(0.0, 0.1), observe=observe, **TIGHT)
    assert ds.sizes["drive"] == 3
    for i, force in enumerate(over["drive"]):
        for j, mass in enumerate(over["mass"]):
            run = ss.simulate(
                whole.replace({"mass": mass}), drive=force, initial=(0.0, 0.1), t_end=3.0, **TIGHT
            )
            np.testing.assert_allclose(ds.final_state[i, j], run.state[-1], atol=1e-10)
            # the work of friction is what the drive and the damper leave
            fine = ss.simulate(
                whole.replace({"mass": mass}),
                drive=force,
                initial=(0.0, 0.1),
                t_end=3.0,
                t_eval=np.linspace(0, 3, 30_001),
                **TIGHT,
            )
            lost = force * (fine.x1[-1]) - truth.DAMPING * np.trapezoid(fine.x2**2, fine.t)
            kept = 0.5 * mass * (fine.x2[-1] ** 2 - 0.01) + 20 * fine.x1[-1] ** 2
            np.testing.assert_allclose(ds.dissipated[i, j], lost - kept, rtol=1e-5, atol=1e-7)
    steady = ss.sweep(whole, {"mass": [8.0, 12.0]}, drive="20*sin(5*t)", t_end=3.0)
    assert (steady.status == 0).all()


def test_a_run_goes_on_with_its_lag() -> None:
    whole, t = model(usual("drive_lag")), np.linspace(0, 1, 21)
    once = ss.simulate(whole, drive="20*sin(5*t)", t_end=1.0, t_eval=t, **TIGHT)
    first = ss.simulate(whole, drive="20*sin(5*t)", t_end=0.4, **TIGHT)
    then = ss.simulate(whole, drive="20*sin(5*t)", initial=first, t_end=1.0, t_eval=t[8:], **TIGHT)
    np.testing.assert_allclose(then.state, once.state[8:], atol=1e-11)
    assert once.hidden_names == ("drive_lag.f",)


def test_a_drive_is_given_in_every_way_that_makes_sense() -> None:
    for same in (25.0, "25 N", "25", "0.025 kN", ([0.0], [25.0]), ss.Speed.of(25.0), "25 + 0*t"):
        run = ss.simulate(model(), drive=same, initial=(0.0, 0.05), t_end=1.0)
        assert run.x1[-1] == pytest.approx(ss.simulate(model(), drive=25, initial=(0, 0.05), t_end=1).x1[-1])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "drive: missing: the force on the slider"),
        ({"drive": "25 mm"}, "measures no force"),
        ({"drive": "sin(x)"}, "unknown name|x"),
        ({"drive": ([0.0, 1.0], [1.0])}, "has 1 samples at 2 times"),
        ({"drive": ([0.0, 0.0], [1.0, 2.0])}, "must increase; entry 1 is 0 after 0"),
        ({"drive": ([0.0, 1.0], [1.0, np.nan])}, "not finite"),
        ({"drive": 1.0, "belt_speed": 0.1}, "a driven slider has no belt"),
        ({"drive": 1.0, "drive_speed": 0.1}, "`drive` is the force"),
    ],
)
def test_a_wrong_drive_is_said_in_a_line(given: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        ss.simulate(model(), t_end=1.0, **given)


def test_no_force_moves_another_rig() -> None:
    other = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())
    with pytest.raises(InputError, match="no force moves this rig"):
        ss.simulate(other, belt_speed=0.1, drive=1.0, t_end=1.0)


def test_every_effect_of_a_driven_slider_is_tried_here() -> None:
    assert {*SMOOTH, *OWN} == {*DRIVEN}


def test_every_number_is_swept_as_simulated() -> None:
    """A delay, and the start of a lag under a drive that varies, stayed as the model had them."""
    whole = model(usual("drive_lag"), usual("drive_delay"))
    over = {"drive_delay.delay": [0.0, 0.3], "drive_lag.tau": [0.1, 0.3]}
    ds = ss.sweep(whole, over, drive="25*sin(4*t)", initial=(0.0, 0.1), t_end=1.0, **TIGHT)
    for i, delay in enumerate(over["drive_delay.delay"]):
        for j, tau in enumerate(over["drive_lag.tau"]):
            one = whole.replace({"drive_delay.delay": delay, "drive_lag.tau": tau})
            run = ss.simulate(one, drive="25*sin(4*t)", initial=(0.0, 0.1), t_end=1.0, **TIGHT)
            np.testing.assert_allclose(ds.final_state[i, j], run.state[-1], atol=1e-11)
    lagged = model(ss.effect("drive_lag", tau=0.3))
    run = ss.simulate(lagged, drive=9.0, t_end=1.0, **TIGHT)
    swept = ss.sweep(lagged, {"drive": [9.0]}, t_end=1.0, **TIGHT)
    np.testing.assert_allclose(swept.final_state[0], run.state[-1], atol=1e-11)


def test_a_store_of_another_drive_is_not_gone_on_with(tmp_path: Path) -> None:
    """Held samples were told apart by how many they are."""
    pytest.importorskip("zarr")
    t = np.arange(0, 3, 0.1)
    for out, drives in (
        ("held", [(t, 9 * np.sin(4 * t)), (t, -18 * np.sin(4 * t))]),
        ("number", [9.0, 9.000001]),
    ):
        ss.sweep(model(), {"mass": [1.0, 2.0]}, drive=drives[0], t_end=3, out=tmp_path / out)
        with pytest.raises(InputError, match="another"):
            ss.sweep(model(), {"mass": [1.0, 2.0]}, drive=drives[1], t_end=3, out=tmp_path / out)


def test_a_root_of_what_is_0_at_the_start_is_refused() -> None:
    """The drive was taken as 0 for the whole run, and the run as finished."""
    for text in ("9*sqrt(t)", "t**1.5", "6 + 9*t**2.5"):
        with pytest.raises(
            InputError, match="takes a root, or a power that is not whole, of what is 0 at t = 0"
        ):
            ss.simulate(model(), drive=text, t_end=1.0)
        block = ss.Model(ss.BlockOnBelt(), friction=LAW)
        with pytest.raises(InputError, match="takes a root"):
            ss.simulate(block, belt_speed=text, t_end=1.0)
    with pytest.raises(InputError, match="takes a root, or a power that is not whole, of what is 0 at t = 1"):
        ss.Speed.steps([0.0, 1.0], [2.0, "((t - 1)**2)**0.75"])
    run = ss.simulate(model(), drive="9*sqrt(t + 1e-9)", t_end=3.0)
    assert run.x1[-1] > 0.1


@pytest.mark.parametrize(("p", "tolerance"), [(15, 1e-4), (20, 1e-8), (24, 1e-10), (33, 1e-11), (200, 1e-11)])
def test_a_power_with_more_factors_than_a_series_has_terms_acts(p: int, tolerance: float) -> None:
    """From where its base is 0 every term was 0: a drive by sin(9 t)**20 did nothing for the whole run."""
    t = np.linspace(0, 1.0, 200_001)
    forces = 20.0 * np.sin(9 * t) ** p
    settings: dict[str, Any] = {"initial": (0.0, 0.0), "t_end": 1.0}
    run = ss.simulate(model(), drive=f"20*sin(9*t)**{p}", rtol=tolerance, atol=tolerance, **settings)
    fine = ss.simulate(model(), drive=(t, forces), max_transitions=2_000_000, **settings)
    np.testing.assert_allclose(run.state[-1], fine.state[-1], atol=5e-6)
    assert len(run.transitions) == len(fine.transitions) > 2


def test_a_slip_the_other_way_is_refused() -> None:
    with pytest.raises(InputError, match="slips the other way"):
        ss.simulate(model(), drive=9, initial=(0, -1), contact="slip+", t_end=1.0)
    ss.simulate(model(), drive=9, initial=(0, -1), contact="slip-", t_end=1.0)


def test_friction_that_drives_is_said() -> None:
    with pytest.warns(ss.ModelWarning, match="friction"):
        ss.simulate(model(ss.effect("friction_drift", r=-1.0)), drive=0, t_end=3.0)


def test_a_bristle_is_bent_by_all_that_acts_at_the_contact() -> None:
    soft = model(
        ss.effect("contact_compliance", k=2e3, c=0.0), ss.effect("viscous_saturation", dT=2.0, v_s=0.2)
    )
    run = ss.simulate(soft, drive=20, initial=(0.0, 0.3), t_end=0.1)
    bent = truth.PLUS + 2.0 * (1 - np.exp(-0.3 / 0.2))
    assert run.hidden["contact_compliance.z"][0] == pytest.approx(bent / 2e3, rel=1e-12)


def test_a_curve_in_the_sliding_speed_acts_on_the_block_too() -> None:
    knots, values = [0.0, 0.5, 1.0], [0.0, 2.0, 0.0]
    runs = [
        ss.simulate(model(ss.tabulated("block", of, knots, values)), drive=25, initial=(0, 0.1), t_end=1.0)
        for of in ("v_w", "x2")
    ]
    np.testing.assert_array_equal(runs[0].state[-1], runs[1].state[-1])
    with pytest.raises(InputError, match="no derivative by a delay"):
        ss.simulate(model(usual("drive_delay")), drive=25, t_end=1.0, sensitivity=("drive_delay.delay",))


@pytest.mark.parametrize("delay", [0.3, -0.2])
def test_a_delay_puts_off_formulas_and_samples(delay: float) -> None:
    late = model(ss.effect("drive_delay", delay=delay))
    settings: dict[str, Any] = {"initial": (0.0, 0.1), "t_end": 1.5, **TIGHT}
    ours = ss.simulate(late, drive="25*sin(4*t)", **settings)
    theirs = ss.simulate(model(), drive=f"25*sin(4*(t - {delay}))", **settings)
    np.testing.assert_allclose(ours.state[-1], theirs.state[-1], atol=1e-12)
    t, forces = held(1.5)
    ours = ss.simulate(late, drive=(t, forces), **settings)
    theirs = ss.simulate(model(), drive=(t + delay, forces), **settings)
    np.testing.assert_allclose(ours.state[-1], theirs.state[-1], atol=1e-12)
