"""Some axis boxes of a layer in halves, and the states that are left of those that held them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stlc.arrays import Ints
from stlc.solve.relaxation.problem import Body
from stlc.solve.states.boxes import AxisGrid
from stlc.solve.states.layers import Layer
from stlc.solve.states.reached import admissible, drawn_in, reach_bits
from stlc.solve.states.steps import spread
from stlc.solve.states.tubes import Tubes


def halved(
    layer: Layer, ways: tuple[Ints, Ints], body: Body, tubes: Tubes, taken: tuple[int, ...], t: int
) -> Layer:
    """The layer of step t with boxes along each axis cut at the middle of their room, along the
    position where `ways` is 0, along the rate where it is 1; not where it is -1. `parent` numbers
    the states that hold the new ones; halves that no run reaches are left out."""
    (x, of_x), (y, of_y) = (_cut(layer.grid(d), ways[d]) for d in (0, 1))
    state, ix = _all(of_x, layer.ix)
    again, iy = _all(of_y, layer.iy[state])
    state, ix = state[again], ix[again]
    bit = layer.bit[state]
    keep = admissible(body, t, x, y, ix, iy)
    keep &= reach_bits(body, tubes, taken, t, x, y, ix, iy)[bit, np.arange(len(ix))]
    return _drawn(layer, x, y, state[keep], ix[keep], iy[keep], tubes, taken, t)


def _drawn(
    old: Layer, x: AxisGrid, y: AxisGrid, state: Ints, ix: Ints, iy: Ints, tubes: Tubes,
    taken: tuple[int, ...], t: int,
) -> Layer:  # fmt: skip
    """The layer of these states, in boxes drawn in around what is reached."""
    used_x, ix = np.unique(ix, return_inverse=True)
    used_y, iy = np.unique(iy, return_inverse=True)
    x, y = drawn_in(tubes, taken, t, x.take(used_x), y.take(used_y))
    bit, cell = old.bit[state], old.cell[state]
    order = np.lexsort((iy, ix, bit, cell))
    return Layer(x, y, ix[order], iy[order], bit[order], cell[order], state[order])


def _all(owners: Ints, boxes: Ints) -> tuple[Ints, Ints]:
    """For each of `boxes` all its parts: (position, part), where part k is one of owners[k]."""
    order = np.argsort(owners, kind="stable")
    count = np.bincount(owners)
    position, entry = spread(np.cumsum(count) - count, count, boxes)
    return position, order[entry]


def _cut(grid: AxisGrid, ways: Ints) -> tuple[AxisGrid, Ints]:
    """The grid with some boxes cut in two, and which box each part is of."""
    owners = np.repeat(np.arange(len(ways)), np.where(ways >= 0, 2, 1))
    second = np.diff(owners, prepend=-1) == 0
    parts, way = grid.take(owners), ways[owners]
    box, room = parts.box.copy(), parts.room.copy()
    for d in (0, 1):
        middle = room[:, 2 * d : 2 * d + 2].mean(1)
        for half, end in ((way == d) & ~second, 2 * d + 1), ((way == d) & second, 2 * d):
            box[half, end] = room[half, end] = middle[half]
    host = np.where(parts.thin[:, None], parts.host, box[:, :2])
    return replace(parts, box=box, room=room, host=host), owners
