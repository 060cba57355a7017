"""Boxes of one axis, a position and a rate apart, and the steps that may lead from one to another.

Every face at which a predicate or a cell ends has a thin box of positions to itself, so that all
other boxes are on one side of it; between faces boxes are about as long as the axis goes in a
part of a step. A step leads from a box to another where some of their points are one step apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve.relaxation.problem import Axis, Singles
from stlc.solve.states.boxes import feasible_pairs

THIN = 2e-6  # m: half a face's own box, wider than solvers let predicates be missed
_LONGER = 1e-4  # of a box: what a box is longer, so that one at full rate ends within the next
_LEAST = 0.2  # of a box: a shorter rest beside a face belongs to the box before it
_MOST = 2000  # boxes of an axis: steps between all pairs of more take too much memory

Span = tuple[int, int]
"""Positions [first, last) of an axis."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisBoxes:
    """Positions `p` (n, 2) and rates `w` (m, 2); box k m + j has position k and rate j. `before`
    and `after` (r, n m) are boxes that a step may come from and lead to, -1 as filling; `far`:
    positions that one leads to at the most."""

    p: Floats
    w: Floats
    before: Ints
    after: Ints
    far: int

    @property
    def rates(self) -> int:
        """How many boxes of the rate there are."""
        return len(self.w)

    def beside(self, span: Span) -> Span:
        """The positions a step away from others."""
        return max(span[0] - self.far, 0), min(span[1] + self.far, len(self.p))

    def stepped(self, values: Singles, span: Span, wanted: Span, *, back: bool) -> Singles:
        """The least value (k', c) of boxes a step before, or after, those of positions `wanted`;
        values (k, c) are of all boxes of positions `span`."""
        m = self.rates
        whole = np.full((len(self.p) * m + 1, values.shape[1]), np.inf, np.float32)
        whole[span[0] * m : span[1] * m] = values
        table = (self.after if back else self.before)[:, wanted[0] * m : wanted[1] * m]
        used = ((table >= span[0] * m) & (table < span[1] * m)).any(axis=1)
        found = np.full((table.shape[1], values.shape[1]), np.inf, np.float32)
        for row in table[used]:
            np.minimum(found, whole[row], out=found)
        return found

    def holding(self, p: float, w: float) -> Ints:
        """The boxes that hold a state."""
        at = np.flatnonzero((self.p[:, 0] <= p) & (p <= self.p[:, 1]))
        going = np.flatnonzero((self.w[:, 0] <= w + THIN) & (w - THIN <= self.w[:, 1]))
        return np.asarray((at[:, None] * self.rates + going).ravel())

    def parents(self, coarse: AxisBoxes) -> tuple[Ints, Ints]:
        """The coarse position and rate that hold each: coarse cuts are cuts here too."""
        at = np.searchsorted(coarse.p[:, 1], self.p.mean(axis=1))
        return at, np.searchsorted(coarse.w[:, 1], self.w.mean(axis=1))


def axis_boxes(axis: Axis, faces: Iterable[float], parts: int) -> AxisBoxes | None:
    """With boxes as long as the fastest step cut into `parts`; None for too many."""
    low, high = float(axis.box[:, 0].min()), float(axis.box[:, 1].max())
    rates = axis.box[1:, 2:]
    fastest = float(np.abs(rates).max())
    p = _cuts(low, high, faces, max(fastest, (high - low) * 1e-3), parts)
    ends = float(rates[:, 0].min()), float(rates[:, 1].max())
    count = max(int(np.ceil((ends[1] - ends[0]) / max(fastest, THIN) - 1e-6)), 1) * parts
    w = np.linspace(*ends, count + 1)
    p, w = np.stack([p[:-1], p[1:]], 1), np.stack([w[:-1], w[1:]], 1)
    if len(p) * count > _MOST:
        return None
    box = np.hstack([np.repeat(p, count, axis=0), np.tile(w, (len(p), 1))])
    source, target = feasible_pairs(box, box, axis)
    far = int(np.abs(source // count - target // count).max(initial=0))
    size = len(box)
    return AxisBoxes(p, w, _listed(target, source, size), _listed(source, target, size), far)


def _cuts(low: float, high: float, faces: Iterable[float], spacing: float, parts: int) -> Floats:
    """Ends of boxes: two around each face, and others between faces."""
    inner = sorted(f for f in faces if low + 2 * THIN < f < high - 2 * THIN)
    known = [low]
    for face in inner:
        if face - known[-1] > 3 * THIN:
            known.append(face)
    known.append(high)
    cuts = [known[0] - THIN]
    for a, b in pairwise(known):
        cuts += [a + THIN, *_between(a + THIN, b - THIN, spacing * (1 + _LONGER), parts), b - THIN]
    return np.array([*cuts, known[-1] + THIN])


def _between(a: float, b: float, spacing: float, parts: int) -> list[float]:
    """Ends of the boxes between two faces."""
    coarse = np.arange(a + spacing, b - _LEAST * spacing, spacing)
    ends = np.array([a, *coarse, b])
    steps = np.diff(ends)[:, None] / parts * np.arange(parts)
    return [float(x) for x in (ends[:-1, None] + steps).ravel()[1:]]


def _listed(key: Ints, value: Ints, size: int) -> Ints:
    """(r, size): the values of each key, -1 as filling."""
    order = np.argsort(key, kind="stable")
    key, value = key[order], value[order]
    count = np.bincount(key, minlength=size)
    found = np.full((int(count.max(initial=0)), size), -1)
    found[np.arange(len(key)) - (np.cumsum(count) - count)[key], key] = value
    return found
