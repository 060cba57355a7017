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


_MOST = 1_000  # legs at once, of 1 kB each for all corners: they stay near the processor
_SIGNS = np.array([1.0, 1.0, -1.0, -1.0])  # of the prices of p_0, w_0, p_k, w_k


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """Corners of legs of `steps` steps: (A, B) = gain (n, 2, 4) prices + shift (n, 2); `met`
    (n, 4): prices that are met there.

    Linear in the prices like them: what p_0, w_0, p_k, w_k count with, `weights` (4 * n, 4 + 1), 0
    where their price is met, and A + B s at both ends of the polygon, `sides` (2 * n, 4 + 1).
    """

    steps: int
    price: float
    gain: Floats
    shift: Floats
    met: Bools
    weights: Floats
    sides: Floats

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
        gain, shift, met = np.array(gains), np.array(shifts), np.array(mets)
        turn = np.array([[0.0, -1.0], [-1.0, -k], [0.0, 1.0], [1.0, 0.0]])  # of A, B
        ends = np.array([[1.0, blend], [1.0, k - 1 + blend]])
        weights = _affine(turn, gain, shift)
        weights[:, :4] += np.repeat(np.diag(_SIGNS), len(gain), axis=0)
        weights[met.T.ravel()] = 0.0
        return Corners(steps, price, gain, shift, met, weights, _affine(ends, gain, shift))

    def least(self, prices: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """Least costs (e,) of legs under prices (e, 4: p_0, w_0, p_k, w_k) between boxes (e, 4),
        and their derivatives by the prices (e, 4)."""
        blocks = [slice(k, k + _MOST) for k in range(0, max(len(prices), 1), _MOST)]
        parts = [self._least(prices[own], low[own], high[own]) for own in blocks]
        return np.concatenate([v for v, _ in parts]), np.concatenate([d for _, d in parts])

    def _least(self, prices: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """`least` of so many legs that every corner of each is looked at at once."""
        many = np.concatenate([prices.T, np.ones((1, len(prices)))])
        factor = (self.weights @ many).reshape(4, -1, len(prices))
        side = np.abs(self.sides @ many).reshape(2, -1, len(prices))
        value = sum(np.minimum(f * u, f * v) for f, u, v in zip(factor, low.T, high.T, strict=True))
        value = np.where((side > self.price * (1 + _TOUCH)).any(axis=0), -np.inf, value)
        which, rows = value.argmax(axis=0), np.arange(len(prices))
        best = factor[:, which, rows].T
        return value[which, rows], self._derivatives(best, low, high, which)

    def _derivatives(self, factor: Floats, low: Floats, high: Floats, which: Ints) -> Floats:
        """Those of the cost by the prices (e, 4), at the corner `which` (e,) with its factors
        (e, 4)."""
        ends = np.where(self.met[which], 0.0, np.where(factor > 0, low, high))
        turned = np.stack([
            ends[:, 3] - ends[:, 1], ends[:, 2] - ends[:, 0] - self.steps * ends[:, 1]
        ], axis=1)  # fmt: skip
        return np.asarray(ends * _SIGNS + np.einsum("eij,ei->ej", self.gain[which], turned))


def _affine(turn: Floats, gain: Floats, shift: Floats) -> Floats:
    """turn (m, 2) times (A, B) at all corners n, as a matrix (m * n, 4 + 1) of prices and 1."""
    linear = np.einsum("mi,nij->mnj", turn, gain).reshape(-1, 4)
    return np.column_stack([linear, (turn @ shift.T).reshape(-1)])
