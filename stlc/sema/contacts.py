"""Where two convex pieces touch without common interior: on a segment, or in a point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from stlc.mission import Array
from stlc.places import Polytope

TOUCH = 1e-6
"""Pieces this near touch [m]: a solver's tolerance, below which a gap is open to no one."""


DEEP = 1e-5
"""Pieces that overlap by this much need no more [m]: ten times a solver's tolerance."""


PLUG = 1e-3
"""Half the side of the plug where two pieces meet in a point [m]; below it a gap is warned of."""


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Where two pieces touch: a segment or a point (both ends alike).

    `faces` are the indices of the face of each piece on the common line, None for a corner;
    `whole` tells for each piece whether that face lies within the other's.
    """

    start: Array
    end: Array
    faces: tuple[int | None, int | None]
    whole: tuple[bool, bool]

    @property
    def length(self) -> float:
        """Length of the segment [m]."""
        return float(np.hypot(*(self.end - self.start)))


def boxes_meet(a: Polytope, b: Polytope) -> bool:
    """Whether the bounding boxes touch: cheap, and needed for any contact."""
    low = np.maximum(a.vertices.min(axis=0), b.vertices.min(axis=0))
    high = np.minimum(a.vertices.max(axis=0), b.vertices.max(axis=0))
    return bool((low <= high + TOUCH).all())


def _gaps(a: Polytope, b: Polytope) -> Array:
    """How far b lies beyond each face of a."""
    return np.asarray((a.normals @ b.vertices.T).min(axis=1) - a.offsets)


@lru_cache(maxsize=4096)
def contact(a: Polytope, b: Polytope) -> Contact | None:
    """Where two pieces touch without a common interior; None if they overlap or are apart.

    Kept for a while: two are asked for again with each third that both touch.
    """
    mine, other = _gaps(a, b), _gaps(b, a)
    own, far = float(mine.max()), float(other.max())
    if not -DEEP <= max(own, far) <= TOUCH:
        return None
    owner, face = (a, int(mine.argmax())) if own >= far else (b, int(other.argmax()))
    normal = owner.normals[face] if owner is a else -owner.normals[face]
    return _along(a, b, normal)


def _along(a: Polytope, b: Polytope, normal: Array) -> Contact | None:
    """The contact of two pieces that a line with this normal parts, a behind it."""
    tangent = np.array([-normal[1], normal[0]])
    (a0, a1), mine = extent(a, normal, tangent)
    (b0, b1), other = extent(b, -normal, tangent)
    low, high = max(a0, b0), min(a1, b1)
    if high < low - TOUCH:
        return None
    level = float((a.vertices @ normal).max())
    start, end = (level * normal + at * tangent for at in (low, max(low, high)))
    whole = (a0 >= b0 - TOUCH and a1 <= b1 + TOUCH, b0 >= a0 - TOUCH and b1 <= a1 + TOUCH)
    return Contact(start, end, (mine, other), whole)


def extent(
    piece: Polytope, normal: Array, tangent: Array
) -> tuple[tuple[float, float], int | None]:
    """Where the part of a piece that is furthest along a normal lies, and its face if it is one."""
    heights = piece.vertices @ normal
    top = piece.vertices[heights >= heights.max() - DEEP] @ tangent
    face = int((piece.normals @ normal).argmax())
    flat = len(top) > 1 and float(np.ptp(top)) > PLUG
    return (float(top.min()), float(top.max())), face if flat else None
