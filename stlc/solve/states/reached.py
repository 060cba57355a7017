"""Which boxes an agent can be in: by its speed, what it avoids, and its tubes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Body
from stlc.solve.states.boxes import EPS, AxisGrid
from stlc.solve.states.tubes import Tubes, boxes_meet, meeting

MARGIN = 1e-6


def admissible(body: Body, t: int, x: AxisGrid, y: AxisGrid, ix: Ints, iy: Ints) -> Bools:
    """Boxes that meet the speed polygon, and with some width one alternative of each avoidance.

    What touches an alternative only along a face lies in the boxes of zero width.
    """
    fine = np.ones(len(ix), bool)
    for nx, ny, c in body.faces:
        least = np.minimum(nx * x.box[:, 2], nx * x.box[:, 3])[ix]
        least = least + np.minimum(ny * y.box[:, 2], ny * y.box[:, 3])[iy]
        fine &= least <= c + EPS
    if not (x.thin.any() or y.thin.any() or body.avoid.get(t)):
        return fine
    thin_x, thin_y = x.thin[ix], y.thin[iy]
    free = {(a, b): _outside(body, t, x, y, a, b)[ix, iy] for a in (0, 1) for b in (0, 1)}
    spare = (thin_x & free[1, 0]) | (thin_y & free[0, 1]) | (thin_x & thin_y & free[1, 1])
    kept = np.logical_and(fine, free[0, 0]) & ~spare
    return np.asarray(kept, dtype=bool)


def _outside(body: Body, t: int, x: AxisGrid, y: AxisGrid, host_x: int, host_y: int) -> Bools:
    """(nx, ny): with some width in an alternative of every avoidance; hosts for thin boxes."""
    fine = np.logical_and.outer(_known(x, bool(host_x)), _known(y, bool(host_y)))
    for group in body.avoid.get(t, ()):
        some = np.zeros_like(fine)
        for box in group:
            some |= np.logical_and.outer(
                _overlaps(x, box[0], bool(host_x)), _overlaps(y, box[1], bool(host_y))
            )
        fine &= some
    return fine


def _known(grid: AxisGrid, host: bool) -> Bools:
    """Boxes, or those that have a host: borders that are cells themselves have none."""
    part = grid.host if host else grid.box[:, :2]
    return np.asarray(part[:, 0] <= part[:, 1])


def _overlaps(grid: AxisGrid, span: Floats, host: bool) -> Bools:
    part = grid.host if host else grid.box[:, :2]
    low, high = np.maximum(part[:, 0], span[0]), np.minimum(part[:, 1], span[1])
    if host:
        return np.asarray(high - low > MARGIN)
    return np.asarray(high >= np.where(grid.thin, low - 1e-9, low + MARGIN))


def reach_bits(
    body: Body, tubes: Tubes, taken: Sequence[int], t: int, x: AxisGrid, y: AxisGrid,
    ix: Ints, iy: Ints,
) -> Bools:  # fmt: skip
    """(2, n): can a run be here at t with its choice still ahead (0), or behind (1)?"""
    fine = np.zeros((2, len(ix)), bool)
    oblique = [_projected(x, y, ix, iy, d) for d in tubes.directions[2:]]
    for j in taken:
        bit = int(tubes.steps[j] <= t)
        meets = boxes_meet(x.box, tubes.sets[0][j][t])[ix]
        meets &= boxes_meet(y.box, tubes.sets[1][j][t])[iy]
        left = np.flatnonzero(meets & ~fine[bit])
        for number, boxes in enumerate(oblique, start=2):
            left = left[boxes_meet(boxes[left], tubes.sets[number][j][t])]
        fine[bit, left] = True
    return fine


def drawn_in(
    tubes: Tubes, taken: Sequence[int], t: int, x: AxisGrid, y: AxisGrid
) -> tuple[AxisGrid, AxisGrid]:
    """The grids with their room drawn in around what the tubes of some alternative reach."""
    made = []
    for d, grid in enumerate((x, y)):
        parts = np.array([meeting(grid.room, tubes.sets[d][j][t]) for j in taken])
        low, high = parts[:, :, ::2].min(0), parts[:, :, 1::2].max(0)
        room = np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], 1)
        room = np.where((low <= high).all(1)[:, None], room, grid.room)
        made.append(replace(grid, room=room))
    return made[0], made[1]


def _projected(x: AxisGrid, y: AxisGrid, ix: Ints, iy: Ints, d: Floats) -> Floats:
    """(n, 4): ranges of (d.p, d.w) over the boxes."""
    out = []
    for k in (0, 2):
        a, b = d[0] * x.box[:, k : k + 2], d[1] * y.box[:, k : k + 2]
        out += [a.min(1)[ix] + b.min(1)[iy], a.max(1)[ix] + b.max(1)[iy]]
    return np.stack(out, 1)
