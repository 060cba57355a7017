"""Least values of conditions on Euclidean lengths along a motion.

On a piece of a step every component of a length is a quadratic p_i(s), so that a number is

    F(s) = r(s) + sum of c |p(s)|,   (c |p|)'' <= c |p'|^2 / |p| + |c| |p''|,

the first of these for c > 0 only. Over a part [a, b] of the piece, F is at least the lesser of its
values at both ends less (b - a)^2 / 8 of that bound, and at least what it is with every |p|
between that of the chord and of its ends. Parts whose bound is below the least value seen are
halved until none is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

GAP = 1e-7
"""How far a value may be below the true one, in the unit of the condition: requirements are judged
to within 1e-6. Two lengths that cancel take some thousand parts of a step to that."""

MOST = 400_000
"""Parts looked at together at most; what is left then is worth its bound."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """r(s) + sum of c |p(s)| over pieces: `rest` (3, rows) are coefficients of 1, s and s^2, as
    are those of each length's components (3, rows, d)."""

    rest: Array
    lengths: tuple[tuple[float, Array], ...] = ()

    def at(self, rows: Rows, s: Array) -> Array:
        """Its value (K,) on each of some pieces at its own time."""
        sizes = [c * np.linalg.norm(_at(p, rows, s), axis=-1) for c, p in self.lengths]
        return np.asarray(sum(sizes, _at(self.rest, rows, s)))

    def floor(self, rows: Rows, a: Array, b: Array) -> Array:
        """What it is at least (K,) over [a, b] of each of some pieces."""
        share = (b - a) ** 2 / 8.0
        bend = 2.0 * self.rest[2, rows]
        ends = [_at(self.rest, rows, s) for s in (a, b)]
        crude = np.minimum(*ends) - share * np.maximum(bend, 0.0)
        for c, p in self.lengths:
            first, last = _at(p, rows, a), _at(p, rows, b)
            sizes = [np.linalg.norm(end, axis=-1) for end in (first, last)]
            ends = [end + c * size for end, size in zip(ends, sizes, strict=True)]
            pull = 2.0 * np.linalg.norm(p[2, rows], axis=-1)
            least = np.maximum(_chord(first, last) - share * pull, 0.0)
            crude += c * (least if c > 0.0 else np.maximum(*sizes) + share * pull)
            bend += abs(c) * pull
            if c > 0.0:
                bend += c * _stretch(p, rows, (a, b), least)
        smooth = np.minimum(*ends) - share * np.maximum(bend, 0.0)
        return np.asarray(np.maximum(crude, smooth))


def least(curves: Sequence[Curve], combine: Callable[[Array], Array], rows: int) -> Array:
    """The least value (rows,) over s in [0, 1] of a combination that rises with each curve's
    value, or less by at most GAP."""
    found, seen = np.full(rows, np.inf), np.full(rows, np.inf)
    row: Rows = np.arange(rows)
    a: Array = np.zeros(rows)
    b: Array = np.ones(rows)
    while len(row):
        for s in (a, b):
            values = combine(np.stack([c.at(row, s) for c in curves], axis=-1))
            np.minimum.at(seen, row, values)
        bound = combine(np.stack([c.floor(row, a, b) for c in curves], axis=-1))
        middle = 0.5 * (a + b)
        done = (bound >= seen[row] - GAP) | (middle <= a) | (middle >= b) | (len(row) > MOST)
        np.minimum.at(found, row[done], bound[done])
        row, a, b, middle = row[~done], a[~done], b[~done], middle[~done]
        row, a, b = np.tile(row, 2), np.concatenate([a, middle]), np.concatenate([middle, b])
    return np.asarray(np.minimum(found, seen))


def _at(parts: Array, rows: Rows, s: Array) -> Array:
    """c0 + c1 s + c2 s^2 of some rows, each at its own s."""
    c0, c1, c2 = (c[rows] for c in parts)
    s = s.reshape(-1, *[1] * (c0.ndim - 1))
    return np.asarray(c0 + s * (c1 + s * c2))


def _chord(first: Array, last: Array) -> Array:
    """How far from the origin the straight line between two points (K, d) is at least (K,)."""
    way = last - first
    square = (way * way).sum(axis=-1)
    share = -(first * way).sum(axis=-1) / np.where(square > 0.0, square, 1.0)
    nearest = first + np.clip(share, 0.0, 1.0)[:, None] * way
    return np.asarray(np.linalg.norm(nearest, axis=-1))


def _stretch(p: Array, rows: Rows, ends: tuple[Array, Array], nearest: Array) -> Array:
    """|p'|^2 / |p| at most (K,): p' is linear, so that it is longest at an end."""
    slopes = np.stack([p[1], 2.0 * p[2], np.zeros_like(p[2])])
    fastest = np.maximum(*((_at(slopes, rows, s) ** 2).sum(axis=-1) for s in ends))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(fastest > 0.0, fastest / nearest, 0.0)
