"""Lifted cuts: the table's value without any pair column.

With cell columns a_i, b_j (continuous, joined to ordered axes; 0-1 at integer points) and one
column g a link and step, for every cell i of the first end:

    g >= sum_j C_ij b_j + sum_i' alpha_ii' a_i',   alpha_ii' = min_j (C_i'j - C_ij) <= 0 at i' = i

At a = e_i', b = e_j the right side is C_ij + min_j(...) <= C_i'j, so no cut passes the value, and
the cut of i' = i attains it. The symmetric family runs over the cells j of the second end. Both
together have the root bound of the pair hull on the tables tried, which is no theorem.

With m_x by m_y intervals in reach of an end, k cells: columns 1 + k_a + k_b and rows k_a + k_b
for table and cuts, rows m_x + m_y for the cell columns of an end, and the ordered axes as in
`unary`. Non-zeros (k_a + k_b)^2 + k_a + k_b in the cuts. `value` needs the value from above too:
its cuts are those of -C, rows 2 (k_a + k_b). One moving end needs its cell columns only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import blake2b
from math import prod

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.context import Affine, Context
from stlc.milp.tables.cells import cell_columns
from stlc.milp.tables.encoding import Size
from stlc.milp.tables.link import Link
from stlc.milp.tables.pairs import pair_value
from stlc.milp.tables.simplex import Kind
from stlc.milp.tables.unary import ordered_size

CHUNK = 4_000_000
"""Table differences held at once while the coefficients are computed."""


@dataclass(frozen=True, slots=True)
class Lifted:
    """Ordered axes, cell columns, cuts."""

    name: str = "lifted"

    def value(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """A column between the cuts from below and those from above."""
        return _bounded(ctx, link, table, above=True)

    def below(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """A column above the cuts."""
        return _bounded(ctx, link, table, above=False)

    def size(self, shapes: Sequence[tuple[int, ...]]) -> Size:
        """The formula above, for `below`."""
        axes = sum((ordered_size(s) for s in shapes), Size(0, 0, 0))
        cells = sum(prod(s) for s in shapes)
        joined = axes + Size(cells, sum(sum(s) for s in shapes), 0)
        return joined + Size(1, cells, 0) if len(shapes) == 2 else joined


def _bounded(ctx: Context, link: Link, table: Floats, *, above: bool) -> Affine:
    """A column bounded by cuts over both ends' cells instead of pair columns; `above` bounds it
    from above too."""
    if len(link.ends) < 2:
        return pair_value(ctx, link, table, Kind.ORDERED)
    seen = link.reachable(ctx, table)
    # Between two choices on a border the cuts are no table: such choices are whole here.
    places = [replace(place, whole=True) for place in link.places]
    cells = [cell_columns(ctx, place, Kind.ORDERED) for place in places]
    value = ctx.builder.add_columns(link.name("link"), (1,), seen.min(), seen.max())
    _cuts(ctx, link.name("cut"), value, cells, seen, 1.0)
    if above:
        _cuts(ctx, link.name("cap"), value, cells, -seen, -1.0)
    return Affine(value, np.ones(1))


def _cuts(
    ctx: Context, name: str, value: Ints, cells: Sequence[Ints], table: Floats, sign: float
) -> None:
    """sign * value >= both families of cuts of the table."""
    for end, costs in enumerate((table, table.T)):
        count = len(costs)
        cols = np.concatenate([value, cells[1 - end], cells[end]])
        values = np.hstack([np.full((count, 1), sign), -costs, -_shared_lifting(ctx, costs)])
        ctx.builder.add_dense_rows(f"{name}_{end}", cols[None, :], values, 0.0, np.inf)


def _shared_lifting(ctx: Context, costs: Floats) -> Floats:
    """`lifting`, once for links and steps that see the same costs."""
    key = ("tables.lifting", costs.shape, blake2b(costs.tobytes()).digest())
    if key not in ctx.memo:
        ctx.memo[key] = lifting(costs)
    found: Floats = ctx.memo[key]
    return found


def lifting(costs: Floats) -> Floats:
    """alpha (k, k): alpha[i, i'] = min_j (costs[i', j] - costs[i, j])."""
    count, width = costs.shape
    alpha = np.empty((count, count))
    block = max(1, CHUNK // (count * width))
    for start in range(0, count, block):
        part = costs[None, :, :] - costs[start : start + block, None, :]
        alpha[start : start + block] = part.min(axis=2)
    return alpha
