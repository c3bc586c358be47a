"""What an identification says of a rig of bodies or matrices: its laws, how friction scatters, its constants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.scale import percent, to_digits
from stickslip.fitted.constant import Constant
from stickslip.fitted.identified import Estimate, Spread
from stickslip.fitted.saved_result import SavedResult
from stickslip.measured.fit_window import Array
from stickslip.objects import one_line

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, repr=False)
class IdentifiedRig(SavedResult):
    """What `identify` finds on a rig of bodies or matrices; numbers are in SI.

    Attributes
    ----------
    model : Model
        The rig with its constants as fitted, under the laws of the mean event.
    declared : Model
        What the fit started from.
    estimates : mapping of str to Estimate
        Every number of the laws, by its name in `Model.parameters`.
    names, covariance
        Numbers that were fitted, and their (p, p) covariance.
    scatter : mapping of str to Spread
        Relative standard deviations from event to event: "<law>.kinetic", "<law>.static" beside it, "belt".
    constants : mapping of str to Constant
        Constants of the rig and gains of the sensors.
    offsets : mapping of str to Estimate
        Offsets of the sensors that are not exact, by channel: what must be added, as `Channel.offset`, in SI.
    noise : mapping of str to float
        Standard deviation of a reading, by channel.
    reduced_chi2 : float
        Squared residual over noise per degree of freedom: 1 where noise alone remains.
    windows : int
        How many windows were fitted.
    fastest : mapping of str to float
        The fastest slip that the runs show, by contact: beyond, the law is not known.
    messages : tuple of str
        Sentences a person should read.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> pin = ss.MatricesRig(M=[[0.5]], C=[[0.4]], K=[[800]], contact=[1], names=["x"])  # kg, N s/m, N/m
    >>> law = ss.CoulombFriction(static=4.0, kinetic=2.0)  # N
    >>> t = np.arange(0, 2, 0.002)
    >>> run = ss.simulate(ss.Model(pin, friction=law), belt_speed=0.05, initial=(0, 0.05), t_end=2, t_eval=t)
    >>> x = run.x + 1e-5 * np.random.default_rng(0).standard_normal(t.size)  # m
    >>> recording = ss.load_recording({"t": t, "x": x}, pin, belt_speed=0.05, noise={"x": 1e-5})
    >>> found = ss.identify(recording, friction=law)
    >>> print(f"{found.estimates['kinetic'].value:.2f} N from {found.windows} windows")
    2.00 N from 10 windows
    """

    model: Model
    declared: Model
    estimates: Mapping[str, Estimate]
    names: tuple[str, ...]
    covariance: Array
    scatter: Mapping[str, Spread]
    constants: Mapping[str, Constant]
    noise: Mapping[str, float]
    reduced_chi2: float
    windows: int
    fastest: Mapping[str, float]
    messages: tuple[str, ...] = ()
    offsets: Mapping[str, Estimate] = field(default_factory=dict)

    def __repr__(self) -> str:
        laws = ", ".join(f"{name} {law.kind}".strip() for name, law in self.laws.items())
        return one_line(
            f"<IdentifiedRig: {laws}; {self.windows} windows, chi2 per degree of freedom {self.reduced_chi2:.3g}>"
        )

    def __str__(self) -> str:
        return self.summary()

    @property
    def law(self) -> FrictionLaw:
        """The identified law, or the laws by their names."""
        return self.model.friction

    @property
    def wrong(self) -> tuple[str, ...]:
        """Constants and gains that are not as declared: whole intervals lie beyond three standard uncertainties."""
        return tuple(name for name, one in self.constants.items() if one.beyond)

    @property
    def laws(self) -> dict[str, FrictionLaw]:
        """The laws by name; "" of the only one."""
        law = self.model.friction
        return dict(law.laws) if isinstance(law, ContactLaws) else {"": law}

    def table(self) -> list[dict[str, str]]:
        """What was found as it is printed: a dictionary of cells for each number, by the head of its column."""
        rows = []
        for name, e in self.estimates.items():
            rows.append(_row(name, e.value, e.low, e.high, e.declared, e.status))
        for name, s in self.scatter.items():
            span = f"{percent(s.low)} .. {percent(s.high)}"
            cells = {"parameter": f"scatter of {name}", "value": percent(s.value), "95 % interval": span}
            rows.append({**cells, "declared": "", "status": ""})
        for name, c in self.constants.items():
            status = "not as declared" if c.beyond else "as declared"
            rows.append(_row(name, c.value, c.low, c.high, c.declared, status))
        for name, e in self.offsets.items():
            rows.append(_row(f"offset.{name}", e.value, e.low, e.high, e.declared, e.status))
        return rows

    def summary(self) -> str:
        """The table as plain text, with the messages below."""
        rows = self.table()
        wide = {head: max(len(head), *(len(row[head]) for row in rows)) for head in rows[0]}
        lines = [
            "  ".join(cell.ljust(wide[head]) for head, cell in row.items()).rstrip()
            for row in ({head: head for head in wide}, *rows)
        ]
        lines.append(f"chi2 per degree of freedom: {self.reduced_chi2:.4g}, {self.windows} windows")
        return "\n".join([*lines, *self.messages])

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each number of the laws: the fields of its `Estimate`."""
        import pandas as pd  # slow to import

        return pd.DataFrame([vars(one) for one in self.estimates.values()], index=list(self.estimates))

    def to_dict(self) -> dict[str, object]:
        """All numbers, for JSON."""
        return {
            "estimates": {name: vars(one) for name, one in self.estimates.items()},
            "names": list(self.names),
            "covariance": self.covariance.tolist(),
            "scatter": {name: asdict(one) for name, one in self.scatter.items()},
            "declared": {name: asdict(one) for name, one in self.constants.items()},
            "offsets": {name: vars(one) for name, one in self.offsets.items()},
            "wrong": list(self.wrong),
            "noise": dict(self.noise),
            "reduced_chi2": self.reduced_chi2,
            "windows": self.windows,
            "fastest": dict(self.fastest),
            "messages": list(self.messages),
        }


def _row(
    name: str, value: float, low: float | None, high: float | None, declared: float | None, status: str
) -> dict[str, str]:
    half = max((abs(x - value) for x in (low, high) if x is not None), default=None)
    span = "-" if low is None or high is None else f"{to_digits(low, half)} .. {to_digits(high, half)}"
    own = "" if declared is None else f"{declared:.4g}"
    return {
        "parameter": name,
        "value": to_digits(value, half),
        "95 % interval": span,
        "declared": own,
        "status": status,
    }
