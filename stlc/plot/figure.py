"""The one figure of a plan: which panels there are and where they go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stlc.mission import Mission
from stlc.plan import Plan
from stlc.plot.altitude import draw_altitudes, flying
from stlc.plot.channel_map import draw_channel, mapped_channel
from stlc.plot.labels import Labels
from stlc.plot.robustness import draw_robustness
from stlc.plot.series import (
    draw_inputs,
    draw_links,
    draw_velocities,
    link_panels,
    velocity_agents,
)
from stlc.plot.style import RC, Look, looks
from stlc.plot.trajectory import draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Draw = Callable[["Axes"], Labels | None]

WIDTH = 15.0
PANEL = 2.5  # inches, the least height of one panel over time


@dataclass(frozen=True, slots=True)
class _Panels:
    """What is drawn: the map, panels below it, panels over time at the right."""

    map: Draw | None
    below: tuple[Draw, ...]
    right: tuple[Draw, ...]


def build(mission: Mission, plan: Plan) -> Figure:
    """The figure. Raises UsageError when the plan doesn't fit the mission."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from stlc.verify.subject import check_shape

    check_shape(mission, plan)
    if not plan.requirements and not plan.links:
        from stlc.verify import verify

        plan = verify(mission, plan).annotate(plan)
    look = looks(mission.agents)
    panels = _panels(mission, plan, look)
    with matplotlib.rc_context(RC):
        height = max(9.0, PANEL * len(panels.right) + 1.0)
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        FigureCanvasAgg(figure)
        _head(figure, plan, look)
        draws = _lay_out(figure, panels)
        labels = [draw(axes) for axes, draw in draws]
        figure.draw_without_rendering()
        for some in filter(None, labels):
            some.place()
    return figure


def _panels(mission: Mission, plan: Plan, look: dict[str, Look]) -> _Panels:
    """What there is to show: map only for placed agents, links and inputs in the right column."""
    placed = any(a.dynamics.position is not None for a in mission.agents.values())
    channel = mapped_channel(mission, plan.links)
    below: list[Draw] = []
    if channel is not None:
        below.append(lambda axes: draw_channel(axes, mission, plan, channel, plan.links))
    if plan.requirements:
        below.append(lambda axes: draw_robustness(axes, mission, plan.requirements))
    right: list[Draw] = []
    if flying(mission):
        right.append(lambda axes: draw_altitudes(axes, mission, plan, look))
    if velocity_agents(mission):
        right.append(lambda axes: draw_velocities(axes, mission, plan, look))
    right.append(lambda axes: draw_inputs(axes, mission, plan, look))
    for panel in link_panels(mission, plan.links):
        right.append(lambda axes, panel=panel: draw_links(axes, mission, plan, panel))  # type: ignore[misc]
    return _Panels(
        (lambda axes: draw_map(axes, mission, plan, look)) if placed else None,
        tuple(below),
        tuple(right),
    )


def _lay_out(figure: Figure, panels: _Panels) -> list[tuple[Axes, Draw]]:
    """Axes for each panel: map above channel and robustness on the left, time series on the right.

    Subfigures rather than a grid: each side is then spaced by its own labels.
    """
    halves: Any = figure.subfigures(1, 2, squeeze=False, width_ratios=[1.25, 1.0], wspace=0.02)
    left, right = halves[0]
    column = right.subplots(len(panels.right), 1, squeeze=False)[:, 0]
    column[-1].set_xlabel("time [s]")
    draws = list(zip(column, panels.right, strict=True))
    rows = [part for part in ((panels.map,) if panels.map else (), panels.below) if part]
    if not rows:
        return draws
    heights = [2.1 if part == (panels.map,) else 1.0 for part in rows]
    areas = left.subfigures(len(rows), 1, squeeze=False, height_ratios=heights)[:, 0]
    for area, part in zip(areas, rows, strict=True):
        draws += list(zip(area.subplots(1, len(part), squeeze=False)[0], part, strict=True))
    return draws


def _head(figure: Figure, plan: Plan, look: dict[str, Look]) -> None:
    """Title, and one legend of the agents for all panels."""
    from matplotlib.lines import Line2D

    facts = [Path(plan.mission).name]
    if plan.solve.status != "unknown":
        facts.append(plan.solve.status)
    if plan.solve.objective is not None:
        facts.append(f"objective {plan.solve.objective:.6g}")
    if plan.solve.gap:
        facts.append(f"gap {100 * plan.solve.gap:.2g} %")
    figure.suptitle("   ".join(facts), x=0.01, ha="left", fontsize=12, fontweight="bold")
    items = [
        Line2D([], [], color=v.colour, marker=v.marker, markersize=6, linewidth=1.8, label=name)
        for name, v in look.items()
    ]
    figure.legend(handles=items, loc="outside lower center", ncols=min(len(items), 10))
