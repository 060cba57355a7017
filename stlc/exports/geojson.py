"""GeoJSON (RFC 7946 geometries in metres of the mission's own frame, as `geojson` reads them)."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from typing import Any

from stlc.exports.track import Tracks, tracks
from stlc.files import write_atomic
from stlc.mission import Mission
from stlc.places import Outline
from stlc.plan import Plan
from stlc.verify.shapes import obstacle_body, region_body


def write_geojson(
    mission: Mission, plan: Plan, path: str | os.PathLike[str], every: float | None
) -> None:
    """A feature for each agent (a line, with its times and a robot's headings), station, region,
    obstacle (where it is at the start) and the workspace."""
    found = tracks(mission, plan, every)
    features = [*_agents(found), *_places(mission), *_stations(mission)]
    data = {"type": "FeatureCollection", "units": "m", "features": features}
    write_atomic(path, json.dumps(data, indent=1, allow_nan=False) + "\n")


def _feature(name: str, kind: str, geometry: dict[str, Any], **more: Any) -> dict[str, Any]:
    properties = {"name": name, "kind": kind, **more}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def _agents(found: Tracks) -> Iterator[dict[str, Any]]:
    for name, places in found.places.items():
        line = {"type": "LineString", "coordinates": places.tolist()}
        known = found.own.get(name)
        headings = {} if known is None else {"headings": known.tolist()}
        yield _feature(name, "agent", line, times=found.times.tolist(), **headings)


def _stations(mission: Mission) -> Iterator[dict[str, Any]]:
    for s in mission.stations.values():
        place = [float(v) for v in s.place]
        yield _feature(s.name, "station", {"type": "Point", "coordinates": place})


def _places(mission: Mission) -> Iterator[dict[str, Any]]:
    """The workspace, regions and obstacles."""
    if mission.workspace is not None:
        ring = [(float(x), float(y)) for x, y in mission.workspace.vertices]
        yield _feature("workspace", "workspace", _multi([Outline(tuple(ring))]))
    for region in mission.regions.values():
        shape = _multi(region_body(region, mission.step).outlines(0.0))
        yield _feature(region.name, "region", shape, heights=_ends(region.heights))
    for obstacle in mission.obstacles.values():
        shape = _multi(obstacle_body(obstacle, mission.step, 0.0).outlines(0.0))
        moves = len(obstacle.frames) > 1
        yield _feature(obstacle.name, "obstacle", shape, heights=_ends(obstacle.heights),
                       inflate=obstacle.inflate, moving=moves)  # fmt: skip


def _ends(heights: tuple[float, float] | None) -> list[float] | None:
    return None if heights is None else [float(h) for h in heights]


def _multi(outlines: Sequence[Outline]) -> dict[str, Any]:
    """Closed rings, the outer ones counter-clockwise and holes clockwise."""
    polygons = [
        [_closed(o.ring, True), *(_closed(hole, False) for hole in o.holes)] for o in outlines
    ]
    return {"type": "MultiPolygon", "coordinates": polygons}


def _closed(ring: Sequence[tuple[float, float]], counter: bool) -> list[list[float]]:
    points = [[float(x), float(y)] for x, y in ring]
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, points[1:] + points[:1],
               strict=True))  # fmt: skip
    if (area > 0) is not counter:
        points.reverse()
    return [*points, points[0]]
