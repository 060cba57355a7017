"""The paper's own encoding (Section IV-C), for comparison.

N_x by N_y equal cells of d_x by d_y, n = N_x N_y. For each agent p and step t integers
a_pt in 1..N_x, b_pt in 1..N_y, r_pt in 1..n:

    x_min + (a - 1) d_x <= x <= x_min + a d_x,   the same with y, b, d_y,   r = (a - 1) N_y + b

Layers of height, which the paper doesn't have, are a third axis: c in 1..N_z and
r = ((a - 1) N_y + b - 1) N_z + c.

and for each pair (p, q) and each cell pair (i, j) a binary O_ijt, 0 iff p is in i and q in j:

    i - r_p <= M O_ij,  r_p - i <= M O_ij,  j - r_q <= M O_ij,  r_q - j <= M O_ij
    sum_ij O_ij = n^2 - 1
    value = sum_ij V_ij (1 - O_ij)

`literal` takes one M for all rows (99999 by default); `literal-tight` the smallest valid one for
each row, from the cells that the agent can reach. For one link and step: n^2 binaries, 3 integers
an end, rows 4 n^2 + 1 + 5 an end (one moving end: n binaries, rows 2 n + 1 + 5). Cells out of
reach stay in, as in the paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.context import Affine, Context
from stlc.milp.tables.cells import Place
from stlc.milp.tables.encoding import Size
from stlc.milp.tables.errors import TableError
from stlc.milp.tables.link import Link
from stlc.milp.tables.spans import TOUCH, Spans


@dataclass(frozen=True, slots=True)
class Literal:
    """The paper's n^2 binaries, with its big-M; -tight: the smallest M for each row.

    `big_m` None asks for the smallest.
    """

    name: str = "literal"
    big_m: float | None = 99999.0

    def value(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """sum V (1 - O)."""
        if not link.ends:
            return Affine(np.empty(0, np.int64), np.empty(0), float(table))
        cols = occupancy(ctx, link, self)
        return Affine(cols.ravel(), -table.ravel(), float(table.sum()))

    def below(self, ctx: Context, link: Link, table: Floats) -> Affine:
        """The same: exact."""
        return self.value(ctx, link, table)

    def size(self, shapes: Sequence[tuple[int, ...]]) -> Size:
        """The formula above; the shapes are those of the whole grid."""
        ends = len(shapes)
        if not ends:
            return Size(0, 0, 0)
        pairs, axes = prod(prod(shape) for shape in shapes), sum(map(len, shapes))
        return Size(pairs + axes + ends, 2 * ends * pairs + 1 + 2 * axes + ends, pairs)


def occupancy(ctx: Context, link: Link, how: Literal) -> Ints:
    """The binaries O (n, n), or (n,) with one moving end (memoised)."""
    key = link.key(how.name)
    if key not in ctx.memo:
        places = [_numbers(ctx, place, how) for place in link.places]
        shape = (len(link.spans),) * len(places)
        cols = ctx.builder.binary(link.name("O"), shape)
        ctx.memo[key] = cols
        for end, (number, low, high) in enumerate(places):
            _big_m_rows(ctx, link.name(f"occupied{end}"), cols, end, number, (low, high), how)
        total = float(cols.size - 1)
        ctx.builder.add_dense_rows(link.name("occupied_one"), cols.ravel(), 1.0, total, total)
    found: Ints = ctx.memo[key]
    return found


def _big_m_rows(
    ctx: Context,
    name: str,
    cols: Ints,
    end: int,
    number: int,
    bounds: tuple[int, int],
    how: Literal,
) -> None:
    """i - r - M O <= 0 and r - i - M O <= 0 for every O, i its cell of this end."""
    cell = np.indices(cols.shape)[end].ravel() + 1.0
    entries = np.stack([np.full(cols.size, number), cols.ravel()], axis=1)
    for sign, tight in ((1.0, cell - bounds[0]), (-1.0, bounds[1] - cell)):
        big_m = np.maximum(tight, 0.0) if how.big_m is None else np.full(cols.size, how.big_m)
        values = np.stack([np.full(cols.size, -sign), -big_m], axis=1)
        side = "above" if sign > 0 else "below"
        ctx.builder.add_dense_rows(f"{name}_{side}", entries, values, -np.inf, -sign * cell)


def _numbers(ctx: Context, place: Place, how: Literal) -> tuple[int, int, int]:
    """Column of r for an agent at a step, and the smallest and largest cell number it takes."""
    key = place.key(how.name)  # every user has numbers of its own
    if key not in ctx.memo:
        shape, origin, width = uniform(place.spans)
        low, high = np.ones(len(shape), np.int64), np.array(shape)
        if how.big_m is None:
            region = place.reach(ctx)
            low = np.array(region.first) + 1
            high = np.array(region.first) + np.array(region.shape)
        axes = [
            int(ctx.builder.add_columns(place.name(n), (1,), low[k], high[k], integer=True)[0])
            for k, n in enumerate("abc"[: len(shape)])
        ]
        for axis in range(len(shape)):
            _place_rows(ctx, place, axis, axes[axis], origin[axis], width[axis])
        strides = np.array([prod(shape[k + 1 :]) for k in range(len(shape))], dtype=np.int64)
        rest = 1 - int(strides.sum())
        first, last = (int(strides @ v) + rest for v in (low, high))
        number = ctx.builder.add_columns(place.name("r"), (1,), first, last, integer=True)
        ctx.builder.add_dense_rows(
            place.name("number"), [[*number, *axes]], [[1.0, *(-strides)]], rest, rest
        )
        ctx.memo[key] = (int(number[0]), first, last)
    found: tuple[int, int, int] = ctx.memo[key]
    return found


def _place_rows(
    ctx: Context, place: Place, axis: int, col: int, origin: float, width: float
) -> None:
    """origin + (a - 1) width <= position <= origin + a width."""
    position = ctx.position(place.agent, place.step, axis)
    cols = np.append(position.cols, col)
    values = np.append(position.values, -width)
    base = origin - position.constant
    lower, upper = [base - width, -np.inf], [np.inf, base]
    ctx.builder.add_dense_rows(
        place.name(f"{'xyz'[axis]}_cell"), np.stack([cols, cols]), values, lower, upper
    )


def uniform(spans: Spans) -> tuple[tuple[int, ...], tuple[float, ...], tuple[float, ...]]:
    """Shape, lower corner and cell size [m] of a uniform grid numbered ix * N_y + iy.

    Raises TableError for any other partition.
    """
    shape = spans.shape
    grid = np.indices(shape).reshape(len(shape), -1).T
    is_grid = len(spans) == len(grid) and np.array_equal(spans.spans, np.repeat(grid, 2, axis=1))
    widths = [np.diff(e) for e in spans.edges]
    if not is_grid or any(np.ptp(w) > TOUCH for w in widths):
        raise TableError("the literal encoding needs a uniform grid; use unary for this partition")
    origin = tuple(float(edges[0]) for edges in spans.edges)
    return shape, origin, tuple(float(w.mean()) for w in widths)
