"""Random linear dynamics of a body in the plane, by matrices."""

from __future__ import annotations

import numpy as np

from truth.scene import Array, Model

Rows = tuple[tuple[float, ...], ...]


def drawn_model(rng: np.random.Generator, continuous: bool) -> Model:
    """Drag, rotation, springs, an actuator's lag, drift; states in any order."""
    kind = int(rng.integers(0, 4))
    a, b, c = _continuous(rng, kind)
    if not continuous:
        a, b, c = _discrete(rng)
    order = rng.permutation(len(a))
    a, b, c = a[np.ix_(order, order)], b[order], c[order]
    where = np.argsort(order)
    return Model(
        "matrices", _rows(a), _rows(b), tuple(c.tolist()) if c.any() else (), continuous,
        (int(where[0]), int(where[1])), (int(where[2]), int(where[3])),
    )  # fmt: skip


def _continuous(rng: np.random.Generator, kind: int) -> tuple[Array, Array, Array]:
    drag, spin = round(float(rng.uniform(0, 1.2)), 2), 0.0
    size = 6 if kind == 3 else 4
    a, b, c = np.zeros((size, size)), np.zeros((size, 2)), np.zeros(size)
    a[0, 2] = a[1, 3] = 1.0
    match kind:
        case 1:
            spin = round(float(rng.uniform(0.3, 1.5)), 2)
        case 2:
            a[2, 0] = a[3, 1] = -0.1
            c[2] = c[3] = 0.5
    a[2:4, 2:4] += [[-drag, -spin], [spin, -drag]]
    if kind == 3:  # thrust follows the input with a lag
        a[2, 4] = a[3, 5] = 1.0
        a[4, 4] = a[5, 5] = -2.0
        b[4, 0] = b[5, 1] = 2.0
    else:
        b[2, 0] = b[3, 1] = 1.0
        c[:2] = np.round(rng.uniform(-0.2, 0.2, 2), 2) * int(rng.integers(0, 2))
    return a, b, c


def _discrete(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    keep, reach = round(float(rng.uniform(0.7, 1.0)), 2), round(float(rng.uniform(0.4, 1.0)), 2)
    a, b = np.eye(4), np.zeros((4, 2))
    a[0, 2] = a[1, 3] = reach
    a[2, 2] = a[3, 3] = keep
    a[2, 3], a[3, 2] = -0.1, 0.1
    b[2, 0] = b[3, 1] = reach
    return a, b, np.zeros(4)


def _rows(matrix: Array) -> Rows:
    return tuple(tuple(float(v) for v in row) for row in matrix)
