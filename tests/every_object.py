"""One of every kind of object that the package gives, by the name of its class; made once."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

import found_by_hand
import stickslip as ss
from stickslip.declared.laws import LAWS

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
SI_RIG = ss.Rig.from_si(m=1.2, J=0.05, r=0.1, k1=600, k2=40, k3=120, c1=0.8, c2=0.3, length=1e-3)
MODEL = ss.Model(RIG, friction=ss.PaperFriction())
BLOCK = ss.BlockOnBelt(mass=0.5, stiffness=500.0, damping=1.0)
COULOMB = ss.CoulombFriction(static=2.0, kinetic=1.2)
CHANNELS = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}


def bodies() -> ss.BodiesRig:
    return ss.BodiesRig(
        body={"bit": ss.Body(inertia="0.35 kg m^2"), "table": {"inertia": 2.0}},
        link=[
            ss.Link(between=("bit", "table"), stiffness="12 N m/rad", damping=0.1),
            {"between": ["table", "drive"], "stiffness": 40.0, "damping": 0.5},
        ],
        contact=[ss.Contact(body="bit", against="ground", arm="20 mm")],
    )


def stribeck() -> ss.StribeckFriction:
    return ss.StribeckFriction(F_s="8 N", F_c="5 N", v_s="10 mm/s")


def block_run(speed: float = 0.005, seed: int = 0, t_end: float = 6.0) -> ss.Recording:
    """A block that sticks and slips, recorded in mm with 1 um of noise."""
    model = ss.Model(BLOCK, friction=COULOMB)
    t = np.arange(0.0, t_end, 0.002)
    x = ss.simulate(model, belt_speed=speed, t_end=t_end, t_eval=t).x1
    x = 1e3 * x + 1e-3 * np.random.default_rng(seed).standard_normal(t.size)
    return ss.load_recording(
        {"t": t, "x1": x}, BLOCK, channels=CHANNELS, belt_speed=speed, noise={"x1": 1e-3}, name="block"
    )


def pin_run() -> tuple[ss.Recording, ss.CoulombFriction]:
    """A pin of one coordinate on a disc, and its law."""
    rig = ss.MatricesRig(M=[[0.5]], C=[[0.4]], K=[[800.0]], contact=[1.0], names=["x"])
    law = ss.CoulombFriction(static=4.0, kinetic=2.0)
    t = np.arange(0.0, 2.0, 0.002)
    x = ss.simulate(
        ss.Model(rig, friction=law), belt_speed=0.05, initial=(0.0, 0.05), t_end=t[-1], t_eval=t
    ).state[:, 0]
    x = x + 1e-5 * np.random.default_rng(0).standard_normal(t.size)
    return ss.load_recording({"t": t, "x": x}, rig, belt_speed=0.05, noise={"x": 1e-5}), law


@cache
def objects() -> dict[str, object]:
    """Every class of `dir(stickslip)` that has instances worth a look, with one of it."""
    run = ss.simulate(MODEL, belt_speed=0.1, t_end=60.0, sensitivity=["T_s_minus"])
    cycle = ss.limit_cycle(MODEL, belt_speed=0.1)
    branch = ss.continuation(MODEL, span=(0.1, 0.14), max_points=30)
    found, case = found_by_hand.made(Path(tempfile.mkdtemp()))
    recording = block_run()
    identified = ss.identify([recording], rig=BLOCK, friction=COULOMB)
    pin, law = pin_run()
    of_pin = ss.identify(pin, friction=law)
    made = [
        RIG,
        BLOCK,
        ss.DrivenSlider(mass=2.0),
        bodies(),
        *bodies().body.values(),
        ss.MatricesRig(M=[[1.0]], K=[[4.0]], contact=[1.0]),
        ss.Link(between=("bit", "ground"), stiffness=3.0),
        ss.Contact(body="bit"),
        SI_RIG.scales,
        *(law(**law.drawn) for law in LAWS.values()),
        stribeck(),
        ss.TabulatedFriction(speeds=[0.0, 0.1, 1.0], forces=[2.0, 1.0, 1.5]),
        ss.LuGreFriction(F_s=8.0, F_c=5.0, v_s=0.01, sigma0=1e4, sigma1=10.0, sigma2=0.5),
        ss.DahlFriction(F_c=5.0, sigma0=1e4),
        ss.RateAndStateFriction(mu0=0.6, a=0.01, b=0.015, D_c=1e-5, normal=10.0, V_0=1e-6),
        ss.FormulaFriction(kinetic="F*(1 + 0.1*u)", static="F_s", F=1.0, F_s=2.0),
        ss.LawState(rate="-z", start="0", unit="1"),
        ss.effect("sensor_lag", tau=0.12),
        ss.tabulated("block", "x1", [-1.0, 0.0, 1.0], [0.0, 0.1, 0.0]),
        ss.Channel("x1", "mm"),
        ss.Speed.of("0.5*sin(1.7*t)"),
        ss.EventScatter(level=0.02, along=0.01, length=0.4, static=0.01, belt=0.004),
        ss.Model(SI_RIG, friction=ss.PaperFriction(), effects=[ss.effect("sensor_lag", tau=0.12)]),
        case,
        recording,
        run,
        run.transitions,
        cycle,
        ss.cycle_sensitivity(cycle, ["T_s_minus"]),
        branch,
        ss.SpecialPoint(kind="fold", value=0.1, cycle=cycle, index=1, turns_round=True),
        ss.steady_sliding(MODEL, 2.0),
        ss.lyapunov(MODEL, belt_speed=0.1, t_end=450.0, transient=10.0),
        identified,
        ss.compare(identified.model, recording),
        of_pin,
        ss.compare(of_pin.model, pin),
        found,
    ]
    return {type(one).__name__: one for one in made}
