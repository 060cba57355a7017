"""Which columns are integer when exactly one of k alternatives is taken (sum z = P, P in {0, 1}).

    one-hot   z_i in {0, 1}: k binaries
    unary     z_i >= 0, y_j = z_1 + ... + z_j in {0, 1}, j < k: k - 1 binaries, ordered
              y_1 <= y_2 <= ...; branching on y_j splits the alternatives into before and after
    log       z_i >= 0, bit w_b = sum of the z_i whose reflected Gray code has bit b: ceil(log2 k)
              binaries (Vielma and Nemhauser, Modeling disjunctive constraints with a logarithmic
              number of binary variables and constraints, 2011)

All three are exact and have the same LP relaxation; what differs is how a solver branches. `bigm`
is one-hot without the shared-face rows of `choice.py`: the textbook encoding, for comparison.
"""

from __future__ import annotations

from enum import Enum

import numpy as np

from stlc.errors import UsageError
from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Ints


class Selector(Enum):
    """How an exclusive choice is made integral."""

    ONE_HOT = "onehot"
    BIG_M = "bigm"  # one-hot, and one big-M row for each alternative's predicate
    UNARY = "unary"
    LOG = "log"


def selector_named(name: str) -> Selector:
    """The selector of that name; `auto` is one-hot. UsageError for an unknown one."""
    if name == "auto":
        return Selector.ONE_HOT
    known = {s.value: s for s in Selector}
    if name not in known:
        raise UsageError(
            f"no formula encoding is called '{name}'; there are: auto, {', '.join(known)}"
        )
    return known[name]


def add_selection(builder: ModelBuilder, name: str, size: int, selector: Selector) -> Ints:
    """Literals z (size,); the caller adds sum z = P."""
    if selector in (Selector.ONE_HOT, Selector.BIG_M) or size <= 2:
        return builder.binary(name, (size,))
    z = builder.add_columns(name, (size,), 0.0, 1.0)
    if selector is Selector.UNARY:
        _add_unary(builder, name, z)
    else:
        _add_bits(builder, name, z)
    return z


def _add_unary(builder: ModelBuilder, name: str, z: Ints) -> None:
    """y_j - y_{j-1} - z_j = 0."""
    y = builder.binary(f"{name}_until", (len(z) - 1,))
    builder.add_dense_rows(f"{name}_until", [[y[0], z[0]]], [1.0, -1.0], 0.0, 0.0)
    if len(y) > 1:
        cols = np.column_stack([y[1:], y[:-1], z[1:-1]])
        builder.add_dense_rows(f"{name}_until", cols, [1.0, -1.0, -1.0], 0.0, 0.0)


def _add_bits(builder: ModelBuilder, name: str, z: Ints) -> None:
    """sum {z_i : bit b of gray(i)} - w_b = 0."""
    codes = np.arange(len(z)) ^ (np.arange(len(z)) >> 1)
    bits = int(len(z) - 1).bit_length()
    w = builder.binary(f"{name}_bit", (bits,))
    for b in range(bits):
        chosen = z[(codes >> b) & 1 == 1]
        cols = np.concatenate([chosen, w[b : b + 1]])
        values = np.concatenate([np.ones(len(chosen)), [-1.0]])
        builder.add_rows(f"{name}_bit", np.zeros(len(cols), np.int64), cols, values, 0.0, 0.0)
