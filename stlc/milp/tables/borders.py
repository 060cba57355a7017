"""A second choice of cell for an agent that stands on a border.

The ordered binaries b of an axis say in which interval the agent counts as being. Two binaries say
that it stands on a border of that interval [e_i, e_i+1], w being the widest one:

    p >= sum_i e_i+1 s_i - w (1 - up)          p <= sum_i e_i s_i + w (1 - down)

Another table's choice is columns c like b that are equal to b within an interval and move one
interval at most on a border, with b_-1 = 1 and b_m-1 = 0 beyond the ends:

    b_k - down <= c_k <= b_k + up,    b_k+1 <= c_k <= b_k-1

So only the c_k of the border itself is free. It may be fractional: indicators joined to c then
spread over touching cells only, of which one is as good as their mean. m intervals: 2 binaries
and 2 rows an axis, for each further choice m - 1 columns and 2 (m - 1) + 2 (m - 2) rows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.builder import ModelBuilder
from stlc.milp.context import Context
from stlc.milp.tables.simplex import Simplex, of_ordered

if TYPE_CHECKING:
    from stlc.milp.tables.cells import Place


def beside(ctx: Context, place: Place, axis: int, shared: Ints) -> Ints:
    """Columns (m - 1,) of a user's own choice along an axis, beside the shared binaries."""
    if not len(shared):
        return shared
    up, down = _on_border(ctx, place, axis, shared)
    name = place.name(f"{'xyz'[axis]}_beside")
    own = ctx.builder.add_columns(name, (len(shared),), 0.0, 1.0, integer=place.whole)
    _below(ctx.builder, name, np.stack([own, shared, np.full_like(own, up)], axis=1))
    _below(ctx.builder, name, np.stack([shared, own, np.full_like(own, down)], axis=1))
    for small, large in ((own[1:], shared[:-1]), (shared[1:], own[:-1])):
        if len(small):
            pairs = np.stack([small, large], axis=1)
            ctx.builder.add_dense_rows(name, pairs, [1.0, -1.0], -np.inf, 0.0)
    return own


def _below(builder: ModelBuilder, name: str, cols: Ints) -> None:
    """cols[:, 0] <= cols[:, 1] + cols[:, 2]."""
    builder.add_dense_rows(name, cols, [1.0, -1.0, -1.0], -np.inf, 0.0)


def _on_border(ctx: Context, place: Place, axis: int, shared: Ints) -> tuple[int, int]:
    """Binaries: on the upper, on the lower border of the shared interval (memoised)."""
    key = place.shared.key(f"border.{axis}")
    if key not in ctx.memo:
        edges = place.reach(ctx).edges[axis]
        width = float(np.diff(edges).max())
        cols = ctx.builder.binary(place.name(f"{'xyz'[axis]}_border"), (2,))
        intervals = of_ordered(shared)
        upper, lower = edges[1:].copy(), edges[:-1].copy()
        upper[-1] -= width  # beyond the last and before the first interval there is none: to stand
        lower[0] += width  # there means nothing, and may be out of reach by a tolerance
        _at(ctx, place, axis, intervals, upper, int(cols[0]), width)
        _at(ctx, place, axis, intervals, lower, int(cols[1]), -width)
        ctx.memo[key] = (int(cols[0]), int(cols[1]))
    found: tuple[int, int] = ctx.memo[key]
    return found


def _at(
    ctx: Context,
    place: Place,
    axis: int,
    intervals: Simplex,
    edges: Floats,
    column: int,
    width: float,
) -> None:
    """p - sum edges s - width * column >= -width; for a negative width <= -width."""
    position = ctx.position(place.agent, place.step, axis)
    cols, values, constant = intervals.weighted(edges)
    entries = np.concatenate([position.cols, cols, [column]])
    factors = np.concatenate([position.values, -values, [-width]])
    limit = constant - position.constant - width
    low, high = (limit, np.inf) if width > 0 else (-np.inf, limit)
    name = place.name(f"{'xyz'[axis]}_border")
    ctx.builder.add_rows(name, np.zeros(len(entries), np.int64), entries, factors, low, high)
