"""Guides: exact dynamic programming of one agent on a lattice of controls, the others held fixed.

Controls are multiples of a part of the greatest one, so every lattice run is an admissible run of
the integrators. Requirements that the problem does not know are not looked at, so a run is only a
guide: the MILP near it decides what it is worth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.solve.links.problem import Axis, Body, Bools, Floats, Ints, Problem, Singles

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


def _axis_step(f: Singles, axis: Axis, grid: AxisLattice, t: int, at: int) -> Singles:
    """Least over the moves of one axis; positions at dimension `at`, rates behind them."""
    g = np.moveaxis(f, (at, at + 1), (0, 1))
    out = np.full_like(g, _INF)
    n = len(g)
    for a, b, s, control in grid.moves:
        if abs(s) >= n:
            continue
        rate = control if axis.speed is None else grid.rates[b]
        turn = 0.0 if axis.speed is None else abs(control)
        weight = np.float32(axis.dear[t + 1] * abs(rate) + axis.turn[t] * turn)
        into = out[max(0, s) : n + min(0, s), b]
        np.minimum(into, g[max(0, -s) : n - max(0, s), a] + weight, out=into)
    return np.moveaxis(out, (0, 1), (at, at + 1))


@dataclass(frozen=True, slots=True, eq=False)
class Lone:
    """One agent on its lattice: stage (T+1, nx, ny) costs, inf where it may not be."""

    problem: Problem
    body: Body
    grids: tuple[AxisLattice, AxisLattice]
    stage: Singles

    def best(self) -> tuple[float, Floats] | None:
        """Value and positions (T+1, 2) of the cheapest run, or None if there is none."""
        x, y = self.grids
        f = np.full((2, *(len(v) for g in (x, y) for v in (g.positions, g.rates))), _INF)
        bit = 0 if self.body.places else 1
        f[(bit, *x.start, *y.start)] = 0
        runs = [f.astype(np.float32)]
        slow = self._slow()
        for t in range(self.problem.steps):
            f = _axis_step(runs[-1], self.body.axes[0], x, t, 1)
            f = _axis_step(f, self.body.axes[1], y, t, 3)
            f += self.stage[t + 1][None, :, None, :, None]
            f += slow
            for into in self._inside(t + 1):
                into = into[:, None, :, None]
                f[1] = np.where(into, np.minimum(f[1], f[0]), f[1])
            runs.append(f)
        last = runs[-1][1]
        k = np.unravel_index(int(np.argmin(last)), last.shape)
        value = float(last[k])
        return (value, self._trace(runs, tuple(int(i) for i in k))) if value < np.inf else None

    def _slow(self) -> Singles:
        """0 where both rates keep to the speed polygon, else inf."""
        v, w = self.grids[0].rates, self.grids[1].rates
        fine = np.ones((len(v), len(w)), bool)
        for nx, ny, c in self.body.faces:
            fine &= nx * v[:, None] + ny * w[None] <= c + EDGE
        return np.where(fine, np.float32(0), _INF)[None, None, :, None, :]

    def _inside(self, t: int) -> list[Bools]:
        return [
            np.logical_and.outer(
                *(between(g.positions, s) for g, s in zip(self.grids, p.box, strict=True))
            )
            for p in self.body.places
            if p.step == t
        ]

    def _trace(self, runs: list[Singles], at: tuple[int, ...]) -> Floats:
        """Positions of the run that ends in state `at` with the choice behind."""
        x, y = self.grids
        out, state = np.empty((len(runs), 2)), (1, *at)
        for t in range(len(runs) - 1, -1, -1):
            bit, i, a, j, b = state
            out[t] = x.positions[i], y.positions[j]
            if t == 0:
                break
            bits = [bit]
            if bit == 1 and any(into[i, j] for into in self._inside(t)):
                bits = [0, 1]
            ways = [_before(g, axis, t - 1, p, r) for g, axis, p, r in
                    ((x, self.body.axes[0], i, a), (y, self.body.axes[1], j, b))]  # fmt: skip
            (pi, ra, wa), (pj, rb, wb) = ways
            costs = wa[:, None] + wb[None]
            best = np.inf
            for flag in bits:
                value = runs[t - 1][flag][pi[:, None], ra[:, None], pj[None], rb[None]] + costs
                k = np.unravel_index(int(np.argmin(value)), value.shape)
                if value[k] < best:
                    best = float(value[k])
                    state = (flag, int(pi[k[0]]), int(ra[k[0]]), int(pj[k[1]]), int(rb[k[1]]))
        return out


def _before(grid: AxisLattice, axis: Axis, t: int, p: int, rate: int) -> tuple[Ints, Ints, Floats]:
    """Positions, rates and costs of the moves that end in (p, rate)."""
    found = []
    for a, b, s, control in grid.moves:
        if b == rate and 0 <= p - s < len(grid.positions):
            w = control if axis.speed is None else grid.rates[b]
            turn = 0.0 if axis.speed is None else abs(control)
            found.append((p - s, a, axis.dear[t + 1] * abs(w) + axis.turn[t] * turn))
    positions, rates, costs = zip(*found, strict=True)
    return np.array(positions), np.array(rates), np.array(costs)


def between(values: Floats, span: Floats) -> Bools:
    return np.asarray((values >= span[0] - EDGE) & (values <= span[1] + EDGE))
