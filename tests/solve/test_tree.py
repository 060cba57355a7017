"""Branch and bound over a toy Bounder: the optimum, an honest bound, and an early end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from stlc.solve.tree import Expansion, branch_and_bound

COSTS = (7.0, 3.0, 9.0, 3.5, 8.0, 4.0, 6.0, 5.0)


@dataclass
class Span:
    """Leaves first..last - 1; no leaf costs less than `bound`."""

    first: int
    last: int
    bound: float = 0.0


@dataclass
class Halving:
    """Halves spans, bounds each half by its cheapest leaf less its width; counts its work."""

    best: list[float]
    expanded: int = 0

    def root(self) -> Span:
        return Span(0, len(COSTS))

    def expand(self, node: Span) -> Expansion[Span]:
        self.expanded += 1
        if node.last - node.first == 1:
            cost = COSTS[node.first]
            self.best[0] = min(self.best[0], cost)
            return Expansion(closed=cost)
        middle = (node.first + node.last) // 2
        ends = ((node.first, middle), (middle, node.last))
        return Expansion(tuple(Span(a, b, min(COSTS[a:b]) - (b - a) + 1) for a, b in ends))


@dataclass
class Holder:
    """The best plan and the clock of the toy."""

    best: list[float]
    allowed: float = math.inf
    bounds: list[float] = field(default_factory=list)

    @property
    def cutoff(self) -> float:
        return self.best[0]

    def stopped(self) -> bool:
        return len(self.bounds) >= self.allowed

    def raise_bound(self, bound: float) -> None:
        self.bounds.append(bound)


def test_the_optimum_is_found_and_proven_without_every_leaf() -> None:
    best = [math.inf]
    bounder, holder = Halving(best), Holder(best)
    branch_and_bound(bounder, bounder.root(), holder)
    assert best[0] == holder.bounds[-1] == min(COSTS)
    assert all(b <= min(COSTS) for b in holder.bounds)
    assert bounder.expanded < 2 * len(COSTS) - 1


def test_nothing_is_expanded_that_cannot_beat_the_incumbent() -> None:
    best = [-1.0]
    bounder, holder = Halving(best), Holder(best)
    branch_and_bound(bounder, bounder.root(), holder)
    assert bounder.expanded == 0


def test_a_search_that_is_stopped_has_a_bound_below_every_leaf() -> None:
    best = [math.inf]
    bounder, holder = Halving(best), Holder(best, allowed=2)
    branch_and_bound(bounder, bounder.root(), holder)
    assert bounder.expanded == 2
    assert holder.bounds[-1] <= min(COSTS)
