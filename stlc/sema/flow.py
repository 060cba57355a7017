"""Discrete matrices back to the continuous ones whose zero-order hold they are."""

from __future__ import annotations

import warnings

import numpy as np

from stlc.dynamics import Flow
from stlc.matrices import exponential, logarithm

_EDGE = 1e-9  # relative: an eigenvalue this near to the negative axis has no real logarithm
_DUST = 1e-13  # relative: rounding errors of a matrix logarithm


def held_flow(given: Flow, dt: float) -> Flow | None:
    """The flow whose zero-order hold over dt [s] are the discrete matrices `given`.

    The principal logarithm: of all flows through the samples the one that turns by less than half
    a circle in a step. None where A is singular or has a negative eigenvalue.
    """
    n, m = given.B.shape
    if not all(np.isfinite(matrix).all() for matrix in (given.A, given.B, given.drift)):
        return None
    values = np.linalg.eigvals(given.A)
    size = float(np.abs(values).max())
    if ((np.abs(values.imag) <= _EDGE * size) & (values.real <= _EDGE * size)).any():
        return None
    discrete = np.eye(n + m + 1)
    discrete[:n] = np.column_stack([given.A, given.B, given.drift])
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # its accuracy is judged below
            found = logarithm(discrete)
            again = None if found is None else exponential(found)
    except ValueError:  # scipy's word for entries that overflow on the way
        return None
    if found is None or again is None or not np.allclose(again, discrete, 1e-9, 1e-12):
        return None
    rates = found[:n] / dt
    rates[np.abs(rates) <= _DUST * np.abs(rates).max()] = 0.0
    return Flow(rates[:, :n], rates[:, n : n + m], rates[:, n + m])
