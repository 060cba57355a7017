"""Extrema of slacks over the motion between samples.

Slacks of faces along a path (`paths.py`) are quadratic in time on each piece, and a minimum or
maximum of quadratics has its extrema at their ends, vertices and intersections, so nothing is
sampled here. What a path may be off by is taken off, so a value is never above the true one; the
paths of integrators are exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from stlc.places import Polytope
from stlc.verify.paths import Path

Array = NDArray[np.float64]
Combine = Callable[[Array], Array]

CHUNK = 2_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Extremum:
    """Least value over each step's motion (T+1,) and where in [0, 1] it is taken (T+1,)."""

    value: Array
    where: Array


def inside(path: Path, piece: Polytope) -> Extremum:
    """min over time of the least distance to a face's line, negative beyond it."""
    return behind(path, piece.normals, piece.offsets)


def behind(path: Path, normals: Array, offsets: Array) -> Extremum:
    """min over time of the least offset - normal @ place, of faces (F, width) and (F,)."""
    slacks = (offsets - path.c0 @ normals.T, -(path.c1 @ normals.T), -(path.c2 @ normals.T))
    q0, q1, q2 = (q - off for q, off in zip(slacks, path.swayed(normals), strict=True))
    return by_step(path, extremum(q0, q1, q2, lambda q: q.min(axis=-1)))


def separation(relative: Path, distances: tuple[float, ...]) -> Extremum:
    """min over time of max(|dx| - distances[0], |dy| - distances[1], ..)."""
    signs = np.repeat(np.eye(len(distances)), 2, axis=0)
    signs[1::2] *= -1.0
    far = np.repeat(np.asarray(distances, dtype=np.float64), 2)
    parts = [c @ signs.T for c in (relative.c0, relative.c1, relative.c2)]
    parts = [q - off for q, off in zip(parts, relative.swayed(signs), strict=True)]
    found = extremum(parts[0] - far, parts[1], parts[2], lambda q: q.max(axis=-1))
    return by_step(relative, found)


def distance(relative: Path) -> Extremum:
    """Least Euclidean distance of each step: 33 samples of each piece, the best one refined by
    Newton's method.

    The square is a quartic; the value is that of a point of the path, so never too small for it,
    less what disturbances may make of it.
    """
    a, b, c = relative.c2, relative.c1, relative.c0
    samples = np.tile(np.linspace(0.0, 1.0, 33), (len(relative.c0), 1))
    s = _least(_length(relative, samples), samples).where
    for _ in range(4):
        p, v = c + s[:, None] * (b + s[:, None] * a), b + 2.0 * s[:, None] * a
        slope, bend = (p * v).sum(axis=1), (v * v + 2.0 * p * a).sum(axis=1)
        convex = np.where(bend > 1e-12, bend, np.inf)
        s = np.clip(s - slope / convex, 0.0, 1.0)
    refined = np.column_stack([samples, s])
    reach = relative.reach.max(axis=0)
    found = _least(_length(relative, refined), refined)
    return by_step(relative, Extremum(found.value - reach, found.where))


def by_step(path: Path, found: Extremum) -> Extremum:
    """The least over the pieces of each step, less what the path may be off by."""
    value = (found.value - path.room).reshape(-1, path.pieces)
    where = (np.arange(path.pieces) + found.where.reshape(-1, path.pieces)) / path.pieces
    return _least(value, where)


def _length(path: Path, where: Array) -> Array:
    """Distance from the origin (rows, K) at `where` (rows, K)."""
    s = where[:, :, None]
    place = path.c0[:, None] + s * (path.c1[:, None] + s * path.c2[:, None])
    return np.asarray(np.linalg.norm(place, axis=2), dtype=np.float64)


def extremum(q0: Array, q1: Array, q2: Array, combine: Combine) -> Extremum:
    """min over s in [0, 1] of combine(q0 + q1 s + q2 s^2), a lattice polynomial of the faces."""
    count = q0.shape[1]
    size = max(1, CHUNK // max(count * (2 + count + count * (count - 1)), 1))
    parts = [
        _extremum_block(q0[i : i + size], q1[i : i + size], q2[i : i + size], combine)
        for i in range(0, len(q0), size)
    ]
    return Extremum(*(np.concatenate(side) for side in zip(*parts, strict=True)))


def _extremum_block(q0: Array, q1: Array, q2: Array, combine: Combine) -> tuple[Array, Array]:
    """Least value and its time (each (rows,)) of `combine` over quadratics q0 + q1 s + q2 s^2, s in
    [0, 1]: it lies at an end, a vertex or a crossing of two of them."""
    pairs = np.array(list(combinations(range(q0.shape[1]), 2)), dtype=np.intp).reshape(-1, 2)
    i, j = pairs.T
    ends = np.tile([0.0, 1.0], (len(q0), 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        vertices = -q1 / (2.0 * q2)
        crossings = _roots(q0[:, i] - q0[:, j], q1[:, i] - q1[:, j], q2[:, i] - q2[:, j])
    where = np.concatenate([ends, vertices, *crossings], axis=1)
    where = np.clip(np.nan_to_num(where, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    s = where[:, :, None]
    least = _least(combine(q0[:, None] + s * (q1[:, None] + s * q2[:, None])), where)
    return least.value, least.where


def _least(values: Array, where: Array) -> Extremum:
    column = np.argmin(values, axis=1)
    rows = np.arange(len(values))
    return Extremum(values[rows, column], where[rows, column])


def _roots(c: Array, b: Array, a: Array) -> tuple[Array, Array]:
    """Roots of a s^2 + b s + c without cancellation; not finite where there is none."""
    root = np.sqrt(np.where(b * b >= 4 * a * c, b * b - 4 * a * c, np.nan))
    half = -0.5 * (b + np.where(b >= 0, root, -root))
    return half / a, c / half
