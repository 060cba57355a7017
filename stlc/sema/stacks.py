"""Places that stand on one another: the seam between them is a floor of no height.

`a outside p and a outside q` holds at the height at which p ends and q begins, wherever they are.
Where an agent must keep out of both, it keeps out of a plate of 2 mm around that height over what
the two cover together: the plate lies within p and q, so it forbids nothing but the seam. Where
they meet along a line or in a point only, seen from above, a bar of 2 mm around that closes it, as
a square does in the plane. A third place that touches both closes what is between it and the plate,
by a plug that lies within what is solid below the height and within what is above it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import inf
from typing import Any

from stlc.places import Polytope, Sweep
from stlc.sema.geometry import polygons, polytope
from stlc.sema.heights import TOUCH, Levels
from stlc.sema.junctions import plugs_between
from stlc.sema.plugs import Sweeps
from stlc.sema.values import Place

HALF = 1e-3
"""Half the height of a plate [m], as half the width of what closes a contact in a point."""


def meeting(
    places: Sequence[Place], each: Sequence[Levels], plugs: Callable[[], list[Sweeps]]
) -> tuple[Levels, list[Sweeps]] | None:
    """Between which heights places leave a way for an agent that keeps out of all, between `each`
    of the levels, and what closes it; None where one stands on another and one of them moves."""
    low, high = max(e[0] for e in each), min(e[1] for e in each)
    if not stacked(each):
        return (low, high), plugs() if low < high else []
    if not all(_rests(place) for place in places):
        return None
    around = (
        max(low - HALF, *(e[0] for e in each if e[0] < low - TOUCH), -inf),
        min(high + HALF, *(e[1] for e in each if e[1] > high + TOUCH), inf),
    )
    pieces = _plates(*places) if len(places) == 2 else _beside(places, each, low)
    return around, [(Sweep(tuple(pieces)),)] if pieces else []


def stacked(each: Sequence[Levels]) -> bool:
    """Whether levels have one height in common."""
    return abs(min(e[1] for e in each) - max(e[0] for e in each)) <= TOUCH


def _plates(a: Place, b: Place) -> list[Polytope]:
    """What two resting places cover together, from above, and bars along what else they share."""
    whole = [_union(place) for place in (a, b)]
    if not whole[0].buffer(TOUCH).intersects(whole[1]):
        return []
    return [*_areas(a, b), *_bars(*whole)]


def _areas(a: Place, b: Place) -> list[Polytope]:
    pairs = ((p, q) for p in a.barriers[0] for q in b.barriers[0])
    return [piece for pair in pairs if (piece := _common(*pair)) is not None]


def _beside(places: Sequence[Place], each: Sequence[Levels], height: float) -> list[Polytope]:
    """Plugs between the two things that are solid on both sides of a height: what places below and
    above it cover together, and a place that goes through."""
    below = [p for p, e in zip(places, each, strict=True) if e[1] <= height + TOUCH]
    above = [p for p, e in zip(places, each, strict=True) if e[0] >= height - TOUCH]
    solids = [list(p.barriers[0]) for p in places if p not in below and p not in above]
    solids += [_areas(low, high) for low in below for high in above]
    one, other = solids
    return list(plugs_between(one, other)) if one and other else []


def _rests(place: Place) -> bool:
    """Whether it has one shape for all times."""
    still = all(sweep.move == (0.0, 0.0) for sweep in place.sweeps)
    return still and len(place.barriers) == 1 and len(place.sweeps) == 1


def _union(place: Place) -> Any:
    import shapely

    return shapely.union_all(polygons(place.frames[0]))


def _bars(one: Any, other: Any) -> list[Polytope]:
    """Bars around lines and points that two shapes share beside areas."""
    import shapely

    wide = {"join_style": "mitre", "mitre_limit": 20.0}
    near = [shape.buffer(TOUCH, **wide) for shape in (one, other)]
    areas = one.intersection(other).buffer(-TOUCH, **wide).buffer(8.0 * TOUCH, **wide)
    rest = near[0].intersection(near[1]).difference(areas)
    if rest.is_empty:
        return []
    found = []
    for start, end in _sides(one):
        shared = shapely.intersection(shapely.LineString([start, end]), rest.buffer(TOUCH))
        for part in (p for p in shapely.get_parts(shared) if not p.is_empty):
            around = part.buffer(HALF, cap_style="square", join_style="mitre")
            found.append(_convex(around.minimum_rotated_rectangle))
    return found


def _sides(shape: Any) -> Iterator[tuple[Any, Any]]:
    import shapely

    for polygon in shapely.get_parts(shape):
        for ring in (polygon.exterior, *polygon.interiors):
            yield from pairwise(ring.coords)


def _common(p: Polytope, q: Polytope) -> Polytope | None:
    """What two convex pieces share, None where that has no area."""
    import shapely

    found = shapely.Polygon(p.vertices).intersection(shapely.Polygon(q.vertices))
    if found.geom_type != "Polygon" or found.area <= TOUCH**2:
        return None
    return _convex(found)


def _convex(polygon: Any) -> Polytope:
    """A convex polygon of shapely's, whose rings may go either way."""
    import shapely

    ring = shapely.orient_polygons(polygon).exterior.coords[:-1]
    return polytope([(float(x), float(y)) for x, y in ring])
