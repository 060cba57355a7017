"""What a channel is conditioned on: one residual for each measured link."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.samples import link_numbers

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

LEAST_NOISE = 1e-9
"""Noise variance [dB^2] below which observations of one link weigh alike."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Links (K, 2 D) [m], all different; residuals to the path loss (K,) [dB], offsets removed;
    their noise variances (K,) [dB^2], independent. Censored samples are Gaussian sites."""

    links: Array
    residual: Array
    noise: Array

    def __len__(self) -> int:
        return len(self.links)

    def take(self, rows: Ints) -> Evidence:
        """The evidence of the given rows."""
        return Evidence(self.links[rows], self.residual[rows], self.noise[rows])


def by_link(links: Array, residual: Array, noise: Array, deviation: float) -> Evidence:
    """Observations of links, some of them of one link (either direction), as one for each link.

    Residuals r_i with noise v_i of one link have the joint evidence sum(r_i / v_i) / P of variance
    1 / P + deviation, P = sum(1 / v_i): exact for all that the link's samples share.
    """
    number = link_numbers(links)
    _, first = np.unique(number, return_index=True)
    weight = 1.0 / np.maximum(noise, LEAST_NOISE)
    precision = np.bincount(number, weights=weight)
    mean = np.bincount(number, weights=weight * residual) / precision
    shared = np.where(np.bincount(number) > 1, 1.0 / precision, noise[first])
    return Evidence(links[first], mean, shared + deviation)
