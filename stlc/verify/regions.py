"""Where a disturbed agent may be within a step, against places: convex polygons that hold it.

On a piece of a step the motion is a parabola with Bezier points P_k, and so is what each push
adds: whatever the pushes are, the agent is in the convex hull of the three sets P_k + Z_k, Z_k the
zonotope of the parts' Bezier points (`sway.py`). Where a hull is in the way it is halved, until
it is no larger than what the motion covers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.verify.barriers import Out
from stlc.verify.paths import Path
from stlc.verify.shapes import Body, Stay

Array = NDArray[np.float64]
Found = tuple[float, float]
"""Distance or minus depth [m], and the time within the step."""

BEND = 2e-7
"""A hull is this much larger than what it holds at most [m], within the tolerance of a verdict."""

SHARE = 1e-3
"""How precisely it is told how deep something goes that goes too deep, relative to that."""

INSTANTS = 129
"""Times of a step at which what turns is looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A motion over times [start, end] of a step: Bezier points of the plan (3, 2) and of the parts
    (3, 2, G) [m]."""

    start: float
    end: float
    plan: Array
    parts: Array

    @property
    def bend(self) -> float:
        """What the hull may be larger than the motion by [m]."""
        off = [np.abs(p[0] - 2.0 * p[1] + p[2]) for p in (self.plan, self.parts)]
        return 0.25 * float(np.linalg.norm(off[0]) + np.linalg.norm(off[1].sum(axis=-1)))

    @property
    def hull(self) -> Any:
        """What holds all places of the motion, a shapely geometry."""
        import shapely

        sets = [p + zonotope(g) for p, g in zip(self.plan, self.parts, strict=True)]
        return shapely.convex_hull(shapely.MultiPoint(np.concatenate(sets)))

    def halves(self) -> tuple[Stretch, Stretch]:
        """Its first and second half (de Casteljau)."""
        middle = 0.5 * (self.start + self.end)
        plans, parts = _halved(self.plan), _halved(self.parts)
        return (
            Stretch(self.start, middle, plans[0], parts[0]),
            Stretch(middle, self.end, plans[1], parts[1]),
        )

    def against(self, stay: Stay) -> Stretch:
        """The same, seen from what moves as `stay` does."""
        times = np.array([self.start, 0.5 * (self.start + self.end), self.end])
        plan = self.plan - stay.start - times[:, None] * stay.move
        return Stretch(self.start, self.end, plan, self.parts)

    def at(self, time: float) -> Any:
        """All places at a time in [start, end]."""
        import shapely

        s = (time - self.start) / (self.end - self.start)
        weights = np.array([(1.0 - s) ** 2, 2.0 * s * (1.0 - s), s**2])
        place, parts = (np.tensordot(weights, p, 1) for p in (self.plan, self.parts))
        return shapely.convex_hull(shapely.MultiPoint(place + zonotope(parts)))

    def nearest(self, distance: Callable[[Any], float]) -> float:
        """The time, one of nine, at which the places are nearest to something."""
        return float(min(np.linspace(self.start, self.end, 9), key=lambda s: distance(self.at(s))))


def _halved(points: Array) -> tuple[Array, Array]:
    a, b, c = points
    ab, bc = 0.5 * (a + b), 0.5 * (b + c)
    middle = 0.5 * (ab + bc)
    return np.stack([a, ab, middle]), np.stack([middle, bc, c])


def zonotope(parts: Array) -> Array:
    """Corners (2 G, 2) of all sums of parts (2, G), each times a number in [-1, 1]."""
    along = np.where((parts[1] < 0.0) | ((parts[1] == 0.0) & (parts[0] < 0.0)), -parts, parts)
    along = along[:, np.argsort(np.arctan2(along[1], along[0]))]
    lowest = -along.sum(axis=1)
    side = lowest[:, None] + 2.0 * np.cumsum(along, axis=1)
    return np.concatenate([side.T, -side.T])


def stretches(path: Path, t: int) -> Iterator[Stretch]:
    """The pieces of a motion in the plane from step t to the next."""
    for piece in range(path.pieces):
        row = t * path.pieces + piece
        first, rate, bent = path.c0[row], path.c1[row], path.c2[row]
        plan = np.stack([first, first + 0.5 * rate, first + rate + bent])
        parts = np.concatenate([s.generators(t, piece) for s in path.sways], axis=-1)
        yield Stretch(piece / path.pieces, (piece + 1) / path.pieces, plan, parts)


def kept_clear(path: Path, t: int, stay: Stay, out: Out) -> Found:
    """Distance to what an agent keeps out of, or minus how deep it may get into it, in a step."""
    import shapely

    def judged(hull: Any) -> float:
        """Distance, or minus the depth."""
        if not shapely.intersects(out.core, hull):
            return float(shapely.distance(out.solid, hull))
        met = _corners(shapely.intersection(hull, out.core), hull)
        return -float(shapely.distance(met, out.border.boundary).max())

    value, stretch = _least(path, t, stay, judged)
    return value, stretch.nearest(lambda place: float(shapely.distance(out.solid, place)))


def kept_within(path: Path, t: int, stay: Stay, room: Any, whole: Any) -> Found:
    """Distance to the border of what an agent stays in, or minus how far out it may be, in a
    step."""
    import shapely

    def judged(hull: Any) -> float:
        """Distance to the border, or minus how far out."""
        if shapely.covers(room, hull):
            return float(shapely.distance(hull, whole.boundary))
        left = _corners(shapely.difference(hull, room), hull)
        return -float(shapely.distance(left, whole).max())

    value, stretch = _least(path, t, stay, judged)
    return value, stretch.nearest(lambda place: float(shapely.distance(whole.boundary, place)))


def _least(path: Path, t: int, stay: Stay, judged: Callable[[Any], float]) -> tuple[float, Stretch]:
    """The least value of a step, and the stretch that has it: that of the worst hull, which is
    halved as long as it is below 0 and the hull says more than the motion."""
    order = count()
    todo: list[tuple[float, int, Stretch]] = []

    def add(stretch: Stretch) -> None:
        heappush(todo, (judged(stretch.hull), next(order), stretch))

    for stretch in stretches(path, t):
        add(stretch.against(stay))
    while True:
        value, _, stretch = heappop(todo)
        if value >= 0.0 or stretch.bend <= max(BEND, -SHARE * value):
            return value, stretch
        for half in stretch.halves():
            add(half)


def _corners(met: Any, hull: Any) -> Array:
    """Points all over a geometry, or over `hull` where rounding leaves nothing of it."""
    import shapely

    shape = hull if met.is_empty else met
    fine = shapely.segmentize(shape, max(shape.length, BEND) / 64.0)
    return np.asarray(shapely.points(shapely.get_coordinates(fine)))


def beside_turning(path: Path, t: int, body: Body, sign: float = 1.0) -> Found:
    """The least of `sign` times the distance to what turns, at many instants of a step."""
    found = []
    for stretch in stretches(path, t):
        for time in np.linspace(stretch.start, stretch.end, INSTANTS // path.pieces + 2):
            found.append((sign * body.gap(t + time, stretch.at(time), sign), float(time)))
    return min(found)
