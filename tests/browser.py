"""Headless Chromium for the tests of pages: what a page says, asks for and looks like. Skips where there is none."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest

WIDTHS = {"phone": (390, 844), "tablet": (820, 1180), "desktop": (1440, 900)}
NAMES = ("chromium", "chromium-browser", "google-chrome")
STEP = 600  # pixels scrolled at once


@dataclass
class Seen:
    """A page that is open, what it complained of, and what it asked of the network."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def scroll(self) -> None:
        """Down to the end, so that everything is drawn."""
        height = self.page.evaluate("document.documentElement.scrollHeight")
        for y in range(0, height, STEP):
            self.page.evaluate(f"window.scrollTo({{top: {y}, behavior: 'instant'}})")
            self.page.wait_for_timeout(60)
        self.page.wait_for_timeout(400)

    def sideways(self) -> int:
        """Pixels that the page is wider than its window."""
        return int(self.page.evaluate("document.documentElement.scrollWidth - window.innerWidth"))


def program() -> str:
    """The path of Chromium; the test skips where there is none."""
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("no Chromium is installed")
    return found


@contextmanager
def chromium(**context: Any) -> Iterator[Seen]:
    """An empty page of a new window; keywords as `Browser.new_context` has them."""
    path = program()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            page = browser.new_context(**context).new_page()
            seen = Seen(page)
            page.on(
                "console", lambda one: one.type in ("error", "warning") and seen.complaints.append(one.text)
            )
            page.on("pageerror", lambda one: seen.complaints.append(str(one)))
            page.on("request", lambda one: seen.asked.append(one.url))
            yield seen
        finally:
            browser.close()
