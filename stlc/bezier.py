"""Bezier points of the motion from one step to the next, linear in x(t), u(t) and 1.

With the input constant, a state moves on E(s) (x, u, 1), E(s) the first rows of exp(M s) and
M = [[A, B, drift], [0, 0, 0]]. A step is cut into equal parts; on each, the entries of E are
interpolated by polynomials of degree d at Chebyshev-Lobatto points, whose error is at most
max |E^(d+1)| (h/2)^(d+1) 2^(1-d) / (d+1)! with |E^(d+1)| <= |M^(d+1) E(s0)| exp(|M| h) entry by
entry (Trefethen, Approximation Theory and Approximation Practice, ch. 8). The least d is taken
whose error is below rounding's reach; a polynomial motion (integrators) is met exactly. The curve
lies in the convex hull of its Bezier points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import ceil, comb, factorial

import numpy as np

from stlc.arrays import Floats
from stlc.dynamics import Dynamics, Flow
from stlc.matrices import exponential

MOST_PARTS = 16
"""A part spans one radian, or one time constant, of the fastest mode; twice that at most."""
MOST_DEGREE = 14
"""Enough for two time constants a part; beyond, Bezier points lose digits to cancellation."""
_ERROR = 1e-8  # of a coefficient, relative to its change in a step: below solvers' tolerances
_DUST = 1e-13


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """States over a step: `starts[k]` (n, n + m + 1) maps (x, u, 1) to the start of part k;
    `starts[parts]` is the next sample. `matrix` is M, or None for a straight line."""

    starts: Floats
    matrix: Floats | None
    step: float
    _degrees: dict[tuple[int, ...] | None, int | None] = field(default_factory=dict, repr=False)

    @property
    def parts(self) -> int:
        """Equal parts of the step."""
        return len(self.starts) - 1

    def degree(self, states: Sequence[int] | None = None) -> int | None:
        """Least degree at which the motion of some states is met on every part; None: too fast."""
        key = None if states is None else tuple(states)
        if key not in self._degrees:
            rows = slice(None) if states is None else list(states)
            found = (d for d in range(1, MOST_DEGREE + 1) if self._meets(d, rows))
            self._degrees[key] = next(found, None)
        return self._degrees[key]

    def _meets(self, degree: int, rows: slice | list[int]) -> bool:
        """Whether the series cut at this degree is near enough in these rows: by its remainder,
        against the motion's own size."""
        if self.matrix is None:
            return True
        h, n = self.step / self.parts, self.starts.shape[1]
        power = np.linalg.matrix_power(self.matrix, degree + 1)[:n]
        factor = (h / 2) ** (degree + 1) * 2.0 ** (1 - degree) / factorial(degree + 1)
        grown = exponential(np.abs(self.matrix) * h)
        error = factor * np.max([np.abs(power @ _square(s)) @ grown for s in self.starts[:-1]], 0)
        change = np.max(np.abs(self.starts[1:] - self.starts[:-1]), axis=0)
        allowed = np.maximum(_ERROR * change, 1e-15 * np.abs(self.starts).max())
        return bool((error[rows] <= allowed[rows]).all())

    def points(self, degree: int) -> Floats:
        """Bezier points (parts, degree + 1, n, n + m + 1)."""
        return _points(self, degree)

    def part(self, k: int, degree: int) -> Floats:
        """Bezier points (degree + 1, n, n + m + 1) of one part."""
        first, last = self.starts[k], self.starts[k + 1]
        if self.matrix is None or degree == 1:
            share = np.linspace(0.0, 1.0, degree + 1)[:, None, None]
            return np.asarray((1.0 - share) * first + share * last)
        h = self.step / self.parts
        if degree == 2:
            middle = first + h / 2.0 * (self.matrix[: len(first)] @ _square(first))
            return np.stack([first, middle, last])
        share = (1.0 - np.cos(np.pi * np.arange(degree + 1) / degree)) / 2.0
        values = [first @ exponential(self.matrix * h * s) for s in share[1:-1]]
        basis = np.array([[comb(degree, j) * s**j * (1 - s) ** (degree - j)
                           for j in range(degree + 1)] for s in share])  # fmt: skip
        stacked = np.stack([first, *values, last])
        return np.linalg.solve(basis, stacked.reshape(degree + 1, -1)).reshape(stacked.shape)


@lru_cache(maxsize=256)
def _points(found: Curve, degree: int) -> Floats:
    points = np.stack([found.part(k, degree) for k in range(found.parts)])
    points[np.abs(points) <= _DUST * np.abs(found.starts).max(axis=0)] = 0.0
    return points


@lru_cache(maxsize=256)
def curve(dynamics: Dynamics, step: float, parts: int | None = None) -> Curve | None:
    """The motion of some dynamics within a step [s], in as many parts as it needs (or is asked
    for); None where it isn't known."""
    n, m = dynamics.B.shape
    here, there = np.eye(n, n + m + 1), np.column_stack([dynamics.A, dynamics.B, dynamics.drift])
    if dynamics.flow is None:
        if not dynamics.straight:
            return None
        shares = np.linspace(0.0, 1.0, (parts or 1) + 1)
        return Curve(np.stack([(1 - s) * here + s * there for s in shares]), None, step)
    matrix = augmented(dynamics.flow)
    count = parts or least_parts(matrix, step)
    one, starts = exponential(matrix * step / count), [here]
    for _ in range(count - 1):
        starts.append(starts[-1] @ one)
    return Curve(np.stack([*starts, there]), matrix, step)


def augmented(flow: Flow) -> Floats:
    """M (n + m + 1, n + m + 1): d/dt of (x, u, 1)."""
    n, m = flow.B.shape
    matrix = np.zeros((n + m + 1, n + m + 1))
    matrix[:n] = np.column_stack([flow.A, flow.B, flow.drift])
    return matrix


def least_parts(matrix: Floats, step: float) -> int:
    """Parts of a step such that each spans about one radian or time constant."""
    rate = float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0)) * step
    return min(MOST_PARTS, max(1, ceil(rate - 1e-6)))


def _square(rows: Floats) -> Floats:
    """(x, u, 1) at some time, from that at the step's start."""
    n, size = rows.shape
    return np.vstack([rows, np.eye(size)[n:]])
