"""Parquet files: their columns of numbers, dates and spans of time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for."""
    parts = pq.ParquetFile(file)
    schema = parts.schema_arrow
    head: dict[str, Any] = {"known": list(schema.names), "units": _units(schema), "times": []}
    if any(schema.names.count(name) != 1 for name in names):
        return head, []
    table = parts.read(columns=names, use_threads=False)
    columns = []
    for name in names:
        column = table.column(name)
        if column.null_count:
            first = column.is_null().index(pa.scalar(value=True)).as_py()
            return _fault(head, name, f"no value at sample {first}; every sample needs a number"), []
        kind = column.type
        if pa.types.is_temporal(kind):
            head["times"].append(name)
            columns.append(_seconds(column))
        elif pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
            columns.append(column.to_numpy().astype(np.float64))
        elif pa.types.is_decimal(kind):
            columns.append(column.cast(pa.float64()).to_numpy())
        else:
            return _fault(head, name, f"holds {kind}; a channel is numbers"), []
    return head, columns


def _fault(head: dict[str, Any], name: str, words: str) -> dict[str, Any]:
    return {**head, "fault": words, "column": name}


def _seconds(column: Any) -> np.ndarray:
    """Dates and times of day since the first one, spans of time as they are."""
    span = pa.types.is_duration(column.type)
    if pa.types.is_date(column.type) or pa.types.is_time(column.type):
        column = column.cast(pa.timestamp("ms") if pa.types.is_date(column.type) else pa.time64("ns"))
    unit = getattr(column.type, "unit", "ns")
    counts = column.cast(pa.int64()).to_numpy()
    first = 0 if span or not counts.size else counts[0]
    seconds: np.ndarray = (counts - first) / {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[unit]
    return seconds


def _units(schema: Any) -> dict[str, str]:
    """The units in the metadata of columns."""
    units = {}
    for field in schema:
        said = field.metadata or {}
        found = next((said[key] for key in (b"unit", b"units") if key in said), b"")
        if found:
            units[field.name] = found.decode(errors="replace")
    return units
