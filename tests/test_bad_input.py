"""Every bad input of the registry gets one clear line, and the page of the docs says which."""

from pathlib import Path

import pytest

import bad_input

ROWS = bad_input.load_rows()


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.area}: {row.tried}")
def test_one_clear_line(row: bad_input.Row) -> None:
    message = bad_input.said(row)
    assert "\n" not in message
    assert 10 < len(message) < 260, message


def test_the_page_is_current() -> None:
    assert bad_input.TABLE.read_text(encoding="utf-8") == bad_input.table(ROWS), (
        "docs/bad-input.md is stale; run python tests/bad_input.py"
    )


def test_accepted_bad_input_is_noticed(tmp_path: Path) -> None:
    accepted = bad_input.Row("test", "nothing wrong", lambda _folder: None)
    with pytest.raises(AssertionError, match="was accepted"):
        accepted.message(tmp_path)
