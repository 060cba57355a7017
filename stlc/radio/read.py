"""Readers of measured samples (CSV) and of link tables (CSV, NPZ), with located errors."""

from __future__ import annotations

import csv
import gzip
import io
import math
import re
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stlc.inputs import MOST_BYTES, InputError, read_input
from stlc.radio.errors import DataError, DataLocation
from stlc.radio.samples import Samples

Array = NDArray[np.float64]

ALIASES: dict[str, tuple[str, ...]] = {
    "tx_x": ("tx_x", "x_tx", "sender_x", "robot_x", "source_x", "x1", "ps_x"),
    "tx_y": ("tx_y", "y_tx", "sender_y", "robot_y", "source_y", "y1", "ps_y"),
    "tx_z": ("tx_z", "z_tx", "sender_z", "robot_z", "source_z", "z1", "ps_z"),
    "rx_x": ("rx_x", "x_rx", "receiver_x", "anchor_x", "station_x", "x2", "pr_x"),
    "rx_y": ("rx_y", "y_rx", "receiver_y", "anchor_y", "station_y", "y2", "pr_y"),
    "rx_z": ("rx_z", "z_rx", "receiver_z", "anchor_z", "station_z", "z2", "pr_z"),
    "rssi": ("rssi", "rss", "rssi_dbm", "rss_dbm", "rss_db_uncalibrated", "rss_db", "power_dbm"),
    "receiver": ("receiver", "rx", "anchor", "receiver_id", "rx_id", "station"),
}
"""Column names understood, after lower case and without a unit such as `_m` or `[m]`."""

REQUIRED = ("tx_x", "tx_y", "rx_x", "rx_y", "rssi")
LARGEST = 1e9
"""Values beyond this are mistakes in any unit."""

LENGTH_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0}


@dataclass(frozen=True, slots=True)
class SampleOptions:
    """height [m] of a moving end that has no z column while the other end has one;
    floor [dBm] below or at which samples are censored; `where` keeps rows whose column
    (first) equals a text (second)."""

    height: float = 0.0
    floor: float | None = None
    where: tuple[str, str] | None = None


def read_samples(path: str | Path, options: SampleOptions | None = None) -> Samples:
    """Samples from a CSV (optionally .gz) with a header: tx_x, tx_y, rx_x, rx_y, rssi_dbm and
    optionally tx_z, rx_z and a receiver column; aliases and units in the header are accepted.

    Raises DataError with file, line and column for anything that cannot be read.
    """
    options = options or SampleOptions()
    rows = csv_rows(_read_text(Path(path)), str(path))
    if not rows:
        raise DataError("the file is empty", DataLocation(str(path)), _EXPECTED)
    columns, scale = _header(rows[0], str(path))
    width = len(rows[0])
    choice = _wanted_column(rows[0], options, str(path))
    body = [(n, r) for n, r in enumerate(rows[1:], start=2) if r and _wanted(r, choice, options)]
    for line, row in body:
        if len(row) != width:
            text = f"{len(row)} values where the header has {width} columns"
            raise DataError(text, DataLocation(str(path), line))
    if not body:
        raise DataError("the file holds no samples", DataLocation(str(path)))
    values = {
        name: np.array([_number(r, c, n, str(path)) for n, r in body]) * scale[name]
        for name, c in columns.items()
        if name != "receiver"
    }
    return _assemble(values, _labels(body, columns.get("receiver")), options)


_EXPECTED = "the header needs tx_x, tx_y, rx_x, rx_y and rssi_dbm"


def _read_text(path: Path) -> str:
    raw = _content(path)
    try:
        return (_unpacked(raw, path) if raw[:2] == b"\x1f\x8b" else raw).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        text = "this is not a text file"
        raise DataError(text, DataLocation(str(path)), "expected a UTF-8 CSV") from error
    except (OSError, EOFError, zlib.error) as error:
        raise DataError(f"cannot unpack the file: {error}", DataLocation(str(path))) from error


def _content(path: Path) -> bytes:
    try:
        return read_input(path)
    except InputError as error:
        raise DataError(f"cannot read the file: {error}", DataLocation(str(path))) from None


def _unpacked(raw: bytes, path: Path) -> bytes:
    """No more than an input may have: a few kilobytes can unpack to gigabytes."""
    with gzip.GzipFile(fileobj=io.BytesIO(raw)) as packed:
        data = packed.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        text = f"it unpacks to more than {MOST_BYTES // 2**20} MiB"
        raise DataError(text, DataLocation(str(path)))
    return data


def csv_rows(text: str, path: str) -> list[list[str]]:
    """The cells of a CSV text. DataError, with the line, for what is no CSV."""
    reader = csv.reader(io.StringIO(text))
    try:
        return list(reader)
    except csv.Error as error:  # a field of more than 128 kB
        raise DataError(f"not a CSV file: {error}", DataLocation(path, reader.line_num)) from None


def _plain(name: str) -> tuple[str, str]:
    """A header cell as (name without unit, unit)."""
    text = name.strip().lower()
    bracket = re.fullmatch(r"(.*?)\s*[\[(]\s*([a-z]+)\s*[\])]", text)
    if bracket:
        return bracket[1].strip().replace(" ", "_"), bracket[2]
    tail = re.fullmatch(r"(.*_[xyz])_(m|cm|mm|km)", text)
    return (tail[1], tail[2]) if tail else (text.replace(" ", "_"), "")


def _header(cells: Sequence[str], path: str) -> tuple[dict[str, int], dict[str, float]]:
    """Column index and unit factor of each known quantity."""
    columns: dict[str, int] = {}
    scale: dict[str, float] = {}
    for index, cell in enumerate(cells):
        name, unit = _plain(cell)
        for key, names in ALIASES.items():
            if name not in names or (key == "receiver" and key in columns):
                continue
            if key in columns:
                text = f"columns {columns[key] + 1} and {index + 1} both give {key}"
                raise DataError(text, DataLocation(path, 1, index + 1))
            columns[key] = index
            scale[key] = _factor(key, unit, DataLocation(path, 1, index + 1))
    missing = [name for name in REQUIRED if name not in columns]
    if missing:
        text = f"no column for {', '.join(missing)}"
        raise DataError(text, DataLocation(path, 1), _EXPECTED)
    return columns, scale


def _factor(key: str, unit: str, where: DataLocation) -> float:
    known = {"": 1.0, "dbm": 1.0, "db": 1.0} if key == "rssi" else {"": 1.0, **LENGTH_UNITS}
    if key == "receiver":
        return 1.0
    if unit not in known:
        text = f"unit {unit!r} does not fit {key}"
        raise DataError(text, where, "use one of " + ", ".join(u for u in known if u))
    return known[unit]


def _wanted_column(cells: Sequence[str], options: SampleOptions, path: str) -> int | None:
    """Index of the column that `where` names."""
    if options.where is None:
        return None
    names = [c.strip() for c in cells]
    if options.where[0] not in names:
        text = f"no column {options.where[0]!r} to choose rows by"
        raise DataError(text, DataLocation(path, 1), "columns: " + ", ".join(names))
    return names.index(options.where[0])


def _wanted(row: Sequence[str], column: int | None, options: SampleOptions) -> bool:
    if column is None or options.where is None or column >= len(row):
        return True
    return row[column].strip() == options.where[1]


def _number(row: Sequence[str], column: int, line: int, path: str) -> float:
    where = DataLocation(path, line, column + 1)
    try:
        value = float(row[column])
    except ValueError:
        raise DataError(f"{row[column]!r} is not a number", where) from None
    if not np.isfinite(value):
        raise DataError(f"{row[column]!r} is not a finite number", where)
    if abs(value) > LARGEST:
        raise DataError(f"{row[column]!r} is out of range", where)
    return value


def _labels(
    body: Sequence[tuple[int, Sequence[str]]], column: int | None
) -> tuple[NDArray[np.intp], tuple[str, ...]]:
    if column is None:
        return np.zeros(len(body), dtype=np.intp), ("",)
    names, index = np.unique([r[column].strip() for _, r in body], return_inverse=True)
    return index.reshape(-1).astype(np.intp), tuple(str(n) for n in names)


def _assemble(
    values: dict[str, Array],
    labels: tuple[NDArray[np.intp], tuple[str, ...]],
    options: SampleOptions,
) -> Samples:
    count = len(values["rssi"])
    axes = ("x", "y", "z") if "tx_z" in values or "rx_z" in values else ("x", "y")
    flat = np.full(count, options.height)
    links = np.column_stack(
        [values.get(f"{end}_{axis}", flat) for end in ("tx", "rx") for axis in axes]
    )
    level = -np.inf if options.floor is None else options.floor
    return Samples(links, values["rssi"], np.full(count, level), labels[0], labels[1])


def read_table(path: str | Path, name: str | None = None) -> Array:
    """Values (na, nb) from a CSV without header, or from one array of an NPZ (never pickled).

    Raises DataError with file, line and column; `name` picks the array when there are several.
    """
    location = Path(path)
    if location.suffix.lower() == ".npz":
        return _read_npz(location, name)
    rows = [r for r in csv_rows(_read_text(location), str(path)) if r]
    if not rows:
        raise DataError("the file is empty", DataLocation(str(path)))
    for line, row in enumerate(rows, start=1):
        if len(row) != len(rows[0]):
            text = f"{len(row)} values where the first line has {len(rows[0])}"
            raise DataError(text, DataLocation(str(path), line))
    return np.array(
        [
            [_number(row, c, line, str(path)) for c in range(len(row))]
            for line, row in enumerate(rows, start=1)
        ]
    )


def _read_npz(path: Path, name: str | None) -> Array:
    where = DataLocation(str(path))
    data = _content(path)
    if data[:6] == b"\x93NUMPY":
        raise DataError("this is one array (.npy), not an archive", where, "use numpy.savez")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            values = _member(archive, _choice(archive.namelist(), name, where), where)
    except DataError:
        raise
    except (OSError, EOFError, ValueError, KeyError, NotImplementedError, RuntimeError,
            zipfile.BadZipFile, zlib.error) as error:  # fmt: skip
        raise DataError(f"cannot read the file: {error}", where) from error
    if values.ndim not in (1, 2) or values.dtype.kind not in "fiu":
        text = f"array of shape {values.shape} and type {values.dtype}"
        raise DataError(text, where, "expected one or two axes of numbers")
    table = np.asarray(np.atleast_2d(values.astype(np.float64)))
    if not np.isfinite(table).all():
        raise DataError("the table holds values that are not finite", where)
    return table


def _choice(members: Sequence[str], name: str | None, where: DataLocation) -> str:
    """The member that is meant; `name` goes without the ending .npy."""
    names = [m.removesuffix(".npy") for m in members]
    if name is None and len(names) != 1:
        raise DataError(f"{len(names)} arrays in the file: {', '.join(names)}", where)
    if name is not None and name not in names:
        raise DataError(f"no array {name!r}; there are: {', '.join(names)}", where)
    return members[0 if name is None else names.index(name)]


def _member(archive: zipfile.ZipFile, member: str, where: DataLocation) -> Array:
    """One array, unpacked only as far as it may go: a header can claim any size."""
    with archive.open(member) as packed:
        data = packed.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise DataError(f"{member} unpacks to more than {MOST_BYTES // 2**20} MiB", where)
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    read = (
        np.lib.format.read_array_header_1_0
        if version == (1, 0)
        else (np.lib.format.read_array_header_2_0)
    )
    shape, _, kind = read(stream)
    if kind.hasobject:
        raise DataError("the array holds pickled objects, which are never read", where)
    claimed = math.prod(shape) * kind.itemsize
    if claimed > len(data) - stream.tell():
        problem = f"the array claims {claimed} bytes, the file holds {len(data) - stream.tell()}"
        raise DataError(problem, where)
    stream.seek(0)
    return np.lib.format.read_array(stream, allow_pickle=False)
