"""States of one agent at each step: axis boxes, and whether its choice over time is behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Axis, Body, Problem
from stlc.solve.states.boxes import AxisGrid, axis_grid, point_grid
from stlc.solve.states.reached import MARGIN, admissible, drawn_in, reach_bits
from stlc.solve.states.tubes import Tubes


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """States (n,), sorted by cell: axis boxes x[ix], y[iy]; bit 1: the choice is behind.

    `parent` numbers the state of the layer this one was made from.
    """

    x: AxisGrid
    y: AxisGrid
    ix: Ints
    iy: Ints
    bit: Ints
    cell: Ints
    parent: Ints

    def __len__(self) -> int:
        return len(self.ix)

    def grid(self, d: int) -> AxisGrid:
        """The boxes along an axis."""
        return self.x if d == 0 else self.y

    def priced(self, x: Floats, y: Floats) -> Layer:
        """With these slopes of the potentials in the boxes along each axis."""
        return replace(self, x=replace(self.x, slope=x), y=replace(self.y, slope=y))

    def bounds(self) -> Floats:
        """(2, 4): p_lo, p_hi, w_lo, w_hi of all states along each axis."""
        boxes = (self.x.room[self.ix], self.y.room[self.iy])
        return np.array(
            [[b[:, 0].min(), b[:, 1].max(), b[:, 2].min(), b[:, 3].max()] for b in boxes]
        )


def start_layer(body: Body) -> Layer:
    """The start, with the choice ahead (or nothing to choose: behind)."""
    zero = np.zeros(1, np.int64)
    bit = zero if body.places else zero + 1
    x, y = (point_grid(*axis.start) for axis in body.axes)
    return Layer(x, y, zero, zero, bit, zero, zero)


@dataclass(frozen=True, slots=True, eq=False)
class Maker:
    """Makes the layers of one agent. `bins` (2,) arrays of rate borders along each axis; `kind` of
    all boxes."""

    problem: Problem
    body: Body
    tubes: Tubes
    taken: tuple[int, ...]
    bins: tuple[Floats, Floats]
    kind: int = -1

    def by_choice(self, old: Sequence[Layer]) -> list[Layer]:
        """Children of `old` for each alternative by itself: its runs alone, within its tubes, so
        that their boxes are smaller and have slopes of their own."""
        parts = [replace(self, taken=(j,), kind=j).layers(old) for j in self.taken]
        return [parts[0][0], *(_joined(row) for row in list(zip(*parts, strict=True))[1:])]

    def layers(self, old: Sequence[Layer] | None = None) -> list[Layer]:
        """Layers 0..T; with `old` only children of its states."""
        grids = [
            axis_grid(
                self.problem.edges[d], _faces(self.body, d), self.bins[d], self.problem.borders
            )
            for d in (0, 1)
        ]
        grids = [replace(g, kind=np.full(len(g.box), self.kind)) for g in grids]
        out = [start_layer(self.body)]
        for t in range(1, self.problem.steps + 1):
            out.append(self._layer(t, grids[0], grids[1], old[t] if old else None))
        return out

    def _layer(self, t: int, x: AxisGrid, y: AxisGrid, old: Layer | None) -> Layer:
        """The states of step t over two axis grids: those of cells of the partition, admissible and
        within the tubes; as children of `old`'s states where it is given."""
        x, y = (_within(g, axis.box[t]) for g, axis in zip((x, y), self.body.axes, strict=True))
        if old is None:
            grid = np.indices((len(x.box), len(y.box))).reshape(2, -1)
            ix, iy = grid
            parent = np.zeros((2, len(ix)), np.int64)
        else:
            ix, iy, parent = _children(x, y, old)
            x, y = _inheriting(x, old.x), _inheriting(y, old.y)
        cell = x.cell[ix] * self.problem.shape[1] + y.cell[iy]
        keep = self.problem.owner[cell] >= 0
        keep &= admissible(self.body, t, x, y, ix, iy)
        ix, iy, parent = ix[keep], iy[keep], parent[:, keep]
        alive = reach_bits(self.body, self.tubes, self.taken, t, x, y, ix, iy) & (parent >= 0)
        bit, position = np.nonzero(alive)
        return self._sorted(t, x, y, ix[position], iy[position], bit, parent[bit, position])

    def _sorted(
        self, t: int, x: AxisGrid, y: AxisGrid, ix: Ints, iy: Ints, bit: Ints, parent: Ints
    ) -> Layer:
        used_x, ix = np.unique(ix, return_inverse=True)
        used_y, iy = np.unique(iy, return_inverse=True)
        x, y = x.take(used_x), y.take(used_y)
        x, y = drawn_in(self.tubes, self.taken, t, x, y)
        cell = x.cell[ix] * self.problem.shape[1] + y.cell[iy]
        order = np.lexsort((iy, ix, bit, cell))
        return Layer(x, y, ix[order], iy[order], bit[order], cell[order], parent[order])


def _joined(layers: Sequence[Layer]) -> Layer:
    """All states of several layers, in boxes of their own."""
    x, y = (_side_by_side([layer.grid(d) for layer in layers]) for d in (0, 1))
    first_x, first_y = (
        np.cumsum([0, *(len(layer.grid(d).box) for layer in layers[:-1])]) for d in (0, 1)
    )
    ix = np.concatenate([layer.ix + k for layer, k in zip(layers, first_x, strict=True)])
    iy = np.concatenate([layer.iy + k for layer, k in zip(layers, first_y, strict=True)])
    bit, cell, parent = (
        np.concatenate(parts)
        for parts in zip(*((k.bit, k.cell, k.parent) for k in layers), strict=True)
    )
    order = np.lexsort((iy, ix, bit, cell))
    return Layer(x, y, ix[order], iy[order], bit[order], cell[order], parent[order])


def _side_by_side(grids: Sequence[AxisGrid]) -> AxisGrid:
    """The boxes of all grids."""
    box, cell, thin, host, room, slope, kind = (
        np.concatenate(parts)
        for parts in zip(
            *((g.box, g.cell, g.thin, g.host, g.room, g.slope, g.kind) for g in grids), strict=True
        )
    )
    return AxisGrid(box, cell, thin, host, room, slope, kind, grids[0].borders)


def _faces(body: Body, d: int) -> list[float]:
    faces = {
        float(v)
        for groups in body.avoid.values()
        for group in groups
        for box in group
        for v in box[d]
        if np.isfinite(v)
    }
    return sorted(faces)


def _within(grid: AxisGrid, box: Floats) -> AxisGrid:
    """Boxes that meet the range of a step."""
    b = grid.box
    meets = (b[:, 0] <= box[1] + MARGIN) & (b[:, 1] >= box[0] - MARGIN)
    meets &= (b[:, 2] <= box[3] + MARGIN) & (b[:, 3] >= box[2] - MARGIN)
    return grid.take(np.flatnonzero(meets))


def with_choice(
    body: Body, tubes: Tubes, part: Sequence[int], row: Sequence[Layer]
) -> tuple[list[Layer], list[Ints]]:
    """Layers 0..T of runs that take one of `part`, and the states of `row` they keep."""
    made, kept = [row[0]], [np.arange(len(row[0]))]
    for t, layer in enumerate(row[1:], start=1):
        bits = reach_bits(body, tubes, part, t, layer.x, layer.y, layer.ix, layer.iy)
        keep = np.asarray(bits[layer.bit, np.arange(len(layer))], dtype=bool)
        kind = layer.x.kind[layer.ix]
        keep &= (kind < 0) | np.isin(kind, part)
        x, y = drawn_in(tubes, part, t, layer.x, layer.y)
        made.append(restrict(replace(layer, x=x, y=y), keep))
        kept.append(np.flatnonzero(keep))
    return made, kept


def cells_of(mask: Bools, a: Layer, b: Layer, cells: int) -> Bools:
    """(cells, cells): cell pairs of the pairs of states of two layers that are in the mask."""
    found = np.zeros((cells, cells), bool)
    i, j = np.nonzero(mask)
    found[a.cell[i], b.cell[j]] = True
    return found


def _children(x: AxisGrid, y: AxisGrid, old: Layer) -> tuple[Ints, Ints, Ints]:
    """Boxes within states of `old`, and for both bits the state (or -1)."""
    table = np.full((2, len(old.x.box) + 1, len(old.y.box) + 1), -1, np.int64)
    table[old.bit, old.ix, old.iy] = np.arange(len(old))
    full = np.maximum.reduce(
        [table[:, px][:, :, py] for px in _parents(x, old.x) for py in _parents(y, old.y)]
    )
    ix, iy = np.nonzero((full >= 0).any(0))
    return ix, iy, full[:, ix, iy]


def _inheriting(fine: AxisGrid, coarse: AxisGrid) -> AxisGrid:
    """Fine boxes with the slopes of those that hold them."""
    slope = coarse.slope[_parents(fine, coarse)[0]]
    return replace(fine, slope=slope)


def _parents(fine: AxisGrid, coarse: AxisGrid) -> Ints:
    """(k, n): for each fine box the coarse boxes that hold it, filled up with -1. A border that
    has become a cell lies in those on both sides."""
    a, b = fine.box[:, None, :], coarse.box[None, :, :]
    inside = (a[..., 0] >= b[..., 0] - 1e-9) & (a[..., 1] <= b[..., 1] + 1e-9)
    inside &= (a[..., 2] >= b[..., 2] - 1e-9) & (a[..., 3] <= b[..., 3] + 1e-9)
    if fine.borders and not coarse.borders:
        inside &= np.abs(fine.cell[:, None] - 2 * coarse.cell[None]) <= 1
    else:
        inside &= fine.cell[:, None] == coarse.cell[None]
        inside &= fine.thin[:, None] == coarse.thin[None]
    inside &= (fine.kind[:, None] == coarse.kind[None]) | (coarse.kind[None] < 0)
    order = np.argsort(~inside, axis=1, kind="stable")[:, : max(1, int(inside.sum(1).max()))]
    return np.where(np.take_along_axis(inside, order, axis=1), order, -1).T


def restrict(layer: Layer, keep: Bools) -> Layer:
    """Only the kept states; `parent` then numbers the states of `layer`."""
    index = np.flatnonzero(keep)
    used_x, ix = np.unique(layer.ix[index], return_inverse=True)
    used_y, iy = np.unique(layer.iy[index], return_inverse=True)
    return Layer(
        layer.x.take(used_x), layer.y.take(used_y), ix, iy, layer.bit[index],
        layer.cell[index], index,
    )  # fmt: skip


def sloped(layers: Sequence[Layer], pi: Floats) -> list[Layer]:
    """Layers with potentials pi (T+1, 2 axes, 2: slopes on p and w), the same in all boxes."""
    return [
        layer.priced(*(np.broadcast_to(pi[t, d], (len(layer.grid(d).box), 2)) for d in (0, 1)))
        for t, layer in enumerate(layers)
    ]


def rate_borders(axis: Axis, count: int) -> Floats:
    """Borders of the bins of an axis's rate: one bin where it has no inertia."""
    bins = 1 if axis.speed is None else count
    return np.linspace(axis.box[1:, 2].min(), axis.box[1:, 3].max(), bins + 1)
