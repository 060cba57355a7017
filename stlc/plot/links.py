"""Link quality over time, with the thresholds asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stlc.ir.nodes import Link, Quantity, Relation, walk
from stlc.mission import Mission
from stlc.plan import LinkSeries
from stlc.plot.clock import Clock
from stlc.plot.style import COLOURS, QUIET, SMALL

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

MOST_PAIRS = 8  # entries that a legend of pairs has room for

_KEYS = {
    Quantity.RSSI: "rssi", Quantity.SNR: "snr", Quantity.BER: "ber",
    Quantity.BER_AT_MEAN: "ber", Quantity.PRR: "prr", Quantity.COST: "cost",
}  # fmt: skip
_TITLES = {
    "rssi": ("Received strength", "RSSI [dBm]"),
    "snr": ("Signal to noise", "SNR [dB]"),
    "ber": ("Bit error rate", "BER"),
    "prr": ("Packet reception", "PRR"),
    "cost": ("Link cost", "cost"),
    "distance": ("Distance", "distance [m]"),
}


@dataclass(frozen=True, slots=True)
class LinkPanel:
    """One quantity of one channel over time."""

    channel: str
    key: str
    series: tuple[LinkSeries, ...]
    predicates: tuple[Link, ...]


def link_panels(mission: Mission, links: Sequence[LinkSeries]) -> list[LinkPanel]:
    """A panel for each channel and each quantity that the mission asks about.

    A channel that is asked nothing shows its RSSI, or its cost.
    """
    found: list[LinkPanel] = []
    predicates = _predicates(mission)
    for channel in dict.fromkeys(series.channel for series in links):
        mine = tuple(s for s in links if s.channel == channel)
        asked = [p for p in predicates if p.channel == channel]
        known = {k for s in mine for k, values in s.values.items() if np.isfinite(values).any()}
        keys = dict.fromkeys(k for k in map(_key_of, asked) if k in known)
        for fallback in () if keys else ("rssi", "cost", "distance"):
            if fallback in known:
                keys = dict.fromkeys([fallback])
                break
        found += [
            LinkPanel(channel, key, mine, tuple(p for p in asked if _key_of(p) == key))
            for key in keys
        ]
    return found


def _predicates(mission: Mission) -> list[Link]:
    nodes = (node for r in mission.requirements for node in walk(r.formula))
    return list(dict.fromkeys(node for node in nodes if isinstance(node, Link)))


def _key_of(link: Link) -> str:
    return _KEYS[link.quantity]


def draw_links(axes: Axes, mission: Mission, clock: Clock, panel: LinkPanel) -> None:
    """One curve for each pair, one dashed line for each threshold."""
    series = asked_pairs(panel)
    named = _most_telling(series, panel)
    for s in series:
        values = s.values[panel.key]
        colour = COLOURS[named.index(s) % len(COLOURS)] if s in named else QUIET
        strong = s in named
        axes.plot(
            clock.times, values, color=colour, linewidth=1.6 if strong else 0.7,
            marker="." if strong else "", markersize=4, zorder=4 if strong else 3,
            label=f"{s.sender} \N{EN DASH} {s.receiver}" if strong else None,
        )  # fmt: skip
        if strong:
            _chance_level(axes, clock, panel, s, colour)
    axes.set_title(link_title(panel, mission), pad=18)
    axes.set_ylabel(_TITLES[panel.key][1])
    for level in {p.threshold for p in panel.predicates}:
        axes.axhline(level, color="black", linewidth=1.0, linestyle=(0, (5, 2)), zorder=5)
    if panel.key == "ber":
        axes.set_yscale("log")
        axes.set_ylim(bottom=max(axes.get_ylim()[0], 1e-12))
    axes.set_ylim(axes.get_ylim())  # final from here on
    _threshold_labels(axes, panel)
    rest = len(series) - len(named)
    if rest:
        axes.plot([], [], color=QUIET, linewidth=0.7, label=f"{rest} more pairs")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.1, borderpad=0.1,
                ncols=MOST_PAIRS, handlelength=1.4, columnspacing=1.0,
                handletextpad=0.4)  # fmt: skip


def link_title(panel: LinkPanel, mission: Mission) -> str:
    """What a panel shows, and of which channel where there are several."""
    title = _TITLES[panel.key][0]
    return f"{title} ({panel.channel})" if len(mission.channels) > 1 else title


def asked_pairs(panel: LinkPanel) -> list[LinkSeries]:
    """The pairs that this panel's predicates name; all of them when there is none."""
    asked = {frozenset((p.sender, p.receiver)) for p in panel.predicates}
    known = [s for s in panel.series if panel.key in s.values]
    return [s for s in known if frozenset((s.sender, s.receiver)) in asked] or known


def _most_telling(series: Sequence[LinkSeries], panel: LinkPanel) -> list[LinkSeries]:
    """The pairs that get a name and a colour: all of a few, else the weakest."""
    if len(series) < MOST_PAIRS:
        return list(series)
    sign = -1.0 if panel.key in ("ber", "cost", "distance") else 1.0
    worst = sorted(series, key=lambda s: float(np.nanmin(sign * s.values[panel.key])))
    return worst[: MOST_PAIRS - 3]


def _chance_level(
    axes: Axes, clock: Clock, panel: LinkPanel, series: LinkSeries, colour: str
) -> None:
    """The level that one packet exceeds with the probability asked for."""
    from stlc.radio.link_budget import z_quantile

    ends = {series.sender, series.receiver}
    for p in panel.predicates:
        if p.probability is None or ends != {p.sender, p.receiver} or panel.key != "rssi":
            continue
        sign = 1.0 if p.relation is Relation.AT_LEAST else -1.0
        level = series.values["rssi"] - sign * z_quantile(p.probability) * series.values["sigma"]
        axes.plot(clock.times, level, color=colour, linewidth=1.0, linestyle=(0, (1, 1)), zorder=4,
                  label=f"{100 * p.probability:g} % level")  # fmt: skip


def _threshold_labels(axes: Axes, panel: LinkPanel) -> None:
    """The value of each distinct threshold, at the right edge."""
    levels = sorted({(p.threshold, p.relation.value) for p in panel.predicates})
    for (level, relation), place in zip(levels, _spread(axes, [x for x, _ in levels]), strict=True):
        axes.annotate(f"{_MARKS[relation]} {level:g}", (1.0, place), (3, 0), va="center",
                      xycoords="axes fraction", textcoords="offset points",
                      fontsize=SMALL)  # fmt: skip


_MARKS = {">=": "\N{GREATER-THAN OR EQUAL TO}", "<=": "\N{LESS-THAN OR EQUAL TO}"}
_APART = 0.085  # share of a panel's height that one line of small text takes


def _spread(axes: Axes, levels: Sequence[float]) -> list[float]:
    """Heights (axes fraction) of labels of rising levels, moved apart where they would overlap."""
    scale = axes.yaxis.get_transform().transform
    low, high = scale(np.array(axes.get_ylim()))
    places: list[float] = []
    for level in levels:
        place = float((scale(np.array([level]))[0] - low) / (high - low))
        places.append(max(place, places[-1] + _APART) if places else place)
    return places
