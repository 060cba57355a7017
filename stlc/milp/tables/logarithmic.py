"""Gray-code binaries for each axis, the pair table joined to the axis indicators they select.

Each end has continuous indicators s_i along x and y with sum 1 and B(m) = ceil(log2 m) binaries
y_l an axis with sum_i s_i bit_l(gray(i)) = y_l: at integer y one s_i is 1. The pair table is
joined to the indicators as in `unary`.

With m_x by m_y intervals in reach of an end (k cells): binaries B(m_x) + B(m_y), columns
m_x + m_y + B(m_x) + B(m_y) and rows 6 + B(m_x) + B(m_y) an end; columns k_a k_b (one end: k) and
rows m_x + m_y an end for the table. Fewest binaries; branching on a bit splits an axis into
scattered intervals, which bounds badly. On a quadtree the code is over the cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

from stlc.arrays import Floats
from stlc.milp.context import Affine, Context
from stlc.milp.tables.encoding import Size
from stlc.milp.tables.link import Link
from stlc.milp.tables.pairs import pair_value
from stlc.milp.tables.simplex import Kind, bits_for


@dataclass(frozen=True, slots=True)
class Logarithmic:
    """Gray-coded axes and joined pair columns."""

    name: str = "logarithmic"

    def value(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """sum V lambda."""
        return pair_value(ctx, link, table, Kind.GRAY)

    def below(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """The same: exact."""
        return self.value(ctx, link, table)

    def size(self, shapes: Sequence[tuple[int, ...]]) -> Size:
        """The formula above."""
        table = Size(prod(prod(s) for s in shapes), sum(sum(s) for s in shapes), 0)
        return sum((_gray_size(s) for s in shapes), table) if shapes else Size(0, 0, 0)


def _gray_size(shape: tuple[int, ...]) -> Size:
    bits = sum(bits_for(m) for m in shape)
    return Size(sum(shape) + bits, 3 * len(shape) + bits, bits)
