"""Links between agents and stations: how good each one is at every step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from stlc.arrays import Floats
from stlc.ir.nodes import Link, Relation
from stlc.mission import Mission
from stlc.plan import LinkSeries, Plan
from stlc.plot.series import LinkPanel, asked_pairs, link_panels
from stlc.report.numbers import short

UNITS = {"rssi": "dBm", "snr": "dB", "distance": "m"}
_LESS_IS_BETTER = ("ber", "cost", "distance")


def links(mission: Mission, plan: Plan) -> list[dict[str, Any]]:
    """Each pair that the map joins, with `value` and `quality` at every step.

    A quality is 1/2 where a link just has what the mission asks of it; where nothing is asked, 0
    and 1 are the worst and the best of all links of the channel.
    """
    first: dict[str, LinkPanel] = {}
    for panel in link_panels(mission, plan.links):
        first.setdefault(panel.channel, panel)
    return [one for panel in first.values() for one in _panel(panel)]


def _panel(panel: LinkPanel) -> list[dict[str, Any]]:
    """The links of a channel by one quantity."""
    shown = asked_pairs(panel)
    ends = _ends(shown, panel.key)
    return [
        {
            "ends": [s.sender, s.receiver], "channel": panel.channel, "of": panel.key,
            "unit": UNITS.get(panel.key, ""), "asked": bool(_asked(s, panel)),
            "value": short(s.values[panel.key]), "quality": short(_quality(s, panel, ends)),
        }
        for s in shown
    ]  # fmt: skip


def _asked(series: LinkSeries, panel: LinkPanel) -> list[Link]:
    """Plain predicates on a pair; one of probability is about more than the mean."""
    pair = {series.sender, series.receiver}
    return [p for p in panel.predicates if {p.sender, p.receiver} == pair and not p.probability]


def _scaled(values: Floats, key: str) -> Floats:
    """Larger is better, and steps of one size are felt alike."""
    if key == "ber":
        return np.asarray(-np.log10(np.maximum(values, 1e-12)))
    return np.asarray(-values if key in _LESS_IS_BETTER else values)


def _ends(shown: Sequence[LinkSeries], key: str) -> tuple[float, float]:
    if key == "prr":
        return 0.0, 1.0
    every = np.concatenate([_scaled(s.values[key], key) for s in shown])
    every = every[np.isfinite(every)]
    return (float(every.min()), float(every.max())) if len(every) else (0.0, 0.0)


def _quality(series: LinkSeries, panel: LinkPanel, ends: tuple[float, float]) -> Floats:
    """Between 0 and 1."""
    low, high = ends
    value = _scaled(series.values[panel.key], panel.key)
    levels = [
        float(_scaled(np.array([p.threshold]), panel.key)[0])
        for p in _asked(series, panel)
        if (p.relation is Relation.AT_LEAST) is (panel.key not in _LESS_IS_BETTER)
    ]
    if levels:
        level = max(levels)
        room = max(high - level, level - low, 1e-9)
        return np.asarray(np.clip(0.5 + 0.5 * (value - level) / room, 0.0, 1.0))
    return np.asarray(np.clip((value - low) / max(high - low, 1e-9), 0.0, 1.0))
