"""Log-distance path loss m(y) = L0 - 10 n log10(max(d, d0)) (paper, Section II-C)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError

Array = NDArray[np.float64]


def split_links(links: Array) -> tuple[Array, Array]:
    """Sender and receiver positions, each (K, D) [m], of links (K, 2 D).

    Raises RadioError unless the array is two-dimensional with 4 or 6 columns.
    """
    if links.ndim != 2 or links.shape[1] not in (4, 6):
        raise RadioError(
            f"links have shape {links.shape}; expected (K, 4) or (K, 6): sender then receiver"
        )
    half = links.shape[1] // 2
    return links[:, :half], links[:, half:]


def swap_ends(links: Array) -> Array:
    """Links (K, 2 D) with sender and receiver exchanged."""
    sender, receiver = split_links(links)
    return np.hstack([receiver, sender])


def link_distance(links: Array) -> Array:
    """Distance (K,) [m] between the two ends of each link."""
    sender, receiver = split_links(links)
    return np.asarray(np.linalg.norm(sender - receiver, axis=1), dtype=np.float64)


def log_distance(distance: Array, d0: float) -> Array:
    """-10 log10(max(d, d0)) [dB for each unit of the exponent], the regressor of n."""
    return np.asarray(-10.0 * np.log10(np.maximum(distance, d0)), dtype=np.float64)


def path_loss_mean(distance: Array, l0: float, exponent: float, d0: float) -> Array:
    """Mean received strength [dBm] at `distance` [m]; d0 [m] clamps it from below."""
    return l0 + exponent * log_distance(distance, d0)
