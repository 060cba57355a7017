"""How far disturbed agents may be off at all times: what each push has become, as it moves on.

Within a step e' = A e + B (K e(t) + w): the part of a push that is e at a step's start moves as a
state that starts there and has the input K e, and that of the push itself starts at 0 and has
the input w. On each piece of a step the part is a parabola with Bezier points P_0, P_1, P_2, so
that

    |f . e(s)| <= sum over k of b_k(s) sum over parts of |f . P_k|

for every row f, with Bernstein's polynomials b_k: exact where no part changes its sign, and never
more than what half widths of states and inputs at the steps say.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.dynamics import Dynamics
from stlc.mission import Agent

Array = NDArray[np.float64]
Quadratic = tuple[Array, Array, Array]


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """What pushes are where a step starts, by their age in steps: states (ages, n, m), and the
    inputs (ages, m, m) that they have within it; the push of that step is the first."""

    states: Array
    inputs: Array

    @classmethod
    def of(cls, agent: Agent, ages: int) -> Parts:
        """Those of a disturbed agent, each push as large as it gets."""
        assert agent.tube is not None
        A, B, K = agent.dynamics.A, agent.dynamics.B, agent.tube.gain
        part = B * agent.tube.bound
        states, inputs = [np.zeros_like(part)], [np.diag(agent.tube.bound)]
        for _ in range(ages):
            states.append(part)
            inputs.append(K @ part)
            part = (A + B @ K) @ part
        return cls(np.array(states), np.array(inputs))

    def moves(self) -> tuple[Array, Array, Array]:
        """Each as a step of its own: from (K, n), to (K, n) [straight], input (K, m)."""
        each = np.moveaxis(self.states, 2, 1)
        inputs = np.moveaxis(self.inputs, 2, 1)[:-1]
        n, m = self.states.shape[1:]
        return each[:-1].reshape(-1, n), each[1:].reshape(-1, n), inputs.reshape(-1, m)


@dataclass(frozen=True, slots=True, eq=False)
class Sway:
    """Bezier points (ages, pieces, 3, d, pushes) of d values of an agent that pushes put off, over
    the steps from `past` on; at the last step it stays as it is there."""

    points: Array
    past: int

    @classmethod
    def of(cls, model: Dynamics, parts: Parts, ends: Array, past: int) -> Sway:
        """From the starts, middles and ends (K, 2 pieces + 1, n) of what `Parts.moves` says; the
        inputs are values behind the states."""
        n, m = model.B.shape
        first, middle, last = ends[:, :-2:2], ends[:, 1::2], ends[:, 2::2]
        bezier = np.stack([first, 2.0 * middle - 0.5 * (first + last), last], axis=2)
        ages, pieces = len(parts.states) - 1, bezier.shape[1]
        states = np.moveaxis(bezier.reshape(ages, m, pieces, 3, n), 1, 4)
        inputs = np.broadcast_to(parts.inputs[:-1, None, None], (ages, pieces, 3, m, m))
        return cls(np.concatenate([states, inputs], axis=3), past)

    def mapped(self, rows: Array) -> Sway:
        """That of rows @ values, for rows that may speak of the first values only."""
        kept = self.points[..., : rows.shape[1], :]
        return replace(self, points=np.einsum("fd,akcdm->akcfm", rows, kept))

    def support(self, rows: Array) -> Array:
        """(3, (T + 1) * pieces, F): the most that rows (F, d) @ values may be off, at each Bezier
        point of each piece of each step."""
        sizes = np.abs(self.mapped(rows).points).sum(axis=-1)
        ages, pieces, _, width = sizes.shape
        ahead = np.cumsum(sizes, axis=0).reshape(ages * pieces, 3, width)
        last = ahead[-1:, 2:] if ages else np.zeros((1, 1, width))
        rest = np.broadcast_to(last, (pieces, 3, width))
        still = np.zeros((self.past * pieces, 3, width))
        return np.moveaxis(np.concatenate([still, ahead, rest]), 1, 0)

    def generators(self, step: int, piece: int) -> Array:
        """(3, d, pushes): Bezier points of all parts that there are within a step."""
        ages, _, _, width, _ = self.points.shape
        if step < self.past or not ages:
            return np.zeros((3, width, 1))
        count = min(step - self.past + 1, ages)
        if step - self.past < ages:
            parts = self.points[:count, piece]
        else:
            parts = np.repeat(self.points[:, -1, 2:], 3, axis=1)
        return np.moveaxis(parts, 0, 3).reshape(3, width, -1)


def quadratic(points: Array) -> Quadratic:
    """Coefficients of 1, s and s^2 of what has Bezier points (3, ..)."""
    first, middle, last = points
    return first, 2.0 * (middle - first), first - 2.0 * middle + last
