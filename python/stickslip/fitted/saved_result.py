"""What `identify` returns is written to the same two files, whatever the rig."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.declared.toml_file import write_text
from stickslip.files import folder
from stickslip.objects import Drawn

if TYPE_CHECKING:
    from stickslip.declared.model import Model

IDENTIFIED = ("model.toml", "identified.json")


class SavedResult(Drawn):
    """A model that was identified, and what is known of it."""

    if TYPE_CHECKING:  # a field of one result, a property of the other

        @property
        def model(self) -> Model:
            """The identified model."""

    def to_dict(self) -> dict[str, Any]:
        """Return what `identified.json` holds."""
        raise NotImplementedError

    def save(self, out: str | Path, *, force: bool = False) -> list[Path]:
        """Write `model.toml` and `identified.json` into the folder `out` (made if absent); return their paths.

        Files of these names that no earlier result put there are replaced only with `force`.
        """
        with folder(Path(out), IDENTIFIED, force=force) as temporary:
            self.fill(temporary)
        return [Path(out) / name for name in IDENTIFIED]

    def fill(self, into: Path) -> None:
        """Write the files of `save` into an existing folder."""
        self.model.save(into / "model.toml")
        write_text(into / "identified.json", json.dumps(self.to_dict(), indent=1))
