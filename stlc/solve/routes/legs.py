"""What it costs an axis at the least to get from one visit to the next, under prices of the ends.

Along an axis p' = p + (1 - b) w + b w' (`relaxation/problem.py`), and each change of the rate costs
c |w' - w|. Over k steps, whatever A and B with |A + B s| <= c at s = b and at s = k - 1 + b,

    c sum |w' - w|  >=  A (w_k - w_0) + B (p_k - p_0 - k w_0),

and the best A and B make it an equality where nothing else bounds the changes. With prices a, b on
p and w at both ends the least of it all over boxes of the ends is a concave function of A and B
with corners where a price is met or the polygon ends: the best of these corners is the best at all.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from stlc.arrays import Bools, Floats, Ints

_PARALLEL = 1e-12
_TOUCH = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """Corners of legs of `steps` steps: (A, B) = gain (n, 2, 4) prices + shift (n, 2); `met`
    (n, 4): prices that are met there."""

    steps: int
    blend: float
    price: float
    gain: Floats
    shift: Floats
    met: Bools

    @staticmethod
    def of(steps: int, blend: float, price: float) -> Corners:
        """All pairs of lines that cross."""
        k = float(steps)
        sides = [(1.0, s, -1, sign * price) for s in (blend, k - 1 + blend) for sign in (-1, 1)]
        lines = [(0.0, 1.0, 0, 0.0), (1.0, k, 1, 0.0), (0.0, 1.0, 2, 0.0), (1.0, 0.0, 3, 0.0)]
        gains, shifts, mets = [], [], []
        for pair in combinations([*lines, *sides], 2):
            left = np.array([line[:2] for line in pair])
            if abs(np.linalg.det(left)) < _PARALLEL:
                continue
            inverse = np.linalg.inv(left)
            right, met = np.zeros((2, 4)), np.zeros(4, bool)
            for row, line in zip(right, pair, strict=True):
                if line[2] >= 0:
                    row[line[2]] = 1.0
                    met[line[2]] = True
            gains.append(inverse @ right)
            shifts.append(inverse @ np.array([line[3] for line in pair]))
            mets.append(met)
        return Corners(steps, blend, price, np.array(gains), np.array(shifts), np.array(mets))

    def least(self, prices: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """Least costs (e,) of legs under prices (e, 4: p_0, w_0, p_k, w_k) between boxes (e, 4),
        and their derivatives by the prices (e, 4)."""
        best, which = np.full(len(prices), -np.inf), np.zeros(len(prices), np.int64)
        for n in range(len(self.gain)):
            at = prices @ self.gain[n].T + self.shift[n]
            factor = self._factors(prices, at, self.met[n])
            value = np.minimum(factor * low, factor * high).sum(axis=1)
            value[~self._allowed(at)] = -np.inf
            better = value > best
            best, which = np.where(better, value, best), np.where(better, n, which)
        return best, self._derivatives(prices, low, high, which)

    def _allowed(self, at: Floats) -> Bools:
        fine = np.ones(len(at), bool)
        for s in (self.blend, self.steps - 1 + self.blend):
            fine &= np.abs(at[:, 0] + at[:, 1] * s) <= self.price * (1 + _TOUCH)
        return fine

    def _factors(self, prices: Floats, at: Floats, met: Bools) -> Floats:
        """What p_0, w_0, p_k, w_k count with: 0 where their price is met."""
        a, b = at.T
        rates = np.stack([-b, -a - self.steps * b, b, a], axis=1)
        return np.where(met, 0.0, rates + prices * np.array([1.0, 1.0, -1.0, -1.0]))

    def _derivatives(self, prices: Floats, low: Floats, high: Floats, which: Ints) -> Floats:
        at = np.einsum("eij,ej->ei", self.gain[which], prices) + self.shift[which]
        met = self.met[which]
        factor = self._factors(prices, at, met)
        ends = np.where(met, 0.0, np.where(factor > 0, low, high))
        turned = np.stack([
            ends[:, 3] - ends[:, 1], ends[:, 2] - ends[:, 0] - self.steps * ends[:, 1]
        ], axis=1)  # fmt: skip
        direct = ends * np.array([1.0, 1.0, -1.0, -1.0])
        return np.asarray(direct + np.einsum("eij,ei->ej", self.gain[which], turned))
