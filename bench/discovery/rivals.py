"""Other methods on the same cases and split: sparse regression of the discrepancy, and a black box.

- *SINDy, ensemble*: accelerations from a smoothing filter; what the declared model leaves of them (for the
  block while it slips) is regressed on polynomials and damping terms with pysindy's optimisers.
- *SINDy, weak*: the same library, integrated against compact test functions; no second derivative is taken.
- *MLP*: a network that continues both readings from their last stretch, trained on the same runs.

All are judged by `forecast_error`: forecasts over one and two cycles from many instants of the validate runs,
root mean square over the reading's standard deviation. The sparse models are integrated with the declared law,
given to them as our own fit left it (model_before.toml) where there is one, Table 1 otherwise.
"""

from __future__ import annotations

import tomllib
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pysindy
from numpy.typing import NDArray
from records import Array, Record, Recorded, read_case
from scipy.signal import savgol_filter
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

TABLE_1 = {
    "T_s_minus": 5.94, "A1": 3.2345, "A2": 2.8736, "t1": 0.0342, "t2": 0.3053, "v_w_min": -0.28,
    "T_min_minus": 1.42, "T_s_plus": 3.63, "T_min_plus": 0.86, "v_w_max": 0.27,
}  # fmt: skip
SPAN = 31  # samples of the smoothing filter, about 1.2 time units
Forecast = Callable[[Record, int, int], Array]
"""(run, first sample, samples) -> (samples, 2) readings; may use the run before the first sample only."""


@dataclass(frozen=True)
class Judged:
    """What one method made of one case."""

    method: str
    named: str
    one_cycle: float
    two_cycles: float


def magnitude(law: dict[str, float], v: Array) -> Array:
    """R(|v|) by the sign of v, (4.1)-(4.3) with magnitudes."""
    u, low = np.abs(v), -law["v_w_min"]
    fall = law["A1"] * np.exp((u - low) / law["t1"]) + law["A2"] * np.exp((u - low) / law["t2"])
    minus = np.maximum(law["T_min_minus"], law["T_s_minus"] - fall)
    slope = (law["T_s_plus"] - law["T_min_plus"]) / law["v_w_max"]
    return np.where(v < 0, minus, np.maximum(law["T_min_plus"], law["T_s_plus"] - slope * u))


def cycle(run: Record) -> int:
    """Samples of one cycle, from the strongest line of x1."""
    x = run.x1 - run.x1.mean()
    power = np.abs(np.fft.rfft(x * np.hanning(x.size), 8 * x.size)) ** 2
    first = 8 * 3
    return int(8 * x.size / (first + int(np.argmax(power[first:]))) + 0.5)


def forecast_error(case: Recorded, forecast: Forecast, cycles: int, windows: int = 1000) -> float:
    """Windowed forecast error on the validate runs; failed forecasts count as the mean's own error, 1."""
    total, weight = 0.0, 0
    for run in (r for r in case.runs if r.role == "validate"):
        length, horizon = cycle(run), cycles * cycle(run)
        places = range(2 * length + SPAN, run.t.size - horizon, max(length, 1))
        for first in places[:: max(1, len(places) // windows)][:windows]:
            made = forecast(run, first, horizon)
            for i, channel in enumerate((run.x1, run.y1)):
                miss = made[:, i] - channel[first : first + horizon]
                square = float(np.mean(miss**2)) / float(np.var(channel))
                total, weight = total + (min(square, 1.0) if np.isfinite(square) else 1.0), weight + 1
    return float(np.sqrt(total / weight)) if weight else float("nan")


def floor(case: Recorded) -> float:
    """The same error with only the noise left."""
    variances = [np.var(c) for r in case.runs if r.role == "validate" for c in (r.x1, r.y1)]
    noise = case.noise if case.noise is not None else estimated_noise(case)
    return float(np.sqrt(np.mean([noise**2 / v for v in variances])))


def estimated_noise(case: Recorded) -> float:
    """Standard deviation of the noise, from third differences."""
    differences = np.concatenate([np.diff(r.x1, 3) for r in case.runs])
    return float(np.median(np.abs(differences)) / 0.6745 / np.sqrt(20.0))


EXPONENTS = np.array([p for p in np.ndindex(4, 4, 4, 4) if sum(p) <= 3])
STATES = ("x1", "x2", "y1", "y2")


def library(states: Array) -> Array:
    """Polynomials up to the third degree and quadratic damping; (n, 4) -> (n, terms)."""
    powers = np.stack([np.ones_like(states), states, states**2, states**3])
    columns = [powers[e, :, i] for i, e in enumerate(EXPONENTS.T)]
    return np.hstack([np.prod(columns, axis=0).T, states * np.abs(states)])


def terms() -> list[str]:
    """Names of the library's terms."""
    power = {1: "", 2: "^2", 3: "^3"}
    names = [
        " ".join(v + power[e] for v, e in zip(STATES, row, strict=True) if e) or "1" for row in EXPONENTS
    ]
    return names + [f"{v}|{v}|" for v in STATES]


NAMES = {
    ("block", "x2"): "block_viscous_damping",
    ("block", "x2|x2|"): "block_quadratic_damping",
    ("block", "x1^3"): "spring_cubic_k1",
    ("block", "1"): "constant_load",
    ("angle", "y1^3"): "spring_cubic_k3",
}


@dataclass
class Sparse:
    """A sparse model of the discrepancy: coefficients for both bodies."""

    rig: dict[str, float]
    law: dict[str, float]
    block: Array
    angle: Array

    def named(self) -> str:
        """The catalogue's name for the heaviest term, or the term itself."""
        names = terms()
        size = np.concatenate([np.abs(self.block), np.abs(self.angle)])
        if not size.any():
            return "none"
        best = int(np.argmax(size))
        place, term = ("block", "angle")[best // len(names)], names[best % len(names)]
        return NAMES.get((place, term), f"{place}: {term}")

    def rates(self, s: Array, vb: float, mode: int) -> Array:
        """Right-hand side for one state."""
        values = library(s[None, :])[0]
        fb, fa = float(values @ self.block), float(values @ self.angle)
        g, (x1, x2, y1, y2) = self.rig, s
        friction = mode * float(
            magnitude(self.law, np.array(mode * max(mode * (x2 - vb), 0.0) or mode * 1e-12))
        )
        block = -x1 + (fb - g["eta1"] * (x2 + y2) - y1 - friction) / g["alpha1"] if mode else 0.0
        return np.array(
            [x2, block, y2, (fa - g["beta3"] * y1 - g["eta12"] * y2 - x1 - g["eta1"] * x2) / g["alpha2"]]
        )

    def held(self, s: Array, vb: float) -> int:
        """Mode of a block at rest on the belt."""
        fb = float(library(s[None, :])[0] @ self.block)
        q = self.rig["alpha1"] * s[0] + self.rig["eta1"] * (vb + s[3]) + s[2] - fb
        return -1 if q > self.law["T_s_minus"] else (1 if q < -self.law["T_s_plus"] else 0)

    def forecast(self, run: Record, first: int, samples: int) -> Array:
        """Integrate from a local fit of the last readings, a step a sample."""
        past = slice(first - SPAN // 2, first)
        since = run.t[past] - run.t[first]
        s = np.empty(4)
        for i, channel in enumerate((run.x1, run.y1)):
            s[2 * i + 1], s[2 * i] = np.polyfit(since, channel[past], 2)[1:]
        vb, out = run.belt_speed, np.full((samples, 2), np.nan)
        mode = self.held(s, vb) if abs(s[1] - vb) < 0.02 else int(np.sign(s[1] - vb))
        for i in range(samples):
            out[i] = s[0], s[2]
            h = float(run.t[first + i + 1] - run.t[first + i]) if first + i + 1 < run.t.size else 0.0
            k1 = self.rates(s, vb, mode)
            k2 = self.rates(s + h * k1, vb, mode)
            s = s + 0.5 * h * (k1 + k2)
            if not np.all(np.abs(s) < 10.0):
                break
            if mode == 0:
                mode, s[1] = self.held(s, vb), vb
            elif (s[1] - vb) * mode < 0:
                s[1] = vb
                mode = self.held(s, vb)
        return out


def law_of(reports: Path | None) -> dict[str, float]:
    """The declared law as fitted, or Table 1."""
    if reports is None or not (reports / "model_before.toml").exists():
        return TABLE_1
    told = tomllib.loads((reports / "model_before.toml").read_text()).get("friction", {})
    return TABLE_1 | {k: float(v) for k, v in told.items() if k in TABLE_1}


@dataclass(frozen=True)
class Balance:
    """One body's discrepancy in one run: ``second'' + first' + rest`` of the readings, and where it is used."""

    second: Array
    first: Array
    rest: Array
    keep: NDArray[np.bool_]
    states: Array
    step: float

    def strong(self) -> Array:
        """With the filter's derivatives."""
        total = np.zeros_like(self.rest)
        for order, part in enumerate((self.rest, self.first, self.second)):
            total += savgol_filter(part, SPAN, 4, order, delta=self.step)
        return total

    def weak(self, theta: Array, width: int = 41) -> tuple[Array, Array]:
        """Rows of the library and of the discrepancy integrated against (1 - u^2)^4: by parts, no derivative."""
        u, half = np.linspace(-1, 1, width), 0.5 * (width - 1) * self.step
        bump = 1 - u**2
        w = bump**4
        w1 = -8 * u * bump**3 / half
        w2 = (-8 * bump**3 + 48 * u**2 * bump**2) / half**2
        places = range(0, self.rest.size - width, width // 4)
        starts = [i for i in places if self.keep[i : i + width].all()]
        rows = np.array([w @ theta[i : i + width] for i in starts]).reshape(-1, theta.shape[1])
        sides = ((self.second, w2), (self.first, -w1), (self.rest, w))
        goal = np.array([sum(k @ part[i : i + width] for part, k in sides) for i in starts])
        return rows / w.sum(), goal / w.sum()


def balances(case: Recorded, law: dict[str, float]) -> tuple[list[Balance], list[Balance]]:
    """(2.1) for block and angle body in every training run; the block only where it clearly slips."""
    g, block, angle = case.rig, [], []
    for run in (r for r in case.runs if r.role == "train"):
        h, x, y = float(np.median(np.diff(run.t))), run.x1, run.y1
        states = np.column_stack([savgol_filter(c, SPAN, 4, d, delta=h) for c in (x, y) for d in (0, 1)])
        v = states[:, 1] - run.belt_speed
        friction = np.sign(v) * magnitude(law, v)
        slips = np.abs(v) > 0.04
        rest = g["alpha1"] * x + y + friction
        block.append(Balance(g["alpha1"] * x, g["eta1"] * (x + y), rest, slips, states, h))
        first, always = g["eta12"] * y + g["eta1"] * x, np.ones(x.size, dtype=bool)
        angle.append(Balance(g["alpha2"] * y, first, g["beta3"] * y + x, always, states, h))
    return block, angle


def sindy(case: Recorded, law: dict[str, float], flavour: str) -> Sparse:
    """Fit the discrepancy: ``flavour`` is "ensemble" or "weak"."""
    found = []
    for body in balances(case, law):
        pieces = []
        for one in body:
            theta = library(one.states)
            strong = (theta[one.keep], one.strong()[one.keep])
            pieces.append(one.weak(theta) if flavour == "weak" else strong)
        rows, goal = np.concatenate([p[0] for p in pieces]), np.concatenate([p[1] for p in pieces])
        size = np.maximum(np.sqrt(np.mean(rows**2, 0)), 1e-12)  # a threshold on forces, not raw coefficients
        optimiser = pysindy.STLSQ(threshold=0.02, alpha=1e-3)
        if flavour == "ensemble":
            optimiser = pysindy.EnsembleOptimizer(opt=optimiser, bagging=True, n_models=20)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            optimiser.fit(rows / size, goal[:, None])
        found.append(np.ravel(optimiser.coef_) / size)
    return Sparse(case.rig, law, *found)


@dataclass
class BlackBox:
    """A network that continues the readings; ``stride`` samples a step, ``memory`` steps back."""

    stride: int = 10
    memory: int = 12

    def fit(self, case: Recorded, seed: int = 0) -> BlackBox:
        rows, goals = [], []
        for run in (r for r in case.runs if r.role == "train"):
            z = np.column_stack([run.x1, run.y1])
            for i in range(self.stride * self.memory, z.shape[0] - self.stride, 2):
                rows.append(self._inputs(z, i, run.belt_speed))
                goals.append(z[i + self.stride] - z[i])
        goal = np.array(goals)
        self.size = goal.std(0)
        net = MLPRegressor(
            hidden_layer_sizes=(96, 96),
            alpha=1e-3,
            learning_rate_init=2e-3,
            max_iter=60,
            tol=0.0,
            random_state=seed,
        )
        self.net = make_pipeline(StandardScaler(), net).fit(np.array(rows), goal / self.size)
        return self

    def _inputs(self, z: Array, i: int, vb: float) -> Array:
        past = z[i - self.stride * self.memory : i + 1 : self.stride]
        return np.concatenate([past[-1], np.diff(past, axis=0).ravel(), [vb]])

    def forecast(self, run: Record, first: int, samples: int) -> Array:
        reach = self.stride * self.memory + 1
        z = np.column_stack([run.x1, run.y1])[max(first - reach, 0) : first]
        z = np.vstack([np.repeat(z[:1], reach - z.shape[0], 0), z])
        steps = [z[-1]]
        grid = z[:: self.stride] if (z.shape[0] - 1) % self.stride == 0 else z[-1 :: -self.stride][::-1]
        history = list(grid)
        for _ in range(samples // self.stride + 2):
            past = np.array(history[-self.memory - 1 :])
            inputs = np.concatenate([past[-1], np.diff(past, axis=0).ravel(), [run.belt_speed]])
            history.append(past[-1] + self.net.predict(inputs[None, :])[0] * self.size)
            steps.append(history[-1])
        made, at = np.array(steps), np.arange(len(steps)) * self.stride
        wanted = np.arange(1, samples + 1)
        return np.column_stack([np.interp(wanted, at, made[:, i]) for i in range(2)])


def judge(folder: Path, report: Path | None, windows: int = 3) -> list[Judged]:
    """All rivals on one case, with the floor of the noise."""
    case, law = read_case(folder), law_of(report)
    still = np.zeros(len(terms()))
    methods: list[tuple[str, str, Forecast]] = []
    declared = Sparse(case.rig, law, still, still)
    methods.append(("declared law alone", "", declared.forecast))
    for flavour in ("ensemble", "weak"):
        model = sindy(case, law, flavour)
        methods.append((f"SINDy, {flavour}", model.named(), model.forecast))
    methods.append(("MLP", "", BlackBox().fit(case).forecast))
    found = [Judged(m, n, *(forecast_error(case, f, c, windows) for c in (1, 2))) for m, n, f in methods]
    return [*found, Judged("noise floor", "", floor(case), floor(case))]
