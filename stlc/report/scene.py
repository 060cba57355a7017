"""What the map shows: places, moving ones at every step, agents along their true motion, links."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from stlc.arrays import Floats
from stlc.mission import Mission
from stlc.places import Obstacle, Outline, Region, Wall
from stlc.plan import Plan
from stlc.plot.style import looks
from stlc.report.links import links
from stlc.report.numbers import short
from stlc.verify.paths import Path
from stlc.verify.robots import true_paths
from stlc.verify.shapes import obstacle_body, region_body

MOST_POINTS = 2000  # of one path: a trail of more is drawn too slowly to move
CURVED = 8  # points drawn for each step of a motion that isn't straight between its samples


def scene(mission: Mission, plan: Plan) -> dict[str, Any]:
    """Everything that has a place, as plain JSON values; coordinates in metres."""
    motion = true_paths(mission, plan)
    agents = [
        {
            "name": name, "colour": look.colour,
            "flies": mission.agents[name].dynamics.altitude is not None,
            **_track(motion[name], mission.horizon),
        }
        for name, look in looks(mission.agents).items()
        if name in motion
    ]  # fmt: skip
    places = [_region(region, mission) for region in mission.regions.values()]
    places += [_obstacle(obstacle, mission) for obstacle in mission.obstacles.values()]
    stations = [
        {"name": s.name, "at": short(np.asarray(s.place))} for s in mission.stations.values()
    ]
    found: dict[str, Any] = {
        "workspace": None if mission.workspace is None else short(mission.workspace.vertices),
        "walls": [_wall(wall) for wall in mission.walls.values()],
        "places": places, "stations": stations, "agents": agents,
        "links": links(mission, plan),
    }  # fmt: skip
    return {**found, "box": _box(found)}


def _track(path: Path, horizon: int) -> dict[str, Any]:
    """Points of a motion, `per` a step: one where it is straight and even within its steps."""
    straight = path.pieces == 1 and not np.abs(path.c2).max(initial=0.0) > 1e-9
    per = 1 if straight else max(1, min(CURVED, MOST_POINTS // max(horizon, 1)))
    steps = np.linspace(0.0, horizon, horizon * per + 1)
    return {"per": per, "path": short(path.at(steps))}


def _region(region: Region, mission: Mission) -> dict[str, Any]:
    body = region_body(region, mission.step)
    rings = [_rings(body.outlines(0.0))]
    return {"name": region.name, "kind": "region", "inflate": 0.0, "frames": rings,
            "heights": _heights(region.heights)}  # fmt: skip


def _obstacle(obstacle: Obstacle, mission: Mission) -> dict[str, Any]:
    """An obstacle at each step, or at one alone if it rests; corners move straight between steps.

    `inflate` is drawn as a border that wide all around.
    """
    body = obstacle_body(obstacle, mission.step, 0.0)
    frames = [body.outlines(float(t)) for t in range(mission.horizon + 1)]
    if all(one == other for one, other in pairwise(frames)):
        frames = frames[:1]
    return {
        "name": obstacle.name, "kind": "obstacle", "inflate": obstacle.inflate,
        "frames": [_rings(f) for f in frames], "heights": _heights(obstacle.heights),
    }  # fmt: skip


def _wall(wall: Wall) -> dict[str, Any]:
    """A line, or the outlines of convex pieces."""
    lines = [np.array(wall.line)] if wall.line else []
    lines += [np.vstack([p.vertices, p.vertices[:1]]) for p in wall.pieces]
    return {"name": wall.name, "lines": [short(one) for one in lines]}


def _rings(outlines: Sequence[Outline]) -> list[Any]:
    """All rings of a union, holes among them: they are filled by the even-odd rule polygon by
    polygon."""
    return [[short(np.array(ring)) for ring in (o.ring, *o.holes)] for o in outlines]


def _heights(heights: tuple[float, float] | None) -> str:
    if heights is None:
        return ""
    low, high = heights
    return f"{low:g} to {high:g} m" if np.isfinite(high) else f"from {low:g} m"


def _box(found: dict[str, Any]) -> Any:
    """(x0, y0, x1, y1) of the map: the workspace with all motion; else everything."""
    points = [p[:2] for agent in found["agents"] for p in agent["path"]]
    points += [s["at"][:2] for s in found["stations"]]
    if found["workspace"] is not None:
        points += found["workspace"]
    else:
        points += [p for place in found["places"] for f in place["frames"] for polygon in f
                   for ring in polygon for p in ring]  # fmt: skip
    if not found["agents"] or not points:
        return None
    corners: Floats = np.array(points, dtype=np.float64)
    low, high = corners.min(axis=0), corners.max(axis=0)
    pad = 0.04 * max(float((high - low).max()), 1e-6)
    return short(np.concatenate([low - pad, high + pad]))
