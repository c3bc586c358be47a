"""CSV and MATLAB files as laboratories write them."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from stickslip.errors import InputError
from stickslip.measured.readers.tables import column_names, read_columns

T = [0.0, 0.5, 1.0, 1.5]
X = [1.25, -3.5e-3, 7.0, 1e5]

DIALECTS = {
    "plain": "t,x\n0,1.25\n0.5,-3.5e-3\n1,7\n1.5,1e5\n",
    "byte-order mark": "\ufefft,x\n0,1.25\n0.5,-3.5e-3\n1,7\n1.5,1e5\n",
    "windows line ends": "t,x\r\n0,1.25\r\n0.5,-3.5e-3\r\n1,7\r\n1.5,1e5\r\n",
    "semicolons, decimal commas": "t;x\n0;1,25\n0,5;-3,5e-3\n1,0;7\n1,5;1e5\n",
    "semicolons, decimal points": "t;x\n0;1.25\n0.5;-3.5e-3\n1;7\n1.5;1e5\n",
    "tabs": "t\tx\n0\t1.25\n0.5\t-3.5e-3\n1\t7\n1.5\t1e5\n",
    "spaces": "  t   x\n  0   1.25\n 0.5  -3.5e-3\n 1.0  7.0\n 1.5  1e5\n",
    "spaces after commas": "t, x\n0, 1.25\n0.5, -3.5e-3\n1, 7\n1.5, 1e5\n",
    "quoted names": '"t","x"\n0,1.25\n0.5,-3.5e-3\n1,7\n1.5,1e5\n',
    "comments above": "# rig 7\n% second line\n// third\nt,x\n0,1.25\n0.5,-3.5e-3\n1,7\n1.5,1e5\n",
    "names in a comment": "# t,x\n0,1.25\n0.5,-3.5e-3\n1,7\n1.5,1e5\n",
    "blank lines": "\nt,x\n\n0,1.25\n0.5,-3.5e-3\n\n1,7\n1.5,1e5\n\n",
    "comments within": "t,x\n0,1.25\n# paused\n0.5,-3.5e-3\n1,7 # here\n1.5,1e5\n",
    "a separator at the end": "t,x\n0,1.25,\n0.5,-3.5e-3,\n1,7,\n1.5,1e5,\n",
    "no new line at the end": "t,x\n0,1.25\n0.5,-3.5e-3\n1,7\n1.5,1e5",
    "text in a column nobody asked for": "t,note,x\n0,a,1.25\n0.5,,-3.5e-3\n1,b c,7\n1.5,d,1e5\n",
}


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS)
def test_dialects_give_the_same_numbers(tmp_path: Path, text: str) -> None:
    (tmp_path / "run.csv").write_text(text, encoding="utf-8", newline="")
    columns = read_columns(tmp_path / "run.csv", ["t", "x"])
    np.testing.assert_array_equal(columns.values["t"], T)
    np.testing.assert_allclose(columns.values["x"], X, rtol=1e-15)
    assert all(column.dtype == np.float64 for column in columns.values.values())


def test_lines_are_those_of_an_editor(tmp_path: Path) -> None:
    text = "# rig\n\nt,x\n0,1\n# pause\n\n1,2\n2,oops\n3,4\n"
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(InputError, match=r"run.csv line 8, column 'x': 'oops' is text"):
        read_columns(tmp_path / "run.csv", ["t", "x"])
    columns = read_columns(tmp_path / "run.csv", ["t"])
    assert [columns.place("t", row).line for row in range(5)] == [4, 7, 8, 9, None]


def test_mat_variables_are_columns(tmp_path: Path) -> None:
    savemat(tmp_path / "run.mat", {"t": np.array(T)[:, None], "x": np.array(X), "note": "hello"})
    columns = read_columns(tmp_path / "run.mat", ["t", "x"])
    np.testing.assert_array_equal(columns.values["t"], T)
    np.testing.assert_array_equal(columns.values["x"], X)
    assert set(column_names(tmp_path / "run.mat")) == {"t", "x"}  # words are no column
    assert columns.place("x", 2).line is None
    with pytest.raises(InputError, match="'note': words; a channel is a real vector"):
        read_columns(tmp_path / "run.mat", ["note"])


def test_mat_with_nan_says_the_sample(tmp_path: Path) -> None:
    savemat(tmp_path / "run.mat", {"t": np.array([0.0, 1.0, np.nan, 3.0])})
    with pytest.raises(InputError, match="nan at sample 2"):
        read_columns(tmp_path / "run.mat", ["t"])


def test_a_missing_file_names_its_neighbour(tmp_path: Path) -> None:
    (tmp_path / "run_01.csv").write_text("t\n1\n")
    with pytest.raises(InputError, match=r"no such file; did you mean 'run_01.csv'"):
        read_columns(tmp_path / "run_1.csv", ["t"])
