"""Prices and masks of a node for its children: on fewer states, or on finer cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Bools, Ints
from stlc.solve.bounders.agreement import Pair, Prices
from stlc.solve.relaxation.problem import Problem
from stlc.solve.states.layers import Layer


def sliced(prices: Prices, index: Sequence[Sequence[Ints]]) -> Prices:
    """Prices of some states, index[agent][t]."""
    states = {
        p: tuple([v[k] for v, k in zip(values, index[n], strict=True)]
                 for n, values in zip(p, ends, strict=True))
        for p, ends in prices.states.items()
    }  # fmt: skip
    return Prices(dict(prices.potentials), {p: (v[0], v[1]) for p, v in states.items()})


def masked(
    masks: dict[Pair, list[Bools]] | None, index: Sequence[Sequence[Ints]]
) -> dict[Pair, list[Bools]] | None:
    """Pairs of some states, index[agent][t]."""
    if masks is None:
        return None
    return {
        p: [m[np.ix_(i, j)] for m, i, j in zip(row, index[p[0]], index[p[1]], strict=True)]
        for p, row in masks.items()
    }


def blocks(fine: Problem, coarse: Problem) -> Ints:
    """The merged cell of each cell."""
    x, y = (
        np.searchsorted(c, (f[:-1] + f[1:]) / 2) - 1
        for f, c in zip(fine.edges, coarse.edges, strict=True)
    )
    return np.asarray((x[:, None] * coarse.shape[1] + y[None]).ravel(), dtype=np.int64)


def prices_of_finer_cells(
    prices: Prices, coarse: Sequence[Sequence[Layer]], fine: Sequence[Sequence[Layer]],
    blocks: Ints,
) -> Prices:  # fmt: skip
    """Prices of merged cells for the cells in them; 0 where a merged cell is gone."""
    index = [[_hosts(a, b, blocks) for a, b in zip(*rows, strict=True)]
             for rows in zip(coarse, fine, strict=True)]  # fmt: skip
    padded = {
        p: tuple([np.append(np.where(np.isfinite(v), v, 0.0), 0.0) for v in end] for end in ends)
        for p, ends in prices.states.items()
    }
    return sliced(Prices(prices.potentials, {p: (v[0], v[1]) for p, v in padded.items()}), index)


def _hosts(coarse: Layer, fine: Layer, blocks: Ints) -> Ints:
    """For each fine state one of the same merged cell, -1 where there is none."""
    table = np.full((2, int(blocks.max()) + 1), -1, np.int64)
    table[coarse.bit, coarse.cell] = np.arange(len(coarse))
    found: Ints = table[fine.bit, blocks[fine.cell]]
    return found
