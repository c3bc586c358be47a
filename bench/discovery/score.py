"""Score discovery reports against the truth of their cases.

    python bench/discovery/score.py CASES REPORTS [--json FILE] [--markdown FILE]

CASES holds answers.json; REPORTS holds for each case a folder with report.json (and outcome.json, if `run.py`
made it: seconds, exit code, last words). A case without a report counts as failed in every share it belongs
to. Shares carry 95 % Wilson intervals. "Named" means that the effect stands in the report's list; "tied"
figures also accept an alternative that the report declares inseparable from the one it names.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.console import Console
from rich.table import Table
from truths import LISTED, MISDECLARED, UNLISTED, kind

Head = tuple[Sequence[str], Sequence[Sequence[str]]]
NAMED = LISTED | MISDECLARED
LAW_NAMES = {
    "T_s_minus": "Ts_m",
    "A1": "A1",
    "A2": "A2",
    "t1": "t1",
    "t2": "t2",
    "T_min_minus": "Tmin_m",
    "T_s_plus": "Ts_p",
    "T_min_plus": "Tmin_p",
}


@dataclass(frozen=True)
class Line:
    """One number of the table with what is asked of it."""

    what: str
    value: float
    low: float
    high: float
    count: int
    target: str
    met: bool | None


@dataclass
class Scored:
    """One case: truth beside what was reported."""

    case: str
    group: str
    conditions: str
    truth: list[str]
    verdict: str = ""
    named: list[str] = field(default_factory=list)
    tied: list[list[str]] = field(default_factory=list)
    place_right: bool = False
    variable_right: bool = False
    before: float = math.nan
    after: float = math.nan
    floor: float = math.nan
    chi2: float = math.nan
    covered: dict[str, bool] = field(default_factory=dict)
    law_covered: dict[str, bool] = field(default_factory=dict)
    seconds: float = math.nan
    why: str = ""

    @property
    def ratio(self) -> float:
        """Error after over error before."""
        return self.after / self.before if self.before > 0 else math.nan

    def first(self, *, ties: bool) -> bool:
        """The first effect of the report is one that acts."""
        if not self.named:
            return False
        return bool(({self.named[0]} | (set(self.tied[0]) if ties else set())) & set(self.truth))

    def exact(self, *, ties: bool) -> bool:
        """The list is the truth's, order apart."""
        if not self.verdict or len(self.named) != len(self.truth):
            return False
        return self.both(ties=ties)

    def both(self, *, ties: bool) -> bool:
        """Every effect that acts is named, each by a line of its own."""
        lines = [{n} | (set(t) if ties else set()) for n, t in zip(self.named, self.tied, strict=True)]
        return _matched(self.truth, lines)


def _matched(names: Sequence[str], lines: Sequence[set[str]]) -> bool:
    """Whether every name finds a line of its own."""
    if not names:
        return True
    return any(
        names[0] in line and _matched(names[1:], [*lines[:i], *lines[i + 1 :]])
        for i, line in enumerate(lines)
    )


def wilson(hits: int, count: int, z: float = 1.96) -> tuple[float, float]:
    """95 % Wilson interval of a share."""
    if count == 0:
        return math.nan, math.nan
    p, d = hits / count, 1 + z * z / count
    middle, half = p + z * z / (2 * count), z * math.sqrt(p * (1 - p) / count + z * z / (4 * count**2))
    return max(0.0, (middle - half) / d), min(1.0, (middle + half) / d)


def group_of(answer: dict[str, Any]) -> str:
    """Class of a case, from its effects where answers.json does not say."""
    if "class" in answer:
        return str(answer["class"])
    names = [e["name"] for e in answer["effects"]]
    if any(n not in NAMED for n in names):
        return "unlisted"
    return ("none", "single", "pair")[min(len(names), 2)]


def inside(interval: dict[str, Any], truth: float, *, unsigned: bool = False) -> bool:
    """Whether a reported interval holds the truth; a limit that is null is open."""
    low = -math.inf if interval.get("low") is None else float(interval["low"])
    high = math.inf if interval.get("high") is None else float(interval["high"])
    return low <= truth <= high or (unsigned and low <= -truth <= high)


def _coverage(
    scored: Scored, truth: Sequence[dict[str, Any]], report: dict[str, Any], law: dict[str, float]
) -> None:
    for effect in truth:
        found = next((e for e in report["effects"] if e["name"] == effect["name"]), None)
        if found is None or effect["name"] not in NAMED:
            continue
        phased = bool(kind(effect["name"]).phase)  # a sign of the amplitude is half a turn of the phase
        for name, value in effect["parameters"].items():
            if name in found["parameters"] and name != "phi":
                unsigned = phased and name == "a"
                key = f"{effect['name']}.{name}"
                scored.covered[key] = inside(found["parameters"][name], value, unsigned=unsigned)
    if scored.exact(ties=False) and group_of({"effects": truth}) != "unlisted":
        for name, interval in (report.get("law") or {}).items():
            if (true := law.get(LAW_NAMES.get(name, name))) is not None:
                scored.law_covered[name] = inside(interval, true)


def _place(scored: Scored, truth: Sequence[dict[str, Any]], report: dict[str, Any]) -> None:
    """Place and variable of an unlisted effect: at least one right, none wrong."""
    if not truth or truth[0]["name"] not in UNLISTED:
        return
    what = kind(truth[0]["name"])
    found = next((e for e in report["effects"] if e["name"] == "unlisted"), None)
    if found is not None:
        variables = set(found.get("depends_on") or ())
        scored.place_right = found.get("where") in {what.where, *what.also_where}
        scored.variable_right = bool(variables & {*what.depends_on, *what.also_depends_on}) and (
            variables <= {*what.depends_on, *what.also_depends_on}
        )


def score_case(answer: dict[str, Any], folder: Path) -> Scored:
    """Compare one report with the truth."""
    names = [e["name"] for e in answer["effects"]]
    scored = Scored(answer["case"], group_of(answer), str(answer.get("conditions", "ordinary")), names)
    outcome = folder / "outcome.json"
    if outcome.exists():
        told = json.loads(outcome.read_text())
        scored.seconds, scored.why = float(told["seconds"]), str(told.get("said", ""))
    file = folder / "report.json"
    if not file.exists():
        scored.why = scored.why or "no report.json"
        return scored
    report = json.loads(file.read_text())
    scored.verdict = str(report["verdict"])
    for effect in report["effects"]:
        if effect["name"] in answer.get("beyond", ()):  # a constant that is as far off as a finding must be
            continue
        scored.named.append(str(effect["name"]))
        rivals = effect.get("alternatives") or []
        scored.tied.append([str(a["name"]) for a in rivals if a.get("tied", True)])
    error = report.get("error") or {}
    for name in ("before", "after", "floor"):
        setattr(scored, name, math.nan if error.get(name) is None else float(error[name]))
    chi2 = (report.get("residual_after") or {}).get("chi2")
    scored.chi2 = math.nan if chi2 is None else float(chi2)
    if math.isnan(scored.seconds) and report.get("seconds") is not None:
        scored.seconds = float(report["seconds"])
    _coverage(scored, answer["effects"], report, answer.get("law") or answer.get("rig", {}))
    _place(scored, answer["effects"], report)
    return scored


def score(cases: Path, reports: Path) -> list[Scored]:
    """Every case of answers.json, in its order."""
    answers = json.loads((cases / "answers.json").read_text())["cases"]
    return [score_case(a, reports / a["case"]) for a in answers]


def _share(what: str, hits: Iterable[bool], target: float | None, most: float | None = None) -> Line:
    values = list(hits)
    n, k = len(values), sum(values)
    p = k / n if n else math.nan
    low, high = wilson(k, n)
    said = "" if target is None else (f">= {target:.0%}" if most is None else f"{target:.0%} to {most:.0%}")
    met = None if target is None or not n else p >= target and (most is None or p <= most)
    return Line(what, p, low, high, n, said, met)


def _number(what: str, values: Iterable[float], summary: Callable[[Any], Any], target: float | None) -> Line:
    known = np.array([v for v in values if math.isfinite(v)])
    value = float(summary(known)) if known.size else math.nan
    said = "" if target is None else f"<= {target:g}"
    met = None if target is None or not known.size else value <= target
    low, high = (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)
    return Line(what, value, low, high, int(known.size), said, met)


def table(scored: Sequence[Scored]) -> list[Line]:
    """The numbers that are asked of the loop."""
    by = {g: [s for s in scored if s.group == g] for g in ("single", "none", "pair", "unlisted", "odd")}
    acting = [s for s in scored if s.truth and s.group != "odd"]
    listed = by["single"] + by["pair"]
    lines = [
        _share("single: named first", (s.first(ties=False) for s in by["single"]), 0.95),
        _share("single: first or tied with it", (s.first(ties=True) for s in by["single"]), None),
        _share("single: exactly the right list", (s.exact(ties=False) for s in by["single"]), 0.90),
        _share("single: right list, ties allowed", (s.exact(ties=True) for s in by["single"]), None),
        _share("none: nothing named", (s.verdict == "no_effect" for s in by["none"]), 0.95),
        _share("two: both named", (s.both(ties=False) for s in by["pair"]), 0.80),
        _share("two: both named, ties allowed", (s.both(ties=True) for s in by["pair"]), None),
        _share("two: exactly the right list", (s.exact(ties=False) for s in by["pair"]), None),
        _share("outside the list: unlisted", (s.verdict == "unlisted_effect" for s in by["unlisted"]), 0.80),
        _share(
            "outside: unlisted, place and variable right",
            (s.verdict == "unlisted_effect" and s.place_right and s.variable_right for s in by["unlisted"]),
            0.80,
        ),
        _share("outside: place right", (s.place_right for s in by["unlisted"]), None),
        _share("unusual conditions: right list, ties allowed", (s.exact(ties=True) for s in by["odd"]), None),
        _number("error after/before, median (effects act)", (s.ratio for s in acting), np.median, 0.1),
        _number("error after/before, largest (all cases)", (s.ratio for s in scored), np.max, 1.02),
        _number(
            "error after/floor, median", (s.after / s.floor for s in acting if s.floor > 0), np.median, None
        ),
        _number("chi-squared per sample after, median (listed)", (s.chi2 for s in listed), np.median, None),
        _number("chi-squared per sample after, largest (listed)", (s.chi2 for s in listed), np.max, 1.05),
        _share("chi-squared at most 1.05 (listed)", (s.chi2 <= 1.05 for s in listed), None),
        _share("intervals cover: effects", (c for s in scored for c in s.covered.values()), 0.90, 0.99),
        _share("intervals cover: friction law", (c for s in scored for c in s.law_covered.values()), None),
        _number("seconds a case, median", (s.seconds for s in scored), np.median, None),
        _number("seconds a case, largest", (s.seconds for s in scored), np.max, 60.0),
        _share("a report was written", (bool(s.verdict) for s in scored), None),
    ]
    return [line for line in lines if line.count]


def _figure(line: Line, value: float) -> str:
    share = ">= " in line.target or " to " in line.target or line.what.split(":")[0] in {
        "single", "two", "outside", "none", "unusual conditions", "outside the list", "intervals cover",
        "chi-squared at most 1.05 (listed)", "a report was written",
    }  # fmt: skip
    return f"{value:.1%}" if share else f"{value:.4g}"


def rows_of(lines: Sequence[Line]) -> list[list[str]]:
    rows = []
    for line in lines:
        spread = f"{_figure(line, line.low)} .. {_figure(line, line.high)}"
        mark = {None: "", True: "met", False: "missed"}[line.met]
        rows.append([line.what, _figure(line, line.value), spread, str(line.count), line.target, mark])
    return rows


HEAD = ["what", "value", "95 % or range", "n", "asked", ""]


def wrong(scored: Sequence[Scored]) -> list[list[str]]:
    """The cases whose list is not the truth's, with what was said instead."""
    rows = []
    for s in scored:
        fine = s.exact(ties=False) if s.group != "unlisted" else s.place_right and s.variable_right
        if not fine:
            truth, said = "+".join(s.truth) or "none", "+".join(s.named) or s.verdict or s.why[-90:]
            ties = ", ".join(sorted({t for tied in s.tied for t in tied}))
            rows.append([s.case, s.conditions, truth, said, ties, f"{s.chi2:.3f}", f"{s.ratio:.3f}"])
    return rows


WRONG_HEAD = ["case", "conditions", "truth", "said", "tied with", "chi2", "after/before"]


def markdown(lines: Sequence[Line], scored: Sequence[Scored], more: Head | None = None) -> str:
    """The tables as Markdown."""

    def one(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
        return [f"| {' | '.join(r)} |" for r in (head, ["---"] * len(head), *rows)]

    text = [*one(HEAD, rows_of(lines)), "", "Not exact:", "", *one(WRONG_HEAD, wrong(scored)), ""]
    if more and more[1]:
        text += ["Forecast error on the validate runs, median:", "", *one(*more), ""]
    return "\n".join(text)


def show(console: Console, title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print one table."""
    drawn = Table(*head, title=title)
    for row in rows:
        drawn.add_row(*row)
    console.print(drawn)


def write(
    lines: Sequence[Line],
    scored: Sequence[Scored],
    as_json: Path | None,
    as_text: Path | None,
    more: Head | None = None,
) -> None:
    """Write what was asked for; ``more`` is a further table (head, rows)."""
    if as_json:
        data = {
            "table": [asdict(line) for line in lines],
            "cases": [asdict(s) for s in scored],
            "methods": more,
        }
        as_json.write_text(json.dumps(data, indent=1))
    if as_text:
        as_text.write_text(markdown(lines, scored, more))


@click.command()
@click.argument("cases", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("reports", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--json", "as_json", type=click.Path(path_type=Path))
@click.option("--markdown", "as_text", type=click.Path(path_type=Path))
def main(cases: Path, reports: Path, as_json: Path | None, as_text: Path | None) -> None:
    """Score REPORTS against CASES."""
    scored = score(cases, reports)
    lines = table(scored)
    console = Console(width=None if sys.stdout.isatty() else 150)
    show(console, "Discovery", HEAD, rows_of(lines))
    show(console, "Not exact", WRONG_HEAD, wrong(scored))
    write(lines, scored, as_json, as_text)


if __name__ == "__main__":
    main()
