"""The one figure of a plan: which panels there are and where they go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stlc.measurements import with_learned
from stlc.mission import Mission
from stlc.plan import Plan
from stlc.plot.altitude import draw_altitudes, flying
from stlc.plot.channel_map import draw_channel, mapped_channel
from stlc.plot.clock import Clock, clock
from stlc.plot.labels import Labels
from stlc.plot.links import draw_links, link_panels
from stlc.plot.robustness import draw_robustness
from stlc.plot.signals import draw_signals, signal_panels
from stlc.plot.style import RC, Look, looks
from stlc.plot.trajectory import aspect_of, draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Draw = Callable[["Axes"], Labels | None]

WIDTH = 15.0
PANEL = 2.5  # inches, the least height of one panel over time
WIDE = 2.0  # a world so many times as wide as high has the map above everything else


@dataclass(frozen=True, slots=True)
class _Panels:
    """What is drawn: the map, panels that go with it, panels over time."""

    map: Draw | None
    below: tuple[Draw, ...]
    times: tuple[Draw, ...]


def build(mission: Mission, plan: Plan) -> Figure:
    """The figure. Raises UsageError when the plan doesn't fit the mission."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    plan = judged(mission, plan)
    mission = with_learned(mission, plan.learned)
    look = looks(mission.agents)
    now = clock(plan)
    panels = _panels(mission, plan, look, now)
    aspect = aspect_of(mission, plan) if panels.map else 0.0
    lay_out = _wide if aspect > WIDE else _beside
    with matplotlib.rc_context(RC):
        figure = Figure(figsize=(WIDTH, 9.0), layout="constrained")
        FigureCanvasAgg(figure)
        _head(figure, plan, look)
        labels = [draw(axes) for axes, draw in lay_out(figure, panels, aspect, now)]
        figure.draw_without_rendering()
        for some in filter(None, labels):
            some.place()
    return figure


def judged(mission: Mission, plan: Plan) -> Plan:
    """The plan with robustness and links. Raises UsageError when it doesn't fit the mission."""
    from stlc.verify.subject import check_shape

    check_shape(mission, plan)
    if plan.requirements or plan.links:
        return plan
    from stlc.verify import verify

    return verify(mission, plan).annotate(plan)


def _panels(mission: Mission, plan: Plan, look: dict[str, Look], now: Clock) -> _Panels:
    """What there is to show: the map only for placed agents, nothing without a curve."""
    placed = any(a.dynamics.position is not None for a in mission.agents.values())
    channel = mapped_channel(mission, plan.links)
    below: list[Draw] = []
    if channel is not None:
        below.append(lambda axes: draw_channel(axes, mission, plan, channel, plan.links))
    if plan.requirements:
        below.append(lambda axes: draw_robustness(axes, mission, plan.requirements))
    times: list[Draw] = []
    if flying(mission):
        times.append(lambda axes: draw_altitudes(axes, mission, plan, now, look))
    times += [partial(draw_signals, panel=p, clock=now, look=look)
              for p in signal_panels(mission, plan)]  # fmt: skip
    times += [partial(draw_links, mission=mission, clock=now, panel=p)
              for p in link_panels(mission, plan.links)]  # fmt: skip
    return _Panels(
        (lambda axes: draw_map(axes, mission, plan, look)) if placed else None,
        tuple(below),
        tuple(times),
    )


def _beside(figure: Figure, panels: _Panels, aspect: float, now: Clock) -> list[tuple[Axes, Draw]]:
    """Map above channel and robustness on the left, panels over time on the right.

    Subfigures rather than a grid: each side is then spaced by its own labels.
    """
    figure.set_figheight(max(9.0, PANEL * len(panels.times) + 1.0))
    rows = [part for part in ((panels.map,) if panels.map else (), panels.below) if part]
    if not rows:
        return _column(figure, panels.times, now)
    if not panels.times:
        return _rows(figure, rows)
    halves: Any = figure.subfigures(1, 2, squeeze=False, width_ratios=[1.25, 1.0], wspace=0.02)
    left, right = halves[0]
    return [*_column(right, panels.times, now), *_rows(left, rows)]


def _rows(area: Any, rows: Sequence[tuple[Draw, ...]]) -> list[tuple[Axes, Draw]]:
    """The map, and below it what goes with it."""
    heights = [2.1 if len(rows) > 1 and k == 0 else 1.0 for k in range(len(rows))]
    areas = area.subfigures(len(rows), 1, squeeze=False, height_ratios=heights)[:, 0]
    found = []
    for one, part in zip(areas, rows, strict=True):
        found += list(zip(one.subplots(1, len(part), squeeze=False)[0], part, strict=True))
    return found


def _wide(figure: Figure, panels: _Panels, aspect: float, now: Clock) -> list[tuple[Axes, Draw]]:
    """The map over the whole width, below it panels over time in two columns, then the rest."""
    assert panels.map is not None
    columns = [c for c in (panels.times[::2], panels.times[1::2]) if c]
    tall = WIDTH / aspect + 1.0
    lower = PANEL * len(panels.times[::2]) + 0.4
    last = 3.2 if panels.below else 0.0
    figure.set_figheight(tall + lower + last + 0.8)
    parts = [(h, p) for h, p in ((tall, "map"), (lower, "times"), (last, "below")) if h > 0.4]
    areas: Any = figure.subfigures(
        len(parts), 1, squeeze=False, height_ratios=[h for h, _ in parts]
    )[:, 0]
    found = [(areas[0].subplots(), panels.map)]
    if columns:
        halves = areas[1].subfigures(1, len(columns), squeeze=False, wspace=0.02)[0]
        for half, part in zip(halves, columns, strict=True):
            found += _column(half, part, now)
    if panels.below:
        axes = areas[-1].subplots(1, len(panels.below), squeeze=False)[0]
        found += list(zip(axes, panels.below, strict=True))
    return found


def _column(area: Any, draws: Sequence[Draw], now: Clock) -> list[tuple[Axes, Draw]]:
    """Panels over time, one below the other, that share their clock."""
    if not draws:
        return []
    axes = area.subplots(len(draws), 1, squeeze=False)[:, 0]
    axes[-1].set_xlabel(now.label)
    return list(zip(axes, draws, strict=True))


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
