"""Predicted RSSI over the workspace, seen from a station or from one agent's place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stlc.channels import true_values
from stlc.mission import Channel, Mission
from stlc.plan import LinkSeries, Plan
from stlc.plot.style import SMALL

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

Array = NDArray[np.float64]

POINTS = 90  # along the longer side


def mapped_channel(mission: Mission, links: Sequence[LinkSeries]) -> Channel | None:
    """The first channel in use that has a model."""
    for series in links:
        channel = mission.channels[series.channel]
        if channel.model is not None:
            return channel
    return None


def draw_channel(
    axes: Axes, mission: Mission, plan: Plan, channel: Channel, links: Sequence[LinkSeries]
) -> None:
    """Mean RSSI between every point and the source, the partition's cells on top."""
    pair = next((s.sender, s.receiver) for s in links if s.channel == channel.name)
    source, other, where = _source(mission, plan, pair)
    boxes = channel.partition.boxes
    low, high = boxes[:, 0:4:2].min(axis=0), boxes[:, 1:4:2].max(axis=0)
    xs, ys = _axis_points(low, high)
    grid = np.stack(np.meshgrid(xs, ys, indexing="xy"), axis=-1).reshape(-1, 2)
    places = np.tile(where, (len(grid), 1))
    height = _height(mission, plan, other)
    grid = np.column_stack([grid, np.full(len(grid), height)])
    rssi = true_values(mission, channel, (other, source), grid, places).mean
    image = axes.imshow(
        rssi.reshape(len(ys), len(xs)), origin="lower", cmap="cividis", interpolation="bilinear",
        extent=(low[0], high[0], low[1], high[1]), aspect="equal",
    )  # fmt: skip
    _cells(axes, boxes)
    axes.plot(*where[:2], marker="^", markersize=9, color="white", markeredgecolor="black",
              markeredgewidth=1.4, linestyle="")  # fmt: skip
    bar = axes.figure.colorbar(image, ax=axes, fraction=0.046, pad=0.03)
    bar.set_label("RSSI [dBm]", fontsize=SMALL)
    bar.ax.tick_params(labelsize=SMALL)
    bar.outline.set_visible(False)
    axes.grid(False)
    when = "" if source in mission.stations else f" at {plan.times[-1]:g} s"
    when += f", {height:.3g} m up" if height else ""
    axes.set(xlabel="x [m]", ylabel="y [m]", title=f"Channel seen from {source}{when}")


def _source(mission: Mission, plan: Plan, pair: tuple[str, str]) -> tuple[str, str, Array]:
    """Whom the map is seen from, the other end of the pair, and the place (3,) [m]."""
    for source, other in (pair, pair[::-1]):
        if source in mission.stations:
            return source, other, mission.stations[source].place
    other, source = pair
    space = mission.agents[source].dynamics.space
    assert space is not None
    return source, other, np.asarray(space @ plan.runs[source].states[-1], dtype=np.float64)


def _height(mission: Mission, plan: Plan, name: str) -> float:
    """The height [m] at which the map is drawn: where its other end flies on average, or stands."""
    if name in mission.stations:
        return mission.stations[name].height
    altitude = mission.agents[name].dynamics.altitude
    return 0.0 if altitude is None else float((plan.runs[name].states @ altitude).mean())


def _axis_points(low: Array, high: Array) -> tuple[Array, Array]:
    spacing = float((high - low).max()) / POINTS
    counts = np.maximum(np.ceil((high - low) / spacing).astype(int), 2)
    width = (high - low) / counts
    x, y = (low[k] + width[k] * (np.arange(counts[k]) + 0.5) for k in (0, 1))
    return x, y


def _cells(axes: Axes, boxes: Array) -> None:
    from matplotlib.collections import LineCollection

    corners = boxes[:, [[0, 2], [1, 2], [1, 3], [0, 3], [0, 2]]]
    thin = 0.5 if len(boxes) <= 400 else 0.2
    axes.add_collection(LineCollection(list(corners), colors="white", linewidths=thin, alpha=0.6))
