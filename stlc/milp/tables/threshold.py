"""Threshold predicates: a literal that forces the occupied cells into an allowed set.

The allowed set of cell pairs, in index space (ix, iy of each end), is covered exactly by boxes
k = 1..K, products of index intervals. With y_k in [0, 1] and the literal z in {0, 1}:

    sum_k y_k = z
    sum {y_k : first_k > i} <= b_i,   sum {y_k : last_k <= i} <= 1 - b_i   for each axis of each end

over the ordered axis binaries b (see `boxes`). At integer b only boxes that hold the
occupied cells keep y_k > 0, so z = 1 needs an allowed cell (pair). K columns and one binary; rows
at most 1 + 2 (binaries of the axes), however many cell pairs are allowed. K = 1 needs no y.

When no small cover is found, with pair columns lambda:

    z <= sum {lambda_ij : (i, j) allowed}      (or z + sum {lambda_ij : not allowed} <= 1)

one binary and one row, plus the pair columns. Nothing allowed fixes z = 0;
everything allowed leaves z free.
"""

from __future__ import annotations

from math import prod

import numpy as np

from stlc.arrays import Bools, Ints
from stlc.milp.context import Context
from stlc.milp.tables.boxes import join_boxes
from stlc.milp.tables.cells import ordered_axes
from stlc.milp.tables.cover import clipped, cover
from stlc.milp.tables.link import Link
from stlc.milp.tables.pairs import pair_columns
from stlc.milp.tables.simplex import Kind
from stlc.milp.tables.spans import Spans

BOXES = 4000
"""A cover of the whole table with more boxes than this, or at a step with more than a quarter
of its cell pairs, gives way to pair columns."""


def literal(ctx: Context, link: Link, allowed: Bools) -> int:
    """The literal's column (memoised); `allowed` covers all cells, one axis a moving end."""
    if not link.ends:
        return _column(ctx, link, float(allowed))
    key = (*link.key("literal"), link.reachable(ctx, allowed).tobytes())
    if key not in ctx.memo:
        ctx.memo[key] = _literal(ctx, link, allowed)
    return int(ctx.memo[key])


def _literal(ctx: Context, link: Link, allowed: Bools) -> int:
    """A column that is 1 only in `allowed` cell pairs (n, n): a constant, by boxes, or by pair
    columns."""
    seen = link.reachable(ctx, allowed)
    column = _column(ctx, link, float(seen.any()))
    if seen.all() or not seen.any():
        return column
    boxes = index_boxes(ctx, link, allowed)
    if boxes is not None:
        _by_boxes(ctx, link, column, boxes)
        return column
    _by_pairs(ctx, link, column, pair_columns(ctx, link, Kind.ORDERED), seen)
    return column


def _column(ctx: Context, link: Link, upper: float) -> int:
    return int(ctx.builder.add_columns(link.name("linked"), (1,), 0.0, upper, integer=True)[0])


def index_boxes(ctx: Context, link: Link, allowed: Bools) -> Ints | None:
    """Cover of the allowed cells in reach by index boxes (K, 2 D an end), None when it is large.

    The whole table is covered once and the boxes are cut to the intervals in reach.
    """
    key = ("tables.cover", link.spans.key, allowed.tobytes(), len(link.ends))
    if key not in ctx.memo:
        ctx.memo[key] = cover(_on_intervals(link.spans, allowed), BOXES)
    regions = [place.reach(ctx) for place in link.places]
    first = tuple(f for r in regions for f in r.first)
    shape = tuple(m for r in regions for m in r.shape)
    cut = _cut(ctx, key, first, shape)
    if cut is None or len(link.ends) == 1 or 4 * len(cut) <= prod(link.shape(ctx)):
        return cut
    return None


def _cut(
    ctx: Context, key: tuple[object, ...], first: tuple[int, ...], shape: tuple[int, ...]
) -> Ints | None:
    """The cover stored under `key`, cut to a window (memoised: many links share windows)."""
    boxes: Ints | None = ctx.memo[key]
    if boxes is None:
        return None
    window = (*key, first, shape)
    if window not in ctx.memo:
        ctx.memo[window] = clipped(boxes, np.array(first), shape)
    found: Ints = ctx.memo[window]
    return found


def _on_intervals(spans: Spans, allowed: Bools) -> Bools:
    """The allowed set over interval indices (m_x, m_y, ..) an end instead of cells.

    Intervals in no cell count as some cell: no agent can be there.
    """
    owner = np.zeros(spans.shape, np.int64)
    for cell, span in enumerate(spans.spans):
        part = tuple(slice(a, b + 1) for a, b in zip(span[0::2], span[1::2], strict=True))
        owner[part] = cell
    ends = allowed.ndim
    return allowed[np.ix_(*[owner.ravel()] * ends)].reshape(spans.shape * ends)


def _by_boxes(ctx: Context, link: Link, column: int, boxes: Ints) -> None:
    axes = [axis for place in link.places for axis in ordered_axes(ctx, place)]
    cols = np.array([column])
    if len(boxes) > 1:
        cols = ctx.builder.add_columns(link.name("box"), (len(boxes),), 0.0, 1.0)
        members, values = np.append(cols, column), np.append(np.ones(len(cols)), -1.0)
        ctx.builder.add_dense_rows(link.name("box_one"), members, values, 0.0, 0.0)
    join_boxes(ctx.builder, link.name("box"), cols, boxes, axes)


def _by_pairs(ctx: Context, link: Link, column: int, pairs: Ints, allowed: Bools) -> None:
    few = 2 * np.count_nonzero(allowed) <= allowed.size
    members = pairs[allowed] if few else pairs[~allowed]
    cols = np.append(members, column)
    values = np.append(np.full(len(members), -1.0 if few else 1.0), 1.0)
    ctx.builder.add_dense_rows(link.name("linked"), cols, values, -np.inf, 0.0 if few else 1.0)
