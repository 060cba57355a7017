"""Received strengths as receivers write them: numbers, marks for packets not heard, nonsense."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import DataError, DataLocation
from stlc.radio.sheet import LARGEST, Sheet

Array = NDArray[np.float64]

WEAKEST = -174.0
"""Thermal noise of one hertz [dBm]: no receiver hears less."""

RELATIVE = 199.0
"""Strengths relative to something unknown [dB] stay within plus and minus this."""

REMEDY = (
    "if it marks packets that were not heard, say so: `floor -100 dBm not_heard {mark}` in a "
    "mission, `--floor -100 --not-heard {mark}` of `stlc fit`; else leave the row out"
)


@dataclass(frozen=True, slots=True)
class Strengths:
    """What the cells of a column of strengths may be.

    relative   in dB of an unknown reference, else in dBm
    floor      [dBm] at or below which samples are censored; None: never
    not_heard  cells, as numbers or texts, that stand for packets below the floor
    """

    relative: bool
    floor: float | None
    not_heard: tuple[str, ...] = ()

    def read(self, sheet: Sheet, cells: Sequence[tuple[int, str]], column: int) -> Array:
        """Strengths (K,) of (line, cell); those not heard lie at the floor.

        Raises DataError at the first cell that can be no strength, with the remedy.
        """
        if self.not_heard and self.floor is None:
            text = "what was not heard needs a floor below which it lies"
            raise DataError(text, DataLocation(sheet.path), "add `floor -100 dBm`, say")
        level = np.empty(len(cells))
        for k, (line, cell) in enumerate(cells):
            value = sheet.parsed(cell)
            if self._unheard(sheet, cell, value):
                level[k] = self.floor
                continue
            fault = self._fault(cell, value)
            if fault or value is None:
                where = DataLocation(sheet.path, line, column + 1)
                raise DataError(fault + _alike(cell, cells), where, _remedy(cell, value))
            level[k] = value
        return level

    def _unheard(self, sheet: Sheet, cell: str, value: float | None) -> bool:
        if cell.strip().lower() in (mark.strip().lower() for mark in self.not_heard):
            return True
        return value is not None and value in map(sheet.parsed, self.not_heard)

    def _fault(self, cell: str, value: float | None) -> str:
        """Why a cell is no strength; empty for one that may be."""
        if value is None:
            return f"{cell!r} is not a number" if cell.strip() else "no strength is given"
        if not np.isfinite(value):
            return f"{cell!r} is not a finite number"
        if abs(value) > LARGEST:
            return f"{cell!r} is out of range"
        if self.relative:
            return f"{value:g} dB is no difference of strengths" if abs(value) > RELATIVE else ""
        if value >= 0.0:
            return f"{value:g} dBm is more than a receiver measures"
        hidden = self.floor is not None and value <= self.floor
        return "" if value > WEAKEST or hidden else f"{value:g} dBm is below thermal noise"


def _alike(cell: str, cells: Sequence[tuple[int, str]]) -> str:
    count = sum(other.strip() == cell.strip() for _, other in cells) - 1
    return f" (and {count} more such {'row' if count == 1 else 'rows'})" if count else ""


def _remedy(cell: str, value: float | None) -> str:
    """How to declare the cell as not heard; nothing for a word that nobody would mean so."""
    text = cell.strip()
    mark = f"{value:g}" if value is not None and np.isfinite(value) else f'"{text}"'
    relative = "; name the column rss_db if its strengths are relative"
    positive = value is not None and value >= 0.0
    return REMEDY.format(mark=mark) + (relative if positive else "")
