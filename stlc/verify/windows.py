"""Sliding extrema and until over arrays of robustness, by steps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def window_min(values: Array, start: int, end: int | None) -> Array:
    """min of values[t + start .. t + end]; `end` None reaches to the last value.

    values (L, ..); returns (max(L - end, 0), ..), or (max(L - start, 0), ..) for an unbounded
    window.
    """
    if end is None:
        return np.minimum.accumulate(values[::-1])[::-1][start:]
    if len(values) <= end:
        return values[:0]
    out, width, wanted = values[start:], 1, end - start + 1
    while 2 * width <= wanted:
        out = np.minimum(out[:-width], out[width:])
        width *= 2
    rest = wanted - width
    return np.minimum(out[: len(out) - rest], out[rest:])


def until(left: Array, right: Array, start: int, end: int | None) -> Array:
    """max over t' in [t+start, t+end] of min(right[t'], min(left[t..t'])): the paper's reading.

    left, right (L, ..), cut to the shorter one; returns as many steps as `window_min` would.
    """
    left, right = left[: len(right)], right[: len(left)]
    held = _until_any(left, right)[start:]
    if start:
        held = np.minimum(held, window_min(left, 0, start))
    if end is None:
        return held
    seen = -window_min(-right, start, end)
    return np.minimum(held[: len(seen)], seen)


def _until_any(left: Array, right: Array) -> Array:
    """Unbounded until from each step: u(t) = min(left(t), max(right(t), u(t+1)))."""
    out = np.minimum(left, right)
    steps = range(len(out) - 1, -1, -1)
    for later, step in pairwise(steps):
        out[step] = np.minimum(left[step], np.maximum(right[step], out[later]))
    return out
