"""The files of a report, known before anything that draws them is loaded."""

from __future__ import annotations

from pathlib import Path

FIGURES = (
    "errors",
    "motion",
    "portrait",
    "friction",
    "residual_in_time",
    "residual_spectrum",
    "residual_against_variable",
    "residual_parts",
    "ranking",
    "learned_curve",
)
OF_DRIVEN = ("friction", "residual_in_time", "wavelengths", "residual_spectrum", "weights")
OF_GENERAL = ("readings_ahead", "errors", "residual_in_time", "residual_spectrum", "ranking", "learned_curve")
PAGES = ("report.html", "report.json", "model_before.toml", "model_after.toml")
DRAWN = tuple(dict.fromkeys((*FIGURES, *OF_DRIVEN, *OF_GENERAL)))
NAMES = (*PAGES, *(f"figures/{name}.{kind}" for name in DRAWN for kind in ("svg", "png")))


def written(out: Path) -> list[Path]:
    """The files of a report in a folder; report.html first."""
    figures = sorted(one for one in (out / "figures").glob("*.*") if _ours(one))
    return [*(out / name for name in PAGES), *figures]


def _ours(figure: Path) -> bool:
    """Whether a figure is one that a report may have; others are somebody's own."""
    return figure.suffix in (".svg", ".png") and figure.stem in DRAWN
