"""The map in motion, as a GIF: agents with their trails, moving obstacles, links by quality."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from stlc.arrays import Floats
from stlc.errors import UsageError
from stlc.mission import Mission
from stlc.places import Obstacle
from stlc.plan import Plan
from stlc.plot.clock import clock
from stlc.plot.figure import judged
from stlc.plot.quality import Quality, link_qualities
from stlc.plot.style import BODY, BUFFER, RC, SMALL, Look, looks
from stlc.plot.trajectory import aspect_of, draw_surroundings, limit
from stlc.verify.paths import Path
from stlc.verify.robots import true_paths
from stlc.verify.shapes import Body, obstacle_body

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_FRAMES = 96  # eight seconds at twelve a second: long enough to follow, small enough to send
RATE = 12  # frames a second
HOLD = 1500  # ms that the last frame stays
WIDTH = 6.4  # inches; at 100 dots an inch a page of text has room for it
DPI = 100
COLOURS = 64  # of the palette: lines and areas need few, and edges some shades between

_RAMP = np.array([[200, 80, 0], [225, 190, 40], [0, 114, 178]]) / 255.0  # poor, just so, good


@dataclass(frozen=True, slots=True, eq=False)
class _Scene:
    """What moves: artists, and the motion that they follow."""

    motion: Mapping[str, Path]
    agents: Mapping[str, tuple[Any, Any]]  # trail and marker
    bodies: tuple[tuple[Body, Any, Any], ...]  # with its patches
    links: tuple[tuple[Quality, Any], ...]
    time: Any


def write_animation(mission: Mission, plan: Plan, stream: BinaryIO) -> None:
    """A GIF that plays the plan for ever. Raises UsageError when it doesn't fit the mission, or
    no agent is anywhere."""
    import matplotlib

    if all(agent.dynamics.position is None for agent in mission.agents.values()):
        raise UsageError("there is nothing to move on a map: no agent has a position")
    with matplotlib.rc_context(RC):
        frames = [frame.convert("RGB") for frame in _frames(mission, judged(mission, plan))]
    palette = frames[len(frames) // 2].quantize(COLOURS)
    few = [frame.quantize(palette=palette, dither=0) for frame in frames]
    times = [1000 // RATE] * (len(few) - 1) + [HOLD]
    few[0].save(
        stream, format="GIF", save_all=True, append_images=few[1:], duration=times, loop=0,
        optimize=True,
    )  # fmt: skip


def _frames(mission: Mission, plan: Plan) -> Iterator[Any]:
    """Pictures at even times."""
    from PIL import Image

    figure, scene = _scene(mission, plan)
    now = clock(plan)
    count = MOST_FRAMES if plan.horizon else 1
    for t in np.linspace(0.0, plan.horizon, count):
        _move(scene, float(t))
        scene.time.set_text(f"{t * now.step:.{1 if now.unit != 'ms' else 0}f} {now.unit}")
        figure.canvas.draw()
        pixels: Any = figure.canvas
        yield Image.fromarray(np.asarray(pixels.buffer_rgba()).copy())


def _scene(mission: Mission, plan: Plan) -> tuple[Figure, _Scene]:
    """The figure, all that rests drawn, and what moves."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    look = looks(mission.agents)
    aspect = float(np.clip(aspect_of(mission, plan), 0.4, 5.0))
    figure = Figure(figsize=(WIDTH, WIDTH / aspect + 0.7), layout="constrained", dpi=DPI)
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    motion = {name: path.plane for name, path in true_paths(mission, plan).items()}
    moving = [o for o in mission.obstacles.values() if len(o.frames) > 1]
    labels = draw_surroundings(axes, mission, [o.name for o in moving])
    steps = np.linspace(0.0, mission.horizon, 24 * mission.horizon + 1)
    curves = [motion[name].at(steps) for name in mission.agents if name in motion]
    labels.avoid.extend(curves)
    limit(axes, mission, curves)
    scene = _Scene(
        motion,
        {name: _agent(axes, look[name]) for name in mission.agents if name in motion},
        tuple(_body(axes, o, mission.step) for o in moving),
        tuple((q, axes.plot([], [], linewidth=2.2, zorder=4)[0])
              for q in link_qualities(mission, plan)),
        axes.set_title("", loc="right"),
    )  # fmt: skip
    _names(axes, look, scene)
    figure.draw_without_rendering()
    labels.place()
    return figure, scene


def _agent(axes: Axes, look: Look) -> tuple[Any, Any]:
    (trail,) = axes.plot([], [], color=look.colour, linewidth=1.8, zorder=5)
    (mark,) = axes.plot([], [], color=look.colour, marker=look.marker, markersize=9,
                        markeredgecolor="white", linestyle="", zorder=7)  # fmt: skip
    return trail, mark


def _names(axes: Axes, look: Mapping[str, Look], scene: _Scene) -> None:
    """The agents' names above the map."""
    marks = [scene.agents[name][1] for name in scene.agents]
    axes.legend(marks, list(scene.agents), loc="lower left", bbox_to_anchor=(0.0, 1.0),
                ncols=6, fontsize=SMALL, borderaxespad=0.2, handletextpad=0.2)  # fmt: skip
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_aspect("equal")


def _body(axes: Axes, obstacle: Obstacle, step: float) -> tuple[Body, Any, Any]:
    """A moving obstacle's shape, its patch, and that of its buffer."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    empty = Outline(np.zeros((1, 2)))
    buffer = PathPatch(empty, facecolor="none", edgecolor=BODY, linestyle=(0, (3, 2)), zorder=2)
    solid = PathPatch(empty, facecolor=BUFFER, edgecolor=BODY, zorder=2)
    axes.add_patch(buffer)
    axes.add_patch(solid)
    return obstacle_body(obstacle, step, obstacle.inflate), solid, buffer


def _move(scene: _Scene, t: float) -> None:
    """Everything to a fractional step."""
    for name, (trail, mark) in scene.agents.items():
        behind = scene.motion[name].at(np.linspace(0.0, t, max(2, int(12 * t))))
        trail.set_data(*behind.T)
        mark.set_data(*behind[-1:].T)
    for body, solid, buffer in scene.bodies:
        solid.set_path(_outline(body, t, 0.0))
        buffer.set_path(_outline(body, t, body.grow))
    for quality, line in scene.links:
        ends = [quality.series.sender, quality.series.receiver]
        places = np.vstack([scene.motion[name].at(np.array([t])) for name in ends])
        line.set_data(*places.T)
        line.set_color(_colour(quality.values, t))


def _outline(body: Body, t: float, grow: float) -> Any:
    """The border of an obstacle at a fractional step, grown."""
    import shapely
    from matplotlib.path import Path as Outline

    polygons = [shapely.Polygon(o.ring, o.holes) for o in body.outlines(t)]
    whole = shapely.normalize(shapely.union_all(polygons).buffer(grow))
    rings = [r for part in shapely.get_parts(whole) for r in (part.exterior, *part.interiors)]
    return Outline.make_compound_path(*(Outline(np.array(r.coords), closed=True) for r in rings))


def _colour(values: Floats, t: float) -> tuple[float, ...]:
    """Grey where nothing is known."""
    k = min(int(t), len(values) - 1)
    after = values[min(k + 1, len(values) - 1)]
    quality = values[k] + (t - k) * (after - values[k])
    if not np.isfinite(quality):
        return 0.6, 0.6, 0.6
    return tuple(float(np.interp(2.0 * quality, (0, 1, 2), channel)) for channel in _RAMP.T)
