"""Gaps too narrow to be meant: between two obstacles, or an obstacle and the workspace's border."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

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
    for one, other in combinations(obstacles, 2):
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


def _between(one: Sequence[Polytope], other: Sequence[Polytope]) -> float | None:
    """The least distance of two unions [m], if they don't touch and it is below 1 mm."""
    import shapely

    boxes = [np.vstack([p.vertices for p in pieces]) for pieces in (one, other)]
    low = np.maximum(*(box.min(axis=0) for box in boxes))
    if (low > np.minimum(*(box.max(axis=0) for box in boxes)) + PLUG).any():
        return None
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
