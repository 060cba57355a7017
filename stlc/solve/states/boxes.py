"""Boxes of (position, rate) on one axis, and the cheapest admissible step between two of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Axis

TOUCH = 1e-6  # m: a border this close to a face counts as on it
EPS = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class AxisGrid:
    """box (n, 4): p_lo, p_hi, w_lo, w_hi; cell (n,) along the axis; thin (n,): next to no width.

    host (n, 2): the part of the cell that a thin box lies at the end of, else the box itself.
    room (n, 4): the part of the box that can be reached, in which steps begin and end.
    slope (n, 2): of the potential on p and w (see `joint`).
    kind (n,): the alternative whose runs alone are in a box, -1 for those of all.
    borders: cells are numbered with the borders between them, see `relaxation/borders`.
    """

    box: Floats
    cell: Ints
    thin: Bools
    host: Floats
    room: Floats
    slope: Floats
    kind: Ints
    borders: bool = False

    def take(self, kept: Ints) -> AxisGrid:
        """Some of the boxes."""
        return AxisGrid(
            self.box[kept], self.cell[kept], self.thin[kept], self.host[kept], self.room[kept],
            self.slope[kept], self.kind[kept], self.borders,
        )  # fmt: skip


def axis_grid(
    edges: Floats, faces: Sequence[float], rates: Floats, borders: bool = False
) -> AxisGrid:
    """Cells cut at faces, times bins of the rate.

    Cells are closed and so is the outside of an obstacle: where a face lies on a cell border, an
    agent on it may count in the cell behind. Such points get boxes of zero width, at the end.
    With `borders` each border between two cells is a cell of zero width itself.
    """
    inner = [f for f in faces if edges[0] < f < edges[-1] and np.abs(edges - f).min() > TOUCH]
    cuts = np.unique(np.concatenate([edges, inner]))
    parts = np.stack([cuts[:-1], cuts[1:]], 1)
    cell = (np.searchsorted(edges, parts.mean(1)) - 1) * (2 if borders else 1)
    thin = _all_borders(edges, faces) if borders else _borders(edges, faces)
    at = np.array([[low, high] for low, high, _ in thin]).reshape(-1, 2)
    behind = np.array([c for _, _, c in thin], np.int64)
    hosts = [_host(parts[cell == c], ends) for ends, c in zip(at, behind, strict=True)]
    span = np.concatenate([parts, at])
    host = np.concatenate([parts, np.array(hosts).reshape(-1, 2)])
    cell = np.concatenate([cell, behind]).astype(np.int64)
    bins = len(rates) - 1
    rate = np.stack([np.tile(rates[:-1], len(span)), np.tile(rates[1:], len(span))], 1)
    box = np.hstack([np.repeat(span, bins, axis=0), rate])
    narrow = np.repeat(span[:, 1] - span[:, 0] <= 2 * TOUCH, bins)
    return AxisGrid(
        box,
        np.repeat(cell, bins),
        narrow,
        np.repeat(host, bins, axis=0),
        box,
        _flat(len(box)),
        np.full(len(box), -1),
        borders,
    )


def _borders(edges: Floats, faces: Sequence[float]) -> list[tuple[float, float, int]]:
    """(low, high, cell): both cells of every border that a face lies on."""
    found = set()
    for face in faces:
        k = int(np.argmin(np.abs(edges - face)))
        ends = (float(min(face, edges[k])), float(max(face, edges[k])))
        if abs(edges[k] - face) <= TOUCH:
            found |= {(*ends, c) for c in (k - 1, k) if 0 <= c < len(edges) - 1}
    return sorted(found)


def _all_borders(edges: Floats, faces: Sequence[float]) -> list[tuple[float, float, int]]:
    """(low, high, cell): each inner border as a cell, and the outer ones that a face lies on."""
    last = len(edges) - 2
    outer = [(low, high, 2 * c) for low, high, c in _borders(edges, faces)
             if (c == 0 and low <= edges[0] + TOUCH)
             or (c == last and high >= edges[-1] - TOUCH)]  # fmt: skip
    near = [[e, *(f for f in faces if abs(f - e) <= TOUCH)] for e in edges[1:-1].tolist()]
    return [(min(at), max(at), 2 * k + 1) for k, at in enumerate(near)] + outer


def _host(parts: Floats, ends: Floats) -> Floats:
    """The part (of one cell) nearest to a thin box; nothing for a border that is a cell."""
    if not len(parts):
        return np.array([np.inf, -np.inf])
    gap = np.abs(parts.mean(1) - ends.mean())
    nearest: Floats = parts[int(np.argmin(gap))]
    return nearest


def point_grid(p: float, w: float) -> AxisGrid:
    """One state. Its cell is never asked for."""
    box = np.array([[p, p, w, w]])
    return AxisGrid(
        box, np.zeros(1, np.int64), np.zeros(1, bool), box[:, :2], box, _flat(1), np.full(1, -1)
    )


def _flat(count: int) -> Floats:
    return np.zeros((count, 2))


def feasible_pairs(src: Floats, dst: Floats, axis: Axis) -> tuple[Ints, Ints]:
    """Pairs (sorted by source) with an admissible step between some points of both boxes.

    A relaxation: the limits on w' - w and on p' - p are met one by one.
    """
    a, b, beta = src[:, None, :], dst[None, :, :], axis.blend
    least, most = b[..., 0] - a[..., 1] - EPS, b[..., 1] - a[..., 0] + EPS
    jump = axis.jump + EPS
    v_lo, v_hi = np.maximum(a[..., 2], b[..., 2] - jump), np.minimum(a[..., 3], b[..., 3] + jump)
    w_lo, w_hi = np.maximum(b[..., 2], v_lo - jump), np.minimum(b[..., 3], v_hi + jump)
    low, high = (1 - beta) * v_lo + beta * w_lo, (1 - beta) * v_hi + beta * w_hi
    fine = (v_lo <= v_hi + EPS) & (low <= most) & (high >= least)
    i, j = np.nonzero(fine)
    return i, j


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """n box pairs: src, dst (n, 4); blend, jump, rate_cost, change_cost (n,): axis and costs."""

    src: Floats
    dst: Floats
    blend: Floats
    jump: Floats
    rate_cost: Floats
    change_cost: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """Admissible steps among which, whatever the slopes, one of the cheapest of each edge is.

    For fixed (w, w') the best p is an end of an interval; what remains is convex and piecewise
    linear in (w, w'), so its minimum lies on a vertex of the arrangement of border and kink lines.
    `at` (5, k) holds w, w', p' - p and the interval of p at these vertices, `edge` (k,) whose they
    are, sorted; `fixed` (k,) is rate_cost |w'| + change_cost |w' - w|. Edges without any are
    inadmissible.
    """

    count: int
    edge: Ints
    at: Floats
    fixed: Floats

    def least(self, a0: Floats, a1: Floats) -> tuple[Floats, Floats]:
        """(n,): least rate_cost |w'| + change_cost |w' - w| + a1.(p', w') - a0.(p, w) of each
        edge, inf where no step is admissible; and the step of every vertex, (k,).

        a0, a1 (n, 2) are the slopes of the potentials at both ends.
        """
        v, w, s, low, high = self.at
        rise = (a1[:, 0] - a0[:, 0])[self.edge]
        value = self.fixed + rise * np.where(rise >= 0, low, high) + a1[self.edge, 0] * s
        value += a1[self.edge, 1] * w - a0[self.edge, 1] * v
        first = np.flatnonzero(np.diff(self.edge, prepend=-1))
        best = np.full(self.count, np.inf)
        if len(first):
            best[self.edge[first]] = np.minimum.reduceat(value, first)
        return best, value

    def cheapest(self, a0: Floats, a1: Floats) -> tuple[Floats, Floats]:
        """`least`, and (n, 3) where it is: p, w, w'; anywhere where no step is admissible."""
        best, value = self.least(a0, a1)
        if not len(value):
            return best, np.zeros((self.count, 3))
        found = np.flatnonzero(value == best[self.edge])
        index = np.zeros(self.count, np.int64)
        index[self.edge[found]] = found
        v, w, _, low, high = self.at[:, index]
        return best, np.stack([np.where(a1[:, 0] >= a0[:, 0], low, high), v, w], axis=1)


@np.errstate(all="ignore")
def corners(edges: Edges) -> Corners:
    """Borders are relaxed by EPS."""
    e, tol = edges, 4 * EPS
    v0, v1 = e.src[:, 2] - EPS, e.src[:, 3] + EPS
    w0, w1 = e.dst[:, 2] - EPS, e.dst[:, 3] + EPS
    s0, s1 = e.dst[:, 0] - e.src[:, 1] - EPS, e.dst[:, 1] - e.src[:, 0] + EPS
    owners, points = [np.empty(0, np.int64)], [np.empty((3, 0))]
    for v, w in _vertices(e, (v0, v1, w0, w1, s0, s1)):
        s = (1 - e.blend) * v + e.blend * w
        fine = (v >= v0 - tol) & (v <= v1 + tol) & (w >= w0 - tol) & (w <= w1 + tol)
        fine &= (np.abs(w - v) <= e.jump + tol) & (s >= s0 - tol) & (s <= s1 + tol)
        found = np.flatnonzero(fine)
        owners.append(found)
        points.append(np.stack([v[found], w[found], s[found]]))
    edge = np.concatenate(owners)
    order = np.argsort(edge, kind="stable")
    edge, (v, w, s) = edge[order], np.concatenate(points, axis=1)[:, order]
    src, dst = e.src[edge], e.dst[edge]
    low, high = np.maximum(src[:, 0], dst[:, 0] - s), np.minimum(src[:, 1], dst[:, 1] - s)
    fixed = e.rate_cost[edge] * np.abs(w) + e.change_cost[edge] * np.abs(w - v)
    return Corners(len(e.blend), edge, np.stack([v, w, s, low, high]), fixed)


def edge_min(edges: Edges, a0: Floats, a1: Floats) -> Floats:
    """`Corners.least` of edges that are asked once."""
    return corners(edges).least(a0, a1)[0]


def _vertices(e: Edges, ends: tuple[Floats, ...]) -> Iterator[tuple[Floats, Floats]]:
    """(w, w') where two lines cross; nan or inf where they are parallel."""
    v0, v1, w0, w1, s0, s1 = ends
    one, zero = np.ones(len(v0)), np.zeros(len(v0))
    rest, blend = 1 - e.blend, e.blend
    lines = [
        (one, zero, v0), (one, zero, v1), (zero, one, w0), (zero, one, w1),
        (-one, one, -e.jump), (-one, one, e.jump), (rest, blend, s0), (rest, blend, s1),
        (zero, one, zero), (-one, one, zero), (rest, blend, e.dst[:, 0] - e.src[:, 0]),
        (rest, blend, e.dst[:, 1] - e.src[:, 1]),
    ]  # fmt: skip
    for m, (c0, c1, d0) in enumerate(lines):
        for e0, e1, d1 in lines[:m]:
            det = c0 * e1 - c1 * e0
            if det.any():
                yield (d0 * e1 - c1 * d1) / det, (c0 * d1 - e0 * d0) / det
