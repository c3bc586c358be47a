"""An error in a TOML file is said at the line of its key, within lists over several lines too."""

from pathlib import Path

import pytest

from stickslip.declared.toml_file import Key, read_toml

TEXT = """[rig]
M = [
  [1, 0],
  [0, 2]
]
names = ["a [m]", "b # no comment", 'c {']
link = [
  { between = ["a", "b"], stiffness = 3 },  # { a comment
  { between = ["b", "c"], stiffness = 4 },
]
body.x = { mass = 2, note = "]" }

[[run]]
file = "a.csv"
belt_speed = [{ from = 0, value = 1 }, { from = 2, value = 3 }]

[[run]]
file = "b.csv"
belt_speed = [
  { from = 0, value = 1 },
  { from = 2, value = 3 },
]
role = "train"
"""


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (("rig", "M"), 2),
        (("rig", "names"), 6),
        (("rig", "link", 0, "stiffness"), 8),
        (("rig", "link", 1, "between"), 9),
        (("rig", "body", "x", "note"), 11),
        (("run", 0, "belt_speed", 1, "value"), 15),
        (("run", 1, "file"), 18),
        (("run", 1, "belt_speed", 1), 21),
        (("run", 1, "belt_speed", 0, "from"), 20),
        (("run", 1, "role"), 23),
        (("run", 1, "from"), 17),
    ],
)
def test_the_line_of_a_key(tmp_path: Path, keys: tuple[Key, ...], line: int) -> None:
    (tmp_path / "a.toml").write_text(TEXT, encoding="utf-8")
    assert read_toml(tmp_path / "a.toml").line(*keys) == line
