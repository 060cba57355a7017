"""Places that stand on one another: the seam between them is a floor of no height.

`a outside p and a outside q` holds at the height at which p ends and q begins, wherever they are.
Where an agent must keep out of both, it keeps out of a plate of 2 mm around that height over what
the two cover together: the plate lies within p and q, so it forbids nothing but the seam. It closes
the seam where the two cover each other by areas; where they meet along a line or in a point as
well, seen from above, there would still be a way through that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from stlc.places import Polytope, Sweep
from stlc.sema.geometry import polygons, polytope
from stlc.sema.heights import TOUCH, Levels
from stlc.sema.plugs import Sweeps
from stlc.sema.values import Place

HALF = 1e-3
"""Half the height of a plate [m], as half the width of what closes a contact in a point."""


def meeting(
    places: Sequence[Place], each: Sequence[Levels], plugs: Callable[[], list[Sweeps]]
) -> tuple[Levels, list[Sweeps]] | None:
    """Between which heights places leave a way for an agent that keeps out of all, between `each`
    of the levels, and what closes it; None where one stands on another and nothing closes it."""
    low, high = max(e[0] for e in each), min(e[1] for e in each)
    if abs(high - low) > TOUCH:
        return (low, high), plugs() if low < high else []
    plates = _plates(places[0], places[1]) if len(places) == 2 else None
    return None if plates is None else ((low - HALF, low + HALF), plates)


def _plates(a: Place, b: Place) -> list[Sweeps] | None:
    """What two resting places cover together, from above; None where that isn't areas alone."""
    if not all(_rests(place) for place in (a, b)):
        return None
    whole = [_union(place) for place in (a, b)]
    if not whole[0].buffer(TOUCH).intersects(whole[1]):
        return []
    if not _is_areas(*whole):
        return None
    pieces = [
        piece for p in a.barriers[0] for q in b.barriers[0] if (piece := _common(p, q)) is not None
    ]
    return [(Sweep(tuple(pieces)),)]


def _rests(place: Place) -> bool:
    """Whether it has one shape for all times."""
    still = all(sweep.move == (0.0, 0.0) for sweep in place.sweeps)
    return still and len(place.barriers) == 1 and len(place.sweeps) == 1


def _union(place: Place) -> Any:
    import shapely

    return shapely.union_all(polygons(place.frames[0]))


def _is_areas(one: Any, other: Any) -> bool:
    """Whether what two shapes share, grown by what touches, is no more than its areas grown."""
    touching = one.buffer(TOUCH, join_style="mitre").intersection(
        other.buffer(TOUCH, join_style="mitre")
    )
    areas = one.intersection(other).buffer(-TOUCH, join_style="mitre")
    grown = areas.buffer(8.0 * TOUCH, join_style="mitre", mitre_limit=20.0)
    return bool(touching.difference(grown).is_empty)


def _common(p: Polytope, q: Polytope) -> Polytope | None:
    """What two convex pieces share, None where that has no area."""
    import shapely

    found = shapely.Polygon(p.vertices).intersection(shapely.Polygon(q.vertices))
    if found.geom_type != "Polygon" or found.area <= TOUCH**2:
        return None
    ring = found.exterior.coords[:-1]
    return polytope([(float(x), float(y)) for x, y in ring])
