"""The likelihood of a channel, exact or by blocks, with left-censored samples.

Samples are nested in links: a sample is the mean, plus shadowing, plus the deviation of its link
(variance sigma_L^2, independent from link to link, one value for all samples of a link whatever
their direction), plus its own fading (Searle, Casella and McCulloch, Variance Components, 1992).
theta holds the logarithms of the `Parameters` of a problem; where no link was measured twice it
lacks sigma_L^2, and sigma_F^2 stands for both. L0 and n are fixed effects, integrated out under a
flat prior: restricted likelihood, in which residuals to a fitted mean don't pass for those to a
known one (Patterson and Thompson, Biometrika 1971). Receivers' offsets are random effects of
variance tau^2: those of a receiver seldom heard shrink to zero, one never heard has zero. With F
the columns and D the prior precision of their coefficients b, b solves N b = F' C^-1 z with
N = F' C^-1 F + D (Henderson, Biometrics 1975), and C^-1 - C^-1 F N^-1 F' C^-1 stands for the
inverse of all covariance.
A censored sample has the likelihood
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
from stlc.radio.kernel import correlation_gradient
from stlc.radio.problem import Parameters, Problem
from stlc.radio.sites import Sites, cavity, update_sites
from stlc.radio.tobit import mills

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

SWEEPS = 30
EP_TOLERANCE = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """At one theta.

    value          restricted log likelihood; gradient: its derivatives by theta
    likelihood     log likelihood with L0 and n at their estimates, offsets integrated out
    coefficients   b (q,), of covariance (q, q)
    given          (q - 2,) variances [dB^2] of the offsets given L0 and n
    """

    value: float
    gradient: Array
    likelihood: float
    coefficients: Array
    covariance: Array
    given: Array
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
    """Inverse and log determinant of one block's covariance; `weighted` = C^-1 F (rows, q)."""

    rows: Ints
    inverse: Array
    log_det: float
    weighted: Array

    def projected(self, covariance: Array) -> Array:
        """The block of C^-1 - C^-1 F N^-1 F' C^-1; covariance: N^-1."""
        return np.asarray(self.inverse - self.weighted @ covariance @ self.weighted.T)


@dataclass(frozen=True, slots=True, eq=False)
class _Trend:
    """Coefficients (q,) and N^-1 (q, q), N, and the log prior density of the coefficients less
    half the log determinant of N: what the mean adds to the log likelihood."""

    coefficients: Array
    covariance: Array
    normal: Array
    value: float


def evaluate(problem: Problem, theta: Array, sites: Sites) -> Evaluation:
    """Log likelihood and gradient at theta, starting from the censored rows of `sites`."""
    at = problem.parameters(theta)
    samples, hidden = problem.merged.samples, problem.censored
    target = np.where(hidden, sites.target, samples.rssi)
    noise = np.where(hidden, sites.noise, at.fading / problem.merged.count)
    shapes = [_shape(problem, rows, at.length) for rows in problem.blocks]
    for _ in range(SWEEPS):
        blocks = _factorise(problem, shapes, at, noise)
        trend = _trend(problem, blocks, target, at.offset)
        residual = target - problem.features @ trend.coefficients
        alpha, diagonal = _leave_one_out(blocks, residual, trend.covariance)
        if not hidden.any():
            break
        new = update_sites(problem, target, noise, alpha, diagonal, at.fading)
        moved = np.abs(1.0 / new.noise - 1.0 / noise)[hidden].max() * (
            at.fading + at.shadowing + at.deviation
        )
        target, noise = new.target, new.noise
        if moved < EP_TOLERANCE:
            break
    value, slope = _value(problem, blocks, target, alpha, diagonal, trend, at.fading, noise)
    gradient = _gradient(problem, blocks, shapes, alpha, diagonal, trend, at)
    gradient["fading"] += slope
    likelihood, given = _unrestricted(value, trend, problem.fixed)
    return Evaluation(
        value,
        np.array([gradient[name] for name in problem.names]),
        likelihood,
        trend.coefficients,
        trend.covariance,
        given,
        Sites(target, noise),
    )


def _unrestricted(value: float, trend: _Trend, fixed: int) -> tuple[float, Array]:
    """The likelihood at the fixed effects' estimates, and the variances of the random ones given
    these."""
    random = trend.normal[fixed:, fixed:]
    gain = np.linalg.slogdet(trend.normal)[1] - np.linalg.slogdet(random)[1]
    given = np.diag(np.linalg.inv(random)) if len(random) else np.zeros(0)
    return value + 0.5 * (float(gain) - fixed * np.log(2.0 * np.pi)), given


def _shape(problem: Problem, rows: Ints, length: float) -> _Shape:
    links, number = problem.merged.samples.links[rows], problem.merged.link[rows]
    value, slope = correlation_gradient(links, links, length, problem.kernel)
    if len(np.unique(number)) == len(rows):
        return _Shape(value, slope, None)
    same = (number[:, None] == number[None, :]).astype(np.float64)
    return _Shape(value, slope, same)


def _factorise(
    problem: Problem, shapes: list[_Shape], at: Parameters, noise: Array
) -> list[_Block]:
    """Cholesky factor, inverse and log-determinant of each block's covariance [dB^2].

    `noise` is the variance of each row's own error [dB^2]; a jitter of 1e-8 of the shadowing is
    added. KernelError where a block isn't positive definite.
    """
    from scipy.linalg.lapack import dpotrf, dpotri

    blocks = []
    for rows, shape in zip(problem.blocks, shapes, strict=True):
        matrix = at.shadowing * shape.value
        shape.add_deviation(matrix, at.deviation)
        matrix[np.diag_indices_from(matrix)] += noise[rows] + 1e-8 * at.shadowing
        lower, info = dpotrf(matrix, lower=1, overwrite_a=1)
        if info:
            raise KernelError("the covariance of the samples is not positive definite")
        log_det = 2.0 * float(np.log(np.diag(lower)).sum())
        inverse, _ = dpotri(lower, lower=1)
        inverse = np.tril(inverse)
        inverse = inverse + np.tril(inverse, -1).T
        blocks.append(_Block(rows, inverse, log_det, inverse @ problem.features[rows]))
    return blocks


def _trend(problem: Problem, blocks: list[_Block], target: Array, offset: float) -> _Trend:
    """Henderson's mixed-model equations; `offset`: variance of the random effects [dB^2]."""
    columns = problem.features.shape[1]
    prior = np.zeros(columns)
    fixed = problem.fixed
    prior[fixed:] = 1.0 / offset if offset else 0.0
    normal, moment = np.diag(prior + 1e-9), np.zeros(columns)
    for block in blocks:
        normal += problem.features[block.rows].T @ block.weighted
        moment += block.weighted.T @ target[block.rows]
    covariance = np.linalg.inv(normal)
    b = covariance @ moment
    value = fixed * np.log(2.0 * np.pi) + float(np.log(prior[fixed:]).sum())
    value -= float(prior @ b**2) + float(np.linalg.slogdet(normal)[1])
    return _Trend(b, np.asarray(covariance, dtype=np.float64), normal, 0.5 * value)


def _leave_one_out(blocks: list[_Block], residual: Array, covariance: Array) -> tuple[Array, Array]:
    """alpha = C^-1 (z - F b) and the diagonal of the inverse of all covariance, both (K,)."""
    alpha, diagonal = np.empty(len(residual)), np.empty(len(residual))
    for block in blocks:
        alpha[block.rows] = block.inverse @ residual[block.rows]
        spread = block.weighted @ covariance
        known = np.einsum("ij,ij->i", spread, block.weighted)
        diagonal[block.rows] = np.diag(block.inverse) - known
    return alpha, diagonal


def _value(
    problem: Problem,
    blocks: list[_Block],
    target: Array,
    alpha: Array,
    diagonal: Array,
    trend: _Trend,
    fading: float,
    noise: Array,
) -> tuple[float, float]:
    """Log likelihood, and the part of its derivative by log sigma_F^2 from censored rows."""
    merged, hidden = problem.merged, problem.censored
    residual = target - problem.features @ trend.coefficients
    value = trend.value - 0.5 * float(residual @ alpha) - 0.5 * sum(b.log_det for b in blocks)
    value -= 0.5 * len(residual) * np.log(2.0 * np.pi)
    surplus, scatter = float((merged.count - 1.0).sum()), float(merged.scatter.sum())
    value -= 0.5 * surplus * np.log(2.0 * np.pi * fading) + 0.5 * scatter / fading
    value -= 0.5 * float(np.log(merged.count).sum())
    if not hidden.any():
        return float(value), 0.0
    a, d = alpha[hidden], diagonal[hidden]
    floor = merged.samples.floor[hidden]
    _, _, spread, t = cavity(target[hidden], noise[hidden], a, d, floor, fading)
    log_cdf, ratio = mills(t)
    value += float((log_cdf + 0.5 * np.log(2.0 * np.pi / d) + 0.5 * a**2 / d).sum())
    return float(value), float(-(0.5 * fading * ratio * t / spread**2).sum())


def _gradient(
    problem: Problem,
    blocks: list[_Block],
    shapes: list[_Shape],
    alpha: Array,
    diagonal: Array,
    trend: _Trend,
    at: Parameters,
) -> dict[str, float]:
    """Derivatives by the logarithms of all parameters at fixed sites."""
    merged, seen = problem.merged, ~problem.censored
    weight = (alpha**2 - diagonal) / merged.count
    out = dict.fromkeys(("shadowing", "length", "deviation"), 0.0)
    out["fading"] = 0.5 * at.fading * float(weight[seen].sum())
    out["fading"] += 0.5 * float((merged.scatter / at.fading - (merged.count - 1.0)).sum())
    for block, shape in zip(blocks, shapes, strict=True):
        a, inverse = alpha[block.rows], block.projected(trend.covariance)
        out["shadowing"] += 0.5 * at.shadowing * _pull(a, inverse, shape.value)
        out["length"] += 0.5 * at.shadowing * _pull(a, inverse, shape.slope)
        out["deviation"] += 0.5 * at.deviation * shape.shared(a, inverse)
    if at.offset:
        fixed = problem.fixed
        square = trend.coefficients[fixed:] ** 2 + np.diag(trend.covariance)[fixed:]
        out["offset"] = 0.5 * float((square / at.offset - 1.0).sum())
    return out


def _pull(alpha: Array, inverse: Array, matrix: Array) -> float:
    """alpha' M alpha - trace(inverse M) for a symmetric M."""
    return float(alpha @ matrix @ alpha) - float(np.einsum("ij,ij->", inverse, matrix))
