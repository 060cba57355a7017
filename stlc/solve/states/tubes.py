"""Planar reach sets of (p, w) along one direction, as convex polygons.

Along a direction d of the plane, (d.p, d.w) moves as an axis does, with the widths of both axes
added up. Sets are exact in each direction and a relaxation together. Polygons are (k, 2) arrays,
counter-clockwise; fewer than three points are a segment, a point or nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.solve.relaxation.problem import Body

EPS = 1e-7
FLAT = 1e-9  # a vertex this near to the chord of its neighbours is left out; well within EPS
Box = tuple[float, float, float, float]


def hull(points: Floats) -> Floats:
    """Convex hull (Andrew 1979)."""
    seq = sorted({(x, y) for x, y in np.round(points, 10).tolist()})
    if len(seq) < 3:
        return np.array(seq).reshape(-1, 2)
    return np.array(_chain(seq)[:-1] + _chain(seq[::-1])[:-1])


def _chain(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    out: list[tuple[float, float]] = []
    for point in points:
        while len(out) >= 2 and _beyond(out[-2], out[-1], point) <= FLAT:
            out.pop()
        out.append(point)
    return out


def _beyond(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """How far b lies to the right of the chord from a to c."""
    turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    return turn / hypot(c[0] - a[0], c[1] - a[1])


def _following(values: Floats) -> Floats:
    """The next of each, around a polygon."""
    return np.concatenate([values[1:], values[:1]])


def clip(poly: Floats, normal: Floats, offset: float) -> Floats:
    """The part with normal . x <= offset (+ EPS)."""
    if len(poly) == 0:
        return poly
    d = poly @ normal - offset - EPS
    if (d <= 0).all():
        return poly
    if len(poly) == 1:
        return poly[:0]
    following, after = _following(poly), _following(d)
    cross = (d <= 0) != (after <= 0)
    share = (d[cross] / (d[cross] - after[cross]))[:, None]
    cut = poly[cross] + share * (following[cross] - poly[cross])
    left = np.concatenate([poly[d <= 0], cut])
    return hull(left) if len(left) else left


_SIDES = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])


def clip_box(poly: Floats, box: Box) -> Floats:
    """The part within p_lo, p_hi, w_lo, w_hi."""
    for normal, offset in zip(_SIDES, (box[1], -box[0], box[3], -box[2]), strict=True):
        poly = clip(poly, normal, offset)
    return poly


def forward(poly: Floats, blend: float, jump: float, box: Box) -> Floats:
    """States one step later, clipped to the box."""
    if len(poly) == 0:
        return poly
    moved = np.stack([poly[:, 0] + poly[:, 1], poly[:, 1]], 1)
    delta = jump * np.array([blend, 1.0])
    return clip_box(hull(np.concatenate([moved + delta, moved - delta])), box)


def backward(poly: Floats, blend: float, jump: float, box: Box) -> Floats:
    """States one step earlier, clipped to the box."""
    if len(poly) == 0:
        return poly
    moved = np.stack([poly[:, 0] - poly[:, 1], poly[:, 1]], 1)
    delta = jump * np.array([1.0 - blend, -1.0])
    return clip_box(hull(np.concatenate([moved + delta, moved - delta])), box)


def intersect(a: Floats, b: Floats) -> Floats:
    """Convex intersection; a degenerate b is replaced by its bounding box (a relaxation)."""
    if len(a) == 0 or len(b) == 0:
        return a[:0]
    if len(b) < 3:
        low, high = b.min(0), b.max(0)
        return clip_box(a, (low[0], high[0], low[1], high[1]))
    for normal, point in zip(_normals(b), b, strict=True):
        a = clip(a, normal, float(normal @ point))
    return a


def _normals(poly: Floats) -> Floats:
    edge = _following(poly) - poly
    normal = np.stack([edge[:, 1], -edge[:, 0]], 1)
    out: Floats = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    return out


def boxes_meet(boxes: Floats, poly: Floats) -> Bools:
    """boxes (n, 4) p_lo p_hi w_lo w_hi: True where box and polygon meet (separating axes)."""
    if len(poly) == 0:
        return np.zeros(len(boxes), bool)
    low, high = poly.min(0), poly.max(0)
    normals = [_SIDES]
    offsets = [np.array([high[0], -low[0], high[1], -low[1]])]
    if len(poly) >= 3:
        normal = _normals(poly)
        normals.append(normal)
        offsets.append((normal * poly).sum(1))
    n, o = np.concatenate(normals), np.concatenate(offsets) + 10 * EPS
    least = np.minimum(np.outer(boxes[:, 0], n[:, 0]), np.outer(boxes[:, 1], n[:, 0]))
    least += np.minimum(np.outer(boxes[:, 2], n[:, 1]), np.outer(boxes[:, 3], n[:, 1]))
    return np.asarray((least <= o).all(1))


def meeting(boxes: Floats, poly: Floats) -> Floats:
    """(n, 4): bounds of the part of each box (n, 4) that lies in the polygon, a little widened;
    low inf and high -inf where there is none."""
    low, high = boxes[:, ::2] - 10 * EPS, boxes[:, 1::2] + 10 * EPS
    points = [_corners(low, high, poly), np.broadcast_to(poly, (len(boxes), *poly.shape))]
    if len(poly) > 1:
        points.append(_crossings(low, high, poly))
    at = np.concatenate(points, axis=1)
    within = (at >= low[:, None] - EPS) & (at <= high[:, None] + EPS)
    known = np.asarray(within.all(2))[:, :, None]
    least = np.where(known, at, np.inf).min(1) - 10 * EPS
    most = np.where(known, at, -np.inf).max(1) + 10 * EPS
    out = np.empty((len(boxes), 4))
    out[:, ::2], out[:, 1::2] = np.maximum(least, boxes[:, ::2]), np.minimum(most, boxes[:, 1::2])
    return np.where(known.any(1), out, np.array([np.inf, -np.inf] * 2))


def _corners(low: Floats, high: Floats, poly: Floats) -> Floats:
    """(n, 4, 2): corners of boxes that lie in a polygon, nan for the others."""
    xs, ys = np.stack([low[:, 0], high[:, 0]], 1), np.stack([low[:, 1], high[:, 1]], 1)
    at = np.stack([xs[:, [0, 1, 0, 1]], ys[:, [0, 0, 1, 1]]], axis=2)
    if len(poly) < 3:
        return np.full_like(at, np.nan)
    normal = _normals(poly)
    inside = (at @ normal.T <= (normal * poly).sum(1) + 10 * EPS).all(2)
    return np.where(inside[:, :, None], at, np.nan)


def _crossings(low: Floats, high: Floats, poly: Floats) -> Floats:
    """(n, 4 k, 2): where the polygon's edges cross the lines of each box's sides."""
    found = []
    step = _following(poly) - poly
    for axis in (0, 1):
        for side in (low[:, axis], high[:, axis]):
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (side[:, None] - poly[None, :, axis]) / step[None, :, axis]
                at = poly[None] + share[:, :, None] * step[None]
            found.append(np.where(((share >= 0) & (share <= 1))[:, :, None], at, np.nan))
    return np.concatenate(found, axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Tubes:
    """directions (k, 2); sets[d][j][t]: where runs that take alternative j of `body.places` can be
    at step t along direction d. Without places there is one alternative, taken at step 0.
    `possible`: alternatives whose sets are nowhere empty."""

    directions: Floats
    steps: tuple[int, ...]
    sets: tuple[tuple[tuple[Floats, ...], ...], ...]
    possible: tuple[int, ...]


def tubes(body: Body, steps: int) -> Tubes:
    """Reach sets of one agent for every alternative."""
    directions = _directions(body)
    sets = tuple(_along(body, d, steps) for d in directions)
    when = tuple(p.step for p in body.places) or (0,)
    full = [j for j in range(len(when)) if all(len(s) for way in sets for s in way[j])]
    return Tubes(directions, when, sets, tuple(full))


def _directions(body: Body) -> Floats:
    """x, y and, where both axes move alike, the oblique normals of the speed polygon."""
    found = [np.array([1.0, 0.0]), np.array([0.0, 1.0])]
    x, y = body.axes
    if x.blend != y.blend:
        return np.array(found)
    for nx, ny, _ in body.faces:
        d = np.array([nx, ny]) / np.hypot(nx, ny)
        if all(abs(abs(d @ e) - 1) > 1e-9 for e in found):
            found.append(d)
    return np.array(found)


def _along(body: Body, d: Floats, steps: int) -> tuple[tuple[Floats, ...], ...]:
    """Reach boxes (position, rate) along direction d at each step, one list for each place that the
    body may have to pass."""
    blend = max((a.blend for a, c in zip(body.axes, d, strict=True) if c), default=0.5)
    jump = float(sum(abs(c) * a.jump for a, c in zip(body.axes, d, strict=True)))
    boxes = [_range(body, d, t) for t in range(steps + 1)]
    start = np.array([[sum(c * a.start[k] for a, c in zip(body.axes, d, strict=True))
                       for k in (0, 1)]])  # fmt: skip
    ahead = [start]
    for t in range(steps):
        ahead.append(forward(ahead[-1], blend, jump, boxes[t + 1]))
    if not body.places:
        return (tuple(ahead),)
    return tuple(_through(ahead, boxes, blend, jump, p.step, _span(d, p.box)) for p in body.places)


def _through(
    ahead: list[Floats], boxes: list[Box], blend: float, jump: float, step: int,
    goal: tuple[float, float],
) -> tuple[Floats, ...]:  # fmt: skip
    """The tube of runs that are in the strip `goal` at `step`."""
    at = clip_box(ahead[step], (*goal, boxes[step][2], boxes[step][3]))
    seq, back = [at], _polygon((*goal, boxes[step][2], boxes[step][3]))
    for t in range(step - 1, -1, -1):
        back = backward(back, blend, jump, boxes[t])
        seq.append(intersect(ahead[t], back))
    seq.reverse()
    for t in range(step, len(boxes) - 1):
        seq.append(forward(seq[-1], blend, jump, boxes[t + 1]))
    return tuple(seq)


def _polygon(box: Box) -> Floats:
    a, b, c, d = box
    return np.array([[a, c], [b, c], [b, d], [a, d]])


def _span(d: Floats, box: Floats) -> tuple[float, float]:
    ends = d[:, None] * box
    return float(ends.min(1).sum()), float(ends.max(1).sum())


def _range(body: Body, d: Floats, t: int) -> Box:
    """Bounds of position and rate along direction d at step t, speed faces included."""
    box = np.array([a.box[t] for a in body.axes])
    p, w = _span(d, box[:, :2]), _span(d, box[:, 2:])
    low, high = w
    for nx, ny, c in body.faces if t else ():
        size = np.hypot(nx, ny)
        side = (nx * d[0] + ny * d[1]) / size
        if side > 1 - 1e-9:
            high = min(high, c / size)
        elif side < -1 + 1e-9:
            low = max(low, -c / size)
    return (*p, low, high)
