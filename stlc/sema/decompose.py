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
    rings = _Rings(parts)
    for edge in sorted((e for e in rings.after if e < (e[1], e[0])), key=order):
        rings.join(edge)
    return rings.left()


def edges(ring: Ring) -> list[Edge]:
    """Directed edges of a ring."""
    return list(zip(ring, (*ring[1:], ring[0]), strict=True))


class _Rings:
    """Convex rings as chains of directed edges, so that two are joined by looking at the corners of
    their common edge alone: in constant time, whatever their size."""

    def __init__(self, parts: list[Ring]) -> None:
        chains = [edges(ring) for ring in parts]
        self.after = {e: f for c in chains for e, f in zip(c, (*c[1:], c[0]), strict=True)}
        self.before = {f: e for e, f in self.after.items()}
        self._longest = {e: size for c in chains for size in [max(map(_length, c))] for e in c}
        self._ring = {e: c[0] for c in chains for e in c}  # one step nearer to a ring's own edge
        self._start = {c[0]: c[0] for c in chains}  # by a ring's own edge: where it is told from

    def join(self, edge: Edge) -> None:
        """Take away a common edge (u, v) of two rings if their union is convex.

        Corners on a straight line are kept: they are where further neighbours meet.
        """
        back = (edge[1], edge[0])
        if back not in self.after or self._of(edge) == self._of(back):
            return
        one, other = self._of(edge), self._of(back)
        longest = max(self._longest[one], self._longest[other])
        # At u and at v: the edge that comes in there, and the one that goes on.
        bends = (self.before[edge], self.after[back]), (self.before[back], self.after[edge])
        if not all(_turns_left(*bend, 1e-12 * longest**2) for bend in bends):
            return
        for come, go in bends:
            self.after[come], self.before[go] = go, come
        for gone in (edge, back):
            del self.after[gone], self.before[gone]
        self._ring[other], self._longest[one] = one, longest
        self._start[one] = bends[1][1]
        del self._start[other]

    def _of(self, edge: Edge) -> Edge:
        """The edge that stands for a ring, paths to it halved on the way."""
        ring = self._ring
        while ring[edge] != edge:
            ring[edge] = edge = ring[ring[edge]]
        return edge

    def left(self) -> list[Ring]:
        """The rings in the order of those that took others in: pieces grow in this order."""
        found = []
        for start in self._start.values():
            ring, edge = [start[0]], self.after[start]
            while edge != start:
                ring.append(edge[0])
                edge = self.after[edge]
            found.append(tuple(ring))
        return found


def _turns_left(come: Edge, go: Edge, tolerance: float) -> bool:
    """Whether a ring goes on to the left or straight; an edge and its own way back don't."""
    return come[0] != go[1] and turn(come[0], go[0], go[1]) >= -tolerance
