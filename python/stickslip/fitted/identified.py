"""What an identification says: the law, how sure it is of each number, and what it never saw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, Rig
from stickslip.declared.scale import law_scale, scales, to_digits
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.declared.units import Channel
from stickslip.errors import InputError
from stickslip.fitted.constant import Constant
from stickslip.fitted.saved_result import SavedResult
from stickslip.fitted.shooting import FARTHEST
from stickslip.measured.fit_window import Array
from stickslip.measured.thinning import Thinned
from stickslip.objects import one_line

if TYPE_CHECKING:
    import pandas as pd

Status = Literal["identified", "weak", "unidentified"]
Branch = Literal["minus", "plus"]
BRANCHES: tuple[Branch, ...] = ("minus", "plus")
DRAWS = 4000


@dataclass(frozen=True)
class Estimate:
    """One number of the law with its 95 % interval.

    `status` is "identified", "weak" (the readings say something, yet the standard deviation is above a third of the
    number, or the number leans on the declared start, or stopped at the limit of the search) or "unidentified" (no
    reading depends on it: the value is the declared start). `low` and `high` are None where that side is open: both
    where a number is not known to a factor of 100, one where it stopped at the limit of the search. `declared` is what
    was declared, by a case's file or in the call; None where nobody said anything: then a fit began at the default.
    """

    value: float
    low: float | None
    high: float | None
    std: float | None
    status: Status
    declared: float | None = None


def estimate(value: float, std: float, prior_share: float, start: float) -> Estimate:
    """An `Estimate` with its status; `prior_share` is the start's share of the information."""
    if prior_share >= 0.99:
        return Estimate(start, None, None, None, "unidentified")
    side = stopped(value, start)
    weak = prior_share > 0.1 or std > abs(value) / 3 or side != 0
    low, high = interval(value, std)
    if side:  # what the readings ask for lies beyond
        low, high = (low, None) if side * value > 0 else (None, high)
    return Estimate(value, low, high, std, "weak" if weak else "identified")


def stopped(value: float, start: float) -> int:
    """1 where a number stopped at the most that is searched, -1 at the least, else 0."""
    ratio = value / start if start else 1.0
    return int(ratio >= FARTHEST / 1.001) - int(ratio <= 1.001 / FARTHEST)


def interval(value: float, std: float) -> tuple[float | None, float | None]:
    """95 % limits: even in the logarithm for a positive number, which forces, speeds and amplitudes are."""
    half = SIGMAS_95 * std
    if value <= 0:
        return value - half, value + half
    if half / value >= np.log(FARTHEST**2):  # the whole of what is searched, and more
        return None, None
    factor = float(np.exp(half / value))
    return value / factor, value * factor


@dataclass(frozen=True)
class ForcePoints:
    """Friction force against relative velocity, from the rearranged equation of motion; (n,) arrays.

    `mode` is 0 where the block sticks (there T is the force the belt supplies, -q), else the sign of v_w.
    `T_std` is the standard deviation that the noise leaves in T. `run` numbers the run each point is from.
    """

    v_w: Array
    T: Array
    T_std: Array
    mode: Array
    run: Array


@dataclass(frozen=True)
class Events:
    """Slips fitted one by one; (k,) arrays. Levels are forces in the rig's unit, times in the run's.

    `static` is the breakaway force, `kinetic` the level of sliding at small speed behind it, `amplitude` the
    displacement lost in the slip, `rms` what the fit leaves, `run` the run's number.
    """

    t: Array
    static: Array
    kinetic: Array
    amplitude: Array
    rms: Array
    run: Array

    def levels(self) -> dict[str, float]:
        """Return mean and scatter of the levels, as `diagnostics` name them."""
        out: dict[str, float] = {}
        for name, size in (
            ("static", self.static),
            ("kinetic", self.kinetic),
            ("drop", self.static - self.kinetic),
        ):
            out |= {
                f"{name}_mean": float(size.mean()),
                f"{name}_std_between_events": float(np.std(size, ddof=1)),
            }
        return out


@dataclass(frozen=True)
class Spread:
    """A number of the scatter with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Scatter:
    """
    How friction and belt differ from event to event.

    `static`, `kinetic` and `belt` are relative standard deviations of the static limit, of kinetic friction and of the
    belt's speed. `correlation` is that of one event's kinetic friction with the next one's, `length` the way along the
    belt over which it falls to 1/e, in the rig's unit of x1; None where neighbours are not seen to be alike.
    """

    static: Spread
    kinetic: Spread
    belt: Spread
    correlation: Spread
    length: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Identified(SavedResult):
    """Result of `stickslip.identify`.

    Attributes
    ----------
    rig, law
        The declared rig and the identified friction law; together they are `model`.
    estimates : mapping of str to Estimate
        Every number of the law.
    names, covariance
        Parameters the readings bear on, and their (p, p) covariance.
    covered : mapping
        Per branch ("minus": v_w < 0, "plus": v_w > 0) the range of |v_w| visited in slip, or None.
    noise : mapping of str to float
        Standard deviation of a reading per channel, in the rig's units.
    reduced_chi2 : float
        Squared residual over noise per degree of freedom: 1 where noise alone remains.
    force : ForcePoints or None
        Friction over sliding velocity, point by point, as the figure has it.
    events : Events or None
        Slips of a block on a belt, where friction was fitted event by event.
    scatter : Scatter or None
        How events differ, where they do and the law was fitted with friction of each its own.
    constants : mapping of str to Constant
        Constants and gains that were fitted beside the law, as well known as declared.
    fitted : Model or None
        Rig and law as fitted, where constants were fitted beside the law; else `rig` and `law` are the model.
    diagnostics : mapping of str to float
        What else the fit tells: events, mean levels, their scatter, ...
    messages : tuple of str
        Sentences a person should read.
    thinned : tuple of Thinned
        What was done to runs too long to be fitted reading by reading.
    channels, reading_noise : mapping or None
        Columns and units of the readings, and the noise declared in these units, where a case says so.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)  # kg, N/m
    >>> law = ss.CoulombFriction(static=2.0, kinetic=1.2)  # N
    >>> t = np.arange(0, 6, 0.002)
    >>> run = ss.simulate(ss.Model(rig, friction=law), belt_speed=0.01, t_end=6, t_eval=t)
    >>> x = 1e3 * run.x1 + 1e-3 * np.random.default_rng(0).standard_normal(t.size)  # mm
    >>> channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}
    >>> recording = ss.load_recording({"t": t, "x1": x}, rig, channels=channels, belt_speed=0.01)
    >>> found = ss.identify(recording, rig=rig, friction=law)
    >>> one = found.estimates["static"]
    >>> print(f"{one.low:.2f} N to {one.high:.2f} N")
    2.00 N to 2.00 N
    >>> found.model.save("identified.toml")
    """

    rig: AnyRig
    law: FrictionLaw
    estimates: Mapping[str, Estimate]
    names: tuple[str, ...]
    covariance: Array
    covered: Mapping[Branch, tuple[float, float] | None]
    noise: Mapping[str, float]
    reduced_chi2: float
    force: ForcePoints | None = None
    events: Events | None = None
    scatter: Scatter | None = None
    constants: Mapping[str, Constant] = field(default_factory=dict)
    fitted: Model | None = None
    diagnostics: Mapping[str, float] = field(default_factory=dict)
    messages: tuple[str, ...] = ()
    thinned: tuple[Thinned, ...] = ()
    channels: Mapping[str, Channel] | None = None
    reading_noise: Mapping[str, float] | None = None

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        unseen = f", {len(self.unidentified)} of them unidentified" if self.unidentified else ""
        return one_line(
            f"<Identified: {self.law.kind} law, {len(self.estimates)} numbers{unseen}; "
            f"chi2 per degree of freedom {self.reduced_chi2:.3g}>"
        )

    @property
    def model(self) -> Model:
        """The rig under the identified law; it knows columns and noise where a case declared them."""
        made = self.fitted or Model(self.rig, friction=self.law)
        return Model(
            made.rig,
            friction=made.friction,
            effects=made.effects,
            channels=self.channels,
            noise=self.reading_noise,
            scatter=made.scatter,
        )

    @property
    def unidentified(self) -> tuple[str, ...]:
        """Names of the numbers that no reading depends on: they are the declared start."""
        return tuple(n for n, e in self.estimates.items() if e.status == "unidentified")

    def band(
        self, branch: Branch, u: Array, *, level: float = 0.95, simultaneous: bool = True
    ) -> tuple[Array, Array, Array]:
        """Lower limit, value and upper limit of the kinetic magnitude R(u) on one branch.

        Parameters
        ----------
        branch : "minus" or "plus"
        u : (n,) array
            |v_w|; meaningful inside `covered[branch]`.
        level : float
            Probability that the band holds the true branch.
        simultaneous : bool
            Over all of u at once (the default), or at each u by itself.

        Returns
        -------
        low, value, high : (n,) arrays
            NaN limits on a branch that was never visited.
        """
        sign = -1.0 if branch == "minus" else 1.0
        u = np.asarray(u, dtype=float)
        value = self.law.magnitude(sign * np.maximum(u, 1e-12))
        if self.covered[branch] is None or not self.names:
            return np.full_like(u, np.nan), value, np.full_like(u, np.nan)
        gradient = np.column_stack([self._slope(n, sign, u) for n in self.names])
        root = _root(self.covariance)
        std = np.sqrt(np.sum((gradient @ root) ** 2, axis=1))
        draws = np.random.default_rng(0).standard_normal((root.shape[1], DRAWS))
        z = np.abs(gradient @ root @ draws) / np.where(std > 0, std, 1.0)[:, None]
        largest = z.max(axis=0) if simultaneous else np.abs(draws[0])
        half = float(np.quantile(largest, level)) * std
        return value - half, value, value + half

    def _slope(self, name: str, sign: float, u: Array) -> Array:
        centre = float(self.estimates[name].value)
        h = 1e-5 * (abs(centre) or 0.01)

        def magnitude(value: float) -> Array:
            return self.model.replace(**{name: value}).friction.magnitude(sign * np.maximum(u, 1e-12))

        above = h
        try:
            up = magnitude(centre + h)
        except InputError:  # friction in motion that is as great as the static limit
            up, above = magnitude(centre), 0.0
        return np.asarray((up - magnitude(centre - h)) / (above + h), dtype=float)

    def table(self) -> list[dict[str, str]]:
        """The estimates as they are printed: a dictionary of cells for each number, by the head of its column.

        Values and intervals are in SI for a rig declared in SI; the model's own number then stands beside.
        """
        rows = []
        for name, e in self.estimates.items():
            scale = law_scale(name, self.rig, self.channels)
            sides = [abs(x - e.value) * scale.size for x in (e.low, e.high) if x is not None]
            half = float(np.mean(sides)) if sides else None
            cells = [None if x is None else to_digits(x * scale.size, half) for x in (e.value, e.low, e.high)]
            row = {"parameter": name, "value": str(cells[0]), "95 % interval": _spanned(cells[1], cells[2])}
            if scale.unit != "1":
                row["unit"] = scale.unit
            if scale.unit != "1" and isinstance(self.rig, Rig):
                row["model"] = to_digits(e.value, None if half is None else half / scale.size)
            rows.append({**row, "status": e.status})
        return rows

    def summary(self) -> str:
        """The estimates as a plain-text table, with the messages below."""
        rows = self.table()
        wide = {head: max(len(head), *(len(row[head]) for row in rows)) for head in rows[0]}
        left = ("parameter", "unit", "status")
        lines = [
            "  ".join(
                cell.ljust(wide[head]) if head in left else cell.rjust(wide[head])
                for head, cell in row.items()
            )
            for row in ({head: head for head in wide}, *rows)
        ]
        speed = scales(self.rig, self.channels)["x2"]
        for branch in BRANCHES:
            span_u = self.covered[branch]
            seen = "never visited" if span_u is None else f"|v_w| up to {speed.of(span_u[1], 4)}"
            lines.append(f"branch {'v_w < 0' if branch == 'minus' else 'v_w > 0'}: {seen}")
        lines.append(f"chi2 per degree of freedom: {self.reduced_chi2:.4g}")
        return "\n".join([*lines, *self.messages])

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each number of the law, in the model's own units: the fields of its `Estimate`."""
        import pandas as pd  # slow to import

        return pd.DataFrame([vars(one) for one in self.estimates.values()], index=list(self.estimates))

    def to_dict(self) -> dict[str, object]:
        """All numbers, for JSON."""
        events = None
        if self.events is not None:
            events = {k: np.asarray(v).tolist() for k, v in vars(self.events).items()}
        return {
            "law": type(self.law).__name__,
            "estimates": {n: vars(e) for n, e in self.estimates.items()},
            "covered": {b: self.covered[b] for b in BRANCHES},
            "unidentified": list(self.unidentified),
            "names": list(self.names),
            "covariance": self.covariance.tolist(),
            "noise": dict(self.noise),
            "reduced_chi2": self.reduced_chi2,
            "diagnostics": dict(self.diagnostics),
            "messages": list(self.messages),
            "thinned": [{**vars(one), "how": one.how.value} for one in self.thinned],
            "events": events,
            "scatter": None if self.scatter is None else asdict(self.scatter),
            "declared": {name: asdict(one) for name, one in self.constants.items()},
        }


def _spanned(low: str | None, high: str | None) -> str:
    """An interval, open or not, in words."""
    if low is None or high is None:
        return "-" if low == high else f"above {low}" if high is None else f"below {high}"
    return f"{low} .. {high}"


def _root(covariance: Array) -> Array:
    """A matrix whose product with its transpose is the covariance (which may be singular)."""
    w, V = np.linalg.eigh(0.5 * (covariance + covariance.T))
    return np.asarray(V * np.sqrt(np.maximum(w, 0.0)), dtype=float)
