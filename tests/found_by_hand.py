"""A `Found` put together by hand from simulations with a known cause: what the report's tests draw and write.

The readings are simulated with an effect, noise is added, and "before" and "after" are simulated from the true state
at the start of every cycle, without and with the effect. No search takes place here.
"""

from __future__ import annotations

import json
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np

import stickslip as ss
from stickslip.declared.model import Model
from stickslip.discovery import result as r

SPEEDS = {
    "run_01": (0.08, "train"), "run_02": (-0.1, "train"), "run_03": (0.12, "validate"), "run_04": (-0.07, "validate")
}  # fmt: skip
NOISE = 1e-3
DT = 0.04
RIG_SI = {
    "m": 42.3, "J": 0.277, "r": 0.1256, "k1": 6243.0, "k2": 362.1, "k3": 1234.0,
    "c1": 2.48, "c2": 2.94, "length": 0.0089
}  # fmt: skip
LAG = ss.effect("sensor_lag", tau=0.12)


SCHEMA = json.loads((files("stickslip.shown.report") / "report.schema.json").read_text(encoding="utf-8"))


def rig(si: bool) -> ss.Rig:
    if si:
        return ss.Rig.from_si(**RIG_SI)
    return ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)


def write_case(folder: Path, *, si: bool = False, extra: str = "") -> Path:
    """Simulated readings as a case's folder; returns rig.toml."""
    model = Model(rig(si), friction=ss.PaperFriction(), effects=[LAG])
    scales = model.rig.scales
    t_unit, x_unit = (1 / scales.omega, 1e3 * scales.length) if scales else (1.0, 1.0)
    lines = ['title = "made by hand"', "[rig]"]
    names = (
        RIG_SI if si else {n: getattr(model.rig, n) for n in ("alpha1", "alpha2", "beta3", "eta1", "eta12")}
    )
    lines += [f"{name} = {value}" for name, value in names.items()]
    lines += ["[noise]", f"x1 = {NOISE * x_unit}", f"y1 = {NOISE * x_unit}"]
    generator = np.random.default_rng(7)
    for name, (speed, role) in SPEEDS.items():
        run = readings(model, speed)
        noisy = run[:, 1:] + NOISE * generator.standard_normal(run[:, 1:].shape)
        table = np.column_stack([run[:, 0] * t_unit, noisy * x_unit])
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header="t,x1,y1", comments="", fmt="%.8g")
        own = speed * scales.velocity if scales else speed
        lines += ["[[run]]", f'file = "{name}.csv"', f'role = "{role}"', f"belt_speed = {own:.10g}"]
    units = ("s", "mm", "mm") if si else ("1", "1", "1")
    lines.append("[channels]")
    lines += [
        f'{c} = {{ column = "{c}", unit = "{u}" }}' for c, u in zip(("t", "x1", "y1"), units, strict=True)
    ]
    path = folder / "rig.toml"
    path.write_text("\n".join(lines) + "\n" + extra, encoding="utf-8")
    return path


def readings(model: Model, speed: float, t_end: float = 60.0) -> np.ndarray:
    """t, x1 and y1 as the sensors read them, noise-free, (n, 3)."""
    t = np.arange(0.0, t_end, DT)
    run = ss.simulate(model, belt_speed=speed, initial=(0.1, 0.1, 0, 0), t_end=t_end, t_eval=t)
    return np.column_stack([t, run.hidden["m"] if "m" in run.hidden else run.state[:, 0], run.state[:, 2]])


def view(model: Model, recording: ss.Recording) -> r.RunView:
    """One run with predictions from the true state at the start of every stretch of 8 time units."""
    t = recording.t - recording.t[0]
    speed = recording.belt_speed
    truth = ss.simulate(model, belt_speed=speed, initial=(0.1, 0.1, 0, 0), t_end=float(t[-1]), t_eval=t)
    bare = model.with_effects([])
    fields = {}
    for name, one in (("before", bare), ("after", model)):
        state = np.empty((len(t), 4))
        read, rate, mode = np.empty(len(t)), np.empty(len(t)), np.empty(len(t), dtype=np.int8)
        for start in range(0, len(t), 200):
            part = slice(start, min(start + 200, len(t)))
            own = [*truth.state[start], *((0, 0, 0, truth.hidden["m"][start]) if one.effects else ())]
            run = ss.simulate(
                one, belt_speed=speed, initial=own, t_start=t[start], t_end=float(t[part][-1]), t_eval=t[part]
            )
            state[part], mode[part] = run.state, run.mode
            read[part] = run.hidden["m"] if one.effects else run.state[:, 0]
            tau = one.effects[0].parameters["tau"] if one.effects else 1.0
            rate[part] = (run.state[:, 0] - read[part]) / tau if one.effects else run.state[:, 1]
        v_w = state[:, 1] - speed
        fields |= {
            name: {"x1": read, "y1": state[:, 2]},
            f"rate_{name}": rate,
            f"state_{name}": state,
            f"mode_{name}": mode,
            f"speed_{name}": v_w,
            f"force_{name}": one.friction.force(v_w),
        }
    assert recording.y1 is not None
    measured = {"x1": recording.x1, "y1": recording.y1}
    return r.RunView(
        name=recording.name, role=recording.role, belt_speed=speed, t=t, measured=measured,
        noise={"x1": NOISE, "y1": NOISE}, **fields
    )  # fmt: skip


def residual(views: list[r.RunView], which: str) -> r.Residual:
    parts, every = [], []
    for channel in ("x1", "y1"):
        z = np.concatenate([(v.measured[channel] - getattr(v, which)[channel]) / NOISE for v in views])
        parts.append(r.Part("channel", channel, float(np.mean(z**2)), float(np.sqrt(2 / len(z))), len(z)))
        every.append(z)
    for mode, name in ((0, "stick"), (-1, "slip, v_w < 0"), (1, "slip, v_w > 0")):
        z = np.concatenate(
            [
                ((v.measured["x1"] - getattr(v, which)["x1"]) / NOISE)[getattr(v, f"mode_{which}") == mode]
                for v in views
            ]
        )
        if len(z) > 10:
            parts.append(r.Part("mode", name, float(np.mean(z**2)), float(np.sqrt(2 / len(z))), len(z)))
    z = np.concatenate(every)
    chi2, error = float(np.mean(z**2)), float(np.sqrt(2 / len(z)))
    clean = chi2 < 1 + 4 * error
    words = "the readings' noise" if clean else "far above the noise, most of it in the x1 channel"
    return r.Residual(chi2, error, 0.8 if clean else 14.0, clean, tuple(parts), f"The residual is {words}.")


def spectrum(views: list[r.RunView]) -> dict[str, np.ndarray]:
    n = min(len(v.t) for v in views)
    out = {"frequency": 2 * np.pi * np.fft.rfftfreq(n, DT)[1:]}
    for which in ("before", "after"):
        z = [(v.measured["x1"][:n] - getattr(v, which)["x1"][:n]) / NOISE for v in views]
        out[which] = np.mean([np.abs(np.fft.rfft(one)[1:]) ** 2 / n for one in z], axis=0)
    return out


def run_error(v: r.RunView, unit: str, scale: float) -> r.RunError:
    def rmse(which: str, channel: str) -> float:
        return float(np.sqrt(np.mean((v.measured[channel] - getattr(v, which)[channel]) ** 2)))

    spread = float(np.std(v.measured["x1"]))
    one = {
        "before": rmse("before", "x1") / spread,
        "after": rmse("after", "x1") / spread,
        "floor": NOISE / spread,
    }
    rms = {
        c: {"before": scale * rmse("before", c), "after": scale * rmse("after", c), "floor": scale * NOISE}
        for c in ("x1", "y1")
    }
    other = {"before": 0.01, "after": 0.001, "floor": 0.0008}
    return r.RunError(
        run=v.name, belt_speed=v.belt_speed, one_cycle=one, two_cycles={k: 1.4 * x for k, x in one.items()},
        transition_time=other, period={"before": 0.02, "after": float("nan"), "floor": 0.001}, stick_fraction=other,
        portrait=other, rmse=rms, unit={"x1": unit, "y1": unit},
    )  # fmt: skip


def evidence(delta: float) -> r.Evidence:
    return r.Evidence(
        delta,
        delta - 9.0,
        0.05,
        0.2 * delta,
        "sensor_delay",
        15.0,
        "Removes what the declared law left over.",
    )


def true_model(case: ss.Case) -> Model:
    """What the readings were made with."""
    return Model(
        case.rig,
        friction=ss.PaperFriction(),
        effects=[LAG],
        channels=dict(case.channels),
        noise=dict(case.noise),
    )


def found(case: ss.Case, *, verdict: str = "effect_found") -> r.Found:
    """The result, with verdict effect_found (tied), no_effect, or unlisted_effect (a curve on the block)."""
    model = true_model(case)
    bare = model.with_effects([])
    runs = [view(model, one) for one in case.runs]
    train, validate = (
        [v for v in runs if v.role == "train"], [v for v in runs if v.role == "validate"]
    )  # fmt: skip
    scales = case.rig.scales
    errors = tuple(
        run_error(v, case.channels["x1"].unit, 1e3 * scales.length if scales else 1.0) for v in validate
    )
    mean = {k: float(np.mean([e.one_cycle[k] for e in errors])) for k in ("before", "after", "floor")}
    law = {
        n: r.Interval(v, 0.98 * v, 1.02 * v)
        for n, v in model.parameters.items()
        if hasattr(model.friction, n)
    }
    law["T_min_plus"] = r.Interval(0.86, None, None)
    block = r.ErrorBlock(
        "one-cycle forecast NRMSE of x1 and y1, mean over validate runs", **mean, runs=errors
    )
    after = residual(train, "after")
    nothing = verdict == "no_effect"
    effects = () if nothing else (_unlisted() if verdict == "unlisted_effect" else found_lag(),)
    ranking = (
        r.Rival(("sensor_lag",), after.chi2, 0.0, {"sensor_lag.tau": 0.12}, 3100.0, not nothing),
        r.Rival(("sensor_delay",), 1.004, 3.1, {"sensor_delay.delay": -0.12}, 2900.0, False),
        r.Rival(("friction_memory",), 4.2, 2511.0, {"friction_memory.tau": 0.05}, 610.0, False),
        r.Rival((), residual(train, "before").chi2, 8123.0, {}, None, nothing),
    )
    draws = np.random.default_rng(1).chisquare(2, 300)
    experiment = r.Experiment(
        "a common trigger for both sensors", None, ("sensor_lag", "sensor_delay"), 410.0, True
    )
    slow = r.Experiment("one more belt speed", 0.2, ("sensor_lag", "sensor_delay"), 1.2, False)
    return r.Found(
        title=case.title, verdict=r.Verdict(verdict), effects=effects, before=bare, after=bare if nothing else model,
        law=law, law_before=law, residual_before=residual(train, "before"), residual_after=after, error=block,
        ranking=ranking, experiments=() if nothing else (experiment, slow),
        gate=r.Gate(4.0 if nothing else 3100.0, 12.7, 0.05, draws), runs=tuple(runs), spectrum=spectrum(train),
        messages=("The belt speed was not recorded.",), seconds=12.3,
    )  # fmt: skip


def found_lag() -> r.FoundEffect:
    delay = {"delay": r.Interval(-0.12, -0.125, -0.115)}
    reason = "in a run without outside time marks only the relative lag of the two channels shows"
    other = r.Alternative("sensor_delay", 0.21, 3.1, True, True, reason, delay, 0.998)
    far = r.Alternative("friction_memory", 0.0, 2511.0, False, False, "far worse", {}, None)
    tau = {"tau": r.Interval(0.12, 0.117, 0.123)}
    return r.FoundEffect(
        "sensor_lag", "x1 channel", ("x1", "memory"), tau, evidence(3100.0), (other, far), "m' = (x1 - m)/tau"
    )


def _unlisted() -> r.FoundEffect:
    x = np.linspace(-0.5, 0.5, 61)
    value = 0.4 * np.sin(7 * x)
    curve = r.Curve(
        "block", "x1", "force on the block", x, value, value - 0.03, value + 0.03, x[::12], "0.4 sin(7 x1)"
    )
    return r.FoundEffect("unlisted", "block", ("x1",), {}, evidence(900.0), (), "+g(x1)", curve)


def guessed() -> r.FoundEffect:
    """What nothing describes, at its likeliest place: there is no evidence."""
    words = "no listed effect and no learned curve explains the residual; the place is the likeliest by score"
    proof = r.Evidence(None, None, None, None, "", 19.2, words)
    return r.FoundEffect("unlisted", "angle_body", ("y1",), {}, proof, (), "not described")


def of_rig(values: dict[str, float], control_name: str = "") -> r.FoundEffect:
    """Wrong numbers of the declared rig, with intervals of 1 %."""
    numbers = {name: r.Interval(one, 0.99 * one, 1.01 * one) for name, one in values.items()}
    control = 8e3 if control_name else None
    proof = r.Evidence(9e3, 8.9e3, 1.0, control, control_name, 19.2, "lowers chi-squared by 9e+03")
    words = " and ".join(f"{name} is {one:.4g}" for name, one in values.items())
    return r.FoundEffect("unlisted", "angle_body", ("y1",), numbers, proof, (), words, of_rig=True)


def with_effect(one: r.Found, effect: r.FoundEffect) -> r.Found:
    """The same result, with this effect in the place of what was found."""
    return replace(one, verdict=r.Verdict.unlisted_effect, effects=(effect,))


def per_reading(case: ss.Case) -> float:
    """How many of the readings' length unit make 1 of the model's."""
    return 1e3 * case.rig.scales.length if case.rig.scales else 1.0


def made(tmp_path: Path, *, si: bool = True, verdict: str = "effect_found") -> tuple[r.Found, ss.Case]:
    """A case written to a folder, and a result of it."""
    case = ss.load_case(write_case(tmp_path, si=si))
    return found(case, verdict=verdict), case
