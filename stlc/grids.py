"""Grids that a channel chooses by itself: `partition auto`, and a channel without a partition.

The first grid has cells about as wide as shadowing is correlated, between 4 and 8 along the longest
side of the workspace, which has a height where agents fly. Where cells rule out what points of them
may offer, `stlc solve` halves them, up to `MOST` along a side. A plan says on which grid it was
made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from stlc.mission import Mission
from stlc.places import Polytope
from stlc.radio.partition import Partition, even_grid

FEWEST, FIRST, MOST = 4, 8, 32
"""Cells along the longer side: the first grid has from FEWEST to FIRST. Measured: two agents with
costs on 20 x 20 cells are proven in 23 s, on 10 x 10 in 7 s; 32 x 32 pairs of cells in reach are
about what a model can hold."""

Ends = tuple[float, float]
Shape = tuple[int, ...]


def first_grid(ends: Sequence[Ends], length: float | None) -> Partition:
    """The grid over a box [m] to begin with, its height last if it has any; `length` [m] of
    shadowing, None without any."""
    sides = [high - low for low, high in ends]
    longer = max(sides)
    width = min(max(length or 0.0, longer / FIRST), longer / FEWEST)
    return even_grid(ends, [max(1, ceil(side / width - 1e-9)) for side in sides])


def shapes(mission: Mission) -> dict[str, Shape]:
    """Cells along each axis of every channel that chooses its own grid."""
    found = {name: c.partition.shape for name, c in mission.channels.items() if c.auto}
    return {name: shape for name, shape in found.items() if shape is not None}


def on_grids(mission: Mission, wanted: Mapping[str, Shape]) -> Mission:
    """The mission with the channels that choose their grid on the ones wanted."""
    own = shapes(mission)
    channels = {
        name: replace(channel, partition=_on(channel.partition, wanted[name]))
        if name in own
        and name in wanted
        and own[name] != wanted[name]
        and len(own[name]) == len(wanted[name])
        else channel
        for name, channel in mission.channels.items()
    }
    return replace(mission, channels=channels)


def finer(mission: Mission) -> Mission | None:
    """The mission on grids with cells of half the width; None where none may get finer."""
    own = shapes(mission)
    wanted = {n: tuple(2 * k for k in s) for n, s in own.items() if 2 * max(s) <= MOST}
    return on_grids(mission, wanted) if wanted else None


def beyond(space: Polytope, out: float) -> float:
    """How far the workspace and the cells at its border go on [m] for an agent that was measured
    `out` [m] outside: twice that far, and a quarter of the workspace's width at least."""
    wide = float(np.ptp(space.vertices, axis=0).min())
    return max(2.0 * out, 0.25 * wide)


def carried_on(mission: Mission, out: float) -> Mission:
    """The mission with the cells at the workspace's border carried on beyond it, for `out` [m]."""
    space = mission.workspace
    if space is None:
        return mission
    low, high = space.vertices.min(axis=0), space.vertices.max(axis=0)
    by = beyond(space, out)
    channels = {
        name: replace(c, partition=c.partition.carried_on(low, high, by))
        for name, c in mission.channels.items()
    }
    return replace(mission, channels=channels)


def text(found: Mapping[str, Shape]) -> str:
    """Grids in words: `radio` on 8 x 8 cells."""
    return ", ".join(
        f"`{name}` on {' x '.join(map(str, shape))} cells" for name, shape in found.items()
    )


def _on(partition: Partition, shape: Shape) -> Partition:
    """The grid over the same box; one whose border cells go on beyond it as far as before."""
    inner = partition.inner
    if inner is not None:
        low, high = inner.low.min(axis=0), inner.high.max(axis=0)
        by = float(max((low - partition.low.min(axis=0)).max(), (partition.high - high).max()))
        return _on(inner, shape).carried_on(low, high, by)
    ends = zip(partition.low.min(axis=0), partition.high.max(axis=0), strict=True)
    return even_grid([(float(low), float(high)) for low, high in ends], shape)
