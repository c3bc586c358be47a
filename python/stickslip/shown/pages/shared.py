"""What the pages of all rigs are given."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from stickslip.declared.rig import DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.si import scales_of
from stickslip.discovery.plain import Json
from stickslip.discovery.result import Found
from stickslip.measured.case import Case
from stickslip.shown.pages.skeleton import Saved, download, rig, shown, today
from stickslip.shown.pages.skeleton import command as usual_command
from stickslip.shown.report import words
from stickslip.shown.report.units import axes_of


def shared(
    found: Found, case: Case, report: Mapping[str, Json], drawings: Mapping[str, Saved], command: str | None
) -> dict[str, Any]:
    """By name, what the parts of a page use."""
    axes = None if isinstance(case.rig, DrivenSlider | GeneralRig) else axes_of(case)
    return {
        "title": f"{found.title}: {found.verdict.value}",
        "found": found,
        "case": case,
        "report": report,
        "figures": shown(drawings),
        "headline": words.headline(found),
        "sureness": words.sureness(found),
        "clean": words.clean_sentence(found),
        "alarms": words.alarms(found),
        "caveats": words.caveats(found, axes),
        "place": words.PLACE,
        "rig": rig(case.rig),
        "si_case": scales_of(case.rig, case.channels) is not None,
        "date": today(),
        "command": command or usual_command(case),
        "downloads": {
            "report.json": download(json.dumps(report, indent=1, ensure_ascii=False), "application/json"),
            "model_before.toml": download(found.before.toml(), "application/toml"),
            "model_after.toml": download(found.after.toml(), "application/toml"),
        },
    }
