"""Links as convex conditions on where their ends are.

Where a link is good enough its ends are in one of the pairs of cells whose table says so, and all
those pairs lie in one polygon of how far apart two agents are (or of where an agent is, before a
station). A mission that asks for the polygon alone asks for less, and needs no cells:

    link(a, b) good  ->  n . (p_a - p_b) <= max over good (i, j) of (max_i n . p - min_j n . p)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.channels import ChannelTables
from stlc.ir.networks import Network, uncomposed
from stlc.ir.nodes import And, Const, Linear, Link, Node, Not, Role, Signal
from stlc.ir.rewrite import rewrite
from stlc.mission import Mission
from stlc.passes import nnf
from stlc.passes.base import Program

_MISS = 1e-6  # what a certified plan may miss a predicate by
_ROOM = 1e-5  # m: around cells, which may be left by a tolerance
_SIDES = 16  # of a polygon


def loosened(mission: Mission, tables: ChannelTables) -> Mission:
    """The mission with a polygon in place of every link that it asks for; costs stay."""
    program = nnf.run(Program(mission.requirements, mission))
    found = []
    for requirement in program.requirements:
        formula, margin = requirement.formula, requirement.margin
        for visit in (_negated, _plain):
            (formula,) = rewrite((formula,), partial(visit, links=_Links(mission, tables, margin)))
        found.append(replace(requirement, formula=formula))
    return replace(mission, requirements=tuple(found))


def _negated(node: Node, links: _Links) -> Node:
    if isinstance(node, Not) and isinstance(node.arg, Link):
        return links.polygon(node.arg, -links.tables.thresholds(node.arg).high)
    return node


def _plain(node: Node, links: _Links) -> Node:
    if isinstance(node, Link):
        return links.polygon(node, links.tables.thresholds(node).low)
    if isinstance(node, Network) and node.composed:
        return uncomposed(node)
    return node


@dataclass(frozen=True, slots=True)
class _Links:
    mission: Mission
    tables: ChannelTables
    margin: float

    def polygon(self, link: Link, table: Floats) -> Node:
        """What a link of robustness `table` over cells asks of the places of its moving ends."""
        good = np.asarray(table >= self.margin - _MISS)
        moving = [n for n in (link.sender, link.receiver) if n in self.mission.agents]
        if good.all():
            return Const(True)
        if not good.any() or not moving:
            return Const(bool(good.any()))
        partition = self.mission.channels[link.channel].partition
        low, high = partition.low - _ROOM, partition.high + _ROOM
        fly = all(self.mission.agents[n].dynamics.altitude is not None for n in moving)
        return And(tuple(
            self._side(link, moving, n, _furthest(good, low, high, n))
            for n in _directions(low.shape[1], fly)
        ))  # fmt: skip

    def _side(self, link: Link, moving: Sequence[str], normal: Floats, most: float) -> Linear:
        """n . p <= most, or n . (p - q) <= most for two agents, in the axes of the cells."""
        terms: list[tuple[Signal, float]] = []
        for sign, name in zip((-1.0, 1.0), moving, strict=False):
            space = self.mission.agents[name].dynamics.space
            assert space is not None, "whoever has a link is somewhere"
            weights = sign * (normal @ space[: len(normal)])
            terms += [
                (Signal(name, Role.STATE, int(k), link.shift), float(weights[k]))
                for k in np.flatnonzero(weights)
            ]
        terms.sort(key=lambda term: term[0].key)
        return Linear(tuple(terms), most + self.margin, "m", span=link.span)


def _directions(axes: int, fly: bool) -> Floats:
    """Unit vectors (k, axes): around in the plane, then up and down for those that all `fly`."""
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    around = np.round(np.stack([np.cos(angles), np.sin(angles)], 1), 12)
    if axes == 2:
        return around
    around = np.pad(around, ((0, 0), (0, 1)))
    return np.vstack([around, [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]]) if fly else around


def _furthest(good: Bools, low: Floats, high: Floats, normal: Floats) -> float:
    """The most of n . p over good cells, or of n . (p - q) over good pairs of cells."""
    corners = np.stack([low * normal, high * normal])
    most, least = corners.max(axis=0).sum(axis=1), corners.min(axis=0).sum(axis=1)
    reach = most if good.ndim == 1 else most[:, None] - least[None]
    return float(reach[good].max())
