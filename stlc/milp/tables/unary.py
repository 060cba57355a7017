"""Ordered ("unary") axis binaries, the pair table joined directly to the four axis one-hots.

Each end has ordered binaries b_0 >= b_1 >= ... along x and along y (b_k = 1: beyond interval k),
whose differences are the axis one-hots s_i = b_{i-1} - b_i. No cell columns:

    sum {lambda_ij : ix(i) = l} = s^{a,x}_l   for every l, the same for iy(i), ix(j), iy(j)
    value = sum_ij V_ij lambda_ij

With m_x by m_y intervals in reach of an end (k = m_x m_y cells): binaries m_x + m_y - 2 and rows
4 + max(0, m_x - 2) + max(0, m_y - 2) an end; columns k_a k_b and rows m_x + m_y an end for the
table (one moving end: columns k). On a quadtree the cells have columns of their own.
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
from stlc.milp.tables.simplex import Kind


@dataclass(frozen=True, slots=True)
class Unary:
    """Ordered axes and joined pair columns."""

    name: str = "unary"

    def value(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """sum V lambda."""
        return pair_value(ctx, link, table, Kind.ORDERED)

    def below(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """The same: exact."""
        return self.value(ctx, link, table)

    def size(self, shapes: Sequence[tuple[int, ...]]) -> Size:
        """The formula above."""
        table = Size(prod(prod(s) for s in shapes), sum(sum(s) for s in shapes), 0)
        return sum((ordered_size(s) for s in shapes), table) if shapes else Size(0, 0, 0)


def ordered_size(shape: tuple[int, ...]) -> Size:
    """Ordered axes of one end on a grid, tied to its position."""
    binaries = sum(m - 1 for m in shape)
    return Size(binaries, 2 * len(shape) + sum(max(0, m - 2) for m in shape), binaries)
