"""Shadowing kernels on links y = (p_s, p_r), symmetric under s: swap of the two ends.

With rho(y, y') = exp(-|y - y'|^2 / (2 l^2)):

``symmetrised``  [rho(y, y') + rho(y, s y')] / sqrt((1 + rho(y, s y)) (1 + rho(y', s y')))
    positive semi-definite with unit variance: the normalised average of a stationary kernel
    over the swap group (Ginsbourger, Roustant and Durrande, 2012).
``paper_min``    max(rho(y, y'), rho(y, s y')), the paper's eq. (4) inside its kernel
    not positive semi-definite in general, therefore used only behind `check_covariance`.

Two that tell the ends apart, for forecasts of links from senders of one kind to receivers of
another (moving robots to fixed anchors, the ground to roofs); no symmetry, no bounds over cells:

``directed``     rho(y, y')
``exponential``  exp(-|y - y'| / l) (Gudmundson, Electronics Letters 27, 1991)
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import KernelError
from stlc.radio.pathloss import link_distance, swap_ends

Array = NDArray[np.float64]


class KernelName(StrEnum):
    """Kernels: a mission's channel may name the first two."""

    SYMMETRISED = "symmetrised"
    PAPER_MIN = "paper_min"
    DIRECTED = "directed"
    EXPONENTIAL = "exponential"


DIRECTED = (KernelName.DIRECTED, KernelName.EXPONENTIAL)
"""Kernels for which a link and its reverse are two links."""


def squared_distance(a: Array, b: Array) -> Array:
    """Squared Euclidean distances (len(a), len(b)) between rows, never negative."""
    centre = b.mean(axis=0) if len(b) else np.zeros(a.shape[1])
    a0, b0 = a - centre, b - centre
    square = (a0**2).sum(1)[:, None] + (b0**2).sum(1)[None, :] - 2.0 * a0 @ b0.T
    return np.asarray(np.maximum(square, 0.0), dtype=np.float64)


def radial(square: Array, length: float, kernel: KernelName) -> Array:
    """Correlation at squared distances `square` [m^2] of links, before any symmetry."""
    if kernel is KernelName.EXPONENTIAL:
        return np.asarray(np.exp(np.sqrt(square) / -length), dtype=np.float64)
    return np.asarray(np.exp(square / (-2.0 * length**2)), dtype=np.float64)


def self_overlap(links: Array, length: float) -> Array:
    """rho(y, s y) (K,): one when both ends coincide, zero when they are far apart."""
    return np.asarray(np.exp(-((link_distance(links) / length) ** 2)), dtype=np.float64)


def correlation(a: Array, b: Array, length: float, kernel: KernelName) -> Array:
    """Correlation (len(a), len(b)) of the shadowing at links `a` and `b`; length [m]."""
    direct = radial(squared_distance(a, b), length, kernel)
    if kernel in DIRECTED:
        return direct
    crossed = radial(squared_distance(a, swap_ends(b)), length, kernel)
    if kernel is KernelName.PAPER_MIN:
        return np.asarray(np.maximum(direct, crossed), dtype=np.float64)
    scale_a = 1.0 / np.sqrt(1.0 + self_overlap(a, length))
    scale_b = 1.0 / np.sqrt(1.0 + self_overlap(b, length))
    return np.asarray((direct + crossed) * scale_a[:, None] * scale_b[None, :], dtype=np.float64)


def correlation_gradient(
    a: Array, b: Array, length: float, kernel: KernelName
) -> tuple[Array, Array]:
    """The correlation and its derivative by log(length), both (len(a), len(b))."""
    near = squared_distance(a, b) / length**2
    if kernel in DIRECTED:
        value = radial(near, 1.0, kernel)
        return value, value * (np.sqrt(near) if kernel is KernelName.EXPONENTIAL else near)
    far = squared_distance(a, swap_ends(b)) / length**2
    direct, crossed = np.exp(-near / 2.0), np.exp(-far / 2.0)
    if kernel is KernelName.PAPER_MIN:
        least = np.minimum(near, far)
        value = np.exp(-least / 2.0)
        return value, value * least
    overlap_a, overlap_b = self_overlap(a, length), self_overlap(b, length)
    scale = 1.0 / np.sqrt((1.0 + overlap_a)[:, None] * (1.0 + overlap_b)[None, :])
    value = (direct + crossed) * scale
    slope_a = _log_norm_slope(a, overlap_a, length)
    slope_b = _log_norm_slope(b, overlap_b, length)
    slope = (direct * near + crossed * far) * scale
    return value, slope - value * (slope_a[:, None] + slope_b[None, :])


def _log_norm_slope(links: Array, overlap: Array, length: float) -> Array:
    """Derivative of log sqrt(1 + rho(y, s y)) by log(length), (K,)."""
    stretched = 2.0 * (link_distance(links) / length) ** 2
    return np.asarray(0.5 * overlap * stretched / (1.0 + overlap), dtype=np.float64)


def check_covariance(links: Array, length: float, kernel: KernelName) -> float:
    """Smallest eigenvalue of the correlation matrix of `links`.

    Raises KernelError when it is negative beyond rounding: then the kernel is no covariance
    on these positions and eq. (3) and (5) of the paper have no meaning.
    """
    matrix = correlation(links, links, length, kernel)
    least = float(np.linalg.eigvalsh((matrix + matrix.T) / 2.0)[0])
    if least < -1e-9 * len(links):
        raise KernelError(
            f"kernel {kernel.value} is not positive semi-definite on these {len(links)} links: "
            f"its smallest eigenvalue is {least:.3g}; use kernel = symmetrised"
        )
    return least
