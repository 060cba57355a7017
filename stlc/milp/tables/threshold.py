"""Threshold predicates: a literal that forces the occupied cells into an allowed set.

The allowed set of cell pairs, in index space (ix, iy of each end), is covered exactly by boxes
k = 1..K, products of index intervals. With y_k in [0, 1] and the literal z in {0, 1}:

    sum_k y_k = z
    sum {y_k : first_k > i} <= b_i,   sum {y_k : last_k <= i} <= 1 - b_i   for each axis of each end

over the ordered axis binaries b (see `cells.join_boxes`). At integer b only boxes that hold the
occupied cells keep y_k > 0, so z = 1 needs an allowed cell (pair). K columns and one binary; rows
at most 1 + 2 (binaries of the axes), however many cell pairs are allowed. K = 1 needs no y.

When no small cover is found, or the pair columns lambda of a link cost are there already:

    z <= sum {lambda_ij : (i, j) allowed}      (or z + sum {lambda_ij : not allowed} <= 1)

one binary and one row, plus the pair columns if they are new. Nothing allowed fixes z = 0;
everything allowed leaves z free.
"""

from __future__ import annotations

import numpy as np

from stlc.milp.context import Context
from stlc.milp.model import Ints
from stlc.milp.tables.cells import join_boxes, ordered_axes
from stlc.milp.tables.cover import Bools, cover
from stlc.milp.tables.link import Link
from stlc.milp.tables.pairs import existing_pair_columns, pair_columns
from stlc.milp.tables.simplex import Kind

BOXES = 400
"""Covers with more boxes than this, or than a quarter of the cell pairs, use pair columns."""


def literal(ctx: Context, link: Link, allowed: Bools) -> int:
    """The literal's column (memoised); `allowed` covers all cells, one axis a moving end."""
    if not link.ends:
        return int(
            ctx.builder.add_columns(link.name("linked"), (1,), 0.0, float(allowed), integer=True)[0]
        )
    seen = link.reachable(ctx, allowed)
    key = (*link.key("literal"), seen.tobytes())
    if key not in ctx.memo:
        ctx.memo[key] = _literal(ctx, link, seen)
    return int(ctx.memo[key])


def _literal(ctx: Context, link: Link, allowed: Bools) -> int:
    upper = float(allowed.any())
    column = int(ctx.builder.add_columns(link.name("linked"), (1,), 0.0, upper, integer=True)[0])
    if allowed.all() or not allowed.any():
        return column
    pairs = existing_pair_columns(ctx, link)
    if pairs is None:
        boxes = index_boxes(ctx, link, allowed)
        if boxes is not None:
            _by_boxes(ctx, link, column, boxes)
            return column
        pairs = pair_columns(ctx, link, Kind.ORDERED)
    _by_pairs(ctx, link, column, pairs, allowed)
    return column


def index_boxes(ctx: Context, link: Link, allowed: Bools) -> Ints | None:
    """Cover of the allowed cells by index boxes (K, 4 an end), None when it is large."""
    regions = [place.reach(ctx) for place in link.places]
    shape = tuple(m for r in regions for m in r.shape)
    expanded = allowed
    for end, region in enumerate(regions):
        expanded = np.moveaxis(expanded, end, -1)[..., _owner(region.spans, region.shape)]
        expanded = np.moveaxis(expanded, -1, end)
    most = BOXES if len(regions) == 1 else min(BOXES, allowed.size // 4)
    return cover(expanded.reshape(shape), most)


def _owner(spans: Ints, shape: tuple[int, int]) -> Ints:
    """Which cell holds each interval pair, flattened (m_x m_y,)."""
    owner = np.zeros(shape, np.int64)
    for cell, (x_first, x_last, y_first, y_last) in enumerate(spans):
        owner[x_first : x_last + 1, y_first : y_last + 1] = cell
    return owner.ravel()


def _by_boxes(ctx: Context, link: Link, column: int, boxes: Ints) -> None:
    axes = [axis for place in link.places for axis in ordered_axes(ctx, place)]
    cols = np.array([column])
    if len(boxes) > 1:
        cols = ctx.builder.add_columns(link.name("box"), (len(boxes),), 0.0, 1.0)
        members, values = np.append(cols, column), np.append(np.ones(len(cols)), -1.0)
        ctx.builder.add_dense_rows(link.name("box_one"), members, values, 0.0, 0.0)
    join_boxes(ctx, link.name("box"), cols, boxes, axes)


def _by_pairs(ctx: Context, link: Link, column: int, pairs: Ints, allowed: Bools) -> None:
    few = 2 * np.count_nonzero(allowed) <= allowed.size
    members = pairs[allowed] if few else pairs[~allowed]
    cols = np.append(members, column)
    values = np.append(np.full(len(members), -1.0 if few else 1.0), 1.0)
    ctx.builder.add_dense_rows(link.name("linked"), cols, values, -np.inf, 0.0 if few else 1.0)
