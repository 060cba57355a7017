"""Formula encodings: how one disjunction with exactly one alternative taken becomes columns and
rows (sum z = P, P in {0, 1}).

    onehot    z_i in {0, 1}: k binaries
    unary     z_i >= 0, y_j = z_1 + ... + z_j in {0, 1}, j < k: k - 1 binaries, ordered
              y_1 <= y_2 <= ...; branching on y_j splits the alternatives into before and after
    log       z_i >= 0, bit w_b = sum of the z_i whose reflected Gray code has bit b: ceil(log2 k)
              binaries (Vielma and Nemhauser, Modeling disjunctive constraints with a logarithmic
              number of binary variables and constraints, 2011)
    bigm      onehot without the shared-face rows of `choice.py`: the textbook, for comparison
    hull      onehot with copies of the variables, see `hull.py`

All are exact. The first three have the same LP relaxation and differ in how a solver branches;
hull's is the tightest, bigm's the weakest. A package offers its own under the entry-point group
`stlc.encodings`: an object with `kind = "stl"` and the methods of `FormulaEncoding`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from types import MappingProxyType
from typing import Protocol

import numpy as np

from stlc.arrays import Ints
from stlc.errors import UsageError, hinted
from stlc.ir.nodes import Linear
from stlc.milp.builder import ModelBuilder
from stlc.milp.formulas.choice import Faces
from stlc.milp.formulas.hull import Hull
from stlc.milp.layout import Literals

ENTRY_POINTS = "stlc.encodings"
"""Entry-point group of encodings, of formulas and of link tables."""

FEW = 4
"""So few alternatives are always one-hot: fewer binaries would not help."""


class FormulaEncoding(Protocol):
    """One way to encode a choice of exactly one alternative."""

    @property
    def name(self) -> str:
        """Its name in options and reports."""

    def literals(self, builder: ModelBuilder, size: int) -> Literals:
        """Columns z (size,) that are 0 or 1 at integer points; the caller adds sum z = P."""

    def add_rows(
        self,
        faces: Faces,
        literals: Ints,
        predicates: Sequence[Sequence[Linear]],
        parents: Sequence[int],
    ) -> None:
        """z_i = 1 => the predicates of alternative i hold; P = sum of `parents`, 1 without any."""


@dataclass(frozen=True, slots=True)
class Selector:
    """Literals by `select`, rows by shared faces (or one literal at a time)."""

    name: str
    select: Callable[[ModelBuilder, int], Literals]
    share: bool = True

    def literals(self, builder: ModelBuilder, size: int) -> Literals:
        """Columns z (size,)."""
        return _one_hot(builder, size) if size <= FEW else self.select(builder, size)

    def add_rows(
        self,
        faces: Faces,
        literals: Ints,
        predicates: Sequence[Sequence[Linear]],
        parents: Sequence[int],
    ) -> None:
        """See `choice.py`; the rows allow for sum z = 0 by themselves."""
        if self.share:
            faces.shared([int(z) for z in literals], predicates)
            return
        for z, own in zip(literals, predicates, strict=True):
            faces.shared([int(z)], [own])


def _one_hot(builder: ModelBuilder, size: int) -> Literals:
    return Literals(builder.binary("z", (size,)))


def _unary(builder: ModelBuilder, size: int) -> Literals:
    """y_j - y_{j-1} - z_j = 0."""
    z = builder.add_columns("z", (size,), 0.0, 1.0)
    y = builder.binary("z_until", (size - 1,))
    builder.add_dense_rows("z_until", [[y[0], z[0]]], [1.0, -1.0], 0.0, 0.0)
    cols = np.column_stack([y[1:], y[:-1], z[1:-1]])
    builder.add_dense_rows("z_until", cols, [1.0, -1.0, -1.0], 0.0, 0.0)
    return Literals(z, y)


def _log(builder: ModelBuilder, size: int) -> Literals:
    """sum {z_i : bit b of gray(i)} - w_b = 0."""
    z = builder.add_columns("z", (size,), 0.0, 1.0)
    codes = np.arange(size) ^ (np.arange(size) >> 1)
    bits = int(size - 1).bit_length()
    w = builder.binary("z_bit", (bits,))
    for b in range(bits):
        chosen = z[(codes >> b) & 1 == 1]
        cols = np.concatenate([chosen, w[b : b + 1]])
        values = np.concatenate([np.ones(len(chosen)), [-1.0]])
        builder.add_rows("z_bit", np.zeros(len(cols), np.int64), cols, values, 0.0, 0.0)
    return Literals(z, w)


ONE_HOT = Selector("onehot", _one_hot)
SELECTORS: Mapping[str, FormulaEncoding] = MappingProxyType(
    {
        "onehot": ONE_HOT,
        "unary": Selector("unary", _unary),
        "log": Selector("log", _log),
        "bigm": Selector("bigm", _one_hot, share=False),
        "hull": Hull(),
    }
)
"""Built-in formula encodings."""


def selector_named(name: str) -> FormulaEncoding | None:
    """The encoding of that name, None for `auto` (chosen for each disjunction).

    Built-in, or offered by an installed package. UsageError for an unknown name.
    """
    if name == "auto":
        return None
    if name in SELECTORS:
        return SELECTORS[name]
    offered = {e.name: e for e in entry_points(group=ENTRY_POINTS)}
    if name in offered:
        loaded = offered[name].load()
        if getattr(loaded, "kind", "link") == "stl":
            own: FormulaEncoding = loaded
            return own
    known = ["auto", *SELECTORS]
    raise UsageError(f"no formula encoding is called '{name}'; {hinted(name, known)}")
