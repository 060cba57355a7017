"""What measurements add to the path loss: a weighted sum of kernels, a reduced variance.

For centres c_1..c_M every posterior used here has the form
    mean(y)     = m(y) + k(y, c) w
    variance(y) = sigma_k^2 - |R k(c, y)|^2
Exact conditioning (paper, eq. (3) and (5)): c are the samples, w = (C + D)^-1 (z - m),
R = L^-1 with L L' = C + D. Inducing points (FITC; Snelson and Ghahramani, 2006): c are M
chosen links, E = D + diag(C_ff - C_fu C_uu^-1 C_uf), B = C_uu + C_uf E^-1 C_fu,
w = B^-1 C_uf E^-1 (z - m), R'R = C_uu^-1 - B^-1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import KernelError
from stlc.radio.kernel import KernelName, correlation

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

JITTER = 1e-8

SMALL = 300
"""Up to this many centres a general solver is faster than the import of a triangular one."""


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """centres (M, 2 D) [m]; weights (M,); factor (r, M): see the module's formulas.

    samples: how many measurements it stands for; exact: False for inducing points.
    """

    centres: Array
    weights: Array
    factor: Array
    samples: int
    exact: bool


def cholesky(matrix: Array, what: str) -> Array:
    """Lower Cholesky factor; raises KernelError naming `what` when there is none."""
    try:
        return np.asarray(np.linalg.cholesky(matrix), dtype=np.float64)
    except np.linalg.LinAlgError as error:
        raise KernelError(
            f"{what} is not positive definite; give a fading variance above zero, "
            "or use kernel = symmetrised"
        ) from error


def solve_lower(lower: Array, right: Array) -> Array:
    """lower^-1 right for a lower triangular matrix."""
    if len(lower) <= SMALL:
        return np.asarray(np.linalg.solve(lower, right), dtype=np.float64)
    from scipy.linalg import solve_triangular

    return np.asarray(
        solve_triangular(lower, right, lower=True, check_finite=False), dtype=np.float64
    )


def exact_posterior(
    links: Array, residual: Array, noise: Array, sigma_k2: float, length: float, kernel: KernelName
) -> Posterior:
    """Condition on K links with residuals z - m (K,) [dB] and noise variances (K,) [dB^2]."""
    covariance = sigma_k2 * correlation(links, links, length, kernel)
    covariance[np.diag_indices_from(covariance)] += noise + JITTER * sigma_k2
    lower = cholesky(covariance, "the covariance of the samples")
    factor = solve_lower(lower, np.eye(len(links)))
    return Posterior(links, factor.T @ (factor @ residual), factor, len(links), True)


def with_more(
    known: Posterior,
    links: Array,
    residual: Array,
    noise: Array,
    sigma_k2: float,
    length: float,
    kernel: KernelName,
) -> Posterior:
    """Condition a posterior on K more links: a step of block elimination.

    With G = R k(c, y) the links' covariance given what is known is S = k(y, y) + noise - G'G, and

        L L' = S,   R+ = [[R, 0], [-L^-1 G' R, L^-1]],   w+ = (w - R' G v, v),
        v = S^-1 (residual - k(y, c) w).
    """
    cross = sigma_k2 * correlation(known.centres, links, length, kernel)
    reduced = known.factor @ cross
    covariance = sigma_k2 * correlation(links, links, length, kernel) - reduced.T @ reduced
    covariance[np.diag_indices_from(covariance)] += noise + JITTER * sigma_k2
    inverse = solve_lower(cholesky(covariance, "the covariance of the samples"), np.eye(len(links)))
    more = inverse.T @ (inverse @ (residual - cross.T @ known.weights))
    back = known.factor.T @ reduced
    rows = len(known.factor)
    factor = np.zeros((rows + len(links), len(known.centres) + len(links)))
    factor[:rows, : len(known.centres)] = known.factor
    factor[rows:, : len(known.centres)] = -inverse @ back.T
    factor[rows:, len(known.centres) :] = inverse
    return Posterior(
        np.vstack([known.centres, links]), np.concatenate([known.weights - back @ more, more]),
        factor, known.samples + len(links), known.exact,
    )  # fmt: skip


def inducing_posterior(
    centres: Array,
    links: Array,
    residual: Array,
    noise: Array,
    sigma_k2: float,
    length: float,
    kernel: KernelName,
) -> Posterior:
    """Condition on K links through M centres; O(K M^2) time, O(M^2 + K) memory."""
    prior = sigma_k2 * correlation(centres, centres, length, kernel)
    prior[np.diag_indices_from(prior)] += JITTER * sigma_k2
    lower = cholesky(prior, "the covariance of the inducing links")
    gram = np.eye(len(centres))
    moment = np.zeros(len(centres))
    for start in range(0, len(links), 2048):
        rows = slice(start, start + 2048)
        cross = sigma_k2 * correlation(centres, links[rows], length, kernel)
        half = solve_lower(lower, cross)
        missed = np.maximum(sigma_k2 - np.einsum("ij,ij->j", half, half), 0.0)
        scale = np.sqrt(noise[rows] + missed)
        half /= scale
        gram += half @ half.T
        moment += half @ (residual[rows] / scale)
    value, vector = np.linalg.eigh(gram)
    inverse = solve_lower(lower, np.eye(len(centres)))
    weights = inverse.T @ (vector @ ((vector.T @ moment) / value))
    shrink = np.sqrt(np.maximum(1.0 - 1.0 / value, 0.0))
    return Posterior(centres, weights, shrink[:, None] * (vector.T @ inverse), len(links), False)


def choose_centres(
    links: Array, length: float, kernel: KernelName, most: int, tolerance: float = 0.01
) -> Ints:
    """Rows chosen greedily by pivoted Cholesky, until no link keeps more than `tolerance` of
    its variance, or `most` are chosen (Fine and Scheinberg, 2001). O(K M^2)."""
    left = np.ones(len(links))
    basis = np.zeros((min(most, len(links)), len(links)))
    chosen: list[int] = []
    for step in range(len(basis)):
        pivot = int(np.argmax(left))
        if left[pivot] <= tolerance:
            break
        row = correlation(links[pivot : pivot + 1], links, length, kernel)[0]
        row -= basis[:step, pivot] @ basis[:step]
        basis[step] = row / np.sqrt(left[pivot])
        left = np.maximum(left - basis[step] ** 2, 0.0)
        left[pivot] = 0.0
        chosen.append(pivot)
    return np.asarray(chosen, dtype=np.intp)
