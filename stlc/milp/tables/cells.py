"""Columns that say in which cell an agent is at a step, shared by everything that asks.

Link costs and threshold predicates alike use one set of columns for each (partition, agent, step,
kind). Cells are closed: on a border the columns may choose either side, so a minimisation takes
the cheapest. What comes second has ordered columns that may differ from the first ones on a border
(`borders`), and in the other kinds columns of its own.

Position and indicators s over intervals [lo_i, hi_i]:

    sum_i lo_i s_i <= p <= sum_i hi_i s_i                                       (2 rows an axis)

Sizes for m_x by m_y intervals in reach, k cells, B(m) = ceil(log2 m); layers of height are a third
axis like the others, with its own intervals, 2 more rows and the same counts of its own:

ordered, grid     (m_x - 1) + (m_y - 1) binaries; rows 4 + max(0, m_x - 2) + max(0, m_y - 2)
ordered, boxes    the same binaries and k columns; rows 5 + the ordering rows + the index rows
one-hot           k binaries; rows 5
gray, grid        m_x + m_y columns and B(m_x) + B(m_y) binaries; rows 6 + B(m_x) + B(m_y)
gray, boxes       k columns and B(k) binaries; rows 5 + B(k)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.builder import ModelBuilder
from stlc.milp.context import Context
from stlc.milp.tables.borders import beside
from stlc.milp.tables.boxes import join_boxes
from stlc.milp.tables.simplex import (
    Kind,
    Simplex,
    gray,
    join,
    of_columns,
    of_ordered,
    one_hot,
    ordered,
)
from stlc.milp.tables.spans import Reach, Spans, reach
from stlc.milp.tables.users import turn_of


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """A marginal: cells (k,) labelled by which indicator they add up to."""

    labels: Ints
    simplex: Simplex


@dataclass(frozen=True, slots=True)
class Place:
    """An agent at a step, on a partition, as one user sees it.

    `whole`: what the user's ordered columns differ by on a border is integer.
    """

    spans: Spans
    agent: str
    step: int
    user: bytes = b""
    whole: bool = False

    def reach(self, ctx: Context) -> Reach:
        """The cells it can be in."""
        return reach(ctx, self.spans, self.agent, self.step)

    def key(self, what: str) -> tuple[object, ...]:
        """Memo key of something made for this place."""
        return ("tables", what, self.spans.key, self.agent, self.step, self.user)

    @property
    def shared(self) -> Place:
        """The place as the first user sees it."""
        return replace(self, user=b"", whole=False)

    def name(self, what: str) -> str:
        """Name of a block made for this place."""
        return f"{what}_{self.agent}_{self.step}"


def marginals(ctx: Context, place: Place, kind: Kind) -> tuple[Group, ...]:
    """Indicators that fix the cell: a group for each axis on a grid, else one of all cells."""
    place = _seen(ctx, place, kind)
    key = place.key(f"marginals.{kind.value}")
    if key not in ctx.memo:
        ctx.memo[key] = _marginals(ctx, place, kind)
    found: tuple[Group, ...] = ctx.memo[key]
    return found


def _seen(ctx: Context, place: Place, kind: Kind) -> Place:
    """The place whose columns a user takes: the shared ones if it is the first, else its own."""
    return place.shared if turn_of(ctx, place, kind) == 0 else place


def _marginals(ctx: Context, place: Place, kind: Kind) -> tuple[Group, ...]:
    """Groups of columns whose sums say in which cell, or part of it, an agent is: by axes, by
    cells, or by a Gray code."""
    region = place.reach(ctx)
    everything = np.arange(len(region.cells))
    if kind is Kind.ORDERED:
        axes = ordered_axes(ctx, place)
        if region.unit:
            return _axis_groups(region, [of_ordered(a) for a in axes])
        return (Group(everything, of_columns(_box_weights(ctx, place))),)
    if kind is Kind.ONE_HOT:
        return (Group(everything, _coded_cells(ctx, place, one_hot, "cell")),)
    if not region.unit:
        return (Group(everything, _coded_cells(ctx, place, gray, "cell_gray")),)
    return _axis_groups(region, [_gray_axis(ctx, place, axis) for axis in range(len(region.shape))])


def _coded_cells(
    ctx: Context, place: Place, make: Callable[[ModelBuilder, str, int], Simplex], name: str
) -> Simplex:
    """Indicators of the cells themselves, tied to the position."""
    region = place.reach(ctx)
    cells = make(ctx.builder, place.name(name), len(region.cells))
    for axis in range(len(region.shape)):
        _pin(ctx, place, axis, cells, region.low[:, axis], region.high[:, axis])
    return cells


def _gray_axis(ctx: Context, place: Place, axis: int) -> Simplex:
    """Gray-coded intervals along one axis, tied to the position."""
    edges = place.reach(ctx).edges[axis]
    simplex = gray(ctx.builder, place.name(f"{'xyz'[axis]}_gray"), len(edges) - 1)
    _pin(ctx, place, axis, simplex, edges[:-1], edges[1:])
    return simplex


def _axis_groups(region: Reach, simplices: Sequence[Simplex]) -> tuple[Group, ...]:
    return tuple(Group(region.spans[:, 2 * k], s) for k, s in enumerate(simplices))


def ordered_axes(ctx: Context, place: Place) -> tuple[Ints, ...]:
    """Ordered binaries along each axis, b_k = 1: beyond interval k; tied to the position."""
    place = _seen(ctx, place, Kind.ORDERED)
    key = place.key("axes")
    if key not in ctx.memo and place.user and place.reach(ctx).unit:
        ctx.memo[key] = tuple(
            beside(ctx, place, axis, cols)
            for axis, cols in enumerate(ordered_axes(ctx, place.shared))
        )
    if key not in ctx.memo:
        region = place.reach(ctx)
        axes = tuple(
            ordered(ctx.builder, place.name(f"{'xyz'[k]}_beyond"), size)
            for k, size in enumerate(region.shape)
        )
        ctx.memo[key] = axes
        if region.unit:
            _pin_axes(ctx, place, region, axes)
        else:
            _box_weights(ctx, place)
    found: tuple[Ints, ...] = ctx.memo[key]
    return found


def _pin_axes(ctx: Context, place: Place, region: Reach, axes: Sequence[Ints]) -> None:
    for axis, cols in enumerate(axes):
        edges = region.edges[axis]
        _pin(ctx, place, axis, of_ordered(cols), edges[:-1], edges[1:])


def _box_weights(ctx: Context, place: Place) -> Ints:
    """Continuous cell columns (k,) that ordered axis binaries force to 0 or 1 (quadtrees)."""
    key = place.key("weights")
    if key not in ctx.memo:
        region = place.reach(ctx)
        cols = ctx.builder.add_columns(place.name("cell"), (len(region.cells),), 0.0, 1.0)
        ctx.memo[key] = cols
        ctx.builder.add_dense_rows(place.name("cell_one"), cols, 1.0, 1.0, 1.0)
        join_boxes(
            ctx.builder, place.name("cell_span"), cols, region.spans, ordered_axes(ctx, place)
        )
        for axis in range(len(region.shape)):
            simplex = of_columns(cols)
            _pin(ctx, place, axis, simplex, region.low[:, axis], region.high[:, axis])
    found: Ints = ctx.memo[key]
    return found


def _pin(
    ctx: Context, place: Place, axis: int, simplex: Simplex, low: Floats, high: Floats
) -> None:
    """sum low_i s_i <= p <= sum high_i s_i along one axis."""
    position = ctx.position(place.agent, place.step, axis)
    parts = [simplex.weighted(low), simplex.weighted(high)]
    sizes = [len(position.cols) + len(p[0]) for p in parts]
    ctx.builder.add_rows(
        place.name(f"{'xyz'[axis]}_cell"),
        np.repeat([0, 1], sizes),
        np.concatenate([position.cols, parts[0][0], position.cols, parts[1][0]]),
        np.concatenate([position.values, -parts[0][1], position.values, -parts[1][1]]),
        [parts[0][2] - position.constant, -np.inf],
        [np.inf, parts[1][2] - position.constant],
        count=2,
    )


def cell_columns(ctx: Context, place: Place, kind: Kind) -> Ints:
    """One column (k,) for each cell in reach: 1 iff the agent counts as being there (memoised).

    On a grid k continuous columns joined to all axes (rows m_x + m_y + ..); else the cells' own.
    """
    place = _seen(ctx, place, kind)
    key = place.key(f"columns.{kind.value}")
    if key in ctx.memo:
        return np.asarray(ctx.memo[key])
    groups = marginals(ctx, place, kind)
    if len(groups) == 1:
        cols = groups[0].simplex.cols[:, 0]
    else:
        cols = ctx.builder.add_columns(place.name("cell"), (len(groups[0].labels),), 0.0, 1.0)
        for axis, group in zip("xyz", groups, strict=False):
            join(ctx.builder, place.name(f"cell_{axis}"), group.labels, cols, group.simplex)
    ctx.memo[key] = cols
    return cols
