"""Recorded signals, read from CSV: a column each, or the waypoints that a plan writes."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.errors import UsageError
from stlc.inputs import InputError, read_input

Array = NDArray[np.float64]

JITTER = 0.1
"""Time stamps may be off the grid by this share of a step. Loggers at 10 to 100 Hz are off by up to
5 %; from 50 % on it is open which step a sample belongs to."""

_INPUT = "_input"  # what a plan's CSV adds to an input that has the name of a state


@dataclass(frozen=True, slots=True, eq=False)
class Columns(Mapping[str, Array]):
    """Signals (N,) by name. What isn't numbers is an error only when it is asked for.

    The inputs of a plan have no value at its last step: NaN.
    """

    found: Mapping[str, Array | UsageError]

    def __getitem__(self, name: str) -> Array:
        """The signal. UsageError, with the line, for a column that isn't all numbers."""
        column = self.found[name]
        if isinstance(column, UsageError):
            raise column
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self.found)

    def __len__(self) -> int:
        return len(self.found)


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """A table of signals: `times` (N,) [s] on a regular grid, `columns` (N,) by name."""

    name: str
    times: Array
    columns: Mapping[str, Array]


@dataclass(frozen=True, slots=True)
class _Table:
    """The cells of the file, as texts, each row with its place for messages."""

    name: str
    header: tuple[str, ...]
    places: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def numbers(self, column: str, gaps: bool = False) -> Array | UsageError:
        """A column (rows,), or its first mistake; with `gaps`, an empty last cell is NaN."""
        k = self.header.index(column)
        values = np.empty(len(self.rows))
        for row, place in enumerate(self.places):
            cell = self.rows[row][k].strip()
            if gaps and not cell and row == len(self.rows) - 1:
                values[row] = math.nan
                continue
            value = _number(cell)
            if value is None or not math.isfinite(value):
                problem = "no number" if value is None else "not finite"
                return UsageError(f"{place}: {column} is {problem}: {cell[:40]!r}")
            values[row] = value
        return values


def read_recording(path: str | os.PathLike[str], step: float) -> Recording:
    """Read a CSV with a header and a column `time` [s] (or `t`, counting steps).

    A column for each signal; or, with a column `agent`, a row for each agent and step, as
    `Plan.to_csv` writes it, whose signals are `agent.name`. Fields are parted by commas,
    semicolons or tabs; lines that begin with # are left out. Raises UsageError, with the line, for
    anything that isn't a regular recording with this step; columns of other things may be there.
    """
    table = _table(os.fspath(path))
    if "agent" not in table.header:
        found = {column: table.numbers(column) for column in table.header}
        return Recording(table.name, _times(table, step), Columns(found))
    k = table.header.index("agent")
    agents = dict.fromkeys(row[k].strip() for row in table.rows)
    found, times = {}, np.empty(0)
    for agent in agents:
        part = _rows_of(table, agent, k)
        own = _times(part, step)
        if len(times) and not np.array_equal(times, own):
            raise UsageError(f"{table.name}: {agent} is recorded at other steps than the rest")
        times = own
        found |= {
            f"{agent}.{column.removesuffix(_INPUT)}": part.numbers(column, gaps=True)
            for column in part.header
            if column not in ("t", "time", "agent")
        }
    return Recording(table.name, times, Columns(found))


def _rows_of(table: _Table, agent: str, column: int) -> _Table:
    """The rows of one agent, and the columns that have anything for it."""
    kept = [j for j, row in enumerate(table.rows) if row[column].strip() == agent]
    rows = [table.rows[j] for j in kept]
    wide = [k for k in range(len(table.header)) if any(row[k].strip() for row in rows)]
    return _Table(
        table.name, tuple(table.header[k] for k in wide), tuple(table.places[j] for j in kept),
        tuple(tuple(row[k] for k in wide) for row in rows),
    )  # fmt: skip


def _table(name: str) -> _Table:
    """Header and rows of a CSV file, separated by whatever its header has most of; UsageError with
    the line."""
    lines = [(k, x) for k, x in enumerate(_text(name).splitlines(), 1) if x.strip()]
    lines = [(k, x) for k, x in lines if not x.lstrip().startswith("#")]
    if len(lines) < 2:
        raise UsageError(f"{name}: a recording needs a header and at least one sample")
    mark = max(",;\t", key=lines[0][1].count)
    places = [f"{name}:{number}" for number, _ in lines]
    header, *rows = (_cells(p, x, mark) for p, (_, x) in zip(places, lines, strict=True))
    if len(set(header)) != len(header):
        raise UsageError(f"{places[0]}: two columns have the same name")
    if not {"time", "t"} & set(header):
        raise UsageError(
            f"{name}: a recording is a CSV file with a column `time` in seconds, or `t` in steps; "
            f"its header is {lines[0][1].strip()[:60]!r}"
        )
    for place, row in zip(places[1:], rows, strict=True):
        if len(row) != len(header):
            raise UsageError(f"{place}: expected {len(header)} fields, found {len(row)}")
    return _Table(name, header, tuple(places[1:]), tuple(rows))


def _cells(place: str, line: str, mark: str) -> tuple[str, ...]:
    try:
        return tuple(cell.strip() for cell in next(csv.reader([line], delimiter=mark)))
    except csv.Error as error:  # a field of more than 128 kB, a NUL
        raise UsageError(f"{place}: no line of a CSV file: {error}") from None


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _text(name: str) -> str:
    try:
        return read_input(name).decode("utf-8-sig")
    except InputError as error:
        raise UsageError(f"{name}: {error}") from None
    except UnicodeDecodeError:
        raise UsageError(f"{name}: not a CSV file: it is not UTF-8 text") from None


def _times(table: _Table, step: float) -> Array:
    """Seconds (N,) of the steps that the samples belong to: a grid from the first stamp on."""
    times = table.numbers("time" if "time" in table.header else "t")
    if isinstance(times, UsageError):
        raise times
    if "time" not in table.header:
        times = times * step
    grid = times[0] + step * np.arange(len(times))
    wrong = np.flatnonzero(~(np.abs(times - grid) <= JITTER * step))
    if not len(wrong):
        return np.asarray(grid, dtype=np.float64)
    row = int(wrong[0])
    gap, off = times[row] - times[row - 1], times[row] - grid[row]
    if abs(gap - step) > JITTER * step:
        problem = f"{gap:g} s after the sample before, but the specification's step is {step:g} s"
    else:
        problem = (
            f"the clock has drifted: {off:+g} s off step {row} after the first stamp; "
            f"{JITTER:.0%} of a step is allowed"
        )
    raise UsageError(f"{table.places[row]}: {problem}")
