"""Gaps too narrow to be meant: between two obstacles, or an obstacle and the workspace's border."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stlc.diagnostics import Diagnostic
from stlc.mission import Mission
from stlc.places import Obstacle, Polytope
from stlc.sema.contacts import PLUG, TOUCH
from stlc.sema.report import with_note
from stlc.sema.warnings import NarrowGap


def narrow_gaps(mission: Mission) -> Iterator[Diagnostic]:
    """A warning for each gap wider than none and narrower than 1 mm, at step 0."""
    obstacles = list(mission.obstacles.values())
    for k, j in _near([o.frames[0] for o in obstacles]):
        one, other = obstacles[k], obstacles[j]
        gap = _between(one.frames[0], other.frames[0])
        if gap is not None:
            found = NarrowGap(span=one.span, name=one.name, gap=gap, what=f"`{other.name}`")
            yield with_note(found, f"`{other.name}`", other.span)
    if mission.workspace is None:
        return
    for obstacle in obstacles:
        gap = _from_border(obstacle, mission.workspace)
        if gap is not None:
            what = "the workspace's border"
            yield NarrowGap(span=obstacle.span, name=obstacle.name, gap=gap, what=what)


def _near(unions: Sequence[Sequence[Polytope]]) -> list[tuple[int, int]]:
    """Pairs whose boxes are within 1 mm, in order."""
    import shapely

    corners = [np.vstack([p.vertices for p in pieces]) for pieces in unions]
    ends = [(*c.min(axis=0), *c.max(axis=0)) for c in corners]
    boxes = shapely.box(*np.array(ends).reshape(-1, 4).T)
    pairs = shapely.STRtree(boxes).query(boxes, predicate="dwithin", distance=PLUG)
    return sorted((i, j) for i, j in pairs.T.tolist() if i < j)


def _between(one: Sequence[Polytope], other: Sequence[Polytope]) -> float | None:
    """The least distance of two unions [m], if they don't touch and it is below 1 mm."""
    import shapely

    a, b = (
        shapely.union_all([shapely.Polygon(p.vertices) for p in pieces]) for pieces in (one, other)
    )
    gap = float(shapely.distance(a, b))
    return gap if TOUCH < gap < PLUG else None


def _from_border(obstacle: Obstacle, space: Polytope) -> float | None:
    """The least distance from a face of the workspace within it [m], if it is below 1 mm."""
    gaps = space.offsets[:, None] - np.column_stack(
        [(space.normals @ p.vertices.T).max(axis=1) for p in obstacle.frames[0]]
    )
    least = gaps.min(axis=1)
    narrow = least[(least > TOUCH) & (least < PLUG)]
    return float(narrow.min()) if len(narrow) else None
