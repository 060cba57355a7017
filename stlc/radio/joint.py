"""Joint draws of the strengths of several links, from a channel's posterior.

For links y_1..y_K the shadowing and the links' own deviations are jointly normal:
    mean       m(y_i) + k(y_i, c) w
    covariance k(y_i, y_j) - (R k(c, y_i))'(R k(c, y_j)) + sigma_L^2 [y_i and y_j are one link]
with centres c, weights w and factor R of `stlc.radio.posterior`. Fading isn't in it: it is
independent from packet to packet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import KernelError
from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import correlation
from stlc.radio.pathloss import swap_ends

Array = NDArray[np.float64]

_SAME = 1e-6
"""Ends this close [m] belong to one link: it is the touching distance of cells, far below any
correlation length."""

_JITTER = 1e-9
"""Of the shadowing variance, added to make repeated links regular: 1e-4 dB at 10 dB^2."""

_NEGATIVE = 1e-6
"""Eigenvalues down to minus this, of the largest, are rounding, as in `checked_variance`."""


@dataclass(frozen=True, slots=True, eq=False)
class JointLinks:
    """`mean` (W, K) [dBm] and a root (W, K, K) of the covariance of K links in W worlds."""

    mean: Array
    root: Array

    def draw(self, rng: np.random.Generator, draws: int) -> Array:
        """Strengths (K, draws) [dBm], fading left out. One world serves all draws, or each draw
        has its own (W = draws)."""
        worlds, links = self.mean.shape
        normal = rng.standard_normal((links, draws))
        if worlds == 1:
            return np.asarray(self.mean[0][:, None] + self.root[0] @ normal)
        return np.asarray(self.mean.T + np.einsum("wij,jw->iw", self.root, normal))


def joint(model: ChannelModel, links: Array) -> JointLinks:
    """The joint law of links (W, K, 2 D) [m] in W worlds, each with links of its own.

    Calibration offsets are left to the caller. Raises KernelError where the kernel is no
    covariance on these links (`paper_min` may not be).
    """
    worlds, count, width = links.shape
    flat = links.reshape(-1, width)
    mean = model.mean(flat)
    covariance = np.stack([model.covariance(world) for world in links])
    if model.posterior is not None and len(flat):
        post = model.posterior
        cross = model.shadowing * correlation(flat, post.centres, model.length, model.kernel)
        mean = mean + cross @ post.weights
        reduced = (cross @ post.factor.T).reshape(worlds, count, -1)
        covariance -= reduced @ reduced.transpose(0, 2, 1)
    if model.deviation:
        covariance += model.deviation * np.stack([_one_link(world) for world in links])
    return JointLinks(mean.reshape(worlds, count), _root(covariance, model))


def _one_link(links: Array) -> NDArray[np.bool_]:
    """Which of K links are one and the same, in either direction (K, K)."""
    straight, crossed = (
        np.abs(links[:, None] - other[None]).max(axis=2) <= _SAME
        for other in (links, swap_ends(links))
    )
    return np.asarray(straight | crossed, dtype=bool)


def _root(covariance: Array, model: ChannelModel) -> Array:
    """Matrices whose square is the covariance (W, K, K)."""
    if not model.shadowing and not model.deviation:
        return np.zeros_like(covariance)
    speck = _JITTER * max(model.shadowing, model.deviation)
    try:
        lower = np.linalg.cholesky(covariance + speck * np.eye(covariance.shape[-1]))
        return np.asarray(lower, dtype=np.float64)
    except np.linalg.LinAlgError:
        value, vector = np.linalg.eigh(covariance)
    if float(value.min()) < -_NEGATIVE * max(float(value.max()), 1.0):
        raise KernelError(
            f"kernel {model.kernel.value} is no covariance of these links (eigenvalue "
            f"{float(value.min()):.3g} dB^2); use kernel = symmetrised"
        )
    return np.asarray(vector * np.sqrt(np.maximum(value, 0.0))[:, None, :])
