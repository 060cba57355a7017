"""What the relaxation knows of a mission: agents as integrators along each axis, link costs.

Along an axis an agent has a position p [m] and a rate w [m a step], and moves by

    p' = p + (1 - blend) w + blend w',    |w' - w| <= jump

A double integrator has blend 1/2 (w is its velocity times the step); a single integrator blend 1
(w is what its input does in a step) and no limit on w' - w. Everything else that a mission asks
is left to the MILP: leaving it out only lowers bounds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.arrays import Floats, Ints

Singles = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """One axis of an agent. `state` and `speed` are its columns in the agent's state; `speed` is
    None for a single integrator. w = gain * speed.

    start (p, w); box (T+1, 4): p_lo, p_hi, w_lo, w_hi at each step; rate_cost (T+1,)
    and change_cost (T,): cost of |w_t| and of |w_{t+1} - w_t|, not negative.
    """

    state: int
    speed: int | None
    gain: float
    start: tuple[float, float]
    blend: float
    jump: float
    box: Floats
    rate_cost: Floats
    change_cost: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """An alternative of a choice over time: in `box` (2, 2: axis, low and high) at `step`."""

    column: int
    step: int
    box: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """An agent. `faces` (k, 3): n_x, n_y, c with n.w <= c at steps 1..T.

    avoid[t]: lists of alternative boxes (2, 2), the position at t lies in one of each list.
    `places`: exactly one alternative is taken (its literals add up to 1).
    """

    name: str
    axes: tuple[Axis, Axis]
    faces: Floats
    avoid: Mapping[int, tuple[tuple[Floats, ...], ...]]
    places: tuple[Place, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Apart:
    """One row of `ways` (k, 5) holds at `step`: a_x, a_y, b_x, b_y, c with
    a.p_first + b.p_second >= c. Used by the search for plans only."""

    first: int
    second: int
    step: int
    ways: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Agents on the cells of one grid; cells number ix * ny + iy.

    pairs[i, j][t] is (n, n) or None, alone[i][t] (n,) or None: link costs at step t = 0..T.
    `rest` is a lower bound on the part of the objective that no pair counts: what stands nowhere
    here, and the own costs of agents in no pair. `owner` (n,) maps a cell to the partition's own
    cell, -1 where there is none. `costly`: links have a cost; otherwise they are only asked for.
    `borders`: those between cells are cells too (see `borders.py`), `owner` is 0 throughout.
    """

    steps: int
    edges: tuple[Floats, Floats]
    bodies: tuple[Body, ...]
    pairs: Mapping[tuple[int, int], tuple[Floats | None, ...]]
    alone: tuple[tuple[Floats | None, ...], ...]
    rest: float
    owner: Ints
    key: bytes
    apart: tuple[Apart, ...] = ()
    costly: bool = True
    borders: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along x and y, borders counted where they are cells of their own."""
        nx, ny = (len(e) - 1 for e in self.edges)
        return (2 * nx - 1, 2 * ny - 1) if self.borders else (nx, ny)

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]
