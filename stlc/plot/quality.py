"""How good each link is at every step, on a scale that a colour can show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats
from stlc.ir.nodes import Link, Relation
from stlc.mission import Mission
from stlc.plan import LinkSeries, Plan
from stlc.plot.links import LinkPanel, asked_pairs, link_panels

_LESS_IS_BETTER = ("ber", "cost", "distance")


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """A pair's `values` (T+1,) between 0 and 1, by the quantity `key` of its series.

    1/2 is where a link just has what the mission asks of it (`asked`); where nothing is asked, 0
    and 1 are the worst and the best of all links of the channel.
    """

    series: LinkSeries
    key: str
    asked: bool
    values: Floats


def link_qualities(mission: Mission, plan: Plan) -> list[Quality]:
    """The pairs that a mission asks about, else all of a channel; one quantity for each channel."""
    first: dict[str, LinkPanel] = {}
    for panel in link_panels(mission, plan.links):
        first.setdefault(panel.channel, panel)
    return [one for panel in first.values() for one in _of_panel(panel)]


def _of_panel(panel: LinkPanel) -> Iterator[Quality]:
    shown = asked_pairs(panel)
    ends = _ends(shown, panel.key)
    for s in shown:
        yield Quality(s, panel.key, bool(_asked(s, panel)), _quality(s, panel, ends))


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
