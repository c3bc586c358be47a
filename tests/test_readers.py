"""Files and columns as people have them: the same numbers, or one clear line; never a value that shifts."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.measured.heads import head_parts
from stickslip.measured.readers.tables import read_columns

RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
N = 40
T = np.round(0.002 * np.arange(N), 6)
F = np.round(1.5 + 0.4 * np.sin(0.3 * np.arange(N)), 6)
CHANNELS = {"t": ss.Channel("t", "s"), "spring_force": ss.Channel("F", "N")}


def load(source: object, channels: dict[str, ss.Channel] | None = None) -> ss.Recording:
    return ss.load_recording(source, RIG, channels=channels or CHANNELS, belt_speed="5 mm/s")  # type: ignore[arg-type]


@st.composite
def tables(draw: st.DrawFn) -> tuple[str, bool]:
    """The text of a table as some program writes it, and whether a row of it has a fault."""
    separator = draw(st.sampled_from([",", ";", "\t", " "]))
    signs = [draw(st.sampled_from(["."] if separator == "," else [".", ","])) for _ in range(2)]
    head = draw(
        st.sampled_from(["t{s}F{s}temp", '"t"{s}"F"{s}"temp"', "t [s]{s}F [N]{s}temp", "t(s){s}F(N){s}temp"])
    )
    if separator == " " and " " in head:
        head = "t{s}F{s}temp"
    rows = [
        [f"{t:.6f}".replace(".", signs[0]), f"{f:.6f}".replace(".", signs[1]), f"{23 + i}"]
        for i, (t, f) in enumerate(zip(T, F, strict=True))
    ]
    at = draw(st.integers(0, N - 1))
    kind = draw(st.sampled_from(["none", "none", "blank", "short", "long", "text", "split"]))
    row, column = rows[at], draw(st.integers(0, 1))
    if kind == "blank":
        row[column] = ""
    elif kind == "short":
        del row[column]
    elif kind == "long":
        row.insert(column, "7")
    elif kind == "text":
        row[column] = "n/a"
    elif kind == "split":  # a decimal sign that is the separator, or a blank between thousands
        row[column] = f"1{separator}234"
    pad = draw(st.sampled_from(["", " "])) if separator != " " else draw(st.sampled_from([" ", "   "]))
    joint = separator.strip(" ") + pad if separator != " " else pad
    comments = draw(st.sampled_from(["", "# a rig\n", "% a rig\n\n"]))
    end = draw(st.sampled_from(["\n", "\r\n"]))
    lines = [head.format(s=separator), *(joint.join(one) for one in rows)]
    return comments + end.join(lines) + end, kind != "none"


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(table=tables())
def test_a_table_gives_its_numbers_or_one_line(tmp_path: Path, table: tuple[str, bool]) -> None:
    text, faulty = table
    file = tmp_path / "run.csv"
    file.write_bytes(text.encode())
    if faulty:
        with pytest.raises(ss.InputError) as refused:
            load(file)
        assert str(refused.value).isprintable()
        return
    run = load(file)
    np.testing.assert_allclose(run.t, T)
    np.testing.assert_allclose(run.x1 * 500, F)


@pytest.mark.parametrize(
    ("late", "sign"), [(25, ","), (1, ","), (25, ".")], ids=["late comma", "early comma", "late point"]
)
def test_a_decimal_sign_that_begins_late_is_seen(tmp_path: Path, late: int, sign: str) -> None:
    force = np.where(np.arange(N) < late, 0.0, F)
    rows = ["0" if f == 0 else f"{f:.6f}".replace(".", sign) for f in force]
    text = "t;F\n" + "".join(f"{2 * i};{f}\n" for i, f in enumerate(rows))
    (tmp_path / "run.csv").write_text(text)
    run = load(tmp_path / "run.csv", {**CHANNELS, "t": ss.Channel("t", "ms")})
    np.testing.assert_allclose(run.x1 * 500, force)


def test_two_decimal_signs_in_one_column_are_refused_where_the_second_begins(tmp_path: Path) -> None:
    text = "t;F\n" + "".join(f"{i};1{'.' if i < 5 else ','}5\n" for i in range(N))
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(ss.InputError, match=r"line 7, column 'F': 1,5, but above .* '\.'"):
        read_columns(tmp_path / "run.csv", ["t", "F"])


SPANS = (T * 1e9).round().astype("m8[ns]")
START = np.datetime64("2024-03-05T10:00:00")
CLOCK = pd.Series(pd.to_datetime(START) + pd.to_timedelta(T, unit="s"))


@pytest.mark.parametrize(
    "t",
    [
        SPANS,
        START + SPANS,
        SPANS.astype("m8[us]"),
        CLOCK,
        CLOCK.dt.tz_localize("Europe/Warsaw"),
        pd.Series(SPANS),
        [dt.datetime(2024, 3, 5) + dt.timedelta(seconds=float(x)) for x in T],
        [dt.timedelta(seconds=float(x)) for x in T],
        pint.UnitRegistry().Quantity(T * 1e3, "ms"),
        xr.DataArray(T / 60, attrs={"units": "min"}),
        list(T),
    ],
)
def test_times_of_any_kind_are_seconds(t: object) -> None:
    np.testing.assert_allclose(load({"t": t, "F": F}).t, T, atol=1e-6)


def test_a_quantity_is_turned_into_the_declared_unit() -> None:
    force = pint.UnitRegistry().Quantity(F * 1e3, "mN")
    np.testing.assert_allclose(load({"t": T, "F": force}).x1 * 500, F)


MASKED = np.ma.masked_array(F.copy())
MASKED[10:12] = np.ma.masked


@pytest.mark.parametrize(
    ("force", "words"),
    [
        (MASKED, "masked at sample 10"),
        (F + 0j, "complex"),
        (pint.UnitRegistry().Quantity(F, "mm"), "is in 'millimeter', but its channel is declared in 'N'"),
        (SPANS, "declared in 'N'"),
        (pd.Series([*F[:-1], None]), "nan at sample 39"),
        (pd.array([*range(N - 1), None], dtype="Int64"), "(not numbers|nan at sample 39)"),
        (["1,5"] * N, "not numbers"),
        (F[:-1], "39 numbers, but column 't' has 40"),
        (np.stack([F, F]), "2 dimensions"),
    ],
)
def test_columns_that_a_conversion_would_cut_are_refused(force: object, words: str) -> None:
    with pytest.raises(ss.InputError, match=words):
        load({"t": T, "F": force})


@pytest.mark.parametrize(
    ("head", "parts"),
    [
        ("F [N]", ("F", "N")),
        ("F[N]", ("F", "N")),
        ("F (N)", ("F", "N")),
        ("F / N", ("F", "N")),
        ("x1 [-]", ("x1", "1")),
        ("Force (left)", None),
        ("x1/y1", None),
        ("F", None),
    ],
)
def test_heads_of_columns(head: str, parts: tuple[str, str] | None) -> None:
    assert head_parts(head) == parts


@pytest.mark.parametrize("column", ["F", "F [mN]"])
def test_a_head_that_contradicts_the_declared_unit_is_refused(tmp_path: Path, column: str) -> None:
    text = "t,F [mN]\n" + "".join(f"{t},{1e3 * f}\n" for t, f in zip(T, F, strict=True))
    (tmp_path / "run.csv").write_text(text)
    channels = {**CHANNELS, "spring_force": ss.Channel(column, "N")}
    with pytest.raises(ss.InputError, match=r"the file has 'F \[mN\]', but its channel is declared in 'N'"):
        load(tmp_path / "run.csv", channels)
    channels["spring_force"] = ss.Channel(column, "N", scale=1e-3)
    np.testing.assert_allclose(load(tmp_path / "run.csv", channels).x1 * 500, F)


@pytest.mark.parametrize("given", ["0,1 m/s", "12,1 mm/s", "0.1.2 m/s", "1'000 mm/s"])
def test_a_number_is_not_cut_at_a_decimal_comma(given: str) -> None:
    with pytest.raises(ss.InputError, match="not a number with a unit"):
        ss.load_recording({"t": T, "F": F}, RIG, channels=CHANNELS, belt_speed=given)
