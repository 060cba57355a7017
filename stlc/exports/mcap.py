"""MCAP recordings that robotics viewers open: poses, the scene, links and inputs as JSON messages.

Message types are those that Foxglove publishes (`foxglove.PoseInFrame`, `foxglove.SceneUpdate`);
links and inputs are plain objects. Times count from the epoch.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from stlc.arrays import Floats
from stlc.errors import UsageError
from stlc.exports.track import FRAME, Tracks, nano, tracks
from stlc.files import atomic_output
from stlc.mission import Mission
from stlc.places import Outline
from stlc.plan import Plan
from stlc.verify.shapes import Body, obstacle_body, region_body

_COLOURS = {"region": (0.0, 0.62, 0.45, 1.0), "obstacle": (0.3, 0.3, 0.3, 1.0),
            "workspace": (0.0, 0.0, 0.0, 1.0)}  # fmt: skip
_LINE_LOOP = 1

Message = tuple[int, str, str, dict[str, Any]]
"""Nanoseconds, topic, name of the schema, content."""


def write_mcap(
    mission: Mission, plan: Plan, path: str | os.PathLike[str], every: float | None
) -> None:
    """`/agents/NAME/pose`, `/agents/NAME/input`, `/links/A/B` and `/scene`."""
    try:
        from mcap.writer import CompressionType, Writer
    except ImportError:
        raise UsageError("MCAP needs a package: pip install 'stlc[mcap]'") from None
    found = tracks(mission, plan, every)
    messages = [*_poses(found, plan.step), *_inputs(plan), *_links(plan), *_scene(mission, plan)]
    with atomic_output(path) as stream:
        writer: Any = Writer(stream, compression=CompressionType.NONE)
        writer.start(library="stlc")
        channels: dict[str, int] = {}
        for time, topic, schema, content in sorted(messages, key=lambda m: m[0]):
            if topic not in channels:
                text = json.dumps({"type": "object", "title": schema}).encode()
                number = writer.register_schema(schema, "jsonschema", text)
                channels[topic] = writer.register_channel(topic, "json", number)
            data = json.dumps(content, allow_nan=False).encode()
            writer.add_message(channels[topic], time, data, time)
        writer.finish()


def _stamp(seconds: float) -> dict[str, int]:
    whole = nano(seconds)
    return {"sec": whole // 10**9, "nsec": whole % 10**9}


def _point(place: Floats) -> dict[str, float]:
    x, y, *z = (float(v) for v in place)
    return {"x": x, "y": y, "z": z[0] if z else 0.0}


def _poses(found: Tracks, step: float) -> Iterator[Message]:
    """Places, heading the way that the agent moves; one at rest keeps its heading, a robot has its
    own."""
    for name, places in found.places.items():
        headings = found.headings(name, step)
        for time, place, heading in zip(found.times, places, headings.tolist(), strict=True):
            turn = {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}
            pose = {"position": _point(place), "orientation": turn}
            content = {"timestamp": _stamp(time), "frame_id": FRAME, "pose": pose}
            yield nano(time), f"/agents/{name}/pose", "foxglove.PoseInFrame", content


def _inputs(plan: Plan) -> Iterator[Message]:
    for name, run in plan.runs.items():
        for time, values in zip(plan.times, run.inputs, strict=False):
            content = dict(zip(run.input_names, map(float, values), strict=True))
            yield nano(time), f"/agents/{name}/input", "stlc.Input", content


def _links(plan: Plan) -> Iterator[Message]:
    """What a plan knows of its links; a quantity that isn't finite is left out."""
    for series in plan.links:
        for t, time in enumerate(plan.times):
            values = {k: float(v[t]) for k, v in series.values.items() if np.isfinite(v[t])}
            topic = f"/links/{series.channel}/{series.sender}/{series.receiver}"
            yield nano(time), topic, "stlc.Link", values


def _scene(mission: Mission, plan: Plan) -> Iterator[Message]:
    """Outlines of places, once; of moving obstacles at every step."""
    still: list[dict[str, Any]] = []
    moving: list[tuple[str, Body]] = []
    if mission.workspace is not None:
        ring = tuple((float(x), float(y)) for x, y in mission.workspace.vertices)
        still.append(_entity("workspace", "workspace", [Outline(ring)], None, 0.0))
    for region in mission.regions.values():
        body = region_body(region, mission.step)
        still.append(_entity(region.name, "region", body.outlines(0.0), region.heights, 0.0))
    for obstacle in mission.obstacles.values():
        body = obstacle_body(obstacle, mission.step, 0.0)
        if len(obstacle.frames) > 1:
            moving.append((obstacle.name, body))
        outlines = body.outlines(0.0)
        still.append(_entity(obstacle.name, "obstacle", outlines, obstacle.heights, 0.0))
    yield _update(0.0, still)
    for t, time in enumerate(plan.times[1:].tolist(), start=1):
        if moving:
            yield _update(time, [
                _entity(name, "obstacle", body.outlines(float(t)), body.levels, time)
                for name, body in moving
            ])  # fmt: skip


def _update(time: float, entities: list[dict[str, Any]]) -> Message:
    return nano(time), "/scene", "foxglove.SceneUpdate", {"deletions": [], "entities": entities}


def _entity(
    name: str,
    kind: str,
    outlines: Sequence[Outline],
    heights: tuple[float, float] | None,
    time: float,
) -> dict[str, Any]:
    """Outlines at the heights that a place lies between, or on the ground."""
    r, g, b, a = _COLOURS[kind]
    levels = [h for h in heights or (0.0,) if math.isfinite(h)]
    rings = [ring for o in outlines for ring in (o.ring, *o.holes)]
    lines = [
        {
            "type": _LINE_LOOP, "thickness": 2.0, "scale_invariant": True,
            "pose": {"position": {"x": 0.0, "y": 0.0, "z": 0.0},
                     "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
            "points": [{"x": float(x), "y": float(y), "z": float(level)} for x, y in ring],
            "color": {"r": r, "g": g, "b": b, "a": a}, "colors": [], "indices": [],
        }
        for level in levels
        for ring in rings
    ]  # fmt: skip
    return {
        "timestamp": _stamp(time), "frame_id": FRAME, "id": name,
        "lifetime": {"sec": 0, "nsec": 0}, "frame_locked": False,
        "metadata": [{"key": "kind", "value": kind}], "lines": lines,
        "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "triangles": [], "texts": [],
        "models": [],
    }  # fmt: skip
