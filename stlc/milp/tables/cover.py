"""Covers a set of index tuples by few boxes, exactly: every box lies within the set.

The smallest cover is NP-hard (Culberson & Reckhow 1994). This is a greedy one: boxes grow from
uncovered seeds, one interval at a time towards whichever side covers most that is still open
(counted in summed-area tables, all seeds at once); the best few are taken, and at the end boxes
that the others make superfluous are dropped.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from stlc.milp.model import Floats, Ints

Bools = NDArray[np.bool_]

SEEDS = 48
"""Boxes grown at once in a round."""


def cover(allowed: Bools, most: int) -> Ints | None:
    """Boxes (K, 2 d), first and last index (inclusive) on each axis, whose union is `allowed`.

    allowed has d axes. None when the greedy cover passes `most` boxes.
    """
    open_ = allowed.copy()
    inside = _summed(allowed)
    found: list[Ints] = []
    while open_.any():
        grown = _grow(inside, _summed(open_), _seeds(open_), allowed.shape)
        for box in _best(grown, open_):
            found.append(box)
            open_[_slices(box)] = False
        if len(found) > 2 * most:
            return None
    boxes = _needed(found, allowed.shape)
    return boxes if len(boxes) <= most else None


def _seeds(open_: Bools) -> Ints:
    """Up to SEEDS open tuples (S, d), evenly spread in index order."""
    flat = np.flatnonzero(open_)
    chosen = flat[np.linspace(0, len(flat) - 1, min(SEEDS, len(flat))).astype(np.int64)]
    return np.stack(np.unravel_index(chosen, open_.shape), axis=1).astype(np.int64)


def _grow(inside: Floats, open_: Floats, seeds: Ints, shape: tuple[int, ...]) -> Ints:
    """Boxes (S, 2 d) grown to maximal ones within the set."""
    low, high = seeds.copy(), seeds.copy()
    axes = len(shape)
    every = np.arange(len(seeds))
    alive = np.ones(len(seeds), bool)
    while alive.any():
        gains = np.full((2 * axes, len(seeds)), -1.0)
        for side in range(2 * axes):
            new_low, new_high = _extended(low, high, side)
            fits = alive & (new_low >= 0).all(axis=1) & (new_high < shape).all(axis=1)
            a, b = new_low[fits], new_high[fits]
            full = _count(inside, a, b) == np.prod(b - a + 1, axis=1)
            gains[side, every[fits][full]] = _count(open_, a[full], b[full])
        side_of = gains.argmax(axis=0)
        alive = gains[side_of, every] >= 0
        axis = side_of // 2
        low[every, axis] -= alive & (side_of % 2 == 0)
        high[every, axis] += alive & (side_of % 2 == 1)
    return _boxes(low, high)


def _extended(low: Ints, high: Ints, side: int) -> tuple[Ints, Ints]:
    """The boxes one longer towards the lower (even side) or upper end of axis side // 2."""
    new_low, new_high = low.copy(), high.copy()
    if side % 2 == 0:
        new_low[:, side // 2] -= 1
    else:
        new_high[:, side // 2] += 1
    return new_low, new_high


def _best(grown: Ints, open_: Bools) -> list[Ints]:
    """Of the grown boxes those, taken in turn, that open at least half as much as the best."""
    gains = np.array([np.count_nonzero(open_[_slices(b)]) for b in grown])
    rest = open_.copy()
    chosen = []
    for number in np.argsort(-gains, kind="stable"):
        window = rest[_slices(grown[number])]
        if 2 * np.count_nonzero(window) >= gains.max():
            window[...] = False
            chosen.append(grown[number])
    return chosen


def _needed(found: list[Ints], shape: tuple[int, ...]) -> Ints:
    """Drop, smallest first, every box whose tuples are all in other boxes."""
    times = np.zeros(shape, np.int64)
    for box in found:
        times[_slices(box)] += 1
    kept = []
    for box in sorted(found, key=lambda b: float(np.prod(b[1::2] - b[0::2] + 1))):
        window = times[_slices(box)]
        if (window > 1).all():
            window -= 1
        else:
            kept.append(box)
    return np.array(kept, np.int64).reshape(len(kept), 2 * len(shape))


def _summed(mask: Bools) -> Floats:
    """Summed-area table, one longer on every axis."""
    table = np.pad(mask.astype(np.float64), [(1, 0)] * mask.ndim)
    for axis in range(mask.ndim):
        table = table.cumsum(axis=axis)
    return table


def _count(summed: Floats, low: Ints, high: Ints) -> Floats:
    """Members within the boxes low .. high (S, d), by inclusion and exclusion."""
    total = np.zeros(len(low))
    corners = (high + 1, low)
    for choice in product((0, 1), repeat=low.shape[1]):
        index = tuple(corners[c][:, axis] for axis, c in enumerate(choice))
        total += (-1.0) ** sum(choice) * summed[index]
    return total


def _boxes(low: Ints, high: Ints) -> Ints:
    return np.stack([low, high], axis=2).reshape(len(low), -1)


def _slices(box: Ints) -> tuple[slice, ...]:
    return tuple(slice(int(a), int(b) + 1) for a, b in zip(box[0::2], box[1::2], strict=True))
