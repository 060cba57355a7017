"""Shapes as the verifier sees them: made by shapely from the outlines in the file, by nothing else.

The encoder keeps out of convex pieces that semantic analysis cut. Nothing of that is used here, so
a fault in it shows. An obstacle is the union of its polygons, each grown by `inflate` metres in
every direction (the Minkowski sum with a disc).

Unions are closed (`unions.py`): polygons within a tolerance of each other leave no way between
them, nor does one so near the workspace's border.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stlc.mission import Mission
from stlc.places import Obstacle, Outline, Polytope, Region, Track

if TYPE_CHECKING:
    import shapely

Array = NDArray[np.float64]
Outlines = tuple[Outline, ...]
Levels = tuple[float, float]

ROUND = 64
"""Segments of a quarter circle, inscribed: 1e-4 of `inflate` short of the disc, never beyond."""


@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """Polygons at rest, grown, and the union of those in the file (`solid`)."""

    parts: tuple[shapely.Geometry, ...]
    solid: shapely.Geometry
    made: dict[object, Any] = field(default_factory=dict)  # what judgements made of it


@dataclass(frozen=True, slots=True, eq=False)
class Stay:
    """A form that is `start` (2,) [m] from its place at one step, and moves rigidly by `move` (2,)
    until the next."""

    form: Form
    start: Array
    move: Array


@dataclass(frozen=True, slots=True, eq=False)
class Spell:
    """Steps (n,) that a form spends moving by `move` (2,) each, from `starts` (n, 2) [m]."""

    form: Form
    steps: NDArray[np.intp]
    starts: Array
    move: Array

    @classmethod
    def of(cls, stays: Sequence[tuple[int, Stay]]) -> Spell:
        """Of steps whose form and move are the same."""
        steps = np.array([t for t, _ in stays], dtype=np.intp)
        starts = np.array([stay.start for _, stay in stays])
        return cls(stays[0][1].form, steps, starts, stays[0][1].move)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """An obstacle or region in time. `step` [s]; `grow` [m] is added all around.

    `levels` [m] are the heights it lies between before it grows; None for all.
    """

    track: Track
    step: float
    grow: float = 0.0
    levels: Levels | None = None
    _stays: dict[int, Stay | None] = field(default_factory=dict)
    _forms: dict[Outlines, Form] = field(default_factory=dict)
    _spells: dict[int, list[Spell]] = field(default_factory=dict)

    def stay(self, t: int) -> Stay | None:
        """The polygons between steps t and t + 1, or None where corners move unlike each other."""
        if t not in self._stays:
            self._stays[t] = self._stay(t)
        return self._stays[t]

    def at(self, t: int) -> Stay:
        """The polygons at step t."""
        last, shape = self.track.frames[-1]
        if t < last:
            return Stay(self._form(self.outlines(float(t))), np.zeros(2), np.zeros(2))
        step = np.array(self.track.velocity) * self.step
        return Stay(self._form(shape), t * step, step)

    def spells(self, count: int) -> list[Spell]:
        """The steps below `count`, those of one form and move together."""
        if count not in self._spells:
            found: dict[tuple[int, bytes], list[tuple[int, Stay]]] = {}
            for t in range(count):
                stay = self.stay(t)
                if stay is not None:
                    key = id(stay.form), stay.move.tobytes()
                    found.setdefault(key, []).append((t, stay))
            self._spells[count] = [Spell.of(stays) for stays in found.values()]
        return self._spells[count]

    def _form(self, outlines: Outlines) -> Form:
        if outlines not in self._forms:
            self._forms[outlines] = _form(_polygons(outlines), self.grow)
        return self._forms[outlines]

    def _stay(self, t: int) -> Stay | None:
        """The body within step t: at rest, translated evenly, or the hulls where its shape changes.

        None where its corners move by different amounts: it is then turned, and judged at times.
        """
        rest = self.at(t)
        if t >= self.track.frames[-1][0]:
            return rest
        now, then = self.outlines(float(t)), self.outlines(float(t + 1))
        if not _alike(now, then):
            hulls = _hulls(_polygons(now), _polygons(then))
            return Stay(_form(hulls, self.grow), np.zeros(2), np.zeros(2))
        steps = _corners(then) - _corners(now)
        if np.ptp(steps, axis=0).max() > 1e-9 * max(1.0, float(np.abs(_corners(now)).max())):
            return None
        return Stay(rest.form, rest.start, steps.mean(axis=0))

    def outlines(self, time: float) -> Outlines:
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

        return self.gap(time, shapely.Point(place))

    def gap(self, time: float, shape: Any, sign: float = 1.0) -> float:
        """That of a shape: its nearest point, or with `sign` -1 its farthest, if all is inside
        minus the distance to the border."""
        import shapely

        union = shapely.union_all(_polygons(self.outlines(time)))
        corners = shapely.points(shapely.get_coordinates(shape))
        within = shapely.contains(union, corners)
        deep, away = shapely.distance(union.boundary, corners), shapely.distance(union, corners)
        values = np.where(within, -deep, away)
        if sign < 0.0:
            return float(values.max()) - self.grow
        near = 0.0 if union.intersects(shape) else float(union.distance(shape))
        return min(near, float(values.min())) - self.grow


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """Every obstacle and region of a mission, each made once."""

    mission: Mission
    _known: dict[tuple[str, bool], Body] = field(default_factory=dict)

    def __contains__(self, name: str) -> bool:
        return name in self.mission.obstacles or name in self.mission.regions

    def of(self, name: str, inflated: bool = True) -> Body:
        """The body of an obstacle or region."""
        if (name, inflated) not in self._known:
            self._known[name, inflated] = self._made(name, inflated)
        return self._known[name, inflated]

    def _made(self, name: str, inflated: bool) -> Body:
        obstacle = self.mission.obstacles.get(name)
        if obstacle is None:
            return region_body(self.mission.regions[name], self.mission.step)
        return obstacle_body(obstacle, self.mission.step, obstacle.inflate if inflated else 0.0)


def obstacle_body(obstacle: Obstacle, step: float, grow: float) -> Body:
    """An obstacle as the file gives it, grown by `grow` [m]."""
    if obstacle.track is not None:
        return Body(obstacle.track, step, grow, obstacle.heights)
    frames = tuple((t, _from_pieces(p)) for t, p in enumerate(obstacle.bodies))
    return Body(Track(frames), step, grow, obstacle.heights)


def region_body(region: Region, step: float) -> Body:
    """A region as the file gives it."""
    outlines = region.outlines or _from_pieces(region.pieces)
    return Body(Track(((0, outlines),)), step, levels=region.heights)


def _from_pieces(pieces: Sequence[Polytope]) -> Outlines:
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


def _mixed(one: Sequence[Outline], other: Sequence[Outline], share: float) -> Outlines:
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


def _hulls(now: Sequence[Any], then: Sequence[Any]) -> list[Any]:
    """What polygons may cover on their way: each one's hull, or the hull of all if they change."""
    import shapely

    pairs = zip(now, then, strict=True) if len(now) == len(then) else [(now, then)]
    return [shapely.convex_hull(shapely.union_all(np.hstack(pair))) for pair in pairs]


def _form(polygons: Sequence[Any], grow: float) -> Form:
    import shapely

    parts = [p.buffer(grow, quad_segs=ROUND) if grow else p for p in polygons]
    solid = shapely.union_all(list(polygons))
    shapely.prepare(solid)
    return Form(tuple(parts), solid)
