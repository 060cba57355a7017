"""Partitions in index space: every cell is a product of intervals between consecutive edges.

The distinct cell borders along one axis are its *edges*. On them any partition into boxes, grid
or quadtree, becomes a set of index boxes (first .. last interval along x, the same along y, and
along z where cells have layers of height), and "the agent is in cell c" becomes a pair of index
bounds for each axis. A grid has cells of one interval each.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Protocol

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.context import Context
from stlc.milp.tables.errors import TableError

TOUCH = 1e-6
"""A position this close [m] to a cell may be counted in it."""


class Cells(Protocol):
    """What is needed of a partition: closed boxes (n, 2 D) [m], x_lo, x_hi, y_lo, y_hi, .."""

    @property
    def boxes(self) -> Floats:
        """Cells with disjoint interiors."""


@dataclass(frozen=True, slots=True, eq=False)
class Spans:
    """A partition on its edges. `spans` (n, 2 D): first and last interval along x, y, .."""

    edges: tuple[Floats, ...]
    spans: Ints
    key: bytes

    def __len__(self) -> int:
        return len(self.spans)

    @property
    def shape(self) -> tuple[int, ...]:
        """Intervals along each axis."""
        return tuple(len(edges) - 1 for edges in self.edges)


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """The cells an agent can be in at a step, on the edges it can be between.

    cells  (k,) numbers in the partition
    spans  (k, 2 D) first and last interval along each axis, counted from `first`
    edges  of the intervals in reach, the outermost drawn in to the reachable range [m]
    first  number of the first interval in reach along each axis
    low, high  (k, D) corners of the cells, cut to those edges [m]
    """

    cells: Ints
    spans: Ints
    edges: tuple[Floats, ...]
    first: tuple[int, ...]
    low: Floats
    high: Floats

    @property
    def shape(self) -> tuple[int, ...]:
        """Intervals in reach along each axis."""
        return tuple(len(edges) - 1 for edges in self.edges)

    @property
    def unit(self) -> bool:
        """Every cell is one interval along each axis, and none is missing, as in a grid."""
        single = np.all(self.spans[:, 0::2] == self.spans[:, 1::2])
        return bool(single) and len(self.cells) == prod(self.shape)


def spans_of(partition: Cells) -> Spans:
    """Index form of a partition; borders closer than TOUCH are one edge."""
    boxes = np.ascontiguousarray(partition.boxes, dtype=np.float64)
    edges = tuple(_distinct(boxes[:, k : k + 2]) for k in range(0, boxes.shape[1], 2))
    columns = []
    for k, axis in enumerate(edges):
        inner = axis - TOUCH
        columns.append(np.searchsorted(inner, boxes[:, 2 * k], side="right") - 1)
        columns.append(np.searchsorted(inner, boxes[:, 2 * k + 1], side="right") - 2)
    spans = np.stack(columns, axis=1).astype(np.int64)
    return Spans(edges, spans, boxes.tobytes())


def _distinct(borders: Floats) -> Floats:
    values: Floats = np.unique(borders)
    apart = np.concatenate([[True], np.diff(values) > TOUCH])
    return np.asarray(values[apart], dtype=np.float64)


def reach(ctx: Context, spans: Spans, agent: str, step: int) -> Reach:
    """Cells that touch the agent's position range at a step (memoised).

    Raises TableError when the range lies outside the partition.
    """
    key = ("tables.reach", spans.key, agent, step)
    if key not in ctx.memo:
        ctx.memo[key] = _reach(ctx, spans, agent, step)
    found: Reach = ctx.memo[key]
    return found


def _reach(ctx: Context, spans: Spans, agent: str, step: int) -> Reach:
    """Cells that an agent can be in at a step, as index boxes over edges drawn in to its range.
    TableError where there is none."""
    ranges = ctx.ranges[agent]
    low, high = ranges.position_lower[step], ranges.position_upper[step]
    axes = range(len(spans.edges))
    bounds = [_touched(spans.edges[k], low[k], high[k]) for k in axes]
    box = np.array([[b[0], b[1]] for b in bounds])
    meets = (spans.spans[:, 1::2] >= box[:, 0]) & (spans.spans[:, 0::2] <= box[:, 1])
    cells = np.flatnonzero(meets.all(axis=1))
    if not len(cells):
        box_text = " x ".join(f"[{low[k]:g}, {high[k]:g}]" for k in axes)
        raise TableError(
            f"{agent} cannot be inside the channel's partition at step {step}: "
            f"it stays within {box_text} m"
        )
    local = np.clip(spans.spans[cells], np.repeat(box[:, 0], 2), np.repeat(box[:, 1], 2))
    local -= np.repeat(box[:, 0], 2)
    edges = tuple(_drawn_in(spans.edges[k], *bounds[k], low[k], high[k]) for k in axes)
    corners = [
        np.stack([edges[k][local[:, 2 * k + side] + side] for k in axes], axis=1)
        for side in range(2)
    ]
    return Reach(cells, local, edges, tuple(int(b) for b in box[:, 0]), corners[0], corners[1])


def _touched(edges: Floats, low: float, high: float) -> tuple[int, int]:
    """First and last interval that meets [low, high]; first > last when none does."""
    first = int(np.searchsorted(edges[1:], low - TOUCH, side="left"))
    last = int(np.searchsorted(edges[:-1], high + TOUCH, side="right")) - 1
    return first, last


def _drawn_in(edges: Floats, first: int, last: int, low: float, high: float) -> Floats:
    """The edges in reach, the outer two moved inwards to the range (never past the next edge)."""
    kept = edges[first : last + 2].copy()
    if len(kept) > 1:
        kept[0] = max(kept[0], min(low, kept[1]))
        kept[-1] = min(kept[-1], max(high, kept[-2]))
    return kept
