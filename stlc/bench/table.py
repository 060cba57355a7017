"""Runs as CSV, one line a run, and back."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Any

from stlc.bench.record import Record, lacking
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
    problem = f"{path} is no store and no table of benchmark runs"
    try:
        text = read_input(path).decode("utf-8-sig")
        rows = csv.DictReader(io.StringIO(text, newline=""))
        if lost := lacking(rows.fieldnames or ()):
            raise UsageError(f"{problem}: its header lacks {', '.join(lost)}")
        return tuple(_record(rows.line_num, row) for row in rows)
    except UnicodeDecodeError:
        raise UsageError(f"{problem}: it is not UTF-8 text") from None
    except (InputError, csv.Error, ValueError) as error:
        raise UsageError(f"{problem}: {error}") from error


def _record(line: int, row: dict[str, str | None]) -> Record:
    """The run of a line; ValueError, with the line, where a figure is missing or is none."""
    found: dict[str, Any] = {}
    for name in (name for name in _COLUMNS if name in row):
        text = row[name] or ""
        try:
            found[name] = _value(name, text)
        except ValueError:
            raise ValueError(f"line {line}: {name} can't be {text!r}") from None
    return Record(**found)


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
