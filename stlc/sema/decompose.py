"""Convex decomposition of polygons with holes into few pieces that overlap.

A constrained Delaunay triangulation is merged greedily along shared edges while the union stays
convex (Hertel and Mehlhorn, 1983), in several orders; the smallest result is kept.

The pieces then grow a little over the cuts between them. Predicates are closed sets, so a point on
a cut would be on the border of both neighbours and count as outside of each; where pieces overlap
no point in the interior does. Their union is unchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import hypot

from stlc.mission import Polytope
from stlc.sema.geometry import Point, is_convex, polytope, simplified, turn

Ring = tuple[Point, ...]
Edge = tuple[Point, Point]


class PolygonError(ValueError):
    """Rings that don't bound a polygon; the message says why."""


def decompose(ring: Sequence[Point], holes: Sequence[Sequence[Point]] = ()) -> list[Polytope]:
    """Convex pieces whose union is the polygon [m]. Raises PolygonError."""
    outer = simplified(ring)
    if len(outer) < 3:
        raise PolygonError("it has no area")
    if not holes and is_convex(outer) and _simple_if_convex(outer):
        return [polytope(outer)]
    pieces = merged(triangles(outer, holes))
    return [polytope(simplified(p)) for p in overlapping(pieces)]


def _simple_if_convex(ring: Sequence[Point]) -> bool:
    """A ring that only turns left is simple when it turns once around: by its lowest vertices."""
    count = len(ring)
    rises = [ring[(k + 1) % count][1] - ring[k][1] > 0 for k in range(count)]
    return sum(rises[k] != rises[k - 1] for k in range(count)) <= 2


def triangles(ring: Sequence[Point], holes: Sequence[Sequence[Point]]) -> list[Ring]:
    """Constrained Delaunay triangulation, counter-clockwise."""
    import shapely

    polygon = shapely.Polygon(ring, [list(h) for h in holes])
    if not polygon.is_valid:
        reason = shapely.is_valid_reason(polygon).split("[")[0].strip().lower()
        raise PolygonError(_REASONS.get(reason, reason))
    parts = shapely.constrained_delaunay_triangles(polygon).geoms
    return [tuple(simplified([(x, y) for x, y in p.exterior.coords[:-1]])) for p in parts]


_REASONS = {
    "self-intersection": "its edges cross",
    "hole lies outside shell": "a hole lies outside",
    "too few points in geometry component": "it has too few corners",
}


def merged(parts: list[Ring]) -> list[Ring]:
    """The best of several merging orders."""
    orders: tuple[Callable[[Edge], tuple[float, ...]], ...] = (
        lambda e: (-_length(e),),
        lambda e: (_length(e),),
        lambda e: (min(e[0][0], e[1][0]), min(e[0][1], e[1][1])),
        lambda e: (-max(e[0][0], e[1][0]), min(e[0][1], e[1][1])),
        lambda e: (min(e[0][1], e[1][1]), min(e[0][0], e[1][0])),
        lambda e: (-max(e[0][1], e[1][1]), min(e[0][0], e[1][0])),
    )
    return min((_merge_in_order(parts, order) for order in orders), key=len)


def _length(edge: Edge) -> float:
    return hypot(edge[0][0] - edge[1][0], edge[0][1] - edge[1][1])


def _merge_in_order(parts: list[Ring], order: Callable[[Edge], tuple[float, ...]]) -> list[Ring]:
    rings: dict[int, Ring] = dict(enumerate(parts))
    owner: dict[Edge, int] = {e: k for k, ring in rings.items() for e in edges(ring)}
    for edge in sorted((e for e in owner if (e[1], e[0]) in owner and e < (e[1], e[0])), key=order):
        a, b = owner[edge], owner[(edge[1], edge[0])]
        union = _joined(rings[a], rings[b], edge) if a != b else None
        if union is None:
            continue
        for e in edges(rings.pop(b)):
            owner[e] = a
        rings[a] = union
    return list(rings.values())


def edges(ring: Ring) -> list[Edge]:
    """Directed edges of a ring."""
    return list(zip(ring, (*ring[1:], ring[0]), strict=True))


def _joined(a: Ring, b: Ring, edge: Edge) -> Ring | None:
    """The union across a shared edge (u -> v in a, v -> u in b), if it is convex.

    Corners on a straight line are kept: they are where further neighbours meet.
    """
    u, v = edge
    i, j = a.index(v), b.index(u)
    union = (*a[i:], *a[:i], *(b[j:] + b[:j])[1:-1])
    count = len(union)
    if len(set(union)) < count:
        return None
    tolerance = 1e-12 * max(_length(e) for e in edges(union)) ** 2
    left = all(
        turn(union[k - 1], union[k], union[(k + 1) % count]) >= -tolerance for k in range(count)
    )
    return union if left else None


def overlapping(pieces: list[Ring]) -> list[Ring]:
    """Each piece with a low gable over every cut it shares with a later piece."""
    owner = {e: k for k, ring in enumerate(pieces) for e in edges(ring)}
    grown = []
    for k, ring in enumerate(pieces):
        points: list[Point] = []
        for u, v in edges(ring):
            points.append(u)
            if owner.get((v, u), -1) > k:
                points.append(_gable(ring, pieces[owner[(v, u)]], (u, v)))
        grown.append(tuple(points))
    return grown


def _gable(own: Ring, other: Ring, edge: Edge) -> Point:
    """A point beyond the middle of a cut, within the neighbour, that keeps the piece convex."""
    u, v = edge
    middle = ((u[0] + v[0]) / 2.0, (u[1] + v[1]) / 2.0)
    length = _length(edge)
    outward = ((v[1] - u[1]) / length, (u[0] - v[0]) / length)
    height = 0.25 * length
    while height > 1e-9 * length:
        tip = (middle[0] + height * outward[0], middle[1] + height * outward[1])
        if _inside(other, tip) and _room(own, edge, height):
            return tip
        height /= 2.0
    return middle


def _inside(ring: Ring, point: Point) -> bool:
    return all(turn(a, b, point) >= 0 for a, b in edges(ring))


def _room(ring: Ring, edge: Edge, height: float) -> bool:
    """The gable's slope takes less than half of what each end lacks to a straight line."""
    slope = height / (_length(edge) / 2.0)
    at = ring.index(edge[0])
    before, after = ring[at - 1], ring[(at + 2) % len(ring)]
    return all(_bend(*corner) / 2.0 > slope for corner in (
        (before, edge[0], edge[1]), (edge[0], edge[1], after)))  # fmt: skip


def _bend(a: Point, b: Point, c: Point) -> float:
    """Sine of the turn at b (0: straight), or 1 for a turn beyond a right angle."""
    lengths = _length((a, b)) * _length((b, c))
    dot = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1])
    return 1.0 if dot <= 0 else turn(a, b, c) / lengths
