"""Random driven sliders: rig, drive, loop, noise and sampling, moved in closed form; nothing of the package is used.

Between two instants at which anything changes the force is constant, and `m v' = F - c v - sgn(v) T` has an exponential
solution up to v = 0, where the slider turns or stays.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FINE = 4  # steps within a sample where a force depends on the motion
LEVELS = (0.0, 0.003, 0.01, 0.03)  # force noise over the rms drive


@dataclass
class Slider:
    """A rig and what acts on it beyond the declared law."""

    mass: float
    damping: float
    minus: float
    plus: float
    force: Callable[[float, float, float], float] | None = None  # of x, v, t
    share: Callable[[float, float, float], float] | None = None  # factor of friction
    gain: Callable[[float, float], float] | None = None  # factor of the drive, of x and t
    delay: int = 0  # samples
    name: str = ""
    numbers: dict[str, float] = field(default_factory=dict)

    def moved(self, x: float, v: float, force: float, h: float, t: float) -> tuple[float, float]:
        """Position and velocity a sample later under a held force."""
        if not (self.force or self.share):
            return exact(x, v, force, h, self.mass, self.damping, self.minus, self.plus)
        for i in range(FINE):
            at = x + 0.5 * v * h / FINE
            now = t + (i + 0.5) * h / FINE
            more = self.force(at, v, now) if self.force else 0.0
            share = self.share(at, v, now) if self.share else 1.0
            x, v = exact(
                x, v, force + more, h / FINE, self.mass, self.damping, share * self.minus, share * self.plus
            )
        return x, v


def exact(
    x: float, v: float, force: float, h: float, m: float, c: float, minus: float, plus: float
) -> tuple[float, float]:
    """Position and velocity after a time h under a constant force, turns and rests included."""
    left = h
    for _ in range(6):
        if v == 0:
            if -minus <= force <= plus:
                return x, 0.0
            way = 1.0 if force > plus else -1.0
        else:
            way = math.copysign(1.0, v)
        last = (force - (plus if way > 0 else -minus)) / c  # where the velocity tends to
        stop = math.inf
        if v != 0 and last * way < 0:
            stop = -m / c * math.log(last / (last - v))
        step = min(left, stop)
        decay = math.exp(-c * step / m)
        x += last * step + (v - last) * m / c * (1 - decay)
        v = 0.0 if step == stop else last + (v - last) * decay
        left -= step
        if left <= 0:
            break
    return x, v


@dataclass
class Drawn:
    """A drawn case: the slider, how it is driven and read, and the record."""

    slider: Slider
    closed: bool
    coloured: bool
    level: float
    rate: float
    seconds: float
    reading: float
    declared: float
    t: Array
    x: Array
    drive: Array

    @property
    def words(self) -> str:
        """One line."""
        loop, colour = ("closed" if self.closed else "open"), ("coloured" if self.coloured else "white")
        sampled = f"{self.rate:5.0f} Hz {self.seconds:4.0f} s reading {self.reading:.1e} m"
        return f"{loop:6s} {colour:8s} {100 * self.level:3.1f} % {sampled}"


def draw(rng: np.random.Generator, *, planted: str = "", closed: bool, coloured: bool, level: float) -> Drawn:
    """Draw a case."""
    mass = float(np.exp(rng.uniform(np.log(2), np.log(100))))
    friction = mass * float(rng.uniform(0.3, 1.2))
    uneven = float(rng.uniform(-0.15, 0.15))
    slider = Slider(mass, mass * float(rng.uniform(0.5, 4)), friction * (1 - uneven), friction * (1 + uneven))
    rate = float(rng.choice([250, 500, 1000, 1000, 2000]))
    seconds = float(rng.uniform(12, 25)) if rate < 2000 else float(rng.uniform(8, 13))
    n = round(seconds * rate)
    reading = float(10 ** rng.uniform(-7, -4.8))
    plan = _drive(rng, n, rate, friction)
    size = float(np.sqrt(np.mean(plan**2)))
    if planted:
        PLANTED[planted](slider, rng, (size, rate))
    noise = level * size * _noise(rng, n, coloured)
    e = reading * rng.standard_normal(n)
    if rng.random() < 0.3:  # an encoder instead
        e = np.full(n, np.nan)
    t = np.arange(n) / rate
    if closed:
        x, drive = _loop(slider, rng, t, plan, noise, e, reading)
    else:
        x, drive = _open(slider, t, plan, noise, e, reading)
    declared = mass * (1 + float(rng.choice([0.0, 0.01])) * float(rng.standard_normal()))
    return Drawn(slider, closed, coloured, level, rate, seconds, reading, declared, t, x, drive)


def _drive(rng: np.random.Generator, n: int, rate: float, friction: float) -> Array:
    """A force that moves the slider: sines, a chirp, or steps."""
    t = np.arange(n) / rate
    kind = rng.integers(3)
    if kind == 0:
        f = np.exp(rng.uniform(np.log(0.2), np.log(9), rng.integers(2, 9)))
        out = np.sum([np.sin(2 * np.pi * one * t + rng.uniform(0, 6.3)) / one**0.3 for one in f], axis=0)
    elif kind == 1:
        top, period = rng.uniform(3, 12), n / rate / 2
        phase = np.mod(t, period)
        out = np.sin(2 * np.pi * (0.2 * phase + (top - 0.2) / (2 * period) * phase**2))
    else:
        hold = int(rate * rng.uniform(0.15, 0.6))
        out = np.repeat(rng.uniform(-1, 1, n // hold + 2), hold)[:n]
        out = out + 0.5 * np.sin(2 * np.pi * rng.uniform(0.3, 1) * t)
    return np.asarray(out / np.sqrt(np.mean(out**2)) * friction * rng.uniform(1.6, 3.5))


def _noise(rng: np.random.Generator, n: int, coloured: bool) -> Array:
    w = rng.standard_normal(n)
    if not coloured:
        return w
    pole = float(rng.uniform(0.7, 0.98))
    out = np.empty(n)
    last = 0.0
    for i in range(n):
        last = pole * last + math.sqrt(1 - pole**2) * w[i]
        out[i] = last
    return out


def _read(x: float, e: float, quantum: float) -> float:
    return x + e if e == e else quantum * round(x / quantum)


def _open(
    slider: Slider, t: Array, plan: Array, noise: Array, e: Array, quantum: float
) -> tuple[Array, Array]:
    x = v = 0.0
    h = t[1]
    out = np.empty(len(t))
    for k in range(len(t)):
        out[k] = _read(x, e[k], quantum)
        force = plan[max(k - slider.delay, 0)] * (slider.gain(x, t[k]) if slider.gain else 1.0)
        x, v = slider.moved(x, v, force + noise[k], h, t[k])
    return out, plan


def _loop(
    slider: Slider, rng: np.random.Generator, t: Array, plan: Array, noise: Array, e: Array, quantum: float
) -> tuple[Array, Array]:
    """A position loop along a path that the plan would make of the slider, smoothed."""
    h = t[1]
    path, _ = _open(Slider(slider.mass, slider.damping, slider.minus, slider.plus), t, plan, 0 * t, 0 * t, 1)
    width = max(int(0.03 / h), 3)
    path = np.convolve(np.pad(path, width, mode="edge"), np.ones(width) / width, mode="same")[width:-width]
    w = 2 * np.pi * min(rng.uniform(3, 10), 1 / (25 * h))
    stiff, brake = slider.mass * w**2, 1.4 * slider.mass * w
    x, v = float(path[0]), 0.0
    before = x
    goal = path[0]
    out, drive = np.empty(len(t)), np.empty(len(t))
    for k in range(len(t)):
        read = _read(x, e[k], quantum)
        speed = (path[k] - goal) / h - (read - before) / h
        drive[k] = stiff * (path[k] - read) + brake * speed
        before, goal = read, path[k]
        out[k] = read
        force = drive[max(k - slider.delay, 0)] * (slider.gain(x, t[k]) if slider.gain else 1.0)
        x, v = slider.moved(x, v, force + noise[k], h, t[k])
    return out, drive


def _ripple(s: Slider, rng: np.random.Generator, scale: tuple[float, float]) -> None:
    a, length = scale[0] * rng.uniform(0.05, 0.15), float(np.exp(rng.uniform(np.log(4e-3), np.log(3e-2))))
    s.force = lambda x, _v, _t: a * math.sin(2 * math.pi * x / length + 1)
    s.name, s.numbers = "position_ripple", {"a": a, "L": length}


def _asymmetry(s: Slider, rng: np.random.Generator, _: tuple[float, float]) -> None:
    c = s.damping * rng.uniform(0.15, 0.4) * rng.choice([-1, 1])
    s.force = lambda _x, v, _t: -c * abs(v)
    s.name, s.numbers = "viscous_asymmetry", {"c": c}


def _peak(s: Slider, rng: np.random.Generator, _: tuple[float, float]) -> None:
    rise, speed = rng.uniform(0.2, 0.5), rng.uniform(0.01, 0.04)
    s.share = lambda _x, v, _t: 1 + rise * math.exp(-((v / speed) ** 2))
    s.name, s.numbers = "stribeck_peak", {"dT": rise * 0.5 * (s.minus + s.plus), "v_s": speed}


def _late(s: Slider, rng: np.random.Generator, scale: tuple[float, float]) -> None:
    s.delay = int(rng.integers(1, 4))
    s.name, s.numbers = "drive_delay", {"delay": s.delay / scale[1]}


def _load(s: Slider, rng: np.random.Generator, scale: tuple[float, float]) -> None:
    k = scale[0] * rng.uniform(0.1, 0.4)
    s.force = lambda x, _v, _t: -k * x
    s.name, s.numbers = "position_load", {"k": k}


def _harmonic(s: Slider, rng: np.random.Generator, scale: tuple[float, float]) -> None:
    a, w = scale[0] * rng.uniform(0.04, 0.15), 2 * math.pi * rng.uniform(3, 15)
    s.force = lambda _x, _v, t: a * math.sin(w * t + 0.4)
    s.name, s.numbers = "harmonic_forcing", {"a": a, "w": w}


def _wearing(s: Slider, rng: np.random.Generator, _: tuple[float, float]) -> None:
    r = rng.uniform(0.004, 0.015) * rng.choice([-1, 1])
    s.share = lambda _x, _v, t: 1 + r * t
    s.name, s.numbers = "friction_drift", {"r": r}


def _heavy(s: Slider, rng: np.random.Generator, _: tuple[float, float]) -> None:
    s.name, s.numbers = "rig_mass", {"e": float(rng.uniform(0.08, 0.2))}


PLANTED = {
    "position_ripple": _ripple,
    "viscous_asymmetry": _asymmetry,
    "stribeck_peak": _peak,
    "drive_delay": _late,
    "position_load": _load,
    "harmonic_forcing": _harmonic,
    "friction_drift": _wearing,
    "rig_mass": _heavy,
}


def write(drawn: Drawn, folder: Path) -> Path:
    """The case as files; the first half is trained on."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = np.column_stack([drawn.t, drawn.x, drawn.drive])
    np.savetxt(folder / "run.csv", rows, fmt="%.12g", delimiter=",", header="t,x,F", comments="")
    half = float(0.5 * (drawn.t[-1] + drawn.t[1]))
    mass = drawn.declared / (1 + drawn.slider.numbers.get("e", 0.0))
    (folder / "rig.toml").write_text(
        f"""title = "a slider"
[rig]
kind = "driven_slider"
m = {mass!r}
[friction]
kind = "coulomb"
[[run]]
file = "run.csv"
role = "train"
to = {half!r}
[[run]]
file = "run.csv"
role = "validate"
from = {half!r}
[channels]
t = {{ column = "t", unit = "s" }}
x1 = {{ column = "x", unit = "m" }}
drive = {{ column = "F", unit = "N" }}
"""
    )
    return folder / "rig.toml"
