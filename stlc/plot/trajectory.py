"""The map: workspace, regions, obstacles, stations and the continuous motion of all agents."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stlc.mission import Mission
from stlc.places import Obstacle, Polytope, Wall
from stlc.plan import Plan
from stlc.plot.labels import Labels
from stlc.plot.style import BODY, BUFFER, QUIET, REGION, SMALL, Look
from stlc.verify.paths import Path
from stlc.verify.robots import true_paths

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path as Outline

Array = NDArray[np.float64]

FINE = 24  # points drawn for each step
MOST_FRAMES = 6


def draw_map(axes: Axes, mission: Mission, plan: Plan, look: Mapping[str, Look]) -> Labels:
    """Everything that has a place; returns the labels, to be placed when the layout is final."""
    motion = true_paths(mission, plan)
    labels = draw_surroundings(axes, mission)
    for name in mission.agents:
        if name in motion:
            _tube(axes, mission, plan, name, look[name])
            curve = _agent(axes, motion[name].plane, mission.horizon, look[name])
            labels.avoid.append(curve)
            labels.marks += [curve[0], curve[-1]]
            labels.add(
                name, curve[0], curve[0], 7.0,
                color=look[name].colour, fontsize=SMALL, fontweight="bold",
            )  # fmt: skip
    axes.set(xlabel="x [m]", ylabel="y [m]", title="Trajectories")
    axes.set_aspect("equal", adjustable="datalim" if mission.workspace is None else "box")
    limit(axes, mission, labels.avoid)
    _key(axes)
    return labels


def draw_surroundings(axes: Axes, mission: Mission, without: Collection[str] = ()) -> Labels:
    """Workspace, regions, obstacles and stations below the trajectories; returns their labels."""
    labels = Labels(axes)
    if mission.workspace is not None:
        _fill(axes, [mission.workspace], facecolor="none", edgecolor="black", linewidth=1.2)
    for region in mission.regions.values():
        style = {"facecolor": REGION + "2E", "edgecolor": REGION, "linewidth": 1.0}
        _fill(axes, region.pieces, **style, zorder=1)
        _label(labels, region.name, region.pieces, color="#00664A", fontsize=SMALL)
    for obstacle in (o for o in mission.obstacles.values() if o.name not in without):
        _obstacle(axes, obstacle, mission.horizon)
        _label(labels, obstacle.name, obstacle.frames[0], color=BODY, fontsize=SMALL)
    for wall in mission.walls.values():
        _wall(axes, wall)
    for station in mission.stations.values():
        x, y = station.position
        axes.plot(x, y, marker="^", markersize=10, color="white", markeredgecolor="black",
                  markeredgewidth=1.6, linestyle="", zorder=8)  # fmt: skip
        labels.marks.append(station.position)
        labels.add(station.name, station.position, station.position, 8.0, fontsize=SMALL)
    return labels


def _obstacle(axes: Axes, obstacle: Obstacle, horizon: int) -> None:
    """Body and buffer; a moving one at a few times, the later the fainter."""
    count = min(len(obstacle.frames), horizon + 1)
    shown = np.unique(np.linspace(0, count - 1, min(count, MOST_FRAMES)).round().astype(int))
    for order, frame in enumerate(shown):
        fade = 1.0 - 0.75 * order / max(len(shown) - 1, 1)
        buffer = {"facecolor": "none", "edgecolor": BODY, "linestyle": (0, (3, 2))}
        if obstacle.inflate or obstacle.frames is not obstacle.bodies:
            _fill(axes, obstacle.frames[frame], **buffer, linewidth=0.9, alpha=fade, zorder=2)
        _fill(axes, obstacle.bodies[frame], facecolor=BUFFER, edgecolor=BODY, linewidth=1.0,
              alpha=fade, zorder=2, hatch="////" if len(shown) == 1 else None)  # fmt: skip


def _wall(axes: Axes, wall: Wall) -> None:
    """What links cross: it hinders nobody on the way."""
    if wall.line:
        axes.plot(*np.array(wall.line).T, color=QUIET, linewidth=2.4, zorder=2)
    if wall.pieces:
        _fill(axes, wall.pieces, facecolor="none", edgecolor=QUIET, linewidth=1.6, zorder=2)


def _tube(axes: Axes, mission: Mission, plan: Plan, name: str, look: Look) -> None:
    """The tube of a robot around the plan of its look-ahead point, lightly; nothing of others."""
    import shapely

    robot, places = mission.agents[name].robot, run_path(mission, plan, name)
    if robot is None or places is None:
        return
    tube = shapely.LineString(places if len(places) > 1 else np.tile(places, (2, 1)))
    style: dict[str, Any] = {"facecolor": look.colour, "alpha": 0.12, "linewidth": 0.0}
    area = shapely.get_coordinates(tube.buffer(robot.radius).exterior)
    axes.fill(*area.T, **style, zorder=1)


def _agent(axes: Axes, path: Path, horizon: int, look: Look) -> Array:
    """The true arc, a dot at each sample, markers at start and end; returns the arc (K, 2)."""
    arc = path.at(np.linspace(0.0, horizon, horizon * FINE + 1))
    axes.plot(*arc.T, color=look.colour, linewidth=1.6, zorder=5)
    dots: dict[str, Any] = {"color": look.colour, "linestyle": "", "zorder": 6}
    axes.plot(
        *path.c0[:: path.pieces].T, marker=".", markersize=5 if horizon <= 60 else 2.5, **dots
    )
    start: dict[str, Any] = {"markerfacecolor": "white", "markeredgewidth": 1.6, "markersize": 8}
    axes.plot(*path.c0[0], marker=look.marker, **dots, **start)
    axes.plot(*path.c0[-1], marker=look.marker, markersize=8, markeredgecolor="white",
              markeredgewidth=0.8, **dots)  # fmt: skip
    return arc


def _fill(axes: Axes, pieces: Iterable[Polytope], **style: Any) -> None:
    from matplotlib.patches import PathPatch

    axes.add_patch(PathPatch(_outline(pieces), **style))


def _outline(pieces: Iterable[Polytope]) -> Outline:
    """The border of a union of convex pieces, holes included, without the seams between them."""
    import shapely
    from matplotlib.path import Path as Outline

    whole = shapely.union_all([shapely.Polygon(piece.vertices) for piece in pieces])
    parts = shapely.get_parts(shapely.normalize(whole))  # holes run against their outer ring
    rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
    return Outline.make_compound_path(
        *(Outline(np.asarray(ring.coords), closed=True) for ring in rings)
    )


def _label(labels: Labels, name: str, pieces: Sequence[Polytope], **style: Any) -> None:
    corners = np.vstack([piece.vertices for piece in pieces])
    labels.add(name, corners.min(axis=0), corners.max(axis=0), **style)


def aspect_of(mission: Mission, plan: Plan) -> float:
    """Width by height of what the map shows."""
    places = [run_path(mission, plan, name) for name in mission.agents]
    points = [p for p in places if p is not None]
    if mission.workspace is not None:
        points.append(mission.workspace.vertices)
    span = np.ptp(np.vstack(points), axis=0)
    return float(span[0] / max(span[1], 1e-9 * span[0], 1e-300))


def run_path(mission: Mission, plan: Plan, name: str) -> Array | None:
    """Places (T+1, 2) of an agent at the steps; None for one that is nowhere."""
    rows = mission.agents[name].dynamics.position
    return None if rows is None else np.asarray(plan.runs[name].states @ rows.T)


def limit(axes: Axes, mission: Mission, curves: Sequence[Array]) -> None:
    """Axes that hold the workspace and all motion (K, 2) [m]."""
    if mission.workspace is None:
        axes.margins(0.08)
        return
    points = np.vstack([mission.workspace.vertices, *curves])
    low, high = points.min(axis=0), points.max(axis=0)
    pad = 0.05 * (high - low)
    axes.set_xlim(low[0] - pad[0], high[0] + pad[0])
    axes.set_ylim(low[1] - pad[1], high[1] + pad[1])


def _key(axes: Axes) -> None:
    """What hollow, filled and small markers mean."""
    from matplotlib.lines import Line2D

    base: dict[str, Any] = {"color": "#404040", "linestyle": "", "marker": "o"}
    items = [
        Line2D([], [], **base, markersize=7, markerfacecolor="white", label="start"),
        Line2D([], [], **base, markersize=7, label="end"),
        Line2D([], [], **base, markersize=2.5, label="sample"),
    ]
    axes.legend(handles=items, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3,
                borderaxespad=0.2, handletextpad=0.2, columnspacing=1.0)  # fmt: skip
