"""Plugs between several unions that are kept out of together: over contacts, and where ends meet.

The plug over a contact of two pieces has the contact as its diagonal, so its ends stay open. Such
an end is inside the union only where further pieces meet there: three wedges around a point, each
touching the next along a face, hold the point inside together, and none of them does alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from math import acos, pi

import numpy as np

from stlc.arrays import Floats
from stlc.places import Polytope
from stlc.sema.contacts import DEEP, PLUG, TOUCH, Contact, boxes_meet, contact
from stlc.sema.geometry import contains, square
from stlc.sema.seams import plug_over

Pieces = Sequence[Polytope]
Met = tuple[Polytope, Polytope, Contact]
_CLOSE = 1e-3  # rad that pieces around a point may lack of a full turn, by rounding
Box = tuple[float, float, float, float]


def touching(boxes: Mapping[int, Box]) -> dict[int, frozenset[int]]:
    """For each box (x0, y0, x1, y1) [m] the keys of the others that touch it."""
    import shapely

    keys = list(boxes)
    shapes = shapely.box(*np.array(list(boxes.values())).reshape(-1, 4).T)
    pairs = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=2.0 * TOUCH)
    found: dict[int, set[int]] = {key: set() for key in keys}
    for i, j in pairs.T.tolist():
        if i != j:
            found[keys[i]].add(keys[j])
    return {key: frozenset(others) for key, others in found.items()}


def plugs_between(one: Pieces, other: Pieces) -> tuple[Polytope, ...]:
    """Plugs for the contacts of two unions that are both kept out of, and where these end."""
    met = _contacts(one, other)
    plugs = [plug_over(a, b, contact) for a, b, contact in met]
    return (*plugs, *_at_ends(met, (one, other)))


def meeting(one: Pieces, other: Pieces, third: Pieces) -> tuple[Polytope, ...]:
    """Plugs about points that three unions together have inside, and no two of them."""
    return tuple(_at_ends(_contacts(one, other), (one, other, third)))


def _at_ends(met: Sequence[Met], unions: Sequence[Pieces]) -> list[Polytope]:
    """Plugs about ends of contacts that all unions share and no piece of them has inside."""
    found: list[Polytope] = []
    for _, _, touch in met:
        if touch.length <= PLUG:
            continue  # a square is about it
        for end in (touch.start, touch.end):
            around = [[p for p in pieces if contains(p, end, -TOUCH)] for pieces in unions]
            if all(around) and not any(contains(p, end, TOUCH) for p in found):
                found += _inside([p for pieces in around for p in pieces], end)
    return found


def _contacts(one: Pieces, other: Pieces) -> list[Met]:
    found = []
    for a in one:
        for b in other:
            met = contact(a, b) if boxes_meet(a, b) else None
            if met is not None:
                found.append((a, b, met))
    return found


def _inside(around: Pieces, place: Floats) -> list[Polytope]:
    """A square about a point (2,) inside the union of the pieces there, if it is in none of them
    and no two meet in it alone, which has its square."""
    import shapely

    if len(around) < 3 or sum(_angle(p, place) for p in around) < 2.0 * pi - _CLOSE:
        return []
    if any(contains(p, place, TOUCH) for p in around):
        return []
    met = [contact(a, b) for a, b in combinations(around, 2)]
    if any(m is not None and m.length <= PLUG for m in met):
        return []
    rings = [shapely.Polygon(p.vertices).buffer(TOUCH, join_style="mitre") for p in around]
    whole = shapely.union_all(rings).buffer(-TOUCH - DEEP, join_style="mitre")
    point = shapely.Point(place)
    if not shapely.contains(whole, point):
        return []
    depth = float(whole.boundary.distance(point))
    return [square(place, min(PLUG, (depth + DEEP) / 2.0))]


def _angle(piece: Polytope, place: Floats) -> float:
    """How much of a full turn about a point of its border a piece takes at most [rad]."""
    here = np.flatnonzero(piece.offsets - piece.normals @ place < TOUCH)
    if len(here) != 2:
        return pi if len(here) else 2.0 * pi
    cosine = float(piece.normals[here[0]] @ piece.normals[here[1]])
    return pi - acos(min(1.0, max(-1.0, cosine)))
