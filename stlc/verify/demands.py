"""What a mission demands of an agent whatever else holds: by conjunctions and windows of always."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from stlc.ir.nodes import Always, And, Node
from stlc.mission import Mission

Claim = Callable[[Node], tuple[str, str] | None]
"""(agent, obstacle to keep out of) that a node states, or None."""


def demanded(mission: Mission, claim: Claim, count: int) -> dict[str, list[set[str]]]:
    """For each agent the obstacles that it must keep out of at each of `count` steps."""
    found: dict[str, list[set[str]]] = {}
    for requirement in mission.requirements:
        for (agent, place), start, end in _demands(
            requirement.formula, claim, (0, 0), mission.horizon
        ):
            if place in mission.obstacles:
                steps = found.setdefault(agent, [set() for _ in range(count)])
                for t in range(start, min(end + 1, count)):
                    steps[t].add(place)
    return found


def _demands(
    node: Node, claim: Claim, window: tuple[int, int], last: int
) -> Iterator[tuple[tuple[str, str], int, int]]:
    """(claim, first step, last step) of what holds whatever else does."""
    stated, (start, end) = claim(node), window
    if stated is not None:
        yield stated, start, end
    elif node.swept is None and node.member is None and isinstance(node, And):
        for arg in node.args:
            yield from _demands(arg, claim, window, last)
    elif isinstance(node, Always):
        stop = last if node.end is None else end + node.end
        yield from _demands(node.arg, claim, (start + node.start, stop), last)
