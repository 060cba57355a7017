"""The mission as the grid of `play.py` sees it: predicates loosened, obstacles no detour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.ir.nodes import Linear, Link, Not, Role, walk
from stlc.milp.compile import Compiled
from stlc.mission import Mission, TermKind
from stlc.solve.routes.moves import Judge, LevelOf, Moves

EDGE = 1e-7


def fits(compiled: Compiled, name: str) -> bool:
    """Whether the bound speaks of an agent: one input moves each state, nothing else does, and
    its effort weighs alike at all steps."""
    agent = compiled.mission.agents[name]
    gain = agent.dynamics.B
    still = np.array_equal(agent.dynamics.A, np.eye(len(gain))) and not agent.dynamics.drift.any()
    square = gain.shape[0] == gain.shape[1] and np.array_equal(gain, np.diag(np.diag(gain)))
    ranges = compiled.ranges[name]
    ends = (ranges.state_lower, ranges.state_upper, agent.input_lower, agent.input_upper)
    placed = agent.dynamics.position
    return (
        placed is not None and np.array_equal(placed, np.eye(2)) and still and square
        and bool(np.diag(gain).all()) and all(bool(np.isfinite(e).all()) for e in ends)
        and weight_of(compiled.mission, name) is not None
    )  # fmt: skip


def weight_of(mission: Mission, name: str) -> float | None:
    """What a unit of an agent's effort costs; None where that changes or other costs matter."""
    total = 0.0
    for term in mission.objective:
        if term.kind is not TermKind.EFFORT or term.normalised or term.weight < 0:
            return None
        if name in term.agents:
            if term.window not in (None, (0, mission.horizon)):
                return None
            total += term.weight
    return total


@dataclass(frozen=True, slots=True, eq=False)
class Spread(Moves):
    """Moves that are known up to open intervals: their upper ends, and those `below`."""

    below: Moves


@dataclass(slots=True, eq=False)
class Loosened(Judge):
    """A judge of the grid's moves: a predicate holds where it may hold for what y stands for."""

    def _linear(self, node: Linear, level: float, moves: Moves) -> Bools:
        if any(signal.owner != moves.agent for signal, _ in node.terms):
            return np.ones(len(moves.after), bool)
        assert isinstance(moves, Spread)
        value = np.full(len(moves.after), node.constant)
        for signal, weight in node.terms:
            most = (moves if weight > 0 else moves.below).values(signal)
            assert most is not None
            value += weight * most
        return np.asarray(value > level + 1e-9 if node.terms else value >= level - 1e-9)

    def _link(self, node: Link | Not, level: float, moves: Moves) -> Bools:
        return np.ones(len(moves.after), bool)


def lines_of(
    compiled: Compiled, name: str, levels: Sequence[LevelOf], spacing: float
) -> tuple[Floats, Floats]:
    """Grid lines along each axis: the start, the ends of the ranges, the edges of predicates on
    that axis alone, and more so that none are further apart than `spacing`."""
    agent, ranges = compiled.mission.agents[name], compiled.ranges[name]
    found: list[set[float]] = [set(), set()]
    for axis, edges in enumerate(found):
        edges.update((float(agent.start[axis]), float(ranges.state_lower[:, axis].min()),
                      float(ranges.state_upper[:, axis].max())))  # fmt: skip
    for one, level in zip(compiled.layout.encoded, levels, strict=True):
        for node in walk(one.formula):
            if isinstance(node, Linear) and len(node.terms) == 1:
                ((signal, weight),) = node.terms
                if signal.owner == name and signal.role is Role.STATE:
                    found[signal.index].add((level(node.unit) - node.constant) / weight)
    x, y = (_filled(np.array(sorted(edges)), spacing, float(start))
            for edges, start in zip(found, agent.start, strict=True))  # fmt: skip
    return x, y


def _filled(edges: Floats, spacing: float, start: float) -> Floats:
    """Without edges next to one another (the start stays), with lines in wide gaps."""
    kept = [edges[0]]
    for edge in edges[1:]:
        if edge - kept[-1] > 1e-7:
            kept.append(edge)
        elif edge == start:
            kept[-1] = edge
    parts = [
        np.linspace(a, b, max(int(np.ceil((b - a) / spacing - 1e-9)), 1), endpoint=False)
        for a, b in pairwise(kept)
    ]
    return np.concatenate([*parts, kept[-1:]])
