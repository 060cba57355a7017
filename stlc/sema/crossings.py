"""Single points in the interior of a union that none of its pieces has inside."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from stlc.mission import Array
from stlc.places import Polytope
from stlc.sema.contacts import DEEP, PLUG, TOUCH
from stlc.sema.geometry import polygons, square


def single_points(pieces: Sequence[Polytope]) -> Iterable[Polytope]:
    """Plugs for single points inside the union that no piece has inside."""
    import shapely

    rings = polygons(pieces)
    # Grown and shrunk again, the union has no slits from rounding.
    whole = shapely.union_all(shapely.buffer(rings, TOUCH, join_style="mitre"))
    whole = whole.buffer(-TOUCH - DEEP, join_style="mitre")
    nodes = shapely.get_coordinates(shapely.union_all(shapely.boundary(rings)))
    nodes = unheld(_distinct(nodes), pieces)
    shapely.prepare(whole)
    for place in nodes[shapely.contains_xy(whole, nodes)]:
        depth = float(whole.boundary.distance(shapely.Point(place)))
        yield square(place, min(PLUG, (depth + DEEP) / 2.0))


def _distinct(points: Array) -> Array:
    """The points (n, 2), each once, to 1e-9 m; compared as complex numbers they are sorted in a
    fifth of the time that rows take (0.03 of 0.17 s for 390,000)."""
    rounded = np.ascontiguousarray(points.round(9)) + 0.0  # -0.0 is another bit pattern, not value
    found: Array = np.unique(rounded.view(np.complex128)).view(np.float64).reshape(-1, 2)
    return found


TOGETHER = 32  # pieces, then the points that they hold are let go. Of 99,000 points in 56 wedges
# of a star each: 0.4 CPU s; a search tree asked for every piece took 5.2


def unheld(points: Array, pieces: Sequence[Polytope]) -> Array:
    """The points (n, 2) that no piece has in its interior, by `TOUCH`, sorted by x.

    Pieces are asked in no order: neighbours hold the same points.
    """
    left = points[points[:, 0].argsort(kind="stable")]
    order = np.random.default_rng(0).permutation(len(pieces))
    for first in range(0, len(order), TOGETHER):
        held = np.zeros(len(left), dtype=bool)
        for piece in (pieces[k] for k in order[first : first + TOGETHER]):
            x = piece.vertices[:, 0]
            near = slice(*left[:, 0].searchsorted((x.min(), x.max())))
            inside = left[near] @ piece.normals.T < piece.offsets - TOUCH
            held[near] |= inside.all(axis=1)
        left = left[~held]
    return left
