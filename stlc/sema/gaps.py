"""Gaps too narrow to be meant: between two obstacles, or an obstacle and the workspace's border."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stlc.diagnostics import Diagnostic
from stlc.mission import Mission
from stlc.places import Obstacle, Polytope
from stlc.sema.contacts import PLUG, TOUCH
from stlc.sema.geometry import polygons
from stlc.sema.report import with_note
from stlc.sema.warnings import NarrowGap


def narrow_gaps(mission: Mission) -> Iterator[Diagnostic]:
    """A warning for each gap wider than none and narrower than 1 mm, at step 0."""
    obstacles = list(mission.obstacles.values())
    for k, j, gap in _between([o.frames[0] for o in obstacles]):
        one, other = obstacles[k], obstacles[j]
        found = NarrowGap(span=one.span, name=one.name, gap=gap, what=f"`{other.name}`")
        yield with_note(found, f"`{other.name}`", other.span)
    if mission.workspace is None:
        return
    for obstacle in obstacles:
        to_border = _from_border(obstacle, mission.workspace)
        if to_border is not None:
            what = "the workspace's border"
            yield NarrowGap(span=obstacle.span, name=obstacle.name, gap=to_border, what=what)


def _between(unions: Sequence[Sequence[Polytope]]) -> Iterator[tuple[int, int, float]]:
    """Pairs of unions that don't touch, but nearly, in order, and their distance [m]."""
    import shapely

    pairs = _near(unions)
    shapes = {
        k: shapely.union_all(polygons(unions[k])) for k in {k for pair in pairs for k in pair}
    }
    gaps = shapely.distance([shapes[i] for i, _ in pairs], [shapes[j] for _, j in pairs])
    for (i, j), gap in zip(pairs, gaps.tolist(), strict=True):
        if TOUCH < gap < PLUG:
            yield i, j, gap


def _near(unions: Sequence[Sequence[Polytope]]) -> list[tuple[int, int]]:
    """Pairs whose boxes are within 1 mm, in order."""
    import shapely

    corners = [np.vstack([p.vertices for p in pieces]) for pieces in unions]
    ends = [(*c.min(axis=0), *c.max(axis=0)) for c in corners]
    boxes = shapely.box(*np.array(ends).reshape(-1, 4).T)
    pairs = shapely.STRtree(boxes).query(boxes, predicate="dwithin", distance=PLUG)
    return sorted((i, j) for i, j in pairs.T.tolist() if i < j)


def _from_border(obstacle: Obstacle, space: Polytope) -> float | None:
    """The least distance from a face of the workspace within it [m], if it is below 1 mm."""
    gaps = space.offsets[:, None] - np.column_stack(
        [(space.normals @ p.vertices.T).max(axis=1) for p in obstacle.frames[0]]
    )
    least = gaps.min(axis=1)
    narrow = least[(least > TOUCH) & (least < PLUG)]
    return float(narrow.min()) if len(narrow) else None
