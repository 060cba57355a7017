"""Curves over time: links, heights, every state and input by its own name and unit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from stlc.mission import Mission
from stlc.plan import LinkSeries, Plan
from stlc.plot.links import LinkPanel, asked_pairs, link_panels, link_title
from stlc.plot.style import COLOURS, looks
from stlc.report.links import UNITS
from stlc.report.numbers import short


def charts(mission: Mission, plan: Plan) -> list[dict[str, Any]]:
    """Charts in the order of the page; `hold` marks values that last until the next step."""
    return [*_links(mission, plan), *_signals(mission, plan, False), *_signals(mission, plan, True)]


def _signals(mission: Mission, plan: Plan, inputs: bool) -> Iterator[dict[str, Any]]:
    """A chart for each name and unit of a signal, with a curve for each agent that has it."""
    colours = {name: look.colour for name, look in looks(mission.agents).items()}
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    heights = _heights(mission)
    for agent, run in plan.runs.items():
        values = run.inputs if inputs else run.states
        names = run.input_names if inputs else run.state_names
        units = run.input_units if inputs else run.state_units
        for column, name, unit in zip(values.T, names, units, strict=True):
            curve = {"name": agent, "colour": colours[agent], "values": short(column)}
            groups.setdefault((name, unit), []).append(curve)
    for (name, unit), curves in groups.items():
        yield {
            "title": name, "what": "input" if inputs else "state", "unit": unit, "hold": inputs,
            "log": False, "curves": curves, "levels": [],
            "bands": heights if not inputs and (name, unit) in _altitudes(mission) else [],
        }  # fmt: skip


def _altitudes(mission: Mission) -> set[tuple[str, str]]:
    """Names of states that are some agent's height."""
    found = set()
    for agent in mission.agents.values():
        model = agent.dynamics
        if model.altitude is not None and np.count_nonzero(model.altitude) == 1:
            k = int(np.flatnonzero(model.altitude)[0])
            found.add((model.states[k], model.state_units[k]))
    return found


def _heights(mission: Mission) -> list[dict[str, Any]]:
    """Ends of the prisms, for charts of heights."""
    return [
        {"name": place.name, "kind": kind, "low": place.heights[0],
         "high": place.heights[1] if np.isfinite(place.heights[1]) else None}
        for kind, places in (("region", mission.regions), ("obstacle", mission.obstacles))
        for place in places.values()
        if place.heights is not None
    ]  # fmt: skip


def _links(mission: Mission, plan: Plan) -> Iterator[dict[str, Any]]:
    """A chart for each quantity of a channel that the mission asks about."""
    for panel in link_panels(mission, plan.links):
        levels = sorted({p.threshold for p in panel.predicates})
        yield {
            "title": link_title(panel, mission), "what": "link", "hold": False,
            "unit": UNITS.get(panel.key, ""), "log": panel.key == "ber",
            "curves": [_link(s, panel, k) for k, s in enumerate(asked_pairs(panel))],
            "levels": [level for level in levels if np.isfinite(level)], "bands": [],
        }  # fmt: skip


def _link(series: LinkSeries, panel: LinkPanel, k: int) -> dict[str, Any]:
    values = np.asarray(series.values[panel.key], dtype=np.float64)
    name = f"{series.sender}\N{EN DASH}{series.receiver}"
    return {"name": name, "colour": COLOURS[k % len(COLOURS)], "values": short(values)}
