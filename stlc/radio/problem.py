"""What a likelihood is of: merged samples, the columns of the mean, blocks of rows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.kernel import KernelName
from stlc.radio.samples import Merged

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

FIXED = 2
"""Columns of the mean whose coefficients are fixed effects: L0 and the exponent; walls' losses
come after them."""


@dataclass(frozen=True, slots=True)
class Parameters:
    """Variances [dB^2] and correlation length [m]: sigma_F^2, sigma_k^2, l, sigma_L^2 and tau^2,
    the variance of receivers' offsets; 0 where a problem has none."""

    fading: float
    shadowing: float
    length: float
    deviation: float = 0.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Merged samples, the mean's columns (K, q), of which those after the first `fixed` are random
    effects of one variance, the blocks of rows, and the names of theta's entries: logarithms of
    these `Parameters`, in their order."""

    merged: Merged
    features: Array
    blocks: tuple[Ints, ...]
    kernel: KernelName
    names: tuple[str, ...]
    fixed: int = FIXED

    @property
    def censored(self) -> NDArray[np.bool_]:
        """Rows (K,) of which only `strength <= floor` is known."""
        return self.merged.samples.censored

    def parameters(self, theta: Array) -> Parameters:
        """The parameters at theta."""
        return Parameters(**dict(zip(self.names, map(float, np.exp(theta)), strict=True)))

    def restricted(self) -> Problem:
        """The problem with only the rows that its blocks hold, renumbered."""
        rows = np.concatenate(self.blocks)
        if len(rows) == len(self.features):
            return self
        ends = np.cumsum([len(b) for b in self.blocks])[:-1]
        blocks = tuple(np.split(np.arange(len(rows), dtype=np.intp), ends))
        return replace(
            self, merged=self.merged.take(rows), features=self.features[rows], blocks=blocks
        )


def make_problem(
    merged: Merged, features: Array, size: int, kernel: KernelName, fixed: int = FIXED
) -> Problem:
    """The problem of all rows in blocks of at most `size`. Links' deviations are parted from fading
    where some link was measured twice."""
    nested = ("deviation",) if merged.repeated else ()
    random = ("offset",) if features.shape[1] > fixed else ()
    names = ("fading", "shadowing", "length", *nested, *random)
    blocks = make_blocks(merged.samples.links, size)
    return Problem(merged, features, blocks, kernel, names, fixed)


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
