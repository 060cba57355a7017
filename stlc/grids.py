"""Grids that a channel chooses by itself: `partition auto`, and a channel without a partition.

The first grid has cells about as wide as shadowing is correlated, between 4 and 8 along the longer
side of the workspace. Where cells rule out what points of them may offer, `stlc solve` halves
them, up to `MOST` along a side. A plan says on which grid it was made.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import ceil

from stlc.mission import Mission
from stlc.radio.partition import Partition, uniform_grid

FEWEST, FIRST, MOST = 4, 8, 32
"""Cells along the longer side: the first grid has from FEWEST to FIRST. Measured: two agents with
costs on 20 x 20 cells are proven in 23 s, on 10 x 10 in 7 s; 32 x 32 pairs of cells in reach are
about what a model can hold."""

Ends = tuple[float, float]
Shape = tuple[int, int]


def first_grid(x: Ends, y: Ends, length: float | None) -> Partition:
    """The grid over a box [m] to begin with; `length` [m] of shadowing, None without any."""
    sides = x[1] - x[0], y[1] - y[0]
    longer = max(sides)
    width = min(max(length or 0.0, longer / FIRST), longer / FEWEST)
    nx, ny = (max(1, ceil(side / width - 1e-9)) for side in sides)
    return uniform_grid(x, y, nx, ny)


def shapes(mission: Mission) -> dict[str, Shape]:
    """Cells along x and y of every channel that chooses its own grid."""
    found = {name: c.partition.shape for name, c in mission.channels.items() if c.auto}
    return {name: shape for name, shape in found.items() if shape is not None}


def on_grids(mission: Mission, wanted: Mapping[str, Shape]) -> Mission:
    """The mission with the channels that choose their grid on the ones wanted."""
    own = shapes(mission)
    channels = {
        name: replace(channel, partition=_on(channel.partition, wanted[name]))
        if name in own and name in wanted and own[name] != wanted[name]
        else channel
        for name, channel in mission.channels.items()
    }
    return replace(mission, channels=channels)


def finer(mission: Mission) -> Mission | None:
    """The mission on grids with cells of half the width; None where none may get finer."""
    own = shapes(mission)
    wanted = {n: (2 * s[0], 2 * s[1]) for n, s in own.items() if 2 * max(s) <= MOST}
    return on_grids(mission, wanted) if wanted else None


def text(found: Mapping[str, Shape]) -> str:
    """Grids in words: `radio` on 8 x 8 cells."""
    return ", ".join(f"`{name}` on {nx} x {ny} cells" for name, (nx, ny) in found.items())


def _on(partition: Partition, shape: Shape) -> Partition:
    x_low, x_high, y_low, y_high = partition.boxes.T
    ends = (float(x_low.min()), float(x_high.max())), (float(y_low.min()), float(y_high.max()))
    return uniform_grid(*ends, *shape)
