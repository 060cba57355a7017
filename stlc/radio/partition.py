"""Cells of the workspace on which a channel is tabulated.

A grid numbers its cells ix * ny + iy (columns of constant x one after the other), and where it has
layers of height too (ix * ny + iy) * nz + iz. A quadtree, of the plane alone, has no axes of its
own; `common_grid` gives the coarsest grid that refines it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

TOUCH = 1e-6
"""A point this close [m] to a cell is counted in it."""


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """Closed axis-aligned cells with disjoint interiors.

    boxes  (n, 2 D) [m]: x_lo, x_hi, y_lo, y_hi and, with D = 3, z_lo, z_hi
    edges  for a grid its increasing edges along each axis [m], one more than cells; else None
    inner  the same cells before some went on beyond a box (`carried_on`); None where none does
    """

    boxes: Array
    edges: tuple[Array, ...] | None = None
    inner: Partition | None = None

    def __post_init__(self) -> None:
        if self.boxes.ndim != 2 or self.boxes.shape[1] not in (4, 6) or not len(self.boxes):
            raise RadioError(
                f"a partition needs boxes of shape (n, 4) or (n, 6), not {self.boxes.shape}"
            )
        width = self.boxes[:, 1::2] - self.boxes[:, 0::2]
        if not (np.isfinite(self.boxes).all() and (width > 0).all()):
            raise RadioError("every cell of a partition needs a width above 0 along each axis")

    def __len__(self) -> int:
        return len(self.boxes)

    @property
    def axes(self) -> int:
        """D: 2 in the plane, 3 with layers of height."""
        return int(self.boxes.shape[1]) // 2

    @property
    def shape(self) -> tuple[int, ...] | None:
        """Cells along each axis of a grid, else None."""
        return None if self.edges is None else tuple(len(e) - 1 for e in self.edges)

    @property
    def low(self) -> Array:
        """Lower corners (n, D) [m]."""
        return self.boxes[:, 0::2]

    @property
    def high(self) -> Array:
        """Upper corners (n, D) [m]."""
        return self.boxes[:, 1::2]

    @property
    def centres(self) -> Array:
        """Centres (n, D) [m]."""
        return np.asarray((self.low + self.high) / 2.0, dtype=np.float64)

    def cells_at(self, point: Sequence[float] | Array, tolerance: float = TOUCH) -> Ints:
        """Every cell that touches the point (D,) [m]; several at a border, none outside."""
        return self.touching(np.asarray(point), np.asarray(point), tolerance)

    def touching(self, low: Array, high: Array, tolerance: float = TOUCH) -> Ints:
        """Every cell that meets the closed box from `low` (D,) to `high` (D,) [m]."""
        meets = (self.low <= high + tolerance) & (self.high >= low - tolerance)
        return np.asarray(np.flatnonzero(meets.all(axis=1)), dtype=np.intp)

    def clip(self, low: Sequence[float], high: Sequence[float]) -> Partition:
        """The cells cut to a box [m]; cells that only touch it are left out.

        Raises RadioError when nothing is left.
        """
        if self.edges is not None:
            axes = [_clip_edges(e, low[k], high[k]) for k, e in enumerate(self.edges)]
            return grid(*axes)
        boxes = self.boxes.copy()
        boxes[:, 0::2] = np.maximum(boxes[:, 0::2], low)
        boxes[:, 1::2] = np.minimum(boxes[:, 1::2], high)
        kept = (boxes[:, 1::2] - boxes[:, 0::2] > TOUCH).all(axis=1)
        return Partition(boxes[kept])

    def carried_on(self, low: Array, high: Array, by: float) -> Partition:
        """Cells at the border of a box in the plane, `low` and `high` (2,) [m], so much wider."""
        boxes = self.boxes.copy()
        edges = None if self.edges is None else [e.copy() for e in self.edges]
        for axis in (0, 1):
            first, last = boxes[:, 2 * axis], boxes[:, 2 * axis + 1]
            first[first <= low[axis] + TOUCH] -= by
            last[last >= high[axis] - TOUCH] += by
            if edges is not None:
                edges[axis][0], edges[axis][-1] = first.min(), last.max()
        return Partition(boxes, None if edges is None else tuple(edges), self.inner or self)

    def common_grid(self) -> tuple[Partition, Ints]:
        """The coarsest grid that refines this partition, and the cell (n_grid,) that holds each
        grid cell (-1 for a grid cell outside every cell)."""
        if self.edges is not None:
            return self, np.arange(len(self), dtype=np.intp)
        fine = grid(np.unique(self.boxes[:, :2]), np.unique(self.boxes[:, 2:]))
        owner = np.full(len(fine), -1, dtype=np.intp)
        for cell, (x_lo, x_hi, y_lo, y_hi) in enumerate(self.boxes):
            x, y = fine.centres[:, 0], fine.centres[:, 1]
            owner[(x > x_lo) & (x < x_hi) & (y > y_lo) & (y < y_hi)] = cell
        return fine, owner


def grid(*along: Sequence[float] | Array) -> Partition:
    """Grid with the given edges [m] along x, y and perhaps z, not necessarily uniform or square.

    Raises RadioError unless the edges are strictly increasing.
    """
    axes = [np.asarray(e, dtype=np.float64) for e in along]
    for name, edges in zip("xyz", axes, strict=False):
        if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0).all():
            raise RadioError(f"partition edges along {name} must be strictly increasing")
    low = np.meshgrid(*(e[:-1] for e in axes), indexing="ij")
    high = np.meshgrid(*(e[1:] for e in axes), indexing="ij")
    ends = [side.ravel() for both in zip(low, high, strict=True) for side in both]
    return Partition(np.column_stack(ends), tuple(axes))


def uniform_grid(
    x_range: tuple[float, float], y_range: tuple[float, float], nx: int, ny: int
) -> Partition:
    """Grid of nx by ny equal cells over a rectangle [m]."""
    return even_grid((x_range, y_range), (nx, ny))


def even_grid(ranges: Sequence[tuple[float, float]], counts: Sequence[int]) -> Partition:
    """Grid of `counts` equal cells along each axis of a box [m], of two or three.

    Raises RadioError where an axis has no cell.
    """
    if min(counts) < 1:
        such = " x ".join(map(str, counts))
        raise RadioError(f"a partition needs at least one cell along each axis, not {such}")
    return grid(*(np.linspace(*r, n + 1) for r, n in zip(ranges, counts, strict=True)))


def _clip_edges(edges: Array, low: float, high: float) -> Array:
    ends = max(low, edges[0]), min(high, edges[-1])
    inner = edges[(edges > ends[0] + TOUCH) & (edges < ends[1] - TOUCH)]
    if ends[1] - ends[0] <= TOUCH:
        raise RadioError("the partition and the workspace do not overlap")
    return np.concatenate([[ends[0]], inner, [ends[1]]])


def split_cells(partition: Partition, cells: Ints) -> Partition:
    """Replace each listed cell by its four quarters."""
    kept = np.delete(partition.boxes, cells, axis=0)
    x_lo, x_hi, y_lo, y_hi = partition.boxes[cells].T
    x_mid, y_mid = (x_lo + x_hi) / 2.0, (y_lo + y_hi) / 2.0
    parts = [kept]
    for x in ((x_lo, x_mid), (x_mid, x_hi)):
        parts += [np.column_stack([*x, *y]) for y in ((y_lo, y_mid), (y_mid, y_hi))]
    boxes = np.vstack(parts)
    return Partition(boxes[np.lexsort((boxes[:, 2], boxes[:, 0]))])


def quadtree(
    start: Partition,
    score: Callable[[Partition], Array],
    tolerance: float,
    most_cells: int,
) -> Partition:
    """Split the cells whose `score(partition)` (n,) exceeds `tolerance`, worst first, until
    none does or one more split would pass `most_cells`.

    `stlc.radio.refine` has scores for tables that vary and for thresholds that pass.
    """
    current = start
    while True:
        value = score(current)
        worst = np.argsort(-value, kind="stable")
        worst = worst[value[worst] > tolerance][: max((most_cells - len(current)) // 3, 0)]
        if not len(worst):
            return current
        current = split_cells(current, np.sort(worst))
