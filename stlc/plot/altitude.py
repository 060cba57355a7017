"""Heights over time of agents that fly, above those that regions and obstacles lie between."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stlc.mission import Agent, Mission
from stlc.plan import Plan
from stlc.plot.clock import Clock
from stlc.plot.style import BODY, REGION, SMALL, Look
from stlc.verify.robots import true_paths

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINE = 24  # points drawn for each step


def flying(mission: Mission) -> list[Agent]:
    """Agents whose height is a signal."""
    return [a for a in mission.agents.values() if a.dynamics.altitude is not None]


def draw_altitudes(
    axes: Axes, mission: Mission, plan: Plan, clock: Clock, look: Mapping[str, Look]
) -> None:
    """The true height of each agent that flies over time, above bands of the places."""
    motion = true_paths(mission, plan)
    _bands(axes, mission)
    steps = np.linspace(0.0, mission.horizon, mission.horizon * FINE + 1)
    for agent in flying(mission):
        path = motion[agent.name]
        colour = look[agent.name].colour
        axes.plot(clock.at(steps), path.at(steps)[:, 2], color=colour, linewidth=1.5)
        samples = path.c0[:: path.pieces, 2]
        axes.plot(clock.times[: len(samples)], samples, ".", color=colour, markersize=5)
    axes.set_ylabel("height [m]")
    axes.set_title("Height")


def _bands(axes: Axes, mission: Mission) -> None:
    """Heights of each prism, named at the right."""
    for places, colour in ((mission.regions, REGION), (mission.obstacles, BODY)):
        for place in places.values():
            if place.heights is not None:
                low, high = place.heights
                axes.axhspan(low, high, color=colour, alpha=0.12, linewidth=0.0)
                axes.text(
                    1.0, (low + high) / 2.0, place.name, transform=axes.get_yaxis_transform(),
                    ha="right", va="center", color=colour, fontsize=SMALL,
                )  # fmt: skip
