"""Where a moving obstacle is at each step, and how it gets from one step to the next."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from stlc.arrays import Floats
from stlc.places import Outline, Polytope, Sweep, Track
from stlc.sema.contacts import PLUG
from stlc.sema.geometry import Point, inflated, polytope, simplified
from stlc.sema.seams import closed

Pieces = tuple[Polytope, ...]

SAME = 1e-9
"""Corners that move alike to within this much of the shape's size move as one."""


def count(track: Track, last: int) -> int:
    """How many steps an obstacle is placed at."""
    return max(track.frames[-1][0], last if track.velocity != (0.0, 0.0) else 0) + 1


def placed(track: Track, dt: float, last: int) -> list[tuple[Outline, ...]]:
    """The polygons at each step from 0; what doesn't move for ever ends with its last frame."""
    steps = [step for step, _ in track.frames]
    found = []
    for t in range(count(track, last)):
        k = bisect_right(steps, t) - 1
        shape = track.frames[k][1]
        if track.linear and k + 1 < len(steps):
            share = (t - steps[k]) / (steps[k + 1] - steps[k])
            shape = between(shape, track.frames[k + 1][1], share)
        found.append(tuple(_moved(o, track.velocity, t * dt) for o in shape))
    return found


def alike(one: Sequence[Outline], other: Sequence[Outline]) -> bool:
    """Whether the polygons have the same numbers of corners, so that one becomes the other."""
    return [_sizes(o) for o in one] == [_sizes(o) for o in other]


def _sizes(outline: Outline) -> tuple[int, ...]:
    return (len(outline.ring), *(len(hole) for hole in outline.holes))


def between(one: Sequence[Outline], other: Sequence[Outline], share: float) -> tuple[Outline, ...]:
    """Polygons that are alike, each corner that share of its way along."""

    def mixed(a: Sequence[Point], b: Sequence[Point]) -> tuple[Point, ...]:
        rings = zip(a, b, strict=True)
        return tuple((p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])) for p, q in rings)

    pairs = zip(one, other, strict=True)
    return tuple(
        Outline(
            mixed(a.ring, b.ring),
            tuple(mixed(g, h) for g, h in zip(a.holes, b.holes, strict=True)),
        )
        for a, b in pairs
    )


def _moved(outline: Outline, velocity: Point, seconds: float) -> Outline:
    if velocity == (0.0, 0.0):
        return outline
    dx, dy = velocity[0] * seconds, velocity[1] * seconds

    def moved(ring: Sequence[Point]) -> tuple[Point, ...]:
        return tuple((x + dx, y + dy) for x, y in ring)

    return Outline(moved(outline.ring), tuple(moved(hole) for hole in outline.holes))


def move(one: Sequence[Outline], other: Sequence[Outline]) -> Point | None:
    """The translation that carries the first to the second, or None [m]."""
    if not alike(one, other):
        return None
    a, b = corners_of(one), corners_of(other)
    steps = b - a
    if np.ptp(steps, axis=0).max() > SAME * max(float(np.ptp(a, axis=0).max()), 1.0):
        return None
    mean = steps.mean(axis=0)
    return float(mean[0]), float(mean[1])


def corners_of(outlines: Sequence[Outline]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """All corners, those of holes included (n, 2) [m]."""
    rings = [ring for o in outlines for ring in (o.ring, *o.holes)]
    return np.vstack([np.array(ring, dtype=np.float64) for ring in rings])


def translated(piece: Polytope, by: Point) -> Polytope:
    """The piece moved [m]."""
    step = np.array(by)
    return Polytope(piece.normals, piece.offsets + piece.normals @ step, piece.vertices + step)


def lasting(pieces: Sequence[Polytope], move: Floats) -> list[Polytope]:
    """What the pieces cover all the time while they move by `move` (2,) [m], slivers left out."""
    import shapely

    found = []
    for piece in pieces:
        ends = (shapely.Polygon(piece.vertices + by) for by in (0.0 * move, move))
        core = shapely.intersection(*ends)
        if core.geom_type == "Polygon" and core.area > 0.0:
            ring = simplified([(float(x), float(y)) for x, y in core.exterior.coords[:-1]])
            if len(ring) > 2:
                found.append(polytope(ring))
    return found


def barriers(frames: Sequence[Pieces], space: Polytope | None) -> tuple[Pieces, ...]:
    """The pieces at each step, seams closed. What moved without turning is closed once."""
    found: list[Pieces] = []
    first: Pieces = ()  # the frame that was closed last
    for pieces in frames:
        by = _carried(first, pieces, space)
        if by is None:
            first, made = pieces, closed(pieces, space)
        found.append(made if by is None else tuple(translated(p, by) for p in made))
    return tuple(found)


def _carried(one: Pieces, other: Pieces, space: Polytope | None) -> Point | None:
    """How all pieces moved [m], where that doesn't change what touches the workspace's border."""
    if not one or [len(p.vertices) for p in one] != [len(p.vertices) for p in other]:
        return None
    a, b = (np.vstack([p.vertices for p in pieces]) for pieces in (one, other))
    if np.ptp(b - a, axis=0).max() > SAME:
        return None
    by = float(b[0, 0] - a[0, 0]), float(b[0, 1] - a[0, 1])
    if space is not None and not np.array_equal(_contact(one, space), _contact(other, space)):
        return None
    return by


def _contact(pieces: Pieces, space: Polytope) -> Floats:
    """Which pieces end at which faces of the workspace, or as good as there, and how near.

    A piece that leaves the workspace may touch it later, where its closing would be another.
    """
    reach = np.stack([(p.vertices @ space.normals.T).max(axis=0) for p in pieces]) - space.offsets
    if (reach > 2.0 * PLUG).any():
        return np.array([np.nan])  # equal to nothing
    return np.where(reach >= -2.0 * PLUG, reach.round(9), -np.inf)


def _leaves(pieces: Pieces, space: Polytope, by: Point) -> bool:
    """Whether a piece moves away from a face of the workspace that it touches."""
    near = _contact(pieces, space)
    return bool(np.isnan(near).any() or ((near > -np.inf) & (space.normals @ by < -SAME)).any())


def sweeps(
    outlines: Sequence[tuple[Outline, ...]],
    frames: Sequence[Pieces],
    closings: Sequence[Pieces],
    grow: float,
    space: Polytope | None,
) -> tuple[Sweep, ...]:
    """What to keep out of after each step; at the last the obstacle rests.

    A shape that keeps its form moves with its pieces, exactly. Any other is within the convex
    hulls of each of its polygons at both ends, corners moving straight; where there are not as many
    polygons, within the hull of all. `closings` are the pieces at each step, closed.
    """
    found = []
    for t in range(len(frames) - 1):
        by = move(outlines[t], outlines[t + 1])
        if by is None:
            found.append(Sweep(closed(_hulls(outlines[t], outlines[t + 1], grow), space)))
        elif space is not None and any(by) and _leaves(frames[t], space, by):
            found.append(Sweep(closed(frames[t], space, by), by))
        else:
            found.append(Sweep(closings[t], by))
    return (*found, Sweep(closings[-1]))


def _hulls(one: Sequence[Outline], other: Sequence[Outline], grow: float) -> Pieces:
    """The hull of each polygon at both ends, or of all if there are not as many, grown [m]."""
    import shapely

    pairs = [[a, b] for a, b in zip(one, other, strict=False)]
    found = []
    for group in pairs if len(one) == len(other) else [[*one, *other]]:
        hull = shapely.convex_hull(shapely.MultiPoint([p for o in group for p in o.ring]))
        ring = [(float(x), float(y)) for x, y in hull.exterior.coords[:-1]]
        found.append(inflated(polytope(simplified(ring)), grow))
    return tuple(found)
