"""The posterior on all pairs of two point sets, using that the kernel factors over the ends.

With c = (c_s, c_r) the centres of a posterior and E_x(p) = exp(-|p - x|^2 / (2 l^2)),
    w_j(a, b) = c_j [E_cs(a) E_cr(b) + E_cr(a) E_cs(b)],   k_j(a, b) = u(a, b) w_j(a, b),
    u(a, b) = (1 + exp(-|a - b|^2 / l^2))^(-1/2),
so a posterior mean on n x n pairs is one matrix product.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import KernelName, self_overlap, squared_distance
from stlc.radio.pathloss import path_loss_mean, split_links, swap_ends

Array = NDArray[np.float64]

BLOCK_BYTES = 64_000_000


@dataclass(frozen=True, slots=True, eq=False)
class PairField:
    """A channel prepared for pairs (symmetrised kernel).

    sender, receiver  (M, D) centres; M = 0 for the prior
    mean_weight       (M,) with S(a, b) = sum_j mean_weight_j [E E + E E], mean = m + u S
    norm              of S in the space of the unnormalised kernel: S'' <= norm |phi''|
    root              (r, M) with variance = sigma_k^2 u^2 (g - |root w|^2), w = E E + E E,
                      g = 1 + exp(-|a - b|^2 / l^2)
    one_way           w = E_cs(a) E_cr(b) alone, with the first end where all senders are
    """

    model: ChannelModel
    sender: Array
    receiver: Array
    mean_weight: Array
    norm: float
    root: Array
    one_way: bool = False

    @property
    def centres(self) -> int:
        """M, the number of kernels in the posterior."""
        return len(self.sender)

    def factors(self, points: Array) -> Array:
        """(n, 2 M): E at the senders, then at the receivers, of points (n, D)."""
        scale = -1.0 / (2.0 * self.model.length**2)
        both = np.vstack([self.sender, self.receiver])
        return np.asarray(np.exp(scale * squared_distance(points, both)), dtype=np.float64)


def prepare(model: ChannelModel, dimension: int) -> PairField:
    """The field of a channel with a symmetrised kernel, for points with `dimension` axes."""
    field = weighted(model, dimension)
    if not field.centres:
        return field
    centres = np.hstack([field.sender, field.receiver])
    kernel = sum(
        np.exp(-squared_distance(centres, other) / (2.0 * model.length**2))
        for other in (centres, swap_ends(centres))
    )
    return replace(field, norm=rounded_norm(np.asarray(kernel), field.mean_weight))


def weighted(model: ChannelModel, dimension: int) -> PairField:
    """The field without its norm, which takes as long as a table by itself."""
    posterior = model.posterior
    if posterior is None or model.shadowing == 0.0:
        none = np.zeros((0, dimension))
        return PairField(model, none, none, np.zeros(0), 0.0, np.zeros((0, 0)))
    sender, receiver = split_links(posterior.centres)
    norm = 1.0 / np.sqrt(1.0 + self_overlap(posterior.centres, model.length))
    weight = model.shadowing * norm * posterior.weights
    root = np.sqrt(model.shadowing) * posterior.factor * norm[None, :]
    return PairField(model, sender, receiver, weight, np.inf, root)


def rounded_norm(kernel: Array, weight: Array) -> float:
    """sqrt(w' K w) of weights (M,) by a kernel (M, M), rounded up."""
    square = max(float(weight @ kernel @ weight), 0.0)
    return float(np.sqrt(square + 1e-9 * float(weight @ weight) * len(weight)))


def swap_halves(factors: Array) -> Array:
    """Factors of the other end: receivers first, so that columns multiply pairwise."""
    half = factors.shape[1] // 2
    return np.hstack([factors[:, half:], factors[:, :half]])


def pair_distance(a: Array, b: Array) -> Array:
    """Distances (na, nb) [m], exact where points coincide."""
    total = np.zeros((len(a), len(b)))
    for axis in range(a.shape[1]):
        total += (a[:, axis, None] - b[None, :, axis]) ** 2
    return np.asarray(np.sqrt(total), dtype=np.float64)


def predict_pairs(
    model: ChannelModel, a: Array, b: Array, fading: bool, receiver: str | None = None
) -> tuple[Array, Array]:
    """Posterior mean [dBm] and variance [dB^2], both (na, nb), between points a (na, D) and
    b (nb, D) [m]; the same numbers as `ChannelModel.predict`, much faster."""
    if model.kernel is not KernelName.SYMMETRISED:
        return _predict_links(model, a, b, fading, receiver)
    field = weighted(model, a.shape[1])
    distance = pair_distance(a, b)
    mean = path_loss_mean(distance, model.l0, model.exponent, model.d0) + model.offset(receiver)
    if model.walls is not None:
        mean -= model.walls.between(a, b)
    extra = model.own_variance(fading) + model.offset_variance(receiver)
    if not field.centres:
        spread = model.shadowing + extra
        return mean, np.full_like(mean, spread)
    overlap = 1.0 + np.exp(-((distance / model.length) ** 2))
    fa, fb = field.factors(a), swap_halves(field.factors(b))
    twice = np.tile(field.mean_weight, 2)
    mean += ((fa * twice) @ fb.T) / np.sqrt(overlap)
    explained = np.empty_like(mean)
    for rows in row_blocks(len(a), len(b) * field.centres * 8):
        explained[rows] = _explained(field, fa[rows], fb)
    variance = model.checked_variance(model.shadowing * (1.0 - explained / overlap))
    return mean, variance + extra


def row_blocks(rows: int, bytes_a_row: int) -> list[slice]:
    """Slices of rows whose temporaries stay within BLOCK_BYTES."""
    step = max(1, BLOCK_BYTES // max(bytes_a_row, 1))
    return [slice(start, min(start + step, rows)) for start in range(0, rows, step)]


def _explained(field: PairField, fa: Array, fb: Array) -> Array:
    """|root w|^2 (na, nb)."""
    half = field.centres
    weight = fa[:, None, :half] * fb[None, :, :half] + fa[:, None, half:] * fb[None, :, half:]
    reduced = weight.reshape(-1, half) @ field.root.T
    total = np.einsum("ij,ij->i", reduced, reduced)
    return np.asarray(total.reshape(len(fa), len(fb)), dtype=np.float64)


def _predict_links(
    model: ChannelModel, a: Array, b: Array, fading: bool, receiver: str | None
) -> tuple[Array, Array]:
    links = np.hstack([np.repeat(a, len(b), axis=0), np.tile(b, (len(a), 1))])
    mean, variance = model.predict(links, fading, receiver)
    return mean.reshape(len(a), len(b)), variance.reshape(len(a), len(b))
