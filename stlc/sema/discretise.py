"""Continuous dynamics with inputs held over a step, exactly."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats
from stlc.matrices import exponential
from stlc.sema.number_errors import NotFinite
from stlc.sema.report import Mistake
from stlc.source import Span

Matrices = tuple[Floats, Floats, Floats]


def discretised(a: Floats, b: Floats, drift: Floats, dt: float, name: str, span: Span) -> Matrices:
    """A, B and drift of one step. Raises Mistake where they overflow."""
    held = zero_order_hold(a, b, drift, dt)
    if all(np.isfinite(matrix).all() for matrix in held):
        return held
    growth = float(np.linalg.eigvals(a * dt).real.max())
    raise Mistake(NotFinite(span=span, name=name, growth=growth))


def zero_order_hold(a: Floats, b: Floats, drift: Floats, dt: float) -> Matrices:
    """Exact discretisation for inputs constant over a step: expm of the augmented matrix.

    Not finite where that overflows.
    """
    n, m = b.shape
    augmented = np.zeros((n + m + 1, n + m + 1))
    augmented[:n] = np.column_stack([a, b, drift])
    with np.errstate(over="ignore", invalid="ignore"):
        discrete = exponential(augmented * dt)
    return discrete[:n, :n], discrete[:n, n : n + m], discrete[:n, n + m]
