"""What an encoding of a link table is, and how large it gets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from stlc.arrays import Floats
from stlc.milp.context import Affine, Context
from stlc.milp.tables.link import Link


@dataclass(frozen=True, slots=True)
class Size:
    """Columns (binaries included), rows and binaries that an encoding adds."""

    columns: int
    rows: int
    binaries: int

    def __add__(self, other: Size) -> Size:
        return Size(
            self.columns + other.columns, self.rows + other.rows, self.binaries + other.binaries
        )


class Encoding(Protocol):
    """One way to turn a table lookup into columns and rows.

    `table` is over all cells, (n, n) for two moving ends, (n,) for one, () for none.
    """

    @property
    def name(self) -> str:
        """Its name in options and reports."""

    def value(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """The table's value at the occupied cells: exact at integer points, both ways."""

    def below(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """At least the value at integer points, and the value itself when minimised."""

    def size(self, shapes: Sequence[tuple[int, ...]]) -> Size:
        """For one link at one step on a grid: intervals in reach (m_x, m_y, ..) of each end."""
