"""Convex polygons as half-planes with unit normals, and how they grow."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stlc.mission import Array
from stlc.places import Polytope

Point = tuple[float, float]

FLAT = 1e-12
"""Relative area below which three points are in one line."""


def area(ring: Sequence[Point]) -> float:
    """Signed area of a ring (counter-clockwise is positive) [m^2], however far it is from 0."""
    return sum(turn(ring[0], a, b) for a, b in pairwise(ring)) / 2.0


def turn(a: Point, b: Point, c: Point) -> float:
    """Twice the signed area of a triangle: positive for a left turn."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def without_repeats(ring: Sequence[Point]) -> list[Point]:
    """The ring without corners that repeat the one before (the first follows the last)."""
    return [p for k, p in enumerate(ring) if p != ring[k - 1] or len(ring) == 1]


def counter_clockwise(ring: Sequence[Point]) -> tuple[Point, ...]:
    """The ring turned to run counter-clockwise."""
    return tuple(ring) if not ring or area(ring) >= 0 else tuple(reversed(ring))


def simplified(ring: Sequence[Point]) -> list[Point]:
    """The ring counter-clockwise, without repeated corners and corners on a straight line.

    Corners go one at a time, so that a fine arc keeps its shape. Where a ring turns back on itself
    the corner stays: a spike of no width isn't part of a simple polygon, and isn't lost silently.
    """
    points = list(counter_clockwise(without_repeats(ring)))
    flat = FLAT * _scale(points)
    before = len(points) + 1
    while 2 < len(points) < before:
        before = len(points)
        points = _straightened(points, flat)
    return points


def _straightened(points: Sequence[Point], flat: float) -> list[Point]:
    """Without corners on the line from the last corner kept to the next one."""
    kept: list[Point] = []
    for k, point in enumerate(points):
        last = kept[-1] if kept else points[-1]
        ahead = points[(k + 1) % len(points)]
        if abs(turn(last, point, ahead)) > flat or _onward(last, point, ahead) < -flat:
            kept.append(point)
    return kept


def _onward(a: Point, b: Point, c: Point) -> float:
    """The scalar product of the ways from a to b and from b to c: negative where it turns back."""
    return (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1])


def _scale(points: Sequence[Point]) -> float:
    xs, ys = [p[0] for p in points] or [0.0], [p[1] for p in points] or [0.0]
    return max((max(xs) - min(xs)) ** 2 + (max(ys) - min(ys)) ** 2, 1e-300)


def is_convex(ring: Sequence[Point]) -> bool:
    """True for a simplified ring that only turns left."""
    count = len(ring)
    return count >= 3 and all(
        turn(ring[k - 1], ring[k], ring[(k + 1) % count]) > 0 for k in range(count)
    )


def polytope(ring: Sequence[Point]) -> Polytope:
    """Half-planes of a convex, counter-clockwise, simplified ring."""
    vertices = np.array(ring, dtype=np.float64)
    edges = np.concatenate((vertices[1:], vertices[:1])) - vertices
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    normals = edges[:, ::-1] * (1.0, -1.0) / lengths[:, None] + 0.0
    offsets = np.einsum("ij,ij->i", normals, vertices)
    return Polytope(normals, _tidy_offsets(normals, offsets, vertices), vertices)


def _tidy_offsets(normals: Array, offsets: Array, vertices: Array) -> Array:
    """The furthest vertex along each normal: no vertex is outside by a rounding error."""
    return np.asarray(np.maximum(offsets, (normals @ vertices.T).max(axis=1)))


def box(x: Point, y: Point) -> Polytope:
    """Axis-aligned box; its half-planes are exact."""
    normals = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    offsets = np.array([-y[0], x[1], y[1], -x[0]]) + 0.0
    vertices = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    return Polytope(normals, offsets, vertices)


def inflated(piece: Polytope, distance: float) -> Polytope:
    """Every face moved outward [m]: the Minkowski sum with a disc, its corners mitred.

    It contains every point within `distance` of the piece. Sharp corners get a second face, so
    that a mitre never reaches further than the square root of two times the distance.
    """
    if distance == 0.0:
        return piece
    normals, offsets = _with_bevels(piece)
    moved = offsets + distance
    return Polytope(normals, moved, corners(normals, moved))


def _with_bevels(piece: Polytope) -> tuple[Array, Array]:
    """Faces of the piece, and one that touches each corner sharper than a right angle."""
    normals: list[Array] = []
    offsets: list[float] = []
    count = len(piece.offsets)
    for k in range(count):
        n0, n1 = piece.normals[k], piece.normals[(k + 1) % count]
        normals.append(n0)
        offsets.append(float(piece.offsets[k]))
        if float(n0 @ n1) < -1e-9:
            middle = (n0 + n1) / np.linalg.norm(n0 + n1)
            normals.append(middle)
            offsets.append(float((piece.vertices @ middle).max()))
    return np.array(normals), np.array(offsets)


def corners(normals: Array, offsets: Array) -> Array:
    """Vertices of a bounded polygon whose faces are sorted by angle, none redundant."""
    following, ahead = np.roll(normals, -1, axis=0), np.roll(offsets, -1)
    determinant = normals[:, 0] * following[:, 1] - normals[:, 1] * following[:, 0]
    x = (offsets * following[:, 1] - ahead * normals[:, 1]) / determinant
    y = (normals[:, 0] * ahead - following[:, 0] * offsets) / determinant
    return np.roll(np.column_stack([x, y]), 1, axis=0)


def polygons(pieces: Sequence[Polytope]) -> np.ndarray[tuple[int], np.dtype[np.object_]]:
    """The pieces as shapely's polygons (n,), made at once."""
    import shapely

    owner = np.repeat(np.arange(len(pieces)), [len(p.vertices) for p in pieces])
    rings = shapely.linearrings(np.concatenate([p.vertices for p in pieces]), indices=owner)
    found: np.ndarray[tuple[int], np.dtype[np.object_]] = shapely.polygons(rings)
    return found


def meeting_point(normals: Array, offsets: Array, corner: int) -> Point:
    """Where face `corner` meets the one before it [m]; they aren't parallel."""
    (ax, ay), a = normals[corner - 1].tolist(), float(offsets[corner - 1])
    (bx, by), b = normals[corner].tolist(), float(offsets[corner])
    turn = ax * by - ay * bx
    return (a * by - b * ay) / turn, (ax * b - bx * a) / turn


def contains(piece: Polytope, point: Array, slack: float = 0.0) -> bool:
    """True when every face is kept with at least `slack` [m]."""
    return bool((piece.offsets - piece.normals @ point >= slack).all())


def disjoint(a: Polytope, b: Polytope) -> bool:
    """True when a face of one separates the two, so that they share no more than a border."""
    return _separates(a, b) or _separates(b, a)


def _separates(a: Polytope, b: Polytope) -> bool:
    nearest = (a.normals @ b.vertices.T).min(axis=1)
    return bool((nearest >= a.offsets - 1e-9).any())


def within(inner: Polytope, outer: Polytope) -> bool:
    """True when `inner` lies in `outer`."""
    return bool(((outer.normals @ inner.vertices.T).max(axis=1) <= outer.offsets + 1e-9).all())


def bounds(pieces: Sequence[Polytope]) -> tuple[float, float, float, float]:
    """x_lo, x_hi, y_lo, y_hi of pieces [m]."""
    points = np.vstack([p.vertices for p in pieces])
    low, high = points.min(axis=0), points.max(axis=0)
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def square(centre: Array, half: float) -> Polytope:
    """An axis-aligned square about a point (2,), of sides 2 `half` [m]."""
    x, y = float(centre[0]), float(centre[1])
    return box((x - half, x + half), (y - half, y + half))
