"""Link costs as the relaxation counts them: by pair and step, over the common grid.

A state of an agent is in the cell that the first table of that agent and step takes. On a border
every other table may take another of the touching cells, so it counts with the least of them; with
`borders` as cells of their own only there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.radio.partition import TOUCH, Partition
from stlc.solve.relaxation.borders import with_borders


@dataclass(frozen=True, slots=True, eq=False)
class Touching:
    """Which cells share a border or a corner; `near` (n, k): numbers, a cell's own as filling."""

    near: Ints

    @classmethod
    def of(cls, boxes: Floats) -> Touching:
        """Of closed boxes (n, 4) [m]."""
        meets = np.ones((len(boxes), len(boxes)), bool)
        for low, high in ((0, 1), (2, 3)):
            meets &= boxes[:, None, low] <= boxes[None, :, high] + TOUCH
            meets &= boxes[None, :, low] <= boxes[:, None, high] + TOUCH
        width = int(meets.sum(axis=1).max())
        order = np.argsort(~meets, axis=1, kind="stable")[:, :width]
        kept = np.take_along_axis(meets, order, axis=1)
        return cls(np.where(kept, order, np.arange(len(boxes))[:, None]))

    def least(self, table: Floats, ends: Sequence[bool]) -> Floats:
        """Least entry among touching cells, along the axes of a table where `ends` says so."""
        for axis in np.flatnonzero(ends):
            parts = (np.take(table, self.near[:, k], axis=axis) for k in range(self.near.shape[1]))
            table = np.minimum.reduce(list(parts))
        return table

    def around(self, alive: Bools, ends: Sequence[bool]) -> Bools:
        """Cells, or cell pairs, that touch one which is alive, along the axes `ends`."""
        return np.asarray(self.least((~alive).astype(np.float64), ends) == 0.0)


@dataclass(slots=True, eq=False)
class Costs:
    """Link costs by pair, or agent alone, and step, on the common grid."""

    names: Sequence[str]
    partition: Partition
    horizon: int
    borders: bool = False
    pairs: dict[tuple[int, int], list[Floats | None]] = field(default_factory=dict)
    alone: list[list[Floats | None]] = field(init=False)
    _owner: Ints = field(init=False)
    _shape: tuple[int, int] = field(init=False)
    _touching: Touching = field(init=False)
    _first: dict[tuple[str, int], object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.alone = [[None] * (self.horizon + 1) for _ in self.names]
        fine, owner = self.partition.common_grid()
        assert fine.shape is not None
        nx, ny = fine.shape
        self._owner, self._shape = np.maximum(owner, 0), (nx, ny)
        self._touching = Touching.of(self.partition.boxes)

    def add(
        self, pair: tuple[str, str], table: Floats, steps: range, *, proof: bool = True
    ) -> bool:
        """Count a table over the partition's cells at some steps; False where no end is known.

        Without `proof` all tables take one cell, which bounds nothing but guides as well.
        """
        ends = [n for n in pair if n in self.names]
        if not ends or len(ends) < table.ndim:
            return False
        if self.borders:
            own = with_borders(self._on_fine(table), self._shape) if table.ndim else table
            for t in steps:
                self._count(ends, own, t)
            return True
        user = object()
        made: dict[tuple[bool, ...], Floats] = {}
        for t in steps:
            first = [self._first.setdefault((n, t), user) is user for n in ends]
            later = tuple(proof and not own for own in first)
            if later not in made:
                made[later] = self._on_fine(self._touching.least(table, later[: table.ndim]))
            self._count(ends, made[later], t)
        return True

    def _count(self, ends: Sequence[str], table: Floats, t: int) -> None:
        """Add a table on the common grid to those of its ends."""
        numbers = [list(self.names).index(n) for n in ends]
        if len(numbers) == 2 and numbers[0] > numbers[1]:
            numbers, table = numbers[::-1], table.T
        into = self.alone[numbers[0]]
        if len(numbers) == 2:
            key = (numbers[0], numbers[1])
            into = self.pairs.setdefault(key, [None] * (self.horizon + 1))
        known = into[t]
        into[t] = table if known is None else known + table

    def _on_fine(self, table: Floats) -> Floats:
        return table[np.ix_(*[self._owner] * table.ndim)] if table.ndim else table
