"""Runs as CSV, one line a run, and back."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Any

from stlc.bench.record import Record
from stlc.bench.store import Store
from stlc.errors import UsageError
from stlc.inputs import InputError, note_input, read_input

_COLUMNS = tuple(f.name for f in fields(Record) if f.name != "trace")
_TYPES = {f.name: str(f.type) for f in fields(Record)}


def to_csv(records: Iterable[Record]) -> str:
    """All figures but the trace; numbers with every digit."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for record in records:
        values = (getattr(record, name) for name in _COLUMNS)
        writer.writerow("" if value is None else value for value in values)
    return out.getvalue()


def read_csv(path: Path) -> tuple[Record, ...]:
    """What `to_csv` wrote. UsageError for anything else."""
    try:
        rows = list(csv.DictReader(io.StringIO(read_input(path).decode("utf-8-sig"), newline="")))
    except (InputError, UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path} is no table of benchmark runs: {error}") from error
    try:
        return tuple(Record(**{k: _value(k, v) for k, v in row.items() if k in _TYPES})
                     for row in rows)  # fmt: skip
    except (TypeError, ValueError) as error:
        raise UsageError(f"{path} is no table of benchmark runs: {error}") from error


def _value(name: str, text: str) -> Any:
    """A field of the CSV in the type of the record's; empty is None where that is allowed."""
    kind = _TYPES[name]
    if text == "" and "None" in kind:
        return None
    match kind.partition(" ")[0]:
        case "int":
            return int(text)
        case "float":
            return float(text)
        case "bool":
            return text == "True"
        case _:
            return text


def read_runs(path: Path) -> tuple[Record, ...]:
    """Runs of a store or of a CSV file. UsageError when there is none, or it is neither."""
    if not path.is_file():
        raise UsageError(f"there is no store or table {path}")
    note_input(path)
    with path.open("rb") as stream:
        is_store = stream.read(15) == b"SQLite format 3"
    return Store(path).records() if is_store else read_csv(path)
