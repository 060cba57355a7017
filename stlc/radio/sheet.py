"""Delimited text as rows of cells: separators, comments, decimal commas, a row of units."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stlc.radio.content import read_text
from stlc.radio.errors import DataError, DataLocation

LARGEST = 1e9
"""Values beyond this are mistakes in any unit."""

SEPARATORS = (";", "\t", ",", " ")
"""The first of these in the first line parts its cells: a comma beside semicolons is a decimal."""

UNIT_WORDS = re.compile(r"[\[(]?(m|cm|mm|km|dbm|db|s|ms|-|)[\])]?")


@dataclass(frozen=True, slots=True)
class Sheet:
    """Cells of a file by line number; lines that are empty or start with `#` are left out.

    comments: (line, cells) of the lines that start with `#`, without the sign
    """

    path: str
    separator: str
    rows: tuple[tuple[int, tuple[str, ...]], ...]
    comments: tuple[tuple[int, tuple[str, ...]], ...]

    def number(self, cell: str, line: int, column: int) -> float:
        """A cell's number; decimal commas are read where a comma parts no cells.

        Raises DataError located at the cell (column from 0).
        """
        where = DataLocation(self.path, line, column + 1)
        value = self.parsed(cell)
        if value is None:
            raise DataError(f"{cell!r} is not a number", where)
        if value - value != 0.0:
            raise DataError(f"{cell!r} is not a finite number", where)
        if abs(value) > LARGEST:
            raise DataError(f"{cell!r} is out of range", where)
        return value

    def parsed(self, cell: str) -> float | None:
        """The number in a cell, perhaps NaN or infinite; None where there is none."""
        text = cell.strip().replace("\N{MINUS SIGN}", "-")
        if self.separator != "," and text.count(",") == 1 and "." not in text:
            text = text.replace(",", ".")
        try:
            return float(text)
        except ValueError:
            return None

    def check_width(self, width: int, what: str) -> None:
        """Raise DataError for a row that hasn't `width` cells; `what` says whose width it is."""
        for line, row in self.rows:
            if len(row) == width:
                continue
            text = f"{len(row)} values where the {what} {width}"
            commas = self.separator == "," and len(row) > width
            hint = "with decimal commas part the columns by `;`" if commas else ""
            raise DataError(text, DataLocation(self.path, line), hint)

    def without_units(self) -> tuple[tuple[str, ...], Sheet]:
        """Units of the columns, from a row of them at the top (else blank), and the rest."""
        first = self.rows[0][1] if self.rows else ()
        words = [cell.strip().lower() for cell in first]
        if not any(words) or not all(not w or UNIT_WORDS.fullmatch(w) for w in words):
            return (), self
        units = tuple(word.strip("[()]-") for word in words)
        return units, Sheet(self.path, self.separator, self.rows[1:], self.comments)


def read_sheet(path: Path) -> Sheet:
    """The rows of a text file, optionally gzipped. Raises DataError."""
    text = read_text(path)
    lines = text.splitlines(keepends=True)
    body = [k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    separator = _separator(lines[body[0]] if body else "")
    # comments and empty lines stay as empty lines, so that the line numbers do
    blank = "".join(lines[k] if k in set(body) else "\n" for k in range(len(lines)))
    noted = [(k + 1, line[1:].strip()) for k, line in enumerate(lines) if line.startswith("#")]
    reader = csv.reader(io.StringIO(blank), delimiter=separator, skipinitialspace=True)
    rows: list[tuple[int, tuple[str, ...]]] = []
    try:
        for row in reader:
            cells = _trimmed(row) if separator == " " else row
            if any(cell.strip() for cell in cells):
                rows.append((reader.line_num, tuple(cells)))
    except csv.Error as error:  # a field of more than 128 kB
        where = DataLocation(str(path), reader.line_num)
        raise DataError(f"not a CSV file: {error}", where) from error
    comments = tuple((k, tuple(_cells(note, separator))) for k, note in noted)
    return Sheet(str(path), separator, tuple(rows), comments)


def _separator(line: str) -> str:
    return next((mark for mark in SEPARATORS if mark in line.strip()), ",")


def _cells(line: str, separator: str) -> Sequence[str]:
    return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])


def _trimmed(row: Sequence[str]) -> list[str]:
    """Cells without those that runs of spaces leave."""
    return [cell for cell in row if cell]
