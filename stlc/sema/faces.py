"""Half-planes about a point that a formula speaks of, as predicates.

A place has many faces, a moving one has them at every step, and all speak of one point: where its
coordinates are linear in signals, these are sorted once and each face is a row over them.
"""

from __future__ import annotations

from dataclasses import dataclass

from stlc.ir.nodes import Linear, Node
from stlc.ir.signals import Signal
from stlc.sema.compare import at_least_zero
from stlc.sema.scalars import add, scale
from stlc.sema.units import METRE
from stlc.sema.values import Scalar
from stlc.source import Span

_UNIT = str(METRE)


@dataclass(frozen=True, slots=True)
class Plane:
    """A point's x and y; `rows` are its signals in order with their factors in x and in y [m].

    `rows` is None where the coordinates are more than linear in signals.
    """

    x: Scalar
    y: Scalar
    rows: tuple[tuple[Signal, float, float], ...] | None
    span: Span

    @staticmethod
    def of(where: tuple[Scalar, ...], span: Span) -> Plane:
        """The plane's part of a point with two or three coordinates [m]."""
        x, y = where[:2]
        atoms = {atom for scalar in (x, y) for atom, _ in scalar.terms}
        if x.folds or y.folds or not all(isinstance(atom, Signal) for atom in atoms):
            return Plane(x, y, None, span)
        in_x, in_y = dict(x.terms), dict(y.terms)
        signals = sorted((a for a in atoms if isinstance(a, Signal)), key=lambda s: s.key)
        rows = tuple((s, in_x.get(s, 0.0), in_y.get(s, 0.0)) for s in signals)
        return Plane(x, y, rows, span)

    def at_least_zero(self, nx: float, ny: float, offset: float) -> Node:
        """`nx x + ny y + offset >= 0` [m]. Raises Mistake as comparisons do."""
        if self.rows is None:
            depth = add(scale(self.x, nx, METRE), scale(self.y, ny, METRE), self.span)
            depth = add(depth, Scalar(offset, unit=METRE), self.span)
            return at_least_zero(depth, self.span, positive=True)
        terms = ((signal, nx * a + ny * b) for signal, a, b in self.rows)
        constant = nx * self.x.constant + ny * self.y.constant + offset
        return Linear(tuple(t for t in terms if t[1] != 0.0), constant, _UNIT, span=self.span)
