"""Convex decomposition of polygons with holes into few pieces.

A constrained Delaunay triangulation is merged greedily along shared edges while the union stays
convex (Hertel and Mehlhorn, 1983), in several orders; the smallest result is kept. The pieces
touch along the cuts between them; `seams` closes those where pieces are kept out of.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import hypot

from stlc.places import Polytope
from stlc.sema.geometry import (
    Point,
    counter_clockwise,
    is_convex,
    polytope,
    simplified,
    turn,
    without_repeats,
)

Ring = tuple[Point, ...]
Edge = tuple[Point, Point]


class PolygonError(ValueError):
    """Rings that don't bound a polygon; the message says why."""


def decompose(ring: Sequence[Point], holes: Sequence[Sequence[Point]] = ()) -> list[Polytope]:
    """Convex pieces whose union is the polygon [m]. Raises PolygonError."""
    for corners in (ring, *holes):
        _no_corner_twice(corners)
    outer = simplified(ring)
    if len(outer) < 3:
        raise PolygonError("it has no area")
    if not holes and is_convex(outer) and _simple_if_convex(outer):
        return [polytope(outer)]
    rings = (simplified(p) for p in merged(triangles(outer, holes)))
    return [polytope(p) for p in rings if len(p) >= 3]


def _no_corner_twice(ring: Sequence[Point]) -> None:
    """A ring that comes back to a corner pinches the polygon; its interior isn't one piece."""
    points = without_repeats(ring)
    if len(set(points)) == len(points):
        return
    x, y = next(p for k, p in enumerate(points) if p in points[:k])
    raise PolygonError(f"it comes to the corner ({x:g}, {y:g}) twice")


def _simple_if_convex(ring: Sequence[Point]) -> bool:
    """A ring that only turns left is simple when it turns once around: by its lowest vertices."""
    count = len(ring)
    rises = [ring[(k + 1) % count][1] - ring[k][1] > 0 for k in range(count)]
    return sum(rises[k] != rises[k - 1] for k in range(count)) <= 2


def triangles(ring: Sequence[Point], holes: Sequence[Sequence[Point]]) -> list[Ring]:
    """Constrained Delaunay triangulation, counter-clockwise; slivers are among them."""
    import shapely

    polygon = shapely.Polygon(ring, [list(h) for h in holes])
    if not polygon.is_valid:
        reason = shapely.is_valid_reason(polygon).split("[")[0].strip().lower()
        raise PolygonError(_REASONS.get(reason, reason))
    parts = shapely.constrained_delaunay_triangles(polygon).geoms
    return [counter_clockwise([(x, y) for x, y in p.exterior.coords[:-1]]) for p in parts]


_REASONS = {
    "self-intersection": "its edges cross",
    "ring self-intersection": "its edges touch",
    "hole lies outside shell": "a hole lies outside",
    "holes are nested": "a hole lies in another",
    "interior is disconnected": "a hole parts it in two",
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
    """Joins parts over common edges as long as the union stays convex, edges in `order`."""
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
