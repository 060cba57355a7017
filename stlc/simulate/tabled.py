"""Link costs that the mission gives as tables, at the positions of every draw."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stlc.channels import given_table
from stlc.mission import Channel, Mission
from stlc.radio.partition import TOUCH, Partition

Array = NDArray[np.float64]

_BLOCK = 4_000_000
"""Entries of the largest mask of positions and cells."""


def tabled_cost(
    mission: Mission, channel: Channel, pair: tuple[str, str], positions: Mapping[str, Array]
) -> Array:
    """Cost (T+1, D) of a pair: the cheapest of the touching cells, infinite outside every cell.

    positions (T+1, 3, D) [m]. Raises StlcError when the channel has no table for the pair.
    """
    table = given_table(mission, channel, pair)
    moving = [name for name in pair if name in mission.agents]
    if not moving:
        return np.full((mission.horizon + 1, 1), float(table))
    places = np.broadcast_arrays(*(positions[name] for name in moving))
    steps, _, draws = places[0].shape
    flat = [np.moveaxis(place, 1, 2).reshape(-1, 3) for place in places]
    size = max(1, _BLOCK // len(channel.partition.boxes))
    parts = [
        _cheapest(table, channel.partition, [place[k : k + size] for place in flat])
        for k in range(0, steps * draws, size)
    ]
    return np.concatenate(parts).reshape(steps, draws)


def _cheapest(table: Array, cells: Partition, places: list[Array]) -> Array:
    """The least touching entry (K,) of a table with one axis for each of `places` (K, 3)."""
    masks = [_touched(cells, place) for place in places]
    counts = [mask.sum(axis=1) for mask in masks]
    out = np.asarray(table[tuple(mask.argmax(axis=1) for mask in masks)], dtype=np.float64).copy()
    for row in np.flatnonzero(np.prod(counts, axis=0) > 1):
        out[row] = table[np.ix_(*(np.flatnonzero(mask[row]) for mask in masks))].min()
    out[np.any([count == 0 for count in counts], axis=0)] = np.inf
    return out


def _touched(cells: Partition, place: Array) -> NDArray[np.bool_]:
    """Which cells each position touches (K, cells)."""
    within = np.ones((len(place), len(cells)), dtype=np.bool_)
    for axis in range(cells.axes):
        at = place[:, axis : axis + 1]
        within &= (at >= cells.low[:, axis] - TOUCH) & (at <= cells.high[:, axis] + TOUCH)
    return within
