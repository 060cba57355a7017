"""Branch and bound, best bound first, over whatever a `Bounder` makes of its nodes.

Invariant: every plan lies in an open node, in a closed one, or is no better than the cutoff. So
the least bound of open and closed nodes, cut at the cutoff, is proven for all plans.
"""

from __future__ import annotations

import heapq
import itertools
import math
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar


class Bounded(Protocol):
    """A node: plans of some kind, none of which costs less than `bound`."""

    bound: float


N = TypeVar("N", bound=Bounded)


@dataclass(frozen=True, slots=True)
class Expansion(Generic[N]):
    """What became of a node: `children` that hold all its plans but those that cost at least
    `closed`."""

    children: tuple[N, ...] = ()
    closed: float = math.inf


class Bounder(Protocol[N]):
    """Bounds nodes and splits them."""

    def root(self) -> N | None:
        """The node of all plans; None where the search has nothing to say."""

    def expand(self, node: N) -> Expansion[N]:
        """Tighten a node, then close it or split it."""


class Incumbent(Protocol):
    """What the tree asks of whoever holds the best plan and the clock."""

    @property
    def cutoff(self) -> float:
        """What a plan has to fall short of to matter."""

    def stopped(self) -> bool:
        """Whether to end."""

    def raise_bound(self, bound: float) -> None:
        """Take a bound on all plans."""


def branch_and_bound(bounder: Bounder[N], root: N, incumbent: Incumbent) -> None:
    """Expand open nodes until none is below the cutoff, or somebody says stop."""
    ticks, closed = itertools.count(), math.inf  # ticks: nodes of one bound in order of age
    open_ = [(root.bound, next(ticks), root)]
    while open_ and open_[0][0] < incumbent.cutoff and not incumbent.stopped():
        _, _, node = heapq.heappop(open_)
        found = bounder.expand(node)
        closed = min(closed, found.closed)
        for child in found.children:
            heapq.heappush(open_, (child.bound, next(ticks), child))
        least = min(closed, open_[0][0] if open_ else math.inf)
        incumbent.raise_bound(min(least, incumbent.cutoff))
