"""A picture of the page, by a headless Chromium of the system's."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from stickslip.errors import InputError
from stickslip.files import whole

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
SECONDS = 120
WAIT = 5000  # ms of the page's own time, in which it draws


def take(layout: Any, title: str, path: Path, size: tuple[int, int]) -> None:
    """Write a PNG of a page with these widgets and curves.

    Parameters
    ----------
    layout
        Bokeh's.
    title
        Of the page.
    path
        The PNG; nothing half-written is left.
    size
        Width and height in pixels.

    Raises
    ------
    InputError
        There is no Chromium, it fails, or the file is no PNG or cannot be written.
    """
    from bokeh.embed import file_html
    from bokeh.resources import INLINE

    if path.suffix.lower() != ".png":
        raise InputError("must be the name of a PNG, like page.png", key="--screenshot", value=str(path))
    program = next((found for name in PROGRAMS if (found := shutil.which(name))), None)
    if program is None:
        raise InputError(f"needs a browser, one of {', '.join(PROGRAMS)}", key="--screenshot")
    with whole(path) as target, tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        text = file_html(layout, INLINE, title, suppress_callback_warning=True)  # a picture answers nothing
        page.write_text(text, encoding="utf-8")
        picture = Path(folder) / "page.png"
        command = [
            program, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
            f"--user-data-dir={folder}/profile", f"--window-size={size[0]},{size[1]}",
            f"--virtual-time-budget={WAIT}", f"--screenshot={picture}", page.as_uri(),
        ]  # fmt: skip
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=SECONDS)
        except subprocess.TimeoutExpired:
            raise InputError(f"the browser gave no picture within {SECONDS} s", key="--screenshot") from None
        if not picture.is_file():
            last = (done.stderr.strip().splitlines() or ["no words"])[-1]
            raise InputError(f"the browser gave no picture: {last[:120]}", key="--screenshot")
        shutil.copyfile(picture, target)
