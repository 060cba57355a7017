"""Euclidean lengths: the meaning behind formulas that stand for them by polygons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stlc.ir.nodes import Signal


@dataclass(frozen=True, slots=True)
class Sum:
    """constant + sum of coefficient * signal."""

    terms: tuple[tuple[Signal, float], ...]
    constant: float


@dataclass(frozen=True, slots=True)
class Norms:
    """`rest + sum of coefficient * sqrt(x^2 + y^2 + ..) >= 0`, behind a node over faces.

    The node is sufficient for it where it stands positively, and implied by it under a negation.
    The verifier and the monitor judge this in place of the node.
    """

    rest: Sum
    lengths: tuple[tuple[float, tuple[Sum, ...]], ...]
    unit: str = ""

    def negated(self) -> Norms:
        """That of the opposite number."""
        terms = tuple((signal, -factor) for signal, factor in self.rest.terms)
        lengths = tuple((-factor, parts) for factor, parts in self.lengths)
        return Norms(Sum(terms, -self.rest.constant), lengths, self.unit)

    @property
    def owners(self) -> frozenset[str]:
        """Whose signals take part."""
        sums = (self.rest, *(part for _, parts in self.lengths for part in parts))
        return frozenset(signal.owner for part in sums for signal, _ in part.terms)
