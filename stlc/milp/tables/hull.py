"""Hull of cell pairs: one-hot cells for each end, one continuous column for each cell pair.

    s^a_i, s^b_j in {0, 1},  sum_i s^a_i = 1,  sum_j s^b_j = 1
    sum_j lambda_ij = s^a_i,  sum_i lambda_ij = s^b_j,  lambda >= 0
    value = sum_ij V_ij lambda_ij

The convex hull of {(e_i, e_j, e_i e_j')} (Sherali & Adams 1990). With k_a and k_b cells in reach:
columns k_a k_b + k_a + k_b, rows k_a + k_b + 5 an end, binaries k_a + k_b. One moving end needs
its cells only: columns and binaries k, rows 5.
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
class Hull:
    """One-hot cells and the hull of their pairs."""

    name: str = "hull"

    def value(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """sum V lambda."""
        return pair_value(ctx, link, table, Kind.ONE_HOT)

    def below(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """The same: exact."""
        return self.value(ctx, link, table)

    def size(self, shapes: Sequence[tuple[int, ...]]) -> Size:
        """The formula above."""
        cells = [prod(s) for s in shapes]
        rows = sum(2 * len(s) + 1 for s in shapes)
        total = Size(sum(cells), rows, sum(cells))
        if len(cells) < 2:
            return total
        return total + Size(cells[0] * cells[1], sum(cells), 0)
