"""All minimal conflicts of a mission's clauses, by MARCO.

Liffiton, Previti, Malik and Marques-Silva, Fast, flexible MUS enumeration, Constraints 21 (2016):
a map of the subsets that are not settled yet hands out a largest one. If it can hold, it is grown
to a maximal satisfiable set and everything below is settled; if not, it is shrunk to a minimal
conflict and everything above is settled. The map is a little set of 0-1 rows:

    sum_{i in C} x_i <= |C| - 1     for each conflict C found
    sum_{i not in S} x_i >= 1       for each maximal satisfiable set S found
    maximise sum x_i
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from stlc import backends
from stlc.backends.base import SolveOptions
from stlc.explain.oracle import Oracle, Verdict
from stlc.explain.shrink import length_of, minimal
from stlc.explain.weaken import conjuncts
from stlc.ir.requirement import Requirement
from stlc.milp.builder import ModelBuilder

Pieces = tuple[Requirement, ...]


def clauses_of(requirements: Pieces) -> Pieces:
    """The members that conflicts are made of: conjuncts of requirements, each once."""
    return tuple(dict.fromkeys(p for r in requirements for p in conjuncts(r)))


def conflicts(oracle: Oracle, requirements: Pieces) -> Iterator[Pieces]:
    """Minimal conflicts as they are found, until all are or the deadline is over.

    Lone clauses that fail by themselves come first. A set that couldn't be decided counts as one
    that can hold: `oracle.open` and `oracle.deadline` tell afterwards whether there may be more.
    """
    pieces = clauses_of(requirements)
    seen = _Map(len(pieces))
    for k, piece in enumerate(pieces):
        if oracle.infeasible([piece]):
            seen.conflict([k])
            yield (piece,)
    while not oracle.deadline.over():
        seed = seen.unsettled()
        if seed is None:
            return
        if oracle([pieces[k] for k in seed]) is Verdict.INFEASIBLE:
            order = sorted(seed, key=lambda k: -length_of(pieces[k]))
            found = minimal(order, lambda ks: oracle.infeasible([pieces[k] for k in ks]))
            seen.conflict(found)
            yield tuple(pieces[k] for k in sorted(found))
        else:
            seen.satisfiable(_grown(oracle, pieces, seed))


def _grown(oracle: Oracle, pieces: Pieces, seed: tuple[int, ...]) -> tuple[int, ...]:
    """More clauses beside the seed, as long as they can hold together. A seed of the map is a
    largest one, so that each further clause closes a conflict that is known: mostly none fits."""
    kept = list(seed)
    for k in range(len(pieces)):
        if k not in kept and not oracle.infeasible([pieces[i] for i in (*kept, k)]):
            kept.append(k)
    return tuple(kept)


@dataclass(slots=True)
class _Map:
    """Subsets of `size` clauses that nothing is known of."""

    size: int
    rows: list[tuple[tuple[int, ...], float]] = field(default_factory=list)  # sum >= number

    def conflict(self, members: list[int] | tuple[int, ...]) -> None:
        """Settle everything that holds these."""
        rest = tuple(members)
        self.rows.append((tuple(-k - 1 for k in rest), 1.0 - len(rest)))

    def satisfiable(self, members: tuple[int, ...]) -> None:
        """Settle everything within these."""
        others = tuple(k + 1 for k in range(self.size) if k not in members)
        self.rows.append((others, 1.0))

    def unsettled(self) -> tuple[int, ...] | None:
        """A largest subset that nothing is known of; None when there is none."""
        if any(not members and least > 0 for members, least in self.rows):
            return None
        builder = ModelBuilder("map")
        x = builder.binary("x", (self.size,), cost=-1.0)
        for members, least in self.rows:
            signs, which = np.sign(members), np.abs(members) - 1
            builder.add_rows("known", np.zeros(len(which), int), x[which], signs, least, np.inf)
        found = backends.get("highs").solve(builder.build(), SolveOptions(gap=0.0)).x
        if found is None:
            return None
        return tuple(np.flatnonzero(found > 0.5).tolist())
