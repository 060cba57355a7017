"""Unions closed as the mission language says: without slits, and through no contact in one point.

The union is grown by half of `TOUCH` and shrunk again, which fills slits and leaves the rest; where
polygons meet in a point only, a disc of `DISC` closes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.places import Polytope

Array = NDArray[np.float64]

TOUCH = 1e-6
"""Polygons this near touch [m]: the tolerance of every judgement."""

DISC = 5e-4
"""Radius of what closes a contact in one point [m]."""


def past_borders(space: Polytope | None, move: Array) -> list[Any]:
    """What lies past each face of the workspace that things moving by `move` [m] don't leave."""
    import shapely

    if space is None:
        return []
    size = 4.0 * (float(np.ptp(space.vertices, axis=0).max()) + float(np.abs(move).max()))
    found = []
    for normal, start, end in _sides(space):
        if abs(float(normal @ move)) <= TOUCH:
            along = size * np.array([-normal[1], normal[0]])
            ring = [start - along, end + along]
            found.append(shapely.Polygon([*ring, *(p + size * normal for p in reversed(ring))]))
    return found


def _sides(space: Polytope) -> list[tuple[Array, Array, Array]]:
    """(outward normal, start, end) of each side of a convex counter-clockwise ring."""
    found = []
    for start, end in zip(space.vertices, np.roll(space.vertices, -1, axis=0), strict=True):
        along = (end - start) / np.hypot(*(end - start))
        found.append((np.array([along[1], -along[0]]), start, end))
    return found


def closed_union(parts: Sequence[Any], around: Sequence[Any] = ()) -> Any:
    """The union of polygons, and of those `around`, without slits and contacts in one point."""
    import shapely

    half = TOUCH / 2.0
    spread = [p.buffer(half, join_style="mitre") for p in (*parts, *around)]
    whole = shapely.union_all(spread).buffer(-half, join_style="mitre")
    discs = [shapely.Point(c).buffer(DISC) for c in _point_contacts(spread, len(parts))]
    return shapely.union_all([whole, *discs]) if discs else whole


def _point_contacts(spread: Sequence[Any], count: int) -> list[Array]:
    """Middles of contacts in one point, of pairs with one of the first `count` at least."""
    import shapely

    tree = shapely.STRtree(spread)
    found = []
    for i, j in tree.query(spread[:count], predicate="intersects").T:
        if i >= j and j < count:
            continue
        for part in shapely.get_parts(shapely.intersection(spread[i], spread[j])):
            x0, y0, x1, y1 = part.bounds
            if max(x1 - x0, y1 - y0) <= 2.0 * DISC:
                found.append(np.array([(x0 + x1) / 2.0, (y0 + y1) / 2.0]))
    return found


def moved(shape: Any, by: Array) -> Any:
    """A shape moved [m]."""
    from shapely.affinity import translate

    return translate(shape, *by)
