"""Covers a set of index tuples by few boxes, exactly: every box lies within the set.

The smallest cover is NP-hard (Culberson & Reckhow 1994). This is a greedy one: boxes grow from
uncovered seeds, one interval at a time towards whichever side covers most that is still open
(counted in summed-area tables, all seeds at once); the best few are taken, and at the end boxes
that the others make superfluous are dropped.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from stlc.arrays import Bools, Ints

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
        grown = _grow(inside, _summed(open_), _seeds(open_))
        for box in _best(grown, open_):
            found.append(box)
            open_[_slices(box)] = False
        if len(found) > 2 * most:
            return None
    boxes = _needed(found, allowed.shape)
    return boxes if len(boxes) <= most else None


def clipped(boxes: Ints, first: Ints, shape: tuple[int, ...]) -> Ints:
    """Boxes cut to the window that starts at `first` (d,), counted from there.

    Of equal boxes one is kept; boxes within another are dropped.
    """
    low = np.maximum(boxes[:, 0::2] - first, 0)
    high = np.minimum(boxes[:, 1::2] - first, np.array(shape) - 1)
    meets = (low <= high).all(axis=1)
    cut = np.stack([low[meets], high[meets]], axis=2).reshape(-1, 2 * len(shape))
    cut = np.unique(cut, axis=0)
    within = np.ones((len(cut), len(cut)), bool)
    for column in range(cut.shape[1]):
        mine, theirs = cut[:, None, column], cut[None, :, column]
        within &= theirs <= mine if column % 2 == 0 else theirs >= mine
    np.fill_diagonal(within, False)
    return np.asarray(cut[~within.any(axis=1)])


def _seeds(open_: Bools) -> Ints:
    """Up to SEEDS open tuples (S, d), evenly spread in index order."""
    flat = np.flatnonzero(open_)
    chosen = flat[np.linspace(0, len(flat) - 1, min(SEEDS, len(flat))).astype(np.int64)]
    return np.stack(np.unravel_index(chosen, open_.shape), axis=1).astype(np.int64)


def _grow(inside: Ints, open_: Ints, seeds: Ints) -> Ints:
    """Boxes (S, 2 d) grown to maximal ones within the set."""
    axes = seeds.shape[1]
    shape = np.array(inside.shape) - 1
    sides, growing = np.arange(2 * axes), np.arange(len(seeds))
    corners = np.stack([seeds, seeds + 1], axis=2)  # (S, d, 2): half-open low and high
    outwards = np.zeros((2 * axes, axes, 2), np.int64)
    outwards[sides, sides // 2, sides % 2] = np.where(sides % 2, 1, -1)
    while len(growing):
        wider = corners[growing] + outwards[:, None]
        fits = np.all((wider[..., 0] >= 0) & (wider[..., 1] <= shape), axis=2)
        wider = wider[fits]
        full = _count(inside, wider) == np.prod(wider[..., 1] - wider[..., 0], axis=1)
        fits[fits] = full
        gains = np.full(fits.shape, -1)
        gains[fits] = _count(open_, wider[full])
        side = gains.argmax(axis=0)
        grows = gains.max(axis=0) >= 0
        growing = growing[grows]
        corners[growing] += outwards[side[grows]]
    corners[:, :, 1] -= 1
    return corners.reshape(len(seeds), -1)


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


def _summed(mask: Bools) -> Ints:
    """Summed-area table, one longer on every axis."""
    table = np.pad(mask.astype(np.int64), [(1, 0)] * mask.ndim)
    for axis in range(mask.ndim):
        table = table.cumsum(axis=axis)
    return table


def _count(summed: Ints, corners: Ints) -> Ints:
    """Members within half-open boxes (..., d, 2), by inclusion and exclusion."""
    axes = summed.ndim
    strides = np.array(summed.strides) // summed.itemsize
    flat = corners * strides[:, None]
    index = flat[..., 0, :]
    for axis in range(1, axes):
        index = (index[..., :, None] + flat[..., axis, None, :]).reshape(
            *index.shape[:-1], 2 << axis
        )
    return np.asarray(summed.ravel()[index] @ _signs(axes))


@cache
def _signs(axes: int) -> Ints:
    """(2^d,): 1 for corners with an even number of low ends, else -1."""
    signs = np.array([1], np.int64)
    for _ in range(axes):
        signs = np.kron(signs, np.array([-1, 1]))
    return signs


def _slices(box: Ints) -> tuple[slice, ...]:
    return tuple(slice(int(a), int(b) + 1) for a, b in zip(box[0::2], box[1::2], strict=True))
