"""Shapes as the verifier sees them: made by shapely from the outlines in the file, by nothing else.

The encoder keeps out of convex pieces that semantic analysis cut. Nothing of that is used here, so
a fault in it shows. An obstacle is the union of its polygons, each grown by `inflate` metres in
every direction (the Minkowski sum with a disc).

Unions are closed: polygons within `TOUCH` of each other leave no way between them, nor does one so
near the workspace's border. The union is grown by half of that and shrunk again, which fills slits
and leaves the rest; where polygons meet in a point only, a disc of `DISC` closes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stlc.mission import Obstacle, Outline, Polytope, Region, Track

if TYPE_CHECKING:
    import shapely

Array = NDArray[np.float64]

TOUCH = 1e-6
"""Polygons this near touch [m]: the tolerance of every judgement."""

DISC = 5e-4
"""Radius of what closes a contact in one point [m]."""

ROUND = 64
"""Segments of a quarter circle, inscribed: 1e-4 of `inflate` short of the disc, never beyond."""


@dataclass(frozen=True, slots=True)
class Stay:
    """Polygons of one step that move rigidly by `move` (2,) [m] until the next, grown already."""

    parts: tuple[shapely.Polygon, ...]
    move: Array


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """An obstacle or region in time. `step` [s]; `grow` [m] is added all around."""

    track: Track
    step: float
    grow: float = 0.0
    _stays: dict[int, Stay | None] = field(default_factory=dict)

    def stay(self, t: int) -> Stay | None:
        """The polygons between steps t and t + 1, or None where corners move unlike each other."""
        key = self._key(t)
        if key not in self._stays:
            self._stays[key] = self._stay(t)
        return self._stays[key]

    def _key(self, t: int) -> int:
        """One key for all steps after the last frame of what stands still."""
        still = self.track.velocity == (0.0, 0.0)
        return min(t, self.track.frames[-1][0]) if still else t

    def _stay(self, t: int) -> Stay | None:
        now, then = self.outlines(float(t)), self.outlines(float(t + 1))
        if not _alike(now, then):
            import shapely

            hull = shapely.convex_hull(shapely.union_all([*_polygons(now), *_polygons(then)]))
            return Stay((_grown(hull, self.grow),), np.zeros(2))
        steps = _corners(then) - _corners(now)
        if np.ptp(steps, axis=0).max() > 1e-9 * max(1.0, float(np.abs(_corners(now)).max())):
            return None
        return Stay(tuple(_grown(p, self.grow) for p in _polygons(now)), steps.mean(axis=0))

    def outlines(self, time: float) -> tuple[Outline, ...]:
        """The polygons at a fractional step, corners moving straight from frame to frame."""
        frames = self.track.frames
        k = max(i for i, (step, _) in enumerate(frames) if step <= time)
        shape, share = frames[k][1], 0.0
        if k + 1 < len(frames):
            end = frames[k + 1][0]
            begin = frames[k][0] if self.track.linear else end - 1
            share = max(0.0, (time - begin) / (end - begin))
        if share > 0.0 and _alike(shape, frames[k + 1][1]):
            shape = _mixed(shape, frames[k + 1][1], share)
        x, y = (v * time * self.step for v in self.track.velocity)
        return tuple(_map(o, lambda p: (p[0] + x, p[1] + y)) for o in shape) if x or y else shape

    def distance(self, time: float, place: Array) -> float:
        """From a place to the grown polygons at a fractional step [m]; negative inside."""
        import shapely

        point, union = shapely.Point(place), shapely.union_all(_polygons(self.outlines(time)))
        away = float(union.distance(point))
        inside = -float(union.boundary.distance(point)) if union.contains(point) else away
        return inside - self.grow


def obstacle_body(obstacle: Obstacle, step: float, grow: float) -> Body:
    """An obstacle as the file gives it, grown by `grow` [m]."""
    if obstacle.track is not None:
        return Body(obstacle.track, step, grow)
    frames = tuple((t, _from_pieces(p)) for t, p in enumerate(obstacle.bodies))
    return Body(Track(frames), step, grow)


def region_body(region: Region, step: float) -> Body:
    """A region as the file gives it."""
    outlines = region.outlines or _from_pieces(region.pieces)
    return Body(Track(((0, outlines),)), step)


def _from_pieces(pieces: Sequence[Polytope]) -> tuple[Outline, ...]:
    """Outlines of a mission that was made without a file."""
    return tuple(Outline(tuple((float(x), float(y)) for x, y in p.vertices)) for p in pieces)


def _alike(one: Sequence[Outline], other: Sequence[Outline]) -> bool:
    sizes = [[(len(o.ring), [len(h) for h in o.holes]) for o in s] for s in (one, other)]
    return sizes[0] == sizes[1]


def _corners(outlines: Sequence[Outline]) -> Array:
    return np.array([p for o in outlines for ring in (o.ring, *o.holes) for p in ring])


def _map(outline: Outline, change: Any) -> Outline:
    rings = [tuple(change(p) for p in ring) for ring in (outline.ring, *outline.holes)]
    return Outline(rings[0], tuple(rings[1:]))


def _mixed(one: Sequence[Outline], other: Sequence[Outline], share: float) -> tuple[Outline, ...]:
    found = []
    for a, b in zip(one, other, strict=True):
        ends = iter([p for ring in (b.ring, *b.holes) for p in ring])
        found.append(_map(a, lambda p, ends=ends: _toward(p, next(ends), share)))
    return tuple(found)


def _toward(p: tuple[float, float], q: tuple[float, float], share: float) -> tuple[float, float]:
    return p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])


def _polygons(outlines: Sequence[Outline]) -> list[shapely.Polygon]:
    import shapely

    return [shapely.Polygon(o.ring, o.holes) for o in outlines]


def _grown(polygon: shapely.Geometry, by: float) -> Any:
    return polygon.buffer(by, quad_segs=ROUND) if by else polygon


# --- closed unions --------------------------------------------------------------------------------


def beyond(space: Polytope | None, move: Array) -> list[Any]:
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
