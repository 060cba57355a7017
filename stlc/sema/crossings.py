"""Single points in the interior of a union that none of its pieces has inside."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from stlc.mission import Array
from stlc.places import Polytope
from stlc.sema.contacts import DEEP, PLUG, TOUCH
from stlc.sema.geometry import square


def single_points(pieces: Sequence[Polytope]) -> Iterable[Polytope]:
    """Plugs for single points inside the union that no piece has inside."""
    import shapely

    rings = [shapely.Polygon(p.vertices) for p in pieces]
    # Grown and shrunk again, the union has no slits from rounding.
    whole = shapely.union_all([r.buffer(TOUCH, join_style="mitre") for r in rings])
    whole = whole.buffer(-TOUCH - DEEP, join_style="mitre")
    nodes = shapely.get_coordinates(shapely.union_all([r.boundary for r in rings]))
    nodes = np.unique(nodes.round(9), axis=0)
    shapely.prepare(whole)
    nodes = nodes[shapely.contains_xy(whole, nodes)]
    for place in unheld(nodes, pieces):
        depth = float(whole.boundary.distance(shapely.Point(place)))
        yield square(place, min(PLUG, (depth + DEEP) / 2.0))


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
