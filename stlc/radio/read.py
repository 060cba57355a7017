"""Reader of measured samples (CSV), with located errors."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import DataError, DataLocation
from stlc.radio.readings import Strengths
from stlc.radio.samples import Samples
from stlc.radio.sheet import Sheet, read_sheet

Array = NDArray[np.float64]

SENDERS = ("tx", "sender", "transmitter", "robot", "source", "ps")
RECEIVERS = ("rx", "receiver", "anchor", "station", "pr")
STRENGTHS = (
    "rssi", "rss", "rssi_dbm", "rss_dbm", "rss_db_uncalibrated", "rss_db", "power_dbm", "power",
    "strength", "signal_strength", "signal", "rx_power", "received_power",
)  # fmt: skip


def _coordinates(words: tuple[str, ...], number: int, axis: str) -> tuple[str, ...]:
    """Names of one coordinate of the first or second end: tx_x, x_tx, .., x1."""
    both = [name for w in words for name in (f"{w}_{axis}", f"{axis}_{w}")]
    return (*both, f"{axis}{number}")


ALIASES: dict[str, tuple[str, ...]] = {
    **{f"tx_{axis}": _coordinates(SENDERS, 1, axis) for axis in "xyz"},
    **{f"rx_{axis}": _coordinates(RECEIVERS, 2, axis) for axis in "xyz"},
    "rssi": STRENGTHS,
    "receiver": ("receiver", "rx", "anchor", "receiver_id", "rx_id", "station"),
}
"""Column names understood, after lower case and without a unit such as `_m` or `[m]`."""

RELATIVE_NAMES = ("rss_db", "rss_db_uncalibrated")
"""Columns of strengths relative to an unknown one."""

REQUIRED = ("tx_x", "tx_y", "rx_x", "rx_y", "rssi")

LENGTH_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0}


@dataclass(frozen=True, slots=True)
class SampleOptions:
    """height [m] of a moving end that has no z column while the other end has one;
    floor [dBm] below or at which samples are censored; `where` keeps rows whose column
    (first) equals a text (second); not_heard: cells that stand for packets below the floor."""

    height: float = 0.0
    floor: float | None = None
    where: tuple[str, str] | None = None
    not_heard: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Header:
    """Column index and unit factor of each known quantity; whether strengths are relative."""

    names: tuple[str, ...]
    columns: dict[str, int]
    scale: dict[str, float]
    relative: bool


def read_samples(path: str | Path, options: SampleOptions | None = None) -> Samples:
    """Samples from a CSV (optionally .gz) with a header: tx_x, tx_y, rx_x, rx_y, rssi_dbm and
    optionally tx_z, rx_z and a receiver column; aliases and units in the header are accepted,
    so are semicolons, tabs or spaces between columns, decimal commas and comments after `#`.

    Raises DataError with file, line and column for anything that cannot be read.
    """
    options = options or SampleOptions()
    whole = read_sheet(Path(path))
    if not whole.rows:
        raise DataError("the file is empty", DataLocation(str(path)), _EXPECTED)
    line, names, sheet = _named(whole)
    units, sheet = sheet.without_units()
    header = _header(names, units, DataLocation(str(path), line))
    choice = _wanted_column(header, options, str(path))
    sheet = replace(sheet, rows=tuple(r for r in sheet.rows if _wanted(r[1], choice, options)))
    sheet.check_width(len(names), "header has")
    if not sheet.rows:
        raise DataError("the file holds no samples", DataLocation(str(path)))
    values = {
        name: np.array([sheet.number(r[c], n, c) for n, r in sheet.rows]) * header.scale[name]
        for name, c in header.columns.items()
        if name not in ("receiver", "rssi")
    }
    column = header.columns["rssi"]
    rule = Strengths(header.relative, options.floor, options.not_heard)
    values["rssi"] = rule.read(sheet, [(n, r[column]) for n, r in sheet.rows], column)
    return _assemble(values, _labels(sheet, header.columns.get("receiver")), options)


_EXPECTED = "the header needs tx_x, tx_y, rx_x, rx_y and rssi_dbm"


def _named(sheet: Sheet) -> tuple[int, tuple[str, ...], Sheet]:
    """Line and cells of the header, and the rows below it; where numbers begin at once, the
    header is the last comment of as many cells (as numpy.savetxt writes it)."""
    line, first = sheet.rows[0]
    if any(sheet.parsed(cell) is None for cell in first):
        return line, first, replace(sheet, rows=sheet.rows[1:])
    above = [c for c in sheet.comments if c[0] < line and len(c[1]) == len(first)]
    if not above:
        text = "the first line holds numbers: there is no header"
        raise DataError(text, DataLocation(sheet.path, line), _EXPECTED)
    return above[-1][0], above[-1][1], sheet


def _plain(name: str) -> tuple[str, str]:
    """A header cell as (name without unit, unit)."""
    text = name.strip().lower()
    bracket = re.fullmatch(r"(.*?)\s*[\[(]\s*([a-z]+)\s*[\])]", text)
    if bracket:
        return bracket[1].strip().replace(" ", "_"), bracket[2]
    tail = re.fullmatch(r"(.+)_(m|cm|mm|km)", text)
    return (tail[1], tail[2]) if tail else (text.replace(" ", "_"), "")


def _header(names: tuple[str, ...], units: tuple[str, ...], line: DataLocation) -> _Header:
    """What the columns hold; `units` are those of a row of their own."""
    columns: dict[str, int] = {}
    scale: dict[str, float] = {}
    relative = False
    for index, cell in enumerate(names):
        name, unit = _plain(cell)
        unit = unit or (units[index] if index < len(units) else "")
        for key in (k for k, known in ALIASES.items() if name in known):
            if key == "receiver" and key in columns:
                continue
            where = DataLocation(line.path, line.line, index + 1)
            if key in columns:
                text = f"columns {columns[key] + 1} and {index + 1} both give {key}"
                raise DataError(text, where)
            columns[key] = index
            scale[key] = _factor(key, unit, where)
            relative |= key == "rssi" and (name in RELATIVE_NAMES or unit == "db")
    _check_complete(names, columns, line)
    return _Header(names, columns, scale, relative)


def _check_complete(names: tuple[str, ...], columns: dict[str, int], line: DataLocation) -> None:
    missing = [name for name in REQUIRED if name not in columns]
    if not missing:
        return
    degrees = any(re.search(r"\b(lat|lon|lng)", n.lower().replace("_", " ")) for n in names)
    found = ", ".join(n.strip() for n in names)
    hint = "turn degrees into metres first" if degrees else f"{_EXPECTED}; it has {found}"
    raise DataError(f"no column for {', '.join(missing)}", line, hint)


def _factor(key: str, unit: str, where: DataLocation) -> float:
    known = {"": 1.0, "dbm": 1.0, "db": 1.0} if key == "rssi" else {"": 1.0, **LENGTH_UNITS}
    if key == "receiver":
        return 1.0
    if unit not in known:
        text = f"unit {unit!r} does not fit {key}"
        raise DataError(text, where, "use one of " + ", ".join(u for u in known if u))
    return known[unit]


def _wanted_column(header: _Header, options: SampleOptions, path: str) -> int | None:
    """Index of the column that `where` names."""
    if options.where is None:
        return None
    names = [c.strip() for c in header.names]
    if options.where[0] not in names:
        text = f"no column {options.where[0]!r} to choose rows by"
        raise DataError(text, DataLocation(path, 1), "columns: " + ", ".join(names))
    return names.index(options.where[0])


def _wanted(row: Sequence[str], column: int | None, options: SampleOptions) -> bool:
    if column is None or options.where is None or column >= len(row):
        return True
    return row[column].strip() == options.where[1]


def _labels(sheet: Sheet, column: int | None) -> tuple[NDArray[np.intp], tuple[str, ...]]:
    if column is None:
        return np.zeros(len(sheet.rows), dtype=np.intp), ("",)
    names, index = np.unique([r[column].strip() for _, r in sheet.rows], return_inverse=True)
    return index.reshape(-1).astype(np.intp), tuple(str(n) for n in names)


def _assemble(
    values: dict[str, Array],
    labels: tuple[NDArray[np.intp], tuple[str, ...]],
    options: SampleOptions,
) -> Samples:
    """Samples from the file's columns; ends without a height get that of the options."""
    count = len(values["rssi"])
    axes = ("x", "y", "z") if "tx_z" in values or "rx_z" in values else ("x", "y")
    flat = np.full(count, options.height)
    links = np.column_stack(
        [values.get(f"{end}_{axis}", flat) for end in ("tx", "rx") for axis in axes]
    )
    level = -np.inf if options.floor is None else options.floor
    return Samples(links, values["rssi"], np.full(count, level), labels[0], labels[1])
