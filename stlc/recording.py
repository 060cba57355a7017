"""Recorded signals, read from CSV."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.errors import UsageError
from stlc.inputs import InputError, read_input

Array = NDArray[np.float64]

STEP_SLACK = 1e-3
"""Recorded times may differ from the grid by this share of a step."""


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """A table of signals: `times` (N,) [s] on a regular grid, `columns` (N,) by name."""

    name: str
    times: Array
    columns: Mapping[str, Array]


def read_recording(path: str | os.PathLike[str], step: float) -> Recording:
    """Read a CSV with a header and a column `time` [s] (or `t`, counting steps).

    Fields are parted by commas, semicolons or tabs; lines that begin with # are left out. Raises
    UsageError, with the line, for anything that isn't a regular recording with this step.
    """
    name = os.fspath(path)
    lines = [(k, x) for k, x in enumerate(_text(name).splitlines(), 1) if x.strip()]
    lines = [(k, x) for k, x in lines if not x.lstrip().startswith("#")]
    if len(lines) < 2:
        raise UsageError(f"{name}: a recording needs a header and at least one sample")
    mark = max(",;\t", key=lines[0][1].count)
    header = [cell.strip() for cell in next(csv.reader([lines[0][1]], delimiter=mark))]
    if len(set(header)) != len(header):
        raise UsageError(f"{name}:{lines[0][0]}: two columns have the same name")
    if not {"time", "t"} & set(header):
        raise UsageError(
            f"{name}: a recording is a CSV file with a column `time` in seconds, or `t` in steps; "
            f"its header is {lines[0][1].strip()[:60]!r}"
        )
    table = np.empty((len(lines) - 1, len(header)))
    for row, (number, line) in enumerate(lines[1:]):
        table[row] = _numbers(f"{name}:{number}", line, mark, header)
    columns = {column: table[:, k] for k, column in enumerate(header)}
    times = _times(name, columns, step, [number for number, _ in lines[1:]])
    return Recording(name, times, columns)


def _text(name: str) -> str:
    try:
        return read_input(name).decode("utf-8-sig")
    except InputError as error:
        raise UsageError(f"{name}: {error}") from None
    except UnicodeDecodeError:
        raise UsageError(f"{name}: not a CSV file: it is not UTF-8 text") from None


def _numbers(place: str, line: str, mark: str, header: Sequence[str]) -> list[float]:
    cells = next(csv.reader([line], delimiter=mark))
    if len(cells) != len(header):
        raise UsageError(f"{place}: expected {len(header)} fields, found {len(cells)}")
    values = []
    for column, cell in zip(header, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            raise UsageError(f"{place}: {column} is no number: {cell.strip()[:40]!r}") from None
        if not math.isfinite(value):
            raise UsageError(f"{place}: {column} is not finite: {cell.strip()[:40]!r}")
        values.append(value)
    return values


def _times(name: str, columns: Mapping[str, Array], step: float, numbers: Sequence[int]) -> Array:
    """Seconds (N,) of the samples, checked against the step."""
    times = columns["time"] if "time" in columns else columns["t"] * step
    gaps = np.diff(times)
    wrong = np.flatnonzero(np.abs(gaps - step) > STEP_SLACK * step)
    if len(wrong):
        row = int(wrong[0])
        raise UsageError(
            f"{name}:{numbers[row + 1]}: {gaps[row]:g} s after the sample before, but the "
            f"specification's step is {step:g} s"
        )
    return times
