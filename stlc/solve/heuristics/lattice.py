"""A lattice of the runs of a double integrator, one axis at a time.

    p' = p + h v + g u,   v' = v + b u,   u in {-U, ..., U} in equal parts

Rates are multiples of b U / parts, positions of the part of a step that one such change makes, so
every lattice run is a run of the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stlc.analysis.ranges import Ranges
from stlc.arrays import Floats
from stlc.mission import Agent

Words = npt.NDArray[np.unsignedinteger[Any]]

_EDGE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """Columns of position and rate; points (n,), rates (k,); moves: (rate, next rate, shift)."""

    position: int
    rate: int
    points: Floats
    rates: Floats
    start: tuple[int, int]
    moves: tuple[tuple[int, int, int], ...]


def axis_lattice(agent: Agent, ranges: Ranges, k: int, parts: int, tight: float) -> Axis | None:
    """The lattice of one axis, None where it is no double integrator."""
    model = agent.dynamics
    if model.position is None or not len(ranges.input_lower):
        return None
    used = np.flatnonzero(model.position[k])
    if len(used) != 1:
        return None
    p = int(used[0])
    others = [int(j) for j in np.flatnonzero(model.A[p]) if j != p]
    if len(others) != 1 or model.drift.any():
        return None
    v = others[0]
    pushes = np.flatnonzero(model.B[v])
    plain = np.array_equal(np.flatnonzero(model.A[v]), [v]) and model.A[v, v] == model.A[p, p] == 1
    if len(pushes) != 1 or not plain:
        return None
    u = int(pushes[0])
    if np.delete(model.B[p], u).any():
        return None
    most = min(-float(ranges.input_lower[:, u].min()), float(ranges.input_upper[:, u].max()))
    if not 0 < most < np.inf:
        return None
    push = tight * most / parts
    spans = [(float(ranges.state_lower[:, i].min()), float(ranges.state_upper[:, i].max()))
             for i in (p, v)]  # fmt: skip
    change, glide, kick = (abs(model.B[v, u]) * push, model.A[p, v], model.B[p, u])
    return _moves(
        agent, (p, v), spans, parts, (change, glide, kick * push * np.sign(model.B[v, u]))
    )


def _moves(
    agent: Agent,
    columns: tuple[int, int],
    spans: Sequence[tuple[float, float]],
    parts: int,
    step: tuple[float, float, float],
) -> Axis | None:
    """The lattice of an axis whose rate changes by whole parts of the input bound; None where a
    step is no whole number of spacings."""
    change, glide, kick = step
    unit = abs(kick) if kick else abs(glide * change)
    if not np.isfinite(spans).all() or unit <= 0:
        return None
    points, i = _multiples(float(agent.start[columns[0]]), unit, spans[0])
    rates, a = _multiples(float(agent.start[columns[1]]), change, spans[1])
    found = []
    for turn in sorted(range(-parts, parts + 1), key=abs):
        for one in range(max(0, -turn), min(len(rates), len(rates) - turn)):
            shift = (glide * rates[one] + turn * kick) / unit
            if abs(shift - round(shift)) > 1e-6:
                return None
            found.append((one, one + turn, round(shift)))
    return Axis(*columns, points, rates, (i, a), tuple(found))


def _multiples(start: float, unit: float, span: tuple[float, float]) -> tuple[Floats, int]:
    below = max(0, int((start - span[0]) / unit + _EDGE))
    above = max(0, int((span[1] - start) / unit + _EDGE))
    return np.asarray(start + np.arange(-below, above + 1) * unit, dtype=float), below


def origins(axis: Axis, point: int, rate: int) -> list[tuple[int, int]]:
    """(rate, point) indices one step before `point` at `rate`."""
    return [
        (one, point - shift)
        for one, to, shift in axis.moves
        if to == rate and 0 <= point - shift < len(axis.points)
    ]


def moved(f: Words, axis: Axis, at: int) -> Words:
    """One step of one axis of words joined by `or`; its positions are dimension `at`, its rates the
    next."""
    g = np.moveaxis(f, (at, at + 1), (0, 1))
    out, n = np.zeros_like(g), len(g)
    for one, to, s in axis.moves:
        if abs(s) < n:
            out[max(0, s) : n + min(0, s), to] |= g[max(0, -s) : n - max(0, s), one]
    return np.ascontiguousarray(np.moveaxis(out, (0, 1), (at, at + 1)))
