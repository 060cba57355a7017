"""Exact dynamic programming of one agent on a lattice of controls, the others held fixed.

Controls are multiples of a part of the greatest one, so every lattice run is an admissible run of
the integrators. Requirements that the problem does not know are not looked at, so a run is only a
reference: the MILP near it decides what it is worth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Axis, Body, Problem, Singles

MOST_STATES = 1_500_000
_INF = np.float32(np.inf)
EDGE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class AxisLattice:
    """positions (n,), rates (k,); start indices; moves: (rate from, rate to, shift, control)."""

    positions: Floats
    rates: Floats
    start: tuple[int, int]
    moves: tuple[tuple[int, int, int, float], ...]


def axis_lattice(axis: Axis, parts: int, low: float, high: float, tight: float) -> AxisLattice:
    """The lattice of one axis; rates at most `tight` times the greatest."""
    most = tight * float(np.abs(axis.box[1:, 2:]).max())
    if axis.speed is None:
        unit = most / max(1, parts)
        reach = parts
        moves = tuple((0, 0, s, s * unit) for s in range(-reach, reach + 1))
        positions, at = _positions(axis.start[0], unit, low, high)
        return AxisLattice(positions, np.zeros(1), (at, 0), moves)
    step = axis.jump / parts
    reach = int(np.floor(most / step + EDGE))
    rates = np.asarray(np.arange(-reach, reach + 1) * step, dtype=np.float64)
    positions, at = _positions(axis.start[0], step / 2, low, high)
    moves = tuple(
        (a, b, a + b - 2 * reach, (b - a) * step)
        for a in range(len(rates))
        for b in range(max(0, a - parts), min(len(rates), a + parts + 1))
    )
    return AxisLattice(positions, rates, (at, int(np.argmin(np.abs(rates - axis.start[1])))), moves)


def _positions(start: float, unit: float, low: float, high: float) -> tuple[Floats, int]:
    below, above = int((start - low) / unit + EDGE), int((high - start) / unit + EDGE)
    return np.asarray(start + np.arange(-below, above + 1) * unit, dtype=np.float64), below


def lattice(problem: Problem, body: Body) -> tuple[AxisLattice, AxisLattice] | None:
    """Lattices of both axes, as fine as fits; None where an axis moves in another way."""
    if any(a.speed is not None and abs(a.blend - 0.5) > EDGE for a in body.axes):
        return None
    tight = 0.7 if len(body.faces) and body.axes[0].speed is None else 1.0
    for parts in (2, 1):
        pair = tuple(
            axis_lattice(a, parts if a.speed is not None else 4 * parts, e[0], e[-1], tight)
            for a, e in zip(body.axes, problem.edges, strict=True)
        )
        if 2 * np.prod([len(v) for a in pair for v in (a.positions, a.rates)]) <= MOST_STATES:
            return pair[0], pair[1]
    return None


def _axis_step(f: Singles, axis: Axis, grid: AxisLattice, t: int, stride: int) -> Singles:
    """Least over the moves of one axis; f (its rates, the other's, points), where points next to
    each other along the axis stand `stride` apart."""
    out = np.full(f.shape, _INF, np.float32)
    size, room = f.shape[2], np.empty(f.shape[1:], np.float32)
    for a, b, s, control in grid.moves:
        low, high = max(0, s * stride), max(0, -s * stride)
        if low + high >= size:
            continue
        found, into = room[:, : size - low - high], out[b, :, low : size - high]
        np.add(f[a, :, high : size - low], _weight(axis, grid, t, b, control), out=found)
        np.minimum(into, found, out=into)
    return out


def _weight(axis: Axis, grid: AxisLattice, t: int, rate: int, control: float) -> np.float32:
    """Cost of a move to a rate."""
    if axis.speed is None:
        return np.float32(axis.rate_cost[t + 1] * abs(control))
    return np.float32(
        axis.rate_cost[t + 1] * abs(grid.rates[rate]) + axis.change_cost[t] * abs(control)
    )


Ways = tuple[Singles | None, Singles | None]
"""Least costs (x rates, y rates, points) with the choice over time ahead, and with it behind;
None where there is no such run."""


@dataclass(frozen=True, slots=True, eq=False)
class Lone:
    """One agent on its lattice: stage (T+1, nx, ny) costs, inf where it may not be.

    The points (i, j) of the lattice are numbered i * width + j, with room for the longest move
    behind each line of them, so that all moves are shifts of one long array.
    """

    problem: Problem
    body: Body
    grids: tuple[AxisLattice, AxisLattice]
    stage: Singles

    @property
    def _width(self) -> int:
        y = self.grids[1]
        return len(y.positions) + max(abs(s) for _, _, s, _ in y.moves)

    def best(self) -> tuple[float, Floats] | None:
        """Value and positions (T+1, 2) of the cheapest run, or None if there is none."""
        runs, slow = [self._start()], self._slow()
        padding = ((0, 0), (0, 0), (0, self._width - self.stage.shape[2]))
        stage = np.pad(self.stage, padding, constant_values=_INF).reshape(len(self.stage), -1)
        for t in range(self.problem.steps):
            moved = [f if f is None else self._moved(t, f, stage[t + 1] + slow) for f in runs[-1]]
            runs.append(self._chosen(t + 1, moved[0], moved[1]))
        last = runs[-1][1]
        if last is None:
            return None
        k = np.unravel_index(int(np.argmin(last)), last.shape)
        value = float(last[k])
        return (value, self._trace(runs, *(int(i) for i in k))) if value < np.inf else None

    def _start(self) -> Ways:
        x, y = self.grids
        points = len(x.positions) * self._width
        f = np.full((len(x.rates), len(y.rates), points), _INF, np.float32)
        f[x.start[1], y.start[1], x.start[0] * self._width + y.start[0]] = 0
        return (f, None) if self.body.places else (None, f)

    def _moved(self, t: int, f: Singles, stage: Singles) -> Singles:
        x, y = self.grids
        f = _axis_step(f, self.body.axes[0], x, t, self._width)
        f = _axis_step(f.swapaxes(0, 1), self.body.axes[1], y, t, 1).swapaxes(0, 1)
        f += stage
        return f

    def _chosen(self, t: int, ahead: Singles | None, behind: Singles | None) -> Ways:
        """With the choice made at t, too; after its last step it can no longer be ahead."""
        inside = self._inside(t)
        if ahead is not None and inside is not None:
            taken = np.where(inside, ahead, _INF)
            behind = taken if behind is None else np.minimum(behind, taken)
        return (ahead if any(p.step > t for p in self.body.places) else None, behind)

    def _slow(self) -> Singles:
        """0 where both rates keep to the speed polygon, else inf."""
        v, w = self.grids[0].rates, self.grids[1].rates
        fine = np.ones((len(v), len(w)), bool)
        for nx, ny, c in self.body.faces:
            fine &= nx * v[:, None] + ny * w[None] <= c + EDGE
        return np.where(fine, np.float32(0), _INF)[:, :, None]

    def _inside(self, t: int) -> Bools | None:
        """Points in an alternative of step t; None where it has none."""
        boxes = [p.box for p in self.body.places if p.step == t]
        if not boxes:
            return None
        out = np.zeros((len(self.grids[0].positions), self._width), bool)
        for box in boxes:
            x, y = (between(g.positions, s) for g, s in zip(self.grids, box, strict=True))
            out[:, : len(y)] |= np.logical_and.outer(x, y)
        return out.ravel()

    def _trace(self, runs: list[Ways], rx: int, ry: int, point: int) -> Floats:
        """Positions of the run that ends in a state with the choice behind."""
        (x, y), width, bit = self.grids, self._width, 1
        out = np.empty((len(runs), 2))
        for t in range(len(runs) - 1, -1, -1):
            i, j = divmod(point, width)
            out[t] = x.positions[i], y.positions[j]
            if t == 0:
                break
            inside = self._inside(t)
            bits = (0, 1) if bit == 1 and inside is not None and inside[point] else (bit,)
            ways = [_before(g, axis, t - 1, p, r) for g, axis, p, r in
                    ((x, self.body.axes[0], i, rx), (y, self.body.axes[1], j, ry))]  # fmt: skip
            (pi, ra, wa), (pj, rb, wb) = ways
            points, costs, best = pi[:, None] * width + pj, wa[:, None] + wb, np.inf
            for flag in bits:
                f = runs[t - 1][flag]
                if f is None:
                    continue
                value = f[ra[:, None], rb, points] + costs
                k = np.unravel_index(int(np.argmin(value)), value.shape)
                if value[k] < best:
                    best, bit = float(value[k]), flag
                    rx, ry, point = int(ra[k[0]]), int(rb[k[1]]), int(points[k])
        return out


def _before(grid: AxisLattice, axis: Axis, t: int, p: int, rate: int) -> tuple[Ints, Ints, Floats]:
    """Positions, rates and costs of the moves that end in (p, rate)."""
    found = [
        (p - s, a, float(_weight(axis, grid, t, b, control)))
        for a, b, s, control in grid.moves
        if b == rate and 0 <= p - s < len(grid.positions)
    ]
    positions, rates, costs = zip(*found, strict=True)
    return np.array(positions), np.array(rates), np.array(costs)


def between(values: Floats, span: Floats) -> Bools:
    """Which values lie within a closed span (2,), up to EDGE."""
    return np.asarray((values >= span[0] - EDGE) & (values <= span[1] + EDGE))
