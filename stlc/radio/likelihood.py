"""The likelihood of a channel, exact or by blocks, with left-censored samples.

theta = (log sigma_F^2, log sigma_k^2, log l); the mean's coefficients b (L0, n, offsets) are
profiled by generalised least squares inside. A censored sample has the likelihood
Phi((floor - f) / sigma_F); expectation propagation replaces it by a Gaussian site (Minka,
2001; Rasmussen and Williams, 2006, section 3.6; for log-concave sites such as this one it is
accurate and stable). With sites at their fixed point the gradient of log Z is that at fixed
sites, so all gradients are analytic.
Beyond one block the rows are cut by position (k-d tree) into blocks taken as independent:
a composite likelihood, O(K B^2) for blocks of B rows (Varin, Reid and Firth, 2011).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import KernelError
from stlc.radio.kernel import KernelName, correlation_gradient
from stlc.radio.samples import Merged
from stlc.radio.tobit import mills

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

SWEEPS = 30
EP_TOLERANCE = 1e-4
DAMPING = 0.9


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Merged samples, the mean's features (K, q), and the blocks of rows."""

    merged: Merged
    features: Array
    blocks: tuple[Ints, ...]
    kernel: KernelName

    @property
    def censored(self) -> NDArray[np.bool_]:
        return self.merged.samples.censored


@dataclass(frozen=True, slots=True, eq=False)
class Sites:
    """Gaussian observations `target` (K,) [dBm] of variance `noise` (K,) [dB^2]."""

    target: Array
    noise: Array


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Log likelihood at theta, its gradient (3,), the coefficients b (q,) with their
    covariance (q, q), and the sites."""

    value: float
    gradient: Array
    coefficients: Array
    covariance: Array
    sites: Sites


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """Inverse and log determinant of one block's covariance."""

    rows: Ints
    inverse: Array
    log_det: float


def make_blocks(links: Array, size: int) -> tuple[Ints, ...]:
    """Rows cut in halves across their widest coordinate until no block exceeds `size`."""
    todo, done = [np.arange(len(links), dtype=np.intp)], []
    while todo:
        rows = todo.pop()
        if len(rows) <= size:
            done.append(rows)
            continue
        axis = int(np.argmax(np.ptp(links[rows], axis=0)))
        order = rows[np.argsort(links[rows, axis], kind="stable")]
        todo += [order[: len(order) // 2], order[len(order) // 2 :]]
    return tuple(done)


def initial_sites(problem: Problem, fading: float, variance: float) -> Sites:
    """Observations as they are; censored ones as a weak Gaussian below their floor."""
    samples, hidden = problem.merged.samples, problem.censored
    target = np.where(hidden, samples.floor - np.sqrt(variance), samples.rssi)
    noise = np.where(hidden, variance, fading / problem.merged.count)
    return Sites(target, noise)


def evaluate(problem: Problem, theta: Array, sites: Sites) -> Evaluation:
    """Log likelihood and gradient at theta, starting from the censored rows of `sites`."""
    fading, shadowing, length = (float(v) for v in np.exp(theta))
    samples, hidden = problem.merged.samples, problem.censored
    target = np.where(hidden, sites.target, samples.rssi)
    noise = np.where(hidden, sites.noise, fading / problem.merged.count)
    shapes = [
        correlation_gradient(samples.links[r], samples.links[r], length, problem.kernel)
        for r in problem.blocks
    ]
    for _ in range(SWEEPS):
        blocks = _factorise(problem, shapes, shadowing, noise)
        fit = _least_squares(problem, blocks, target)
        alpha, diagonal = _leave_one_out(problem, blocks, target - problem.features @ fit[0])
        if not hidden.any():
            break
        new = _update_sites(problem, target, noise, alpha, diagonal, fading)
        moved = np.abs(1.0 / new.noise - 1.0 / noise)[hidden].max() * (fading + shadowing)
        target, noise = new.target, new.noise
        if moved < EP_TOLERANCE:
            break
    value, slope = _value(problem, blocks, target, alpha, diagonal, fit[0], fading, noise)
    gradient = _gradient(problem, blocks, shapes, alpha, diagonal, shadowing, fading)
    gradient[0] += slope
    return Evaluation(value, gradient, fit[0], fit[1], Sites(target, noise))


def _factorise(
    problem: Problem, shapes: list[tuple[Array, Array]], shadowing: float, noise: Array
) -> list[_Block]:
    from scipy.linalg.lapack import dpotrf, dpotri

    blocks = []
    for rows, (shape, _) in zip(problem.blocks, shapes, strict=True):
        matrix = shadowing * shape
        matrix[np.diag_indices_from(matrix)] += noise[rows] + 1e-8 * shadowing
        lower, info = dpotrf(matrix, lower=1, overwrite_a=1)
        if info:
            raise KernelError("the covariance of the samples is not positive definite")
        log_det = 2.0 * float(np.log(np.diag(lower)).sum())
        inverse, _ = dpotri(lower, lower=1)
        inverse = np.tril(inverse)
        inverse = inverse + np.tril(inverse, -1).T
        blocks.append(_Block(rows, inverse, log_det))
    return blocks


def _least_squares(problem: Problem, blocks: list[_Block], target: Array) -> tuple[Array, Array]:
    """GLS coefficients (q,) and their covariance (q, q)."""
    columns = problem.features.shape[1]
    normal, moment = 1e-9 * np.eye(columns), np.zeros(columns)
    for block in blocks:
        part = problem.features[block.rows]
        weighted = block.inverse @ part
        normal += part.T @ weighted
        moment += weighted.T @ target[block.rows]
    covariance = np.linalg.inv(normal)
    return covariance @ moment, np.asarray(covariance, dtype=np.float64)


def _leave_one_out(problem: Problem, blocks: list[_Block], residual: Array) -> tuple[Array, Array]:
    """alpha = C^-1 r and the diagonal of C^-1, both (K,)."""
    alpha, diagonal = np.empty(len(residual)), np.empty(len(residual))
    for block in blocks:
        alpha[block.rows] = block.inverse @ residual[block.rows]
        diagonal[block.rows] = np.diag(block.inverse)
    return alpha, diagonal


def _cavity(
    target: Array, noise: Array, alpha: Array, diagonal: Array, floor: Array, fading: float
) -> tuple[Array, Array, Array, Array]:
    """Cavity mean and variance, spread s of the censored sample, and t = (floor - mean)/s."""
    mean = target - alpha / diagonal
    variance = np.maximum(1.0 / diagonal - noise, 1e-9)
    spread = np.sqrt(variance + fading)
    return mean, variance, spread, (floor - mean) / spread


def _update_sites(
    problem: Problem, target: Array, noise: Array, alpha: Array, diagonal: Array, fading: float
) -> Sites:
    """One damped parallel EP sweep over the censored rows."""
    rows = np.flatnonzero(problem.censored)
    floor = problem.merged.samples.floor[rows]
    mean, variance, spread, t = _cavity(
        target[rows], noise[rows], alpha[rows], diagonal[rows], floor, fading
    )
    _, ratio = mills(t)
    bend = np.clip(ratio * (t + ratio), 1e-9, 1.0)
    fresh = np.clip(spread**2 / bend - variance, 1e-6, 1e8)
    aim = mean - (fresh + variance) * ratio / spread
    precision = DAMPING / fresh + (1.0 - DAMPING) / noise[rows]
    moment = DAMPING * aim / fresh + (1.0 - DAMPING) * target[rows] / noise[rows]
    new_target, new_noise = target.copy(), noise.copy()
    new_noise[rows] = 1.0 / precision
    new_target[rows] = moment / precision
    return Sites(new_target, new_noise)


def _value(
    problem: Problem,
    blocks: list[_Block],
    target: Array,
    alpha: Array,
    diagonal: Array,
    coefficients: Array,
    fading: float,
    noise: Array,
) -> tuple[float, float]:
    """Log likelihood, and the part of its derivative by log sigma_F^2 from censored rows."""
    merged, hidden = problem.merged, problem.censored
    residual = target - problem.features @ coefficients
    value = -0.5 * float(residual @ alpha) - 0.5 * sum(b.log_det for b in blocks)
    value -= 0.5 * len(residual) * np.log(2.0 * np.pi)
    value -= 0.5 * merged.surplus * np.log(2.0 * np.pi * fading) + 0.5 * merged.scatter / fading
    value -= 0.5 * float(np.log(merged.count).sum())
    if not hidden.any():
        return float(value), 0.0
    a, d = alpha[hidden], diagonal[hidden]
    floor = merged.samples.floor[hidden]
    _, _, spread, t = _cavity(target[hidden], noise[hidden], a, d, floor, fading)
    log_cdf, ratio = mills(t)
    value += float((log_cdf + 0.5 * np.log(2.0 * np.pi / d) + 0.5 * a**2 / d).sum())
    return float(value), float(-(0.5 * fading * ratio * t / spread**2).sum())


def _gradient(
    problem: Problem,
    blocks: list[_Block],
    shapes: list[tuple[Array, Array]],
    alpha: Array,
    diagonal: Array,
    shadowing: float,
    fading: float,
) -> Array:
    """Derivatives by (log sigma_F^2, log sigma_k^2, log l) at fixed sites."""
    merged, seen = problem.merged, ~problem.censored
    weight = (alpha**2 - diagonal) / merged.count
    out = np.zeros(3)
    out[0] = 0.5 * fading * float(weight[seen].sum())
    out[0] += 0.5 * merged.scatter / fading - 0.5 * merged.surplus
    for block, (shape, slope) in zip(blocks, shapes, strict=True):
        a = alpha[block.rows]
        for k, matrix in ((1, shape), (2, slope)):
            pull = float(a @ matrix @ a) - float(np.einsum("ij,ij->", block.inverse, matrix))
            out[k] += 0.5 * shadowing * pull
    return out
