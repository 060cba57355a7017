"""How deep a plan goes into what it should keep out of, at any time.

An agent's forbidden set is the union of what it keeps out of, *together with all that lies outside
the workspace*: seams between pieces, and between a wall and the border, are inside that union and
no way through it. The sets are made from the generator's own numbers.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from functools import cache

import numpy as np
import shapely
from shapely.affinity import translate

from truth.motion import Motion
from truth.scene import Array, Obstacle, Part, Ring, Scene, Window

POINTS = 240  # in each step, before the refinement around the worst ones
FINE = 60
SEAL = 1e-7  # m: gaps narrower than twice this are rounding
FAR = 50.0  # m of the world outside the workspace

Excess = Callable[[int, Array], Array]  # step, fractions (K,) -> how far a limit is passed (K,)


def judge(scene: Scene, motions: Mapping[str, Motion]) -> dict[str, float]:
    """The worst excess of each kind of condition, in its unit; negative: room was left."""
    found: dict[str, float] = {}
    for kind, value in _findings(scene, motions):
        found[kind] = max(found.get(kind, -np.inf), value)
    return found


def _findings(scene: Scene, motions: Mapping[str, Motion]) -> Iterator[tuple[str, float]]:
    for name, motion in motions.items():
        yield from _limits(motion)
        beyond = shapely.Polygon(scene.workspace)
        yield "workspace", _worst(_distance(beyond, motion), 0, scene.horizon)
        yield "goal", _goal(scene, name, motion)
        for first, last, names in _spells(scene, name):
            sealed = _Forbidden(scene, names)
            yield "obstacle", _worst(sealed.excess(motion), first, last)
        yield "sampled", _samples(scene, name, motion)
    for (who, where), window in scene.keep_in.items():
        place = _union(scene.regions[where])
        yield "inside", _over(_distance(place, motions[who]), window)
    for (one, other), (gap, window) in scene.apart.items():
        yield "separation", _over(_closeness(motions[one], motions[other], gap), window)


def _limits(motion: Motion) -> Iterator[tuple[str, float]]:
    """Controls, speeds and turning rates at the samples, where the language promises them."""
    body, size = motion.body, np.linalg.norm(motion.inputs, axis=1)
    yield "control", float((size if body.disc else abs(motion.inputs)).max() - body.control)
    if body.speed is None or motion.velocities is None:
        return
    speed = np.linalg.norm(motion.velocities, axis=1)
    yield "speed", float(speed[1:].max() - body.speed)
    if body.turns:
        fast = speed[:-1] > 0.05 + 1e-6
        turning = size - body.control / body.speed * speed[:-1]
        yield "turning", float(np.where(fast, turning, -np.inf).max())


def _goal(scene: Scene, name: str, motion: Motion) -> float:
    if name not in scene.goals:
        return -np.inf
    place = motion.states[1:][:, list(motion.body.model.position)]
    goal = _union((scene.goals[name],))
    return float(shapely.distance(shapely.points(place), goal).min())


def _spells(scene: Scene, name: str) -> Iterator[tuple[int, int, frozenset[str]]]:
    """(first, last, obstacles) of the times at which the same obstacles are to be avoided."""
    windows = {o: w for (who, o), w in scene.keep_out.items() if who == name and w.swept}
    ends = sorted({e for w in windows.values() for e in (w.first, w.last)})
    for first, last in itertools.pairwise(ends):
        held = frozenset(o for o, w in windows.items() if w.first <= first and last <= w.last)
        if held:
            yield first, last, held


def _samples(scene: Scene, name: str, motion: Motion) -> float:
    """Depth at the samples, in each sampled obstacle alone."""
    worst = -np.inf
    place = motion.states[:, list(motion.body.model.position)]
    for (who, what), window in scene.keep_out.items():
        if who == name:
            obstacle = next(o for o in scene.obstacles if o.name == what)
            for step in range(window.first, window.last + 1):
                shape = _grown(_union(obstacle.frame(step)), obstacle.grow)
                worst = max(worst, float(_depth(_sealed(shape), place[step : step + 1])[0]))
    return worst


class _Forbidden:
    """What lies outside the workspace and in the named obstacles, at any time."""

    def __init__(self, scene: Scene, names: frozenset[str]) -> None:
        self._obstacles = [o for o in scene.obstacles if o.name in names]
        self._outside = _outside(scene.workspace)
        self._static = cache(self._at)

    def excess(self, motion: Motion) -> Excess:
        """Depth below the surface of the union, negative outside of it."""
        moving = any(o.moves for o in self._obstacles)

        def depth(step: int, s: Array) -> Array:
            place = motion.at(step, s)
            if not moving:
                return _depth(self._static(0, 0.0), place)
            pairs = zip(s, place, strict=True)
            return np.array([_depth(self._at(step, float(f)), p[None])[0] for f, p in pairs])

        return depth

    def _at(self, step: int, s: float) -> shapely.Geometry:
        shapes = [_grown(_between(o, step, s), o.grow) for o in self._obstacles]
        return _sealed(shapely.union_all([self._outside, *shapes]))


def _between(obstacle: Obstacle, step: int, s: float) -> shapely.Geometry:
    """Parts on their way from one frame to the next, which only shifts them."""
    parts = []
    for now, then in zip(obstacle.frame(step), obstacle.frame(step + 1), strict=True):
        dx, dy = (then.ring[0][k] - now.ring[0][k] for k in range(2))
        parts.append(translate(_polygon(now), s * dx, s * dy))
    return shapely.union_all(parts)


def _polygon(part: Part) -> shapely.Polygon:
    return shapely.Polygon(part.ring, part.holes)


def _union(parts: tuple[Part, ...]) -> shapely.Geometry:
    return shapely.union_all([_polygon(part) for part in parts])


def _grown(shape: shapely.Geometry, distance: float) -> shapely.Geometry:
    return shape.buffer(distance, quad_segs=64) if distance else shape


def _sealed(shape: shapely.Geometry) -> shapely.Geometry:
    """Closed over gaps of measure zero."""
    return shape.buffer(SEAL, join_style="mitre").buffer(-SEAL, join_style="mitre")


def _outside(ring: Ring) -> shapely.Geometry:
    space = shapely.Polygon(ring)
    return shapely.box(*space.buffer(FAR).bounds).difference(space)


def _depth(shape: shapely.Geometry, place: Array) -> Array:
    points = shapely.points(place)
    inside = shapely.contains_xy(shape, place[:, 0], place[:, 1])
    return np.asarray(np.where(inside, 1.0, -1.0) * shapely.distance(shape.boundary, points))


def _distance(shape: shapely.Geometry, motion: Motion) -> Excess:
    """How far outside a shape an agent is."""
    return lambda step, s: np.asarray(shapely.distance(shape, shapely.points(motion.at(step, s))))


def _closeness(one: Motion, other: Motion, gap: tuple[float, float]) -> Excess:
    def close(step: int, s: Array) -> Array:
        apart = abs(one.at(step, s) - other.at(step, s)) - np.array(gap)
        return np.asarray(-apart.max(axis=1))

    return close


def _over(excess: Excess, window: Window) -> float:
    if window.swept:
        return _worst(excess, window.first, window.last)
    ends = [(k, 0.0) for k in range(window.first, window.last)] + [(window.last - 1, 1.0)]
    return max(float(excess(k, np.array([s]))[0]) for k, s in ends)


def _worst(excess: Excess, first: int, last: int) -> float:
    """max over the motion from step `first` to `last`: dense points, then local refinement."""
    s = np.linspace(0.0, 1.0, POINTS + 1)
    values = np.array([excess(k, s) for k in range(first, last)])
    best = float(values.max())
    for index in np.argsort(values, axis=None)[-3:]:
        row, column = np.unravel_index(index, values.shape)
        best = max(best, _refined(excess, first + int(row), float(s[column])))
    return best


def _refined(excess: Excess, step: int, at: float) -> float:
    best, width = -np.inf, 1.0 / POINTS
    for _ in range(3):
        s = np.clip(np.linspace(at - width, at + width, FINE), 0.0, 1.0)
        values = excess(step, s)
        best, at, width = float(values.max()), float(s[values.argmax()]), width * 2.0 / FINE
    return best
