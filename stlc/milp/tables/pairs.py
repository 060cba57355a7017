"""Pair columns: one continuous column for each cell pair in reach, joined to the ends' indicators.

lambda_ij >= 0 for cells i of one end and j of the other. For every marginal group of an end (its
x axis, its y axis, or all its cells) and every indicator s_l of the group:

    sum {lambda_ij : cell i has label l} = s_l

At integer s exactly one lambda is 1, so sum_ij V_ij lambda_ij is the table's value from both
sides. With one group of cells an end this is the convex hull of cell pairs; with axis groups the
cells themselves need no columns.
"""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.context import Affine, Context
from stlc.milp.layout import PairColumns
from stlc.milp.tables.cells import cell_columns, marginals
from stlc.milp.tables.link import Link
from stlc.milp.tables.simplex import Kind, join
from stlc.milp.tables.users import COST, turn_of


def pair_columns(ctx: Context, link: Link, kind: Kind) -> Ints:
    """Columns (k_a, k_b) of a link with two moving ends, (k,) of one (memoised)."""
    if len(link.ends) == 1:
        return cell_columns(ctx, link.places[0], kind)
    key = link.key(f"pairs.{kind.value}")
    if key not in ctx.memo:
        ctx.memo[key] = _pair_columns(ctx, link, kind)
    found: Ints = ctx.memo[key]
    return found


def _pair_columns(ctx: Context, link: Link, kind: Kind) -> Ints:
    """Columns (k_a, k_b) of a link's cell pairs, joined to the marginals of both ends; leaves the
    receipt."""
    groups = [marginals(ctx, place, kind) for place in link.places]
    shape = link.shape(ctx)
    cols = ctx.builder.add_columns(link.name("pair"), shape, 0.0, 1.0)
    for end, own in enumerate(groups):
        for number, group in enumerate(own):
            labels = group.labels[:, None] if end == 0 else group.labels[None, :]
            spread = np.broadcast_to(labels, shape).ravel()
            name = link.name(f"pair_end{end}_{number}")
            join(ctx.builder, name, spread, cols.ravel(), group.simplex)
    first, second = (place.reach(ctx).cells for place in link.places)
    ends = (link.ends[0], link.ends[1])
    later = not link.user.startswith(COST)
    beside = tuple(later or turn_of(ctx, place, kind) > 0 for place in link.places)
    cells = (first, second)
    receipt = PairColumns(ends, link.step, link.spans.key, cells, cols, (beside[0], beside[1]))
    ctx.layout.pairs.append(receipt)
    return cols


def pair_value(ctx: Context, link: Link, table: Floats, kind: Kind) -> Affine:
    """The table's value at the occupied cells as an expression, exact at integer points."""
    if not link.ends:
        return Affine(np.empty(0, np.int64), np.empty(0), float(table))
    cols = pair_columns(ctx, link, kind)
    return Affine(cols.ravel(), link.reachable(ctx, table).ravel())
