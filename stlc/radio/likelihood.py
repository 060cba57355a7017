"""The likelihood of a channel, exact or by blocks, with left-censored samples.

Samples are nested in links: a sample is the mean, plus shadowing, plus the deviation of its link
(variance sigma_L^2, independent from link to link, one value for all samples of a link whatever
their direction), plus its own fading (Searle, Casella and McCulloch, Variance Components, 1992).
theta = (log sigma_F^2, log sigma_k^2, log l, log sigma_L^2), without the last where no link was
measured twice: then sigma_F^2 stands for both. The mean's coefficients b (L0, n, offsets) are
profiled by generalised least squares inside. A censored sample has the likelihood
Phi((floor - f) / sigma_F), f the strength of its link; expectation propagation replaces it by a
Gaussian site (Minka, 2001; Rasmussen and Williams, 2006, section 3.6; for log-concave sites such
as this one it is accurate and stable). With sites at their fixed point the gradient of log Z is
that at fixed sites, so all gradients are analytic.
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
    """Log likelihood at theta, its gradient by theta, the coefficients b (q,) with their
    covariance (q, q), and the sites."""

    value: float
    gradient: Array
    coefficients: Array
    covariance: Array
    sites: Sites


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """Correlation of one block's shadowing, its derivative by log l, and which rows share a link
    (None where each row has its own)."""

    value: Array
    slope: Array
    same: Array | None

    def add_deviation(self, matrix: Array, deviation: float) -> None:
        """Add the covariance of the links' deviations."""
        if self.same is None:
            matrix[np.diag_indices_from(matrix)] += deviation
        else:
            matrix += deviation * self.same

    def shared(self, alpha: Array, inverse: Array) -> float:
        """alpha' S alpha - trace(inverse S), S = 1 where rows share a link."""
        if self.same is None:
            return float(alpha @ alpha) - float(np.trace(inverse))
        return _pull(alpha, inverse, self.same)


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
    fading, shadowing, length, deviation = variances(theta)
    samples, hidden = problem.merged.samples, problem.censored
    target = np.where(hidden, sites.target, samples.rssi)
    noise = np.where(hidden, sites.noise, fading / problem.merged.count)
    shapes = [_shape(problem, rows, length) for rows in problem.blocks]
    spread = (shadowing, deviation, fading)
    for _ in range(SWEEPS):
        blocks = _factorise(problem, shapes, spread, noise)
        fit = _least_squares(problem, blocks, target)
        alpha, diagonal = _leave_one_out(problem, blocks, target - problem.features @ fit[0])
        if not hidden.any():
            break
        new = _update_sites(problem, target, noise, alpha, diagonal, fading)
        moved = np.abs(1.0 / new.noise - 1.0 / noise)[hidden].max() * (
            fading + shadowing + deviation
        )
        target, noise = new.target, new.noise
        if moved < EP_TOLERANCE:
            break
    value, slope = _value(problem, blocks, target, alpha, diagonal, fit[0], fading, noise)
    gradient = _gradient(problem, blocks, shapes, alpha, diagonal, spread)
    gradient[0] += slope
    gradient = gradient[: len(theta)]
    return Evaluation(value, gradient, fit[0], fit[1], Sites(target, noise))


def variances(theta: Array) -> tuple[float, float, float, float]:
    """sigma_F^2, sigma_k^2 [dB^2], l [m] and sigma_L^2 [dB^2], 0 where theta lacks it."""
    fading, shadowing, length = (float(v) for v in np.exp(theta[:3]))
    return fading, shadowing, length, float(np.exp(theta[3])) if len(theta) > 3 else 0.0


def _shape(problem: Problem, rows: Ints, length: float) -> _Shape:
    links, number = problem.merged.samples.links[rows], problem.merged.link[rows]
    value, slope = correlation_gradient(links, links, length, problem.kernel)
    if len(np.unique(number)) == len(rows):
        return _Shape(value, slope, None)
    same = (number[:, None] == number[None, :]).astype(np.float64)
    return _Shape(value, slope, same)


def _factorise(
    problem: Problem, shapes: list[_Shape], spread: tuple[float, float, float], noise: Array
) -> list[_Block]:
    """`spread`: variances of shadowing, links' deviations and fading."""
    from scipy.linalg.lapack import dpotrf, dpotri

    blocks = []
    shadowing, deviation, _ = spread
    for rows, shape in zip(problem.blocks, shapes, strict=True):
        matrix = shadowing * shape.value
        shape.add_deviation(matrix, deviation)
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
    surplus, scatter = float((merged.count - 1.0).sum()), float(merged.scatter.sum())
    value -= 0.5 * surplus * np.log(2.0 * np.pi * fading) + 0.5 * scatter / fading
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
    shapes: list[_Shape],
    alpha: Array,
    diagonal: Array,
    spread: tuple[float, float, float],
) -> Array:
    """Derivatives by all four entries of theta at fixed sites."""
    merged, seen = problem.merged, ~problem.censored
    shadowing, deviation, fading = spread
    weight = (alpha**2 - diagonal) / merged.count
    out = np.zeros(4)
    out[0] = 0.5 * fading * float(weight[seen].sum())
    out[0] += 0.5 * float((merged.scatter / fading - (merged.count - 1.0)).sum())
    for block, shape in zip(blocks, shapes, strict=True):
        a = alpha[block.rows]
        out[1] += 0.5 * shadowing * _pull(a, block.inverse, shape.value)
        out[2] += 0.5 * shadowing * _pull(a, block.inverse, shape.slope)
        out[3] += 0.5 * deviation * shape.shared(a, block.inverse)
    return out


def _pull(alpha: Array, inverse: Array, matrix: Array) -> float:
    """alpha' M alpha - trace(inverse M) for a symmetric M."""
    return float(alpha @ matrix @ alpha) - float(np.einsum("ij,ij->", inverse, matrix))
