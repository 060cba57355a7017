"""Exponential and logarithm of matrices, without loading SciPy where the series ends by itself.

Integrators, the commonest dynamics, have nilpotent matrices: N^k = 0 for some k <= n, so

    exp(N) = sum_{j<k} N^j / j!        log(I + N) = sum_{0<j<k} (-1)^(j+1) N^j / j

are finite sums. SciPy's linear algebra takes longer to load than such a mission to check.
"""

from __future__ import annotations

import warnings

import numpy as np

from stlc.arrays import Floats


def exponential(matrix: Floats) -> Floats:
    """exp(matrix), (n, n); not finite where it overflows."""
    powers = _powers(matrix)
    if powers is None:
        if not np.isfinite(matrix).all():
            return np.full_like(matrix, np.nan)
        from scipy.linalg import expm

        with np.errstate(all="ignore"):
            return np.asarray(expm(matrix), dtype=np.float64)
    found, factor = np.eye(len(matrix)), 1.0
    for j, power in enumerate(powers, start=1):
        factor /= j
        found = found + factor * power
    return found


def logarithm(matrix: Floats) -> Floats | None:
    """The principal logarithm of matrix, (n, n), where it is real; None where it isn't.

    ValueError where entries overflow on the way.
    """
    powers = _powers(matrix - np.eye(len(matrix)))
    if powers is not None:
        terms = [(-1.0) ** (j + 1) / j * power for j, power in enumerate(powers, start=1)]
        return np.asarray(np.sum([np.zeros_like(matrix), *terms], axis=0))
    from scipy.linalg import logm

    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # nearly singular: whoever asks looks at what comes out
        found = np.asarray(logm(matrix))
    if np.iscomplexobj(found) and np.abs(found.imag).max() > _IMAGINARY:
        return None
    return np.asarray(found.real, dtype=np.float64)


_IMAGINARY = 1e-9  # of a real logarithm: rounding


@np.errstate(over="ignore", invalid="ignore")
def _powers(matrix: Floats) -> list[Floats] | None:
    """Powers 1, 2, ... of a matrix before they vanish exactly; None where they don't."""
    found: list[Floats] = []
    power = matrix
    for _ in range(len(matrix)):
        if not power.any():
            return found
        found.append(power)
        power = power @ matrix
    return None if power.any() else found
