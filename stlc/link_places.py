"""Where the ends of links are: cells, stations, heights, and how far robots may be off.

Which cells a position touches is none of its business.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stlc.mission import Agent, Channel, Mission
from stlc.radio.gp import UNHEARD, ChannelModel
from stlc.radio.link_ends import LinkEnds
from stlc.radio.partition import Partition

Array = NDArray[np.float64]
Pair = tuple[str, str]


def link_ends(mission: Mission, channel: Channel, pair: Pair, sure: bool = False) -> LinkEnds:
    """Both ends of a pair for the radio, the moving one first (channels are symmetric).

    `sure`: the cells of a robot or a disturbed agent, which say where its plan is, are as much
    larger as its tube, so that what is worst over them is worst for it.
    """
    first, second = pair[::-1] if pair[0] in mission.stations else pair
    station = mission.stations.get(second)
    radii = [tube_radius(mission, name) if sure else 0.0 for name in (first, second)]
    cells, others = _wider(channel.partition, radii[0]), None
    if first in mission.stations:  # two stations: a table with one entry
        cells = _speck(mission.stations[first].position)
    elif station is None and radii[0] != radii[1]:
        others = _wider(channel.partition, radii[1])
    point = None if station is None else np.asarray(station.position, dtype=np.float64)
    model = channel.model
    heights = (height_of(mission, first), height_of(mission, second))
    use = heights if model is not None and dimensions(mission, model, pair) == 3 else None
    known = None if model is None else receiver(model, pair)
    return LinkEnds(cells, others if point is None else point, use, known)


def tube_radius(mission: Mission, name: str) -> float:
    """How far along an axis an agent or station may be from where it is planned, at all times [m];
    the same however much of the mission is left."""
    agent = mission.agents.get(name)
    if agent is None:
        return 0.0
    if agent.tube is not None:
        return _pushed(agent)
    return 0.0 if agent.robot is None else agent.robot.radius


@lru_cache(maxsize=64)
def _pushed(agent: Agent) -> float:
    """How far a disturbance carries an agent off, along the axis along which that is most."""
    model, tube = agent.dynamics, agent.tube
    if tube is None or model.position is None:
        return 0.0
    return float((np.abs(model.axes) @ tube.widest(model.A, model.B)).max())


def _wider(cells: Partition, by: float) -> Partition:
    """Cells that reach further by so much [m], along each axis; layers of height mean nothing to
    ends that stay at theirs."""
    if not by:
        return cells
    boxes = cells.boxes.copy()
    boxes[:, 0::2] -= by
    boxes[:, 1::2] += by
    return Partition(boxes)


def _speck(position: Array) -> Partition:
    x, y = (float(c) for c in position)
    return Partition(np.array([[x - 1e-9, x + 1e-9, y - 1e-9, y + 1e-9]]))


def dimensions(mission: Mission, model: ChannelModel, pair: Pair) -> int:
    """3 when the channel was measured, or a station or an antenna stands, or an end of the pair may
    be, at a height; else 2."""
    if model.posterior is not None:
        return int(model.posterior.centres.shape[1]) // 2
    if any(height_of(mission, name) is None for name in pair):
        return 3
    radios = (*mission.stations, *mission.agents)
    return 3 if any(height_of(mission, name) for name in radios) else 2


def height_of(mission: Mission, name: str) -> float | None:
    """Where its antenna is [m]; None for an agent whose height is a signal."""
    station = mission.stations.get(name)
    if station is not None:
        return station.height
    agent = mission.agents[name]
    return agent.antenna if agent.dynamics.altitude is None else None


def receiver(model: ChannelModel, pair: Pair) -> str | None:
    """The end whose calibration offset applies: the receiver, or else the sender; UNHEARD where
    offsets were fitted and neither was heard."""
    known = dict(model.offsets)
    found = next((name for name in pair[::-1] if name in known), None)
    return UNHEARD if found is None and model.offset_spread else found


def true_links(mission: Mission, model: ChannelModel, pair: Pair, a: Array, b: Array) -> Array:
    """The links (K, 4), or (K, 6) where heights count, between places a and b (K, 3) [m], in the
    plane (K, 2) too; antennas are above their agents."""
    axes = dimensions(mission, model, pair)
    ends = [np.asarray(place, dtype=np.float64)[:, :axes] for place in (a, b)]
    up = [raised(mission, name)[: end.shape[1]] for name, end in zip(pair, ends, strict=True)]
    return np.hstack([end + by for end, by in zip(ends, up, strict=True)])


def raised(mission: Mission, name: str) -> Array:
    """(3,): how far a radio's antenna is above its place [m]."""
    agent = mission.agents.get(name)
    return np.array([0.0, 0.0, 0.0 if agent is None else agent.antenna])
