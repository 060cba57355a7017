"""Path loss alone, left-censored: regression with normal errors (Tobin, Econometrica 1958)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.arrays import Bools

Array = NDArray[np.float64]


FAR = -1e4
"""Below this phi / Phi is -t to eight digits, and its two logarithms cancel badly."""


@dataclass(frozen=True, slots=True, eq=False)
class Regression:
    """coefficients (q,); variance [dB^2] of one sample; log likelihood of all samples."""

    coefficients: Array
    variance: float
    log_likelihood: float


def mills(t: Array) -> tuple[Array, Array]:
    """log Phi(t) and phi(t) / Phi(t), accurate in both tails."""
    from scipy.special import log_ndtr

    log_cdf = np.asarray(log_ndtr(t), dtype=np.float64)
    near = np.maximum(t, FAR)
    ratio = np.exp(-0.5 * near**2 - 0.5 * np.log(2.0 * np.pi) - np.maximum(log_cdf, log_ndtr(FAR)))
    return log_cdf, np.where(t < FAR, -t, ratio)


def regress(features: Array, rssi: Array, floor: Array, censored: Bools) -> Regression:
    """Maximum likelihood of rssi = features b + e, of censored rows only rssi <= floor known."""
    from scipy.optimize import minimize

    seen = ~censored
    start, *_ = np.linalg.lstsq(features, np.where(seen, rssi, floor), rcond=None)
    residual = np.where(seen, rssi, floor) - features @ start
    variance = max(float(residual @ residual) / len(rssi), 1e-6)
    if not censored.any():
        likelihood = -0.5 * len(rssi) * (np.log(2.0 * np.pi * variance) + 1.0)
        return Regression(np.asarray(start), variance, float(likelihood))

    def objective(point: Array) -> tuple[float, Array]:
        """Negative log likelihood of (coefficients, log sigma) under censoring, and its
        gradient."""
        sigma = np.exp(point[-1])
        level = np.where(seen, rssi, floor)
        t = (level - features @ point[:-1]) / sigma
        log_cdf, ratio = mills(t)
        density = -0.5 * t**2 - 0.5 * np.log(2.0 * np.pi) - point[-1]
        value = -float(np.where(seen, density, log_cdf).sum())
        pull = np.where(seen, t, -ratio) / sigma
        scale = np.where(seen, t**2 - 1.0, -ratio * t)
        return value, np.append(-(features.T @ pull), -scale.sum())

    first = np.append(start, 0.5 * np.log(variance))
    found = minimize(objective, first, jac=True, method="L-BFGS-B", options={"maxiter": 500})
    return Regression(found.x[:-1], float(np.exp(2.0 * found.x[-1])), -float(found.fun))
