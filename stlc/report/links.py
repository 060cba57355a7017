"""Links between agents and stations as the map shows them."""

from __future__ import annotations

from typing import Any

from stlc.mission import Mission
from stlc.plan import Plan
from stlc.plot.quality import link_qualities
from stlc.report.numbers import short

UNITS = {"rssi": "dBm", "snr": "dB", "distance": "m"}


def links(mission: Mission, plan: Plan) -> list[dict[str, Any]]:
    """Each pair that the map joins, with `value` and `quality` at every step."""
    return [
        {
            "ends": [q.series.sender, q.series.receiver], "channel": q.series.channel,
            "of": q.key, "unit": UNITS.get(q.key, ""), "asked": q.asked,
            "value": short(q.series.values[q.key]), "quality": short(q.values),
        }
        for q in link_qualities(mission, plan)
    ]  # fmt: skip
