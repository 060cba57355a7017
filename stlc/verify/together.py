"""Obstacles that touch: no agent that must keep out of both passes between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np

from stlc.ir.nodes import Always, And, Motion, Node
from stlc.mission import Mission
from stlc.verify.clearance import Chain, Meeting, keep_out, of_step
from stlc.verify.report import Violation
from stlc.verify.shapes import TOUCH, Body, Stay, obstacle_body
from stlc.verify.subject import TOLERANCE


def passages(mission: Mission, chains: Mapping[str, Chain]) -> Iterator[Violation]:
    """Motions through the seam of obstacles that an agent must keep out of at the same time."""
    for name, places in _avoided(mission).items():
        if name in chains:
            yield from _Passages(mission, name, chains[name]).found(places)


def _avoided(mission: Mission) -> dict[str, list[set[str]]]:
    """For each agent the obstacles that it must keep out of, `swept`, after each step."""
    found: dict[str, list[set[str]]] = {}
    for requirement in mission.requirements:
        for agent, place, start, end in _demands(requirement.formula, 0, 0, mission.horizon):
            if place in mission.obstacles:
                steps = found.setdefault(agent, [set() for _ in range(mission.horizon)])
                for t in range(start, min(end + 1, mission.horizon)):
                    steps[t].add(place)
    return found


def _demands(node: Node, start: int, end: int, last: int) -> Iterator[tuple[str, str, int, int]]:
    """(agent, place, first step, last step) of what holds whatever else does."""
    claim = node.swept
    if claim is not None:
        if claim.motion is Motion.OUTSIDE and claim.place is not None:
            yield claim.agent, claim.place, start, end
    elif isinstance(node, And):
        for arg in node.args:
            yield from _demands(arg, start, end, last)
    elif isinstance(node, Always):
        stop = last if node.end is None else end + node.end
        yield from _demands(node.arg, start + node.start, stop, last)


@dataclass(slots=True, eq=False)
class _Passages:
    mission: Mission
    agent: str
    chain: Chain
    bodies: dict[str, Body] = field(default_factory=dict)
    unions: dict[tuple[int, ...], list[Any]] = field(default_factory=dict)

    def found(self, places: Sequence[set[str]]) -> Iterator[Violation]:
        """One violation for each step that passes between obstacles but into none of them."""
        space = self.mission.workspace
        seen = Meeting(lambda parts, move: keep_out(parts, space, move))
        for t, names in enumerate(places):
            for group in self._groups(t, sorted(names)):
                parts, move = self._touching(group), next(iter(group.values())).move
                if not parts or _enters_one(self.chain, t, group, seen):
                    continue
                value, when = of_step(self.chain, t, parts, move, seen)
                if value < -TOLERANCE:
                    yield self._violation(group, value, t + when)

    def _groups(self, t: int, names: Sequence[str]) -> list[dict[str, Stay]]:
        """Obstacles that move alike after a step."""
        groups: dict[bytes, dict[str, Stay]] = {}
        for name in names:
            obstacle, step = self.mission.obstacles[name], self.mission.step
            if name not in self.bodies:
                self.bodies[name] = obstacle_body(obstacle, step, obstacle.inflate)
            stay = self.bodies[name].stay(t)
            if stay is not None:
                groups.setdefault(np.round(stay.move, 9).tobytes(), {})[name] = stay
        return [g for g in groups.values() if len(g) > 1]

    def _touching(self, group: Mapping[str, Stay]) -> list[Any]:
        """Polygons of obstacles that touch another; none if all are apart."""
        key = tuple(id(stay) for stay in group.values())
        if key not in self.unions:
            near = set()
            for one, other in combinations(group, 2):
                if _distance(group[one], group[other]) <= TOUCH:
                    near |= {one, other}
            self.unions[key] = [p for name in near for p in group[name].parts]
        return self.unions[key]

    def _violation(self, group: Mapping[str, Stay], value: float, time: float) -> Violation:
        seconds = time * self.mission.step
        text = (
            f"{self.agent} passes between {' and '.join(group)}, which touch, "
            f"at {seconds:.3g} s: {-value:.4g} m within their union"
        )
        return Violation("swept", text, -value, time, self.agent, None)


def _distance(one: Stay, other: Stay) -> float:
    import shapely

    return float(shapely.distance(*(shapely.union_all(list(s.parts)) for s in (one, other))))


def _enters_one(chain: Chain, t: int, group: Mapping[str, Stay], seen: Meeting) -> bool:
    """Whether an obstacle alone is entered, which its own requirement tells."""
    clear = (of_step(chain, t, s.parts, s.move, seen)[0] for s in group.values())
    return any(value < -TOLERANCE for value in clear)
