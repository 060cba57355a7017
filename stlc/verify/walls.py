"""Walls as the verifier sees them: the line of sight of each step, by shapely and by hand."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stlc.places import Wall

Array = NDArray[np.float64]
Point = tuple[float, float]

_ON = 1e-6  # m: an end as near as that to a wall isn't beyond it


def losses(walls: Mapping[str, Wall], loss: Mapping[str, float], a: Array, b: Array) -> Array:
    """What links from a to b (K, 2 or more) [m] lose to walls (K,), by the loss of each [dB]."""
    total = np.zeros(len(a))
    for name, each in loss.items():
        wall = walls[name]
        for p, q in pairwise(wall.line):
            total += each * _cut(p, q, a, b)
        if wall.outlines:
            total += each * _through(wall, a, b)
    return total


def _cut(p: Point, q: Point, a: Array, b: Array) -> NDArray[np.bool_]:
    """Which links cross a stretch of wall: a + s (b - a) = p + t (q - p), 0 <= t <= 1, with both
    ends off the wall's line, on different sides of it."""
    ux, uy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(ux, uy)
    off = [((e[:, 1] - p[1]) * ux - (e[:, 0] - p[0]) * uy) / length for e in (a, b)]
    beyond = (np.abs(off[0]) > _ON) & (np.abs(off[1]) > _ON) & (off[0] * off[1] < 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = off[0] / (off[0] - off[1])
        x, y = (a[:, k] + s * (b[:, k] - a[:, k]) for k in (0, 1))
        t = ((x - p[0]) * ux + (y - p[1]) * uy) / length**2
    return np.asarray(beyond & (t >= 0.0) & (t <= 1.0))


def _through(wall: Wall, a: Array, b: Array) -> NDArray[np.bool_]:
    """Which links run through a wall with a thickness."""
    import shapely

    body = shapely.union_all([shapely.Polygon(o.ring, o.holes) for o in wall.outlines])
    core = body.buffer(-_ON, join_style="mitre")
    sight = shapely.linestrings(np.stack([a[:, :2], b[:, :2]], axis=1))
    return np.asarray(shapely.intersects(core, sight))
