"""Cover a set of allowed cell pairs on grids by few boxes.

A box is a product of index intervals [ix0, ix1] x [iy0, iy1] for each end. The cover is exact:
the union of its boxes is the allowed set, no disallowed pair is ever included. Boxes may
overlap, as a disjunction lets them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools
from stlc.radio.errors import RadioError


@dataclass(frozen=True, slots=True)
class IndexBox:
    """Inclusive index intervals: (first, last) along x and y of end a, then of end b."""

    intervals: tuple[tuple[int, int], ...]

    @property
    def slices(self) -> tuple[slice, ...]:
        """Slices that select the box from a tensor over the same axes."""
        return tuple(slice(low, high + 1) for low, high in self.intervals)

    def size(self) -> int:
        """How many cell tuples the box holds."""
        return int(np.prod([high - low + 1 for low, high in self.intervals]))


def cover_pairs(
    allowed: Bools, shape_a: tuple[int, int], shape_b: tuple[int, int] | None
) -> tuple[IndexBox, ...]:
    """Boxes whose union is `allowed` (na, nb); cells numbered ix * ny + iy; shape_b None: station.

    Greedy: from an uncovered pair the box grows until no side can move; several seeds and
    orders of growth compete for the most newly covered pairs. Boxes made redundant by later
    ones are dropped. Raises RadioError when the shapes do not fit.
    """
    shape = shape_a if shape_b is None else (*shape_a, *shape_b)
    if allowed.size != int(np.prod(shape)):
        raise RadioError(f"{allowed.size} cell pairs do not fit grids of shape {shape}")
    tensor = np.ascontiguousarray(allowed).reshape(shape)
    left = tensor.copy()
    boxes: list[IndexBox] = []
    while left.any():
        best = max(_candidates(tensor, left), key=lambda box: int(left[box.slices].sum()))
        left[best.slices] = False
        boxes.append(best)
    return _irredundant(tensor, boxes)


def _candidates(tensor: Bools, left: Bools) -> list[IndexBox]:
    """Grown boxes from a few uncovered seeds, with several orders of growth."""
    places = np.flatnonzero(left.ravel())
    picks = places[np.unique(np.linspace(0, len(places) - 1, 5).astype(np.intp))]
    axes = range(tensor.ndim)
    orders = [tuple(axes), tuple(reversed(axes)), tuple(sorted(axes, key=lambda k: k % 2))]
    seeds = [tuple(int(i) for i in np.unravel_index(p, tensor.shape)) for p in picks]
    greedy = [_grow_evenly(tensor, seed) for seed in seeds]
    return greedy + [_grow(tensor, seed, order) for seed in seeds for order in orders]


def _grow(tensor: Bools, seed: tuple[int, ...], order: tuple[int, ...]) -> IndexBox:
    """Stretch axis after axis as far as the box stays allowed."""
    box = [[i, i] for i in seed]
    for axis in order:
        while _can_move(tensor, box, axis, -1):
            box[axis][0] -= 1
        while _can_move(tensor, box, axis, 1):
            box[axis][1] += 1
    return _freeze(box)


def _grow_evenly(tensor: Bools, seed: tuple[int, ...]) -> IndexBox:
    """Move every side by one cell in turn until none can move."""
    box = [[i, i] for i in seed]
    moved = True
    while moved:
        moved = False
        for axis in range(tensor.ndim):
            for step, side in ((-1, 0), (1, 1)):
                if _can_move(tensor, box, axis, step):
                    box[axis][side] += step
                    moved = True
    return _freeze(box)


def _can_move(tensor: Bools, box: list[list[int]], axis: int, step: int) -> bool:
    """True when the next layer along `axis` exists and is allowed throughout."""
    layer = box[axis][0] - 1 if step < 0 else box[axis][1] + 1
    if not 0 <= layer < tensor.shape[axis]:
        return False
    where = [slice(low, high + 1) for low, high in box]
    where[axis] = slice(layer, layer + 1)
    return bool(tensor[tuple(where)].all())


def _freeze(box: list[list[int]]) -> IndexBox:
    return IndexBox(tuple((low, high) for low, high in box))


def _irredundant(tensor: Bools, boxes: list[IndexBox]) -> tuple[IndexBox, ...]:
    """Drop boxes whose pairs the others hold, smallest first."""
    count = np.zeros(tensor.shape, dtype=np.int32)
    for box in boxes:
        count[box.slices] += 1
    kept = list(boxes)
    for box in sorted(boxes, key=IndexBox.size):
        if (count[box.slices] > 1).all():
            count[box.slices] -= 1
            kept.remove(box)
    return tuple(kept)
