"""A link at a step: the ends that move, the cells they can be in, and the table between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stlc.arrays import Floats
from stlc.milp.context import Context
from stlc.milp.tables.cells import Place
from stlc.milp.tables.errors import TableError
from stlc.milp.tables.spans import Cells, Spans, spans_of

Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, slots=True)
class Link:
    """No, one or two moving ends on one partition at one step, for one user: see `users`."""

    spans: Spans
    ends: tuple[str, ...]
    step: int
    user: bytes = b""

    @property
    def places(self) -> tuple[Place, ...]:
        """Each end at this step."""
        return tuple(Place(self.spans, end, self.step, self._at(end)) for end in self.ends)

    def _at(self, end: str) -> bytes:
        """The user of one end's columns: the same table between others is another user."""
        return b"|".join([self.user, *(e.encode() for e in self.ends if e != end)])

    def key(self, what: str) -> tuple[object, ...]:
        """Memo key of something made for this link."""
        return ("tables", what, self.spans.key, self.ends, self.step, self.user)

    def name(self, what: str) -> str:
        """Name of a block made for this link."""
        return "_".join([what, *self.ends, str(self.step)])

    def shape(self, ctx: Context) -> tuple[int, ...]:
        """Cells in reach of each end."""
        return tuple(len(p.reach(ctx).cells) for p in self.places)

    def reachable(self, ctx: Context, table: NDArray[Scalar]) -> NDArray[Scalar]:
        """The part of a table over all cells that this step can see."""
        return table[np.ix_(*(p.reach(ctx).cells for p in self.places))]


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """The moving ends of a pair in canonical order; `swapped` says that the table turns over."""

    spans: Spans
    names: tuple[str, ...]
    swapped: bool

    def at(self, step: int, user: bytes = b"") -> Link:
        """The link at a step, for a user."""
        return Link(self.spans, self.names, step, user)

    def table(self, values: ArrayLike) -> Floats:
        """A table (n,) * moving ends in canonical order. Raises TableError on any other shape."""
        table = np.asarray(values, dtype=np.float64)
        expected = (len(self.spans),) * len(self.names)
        if table.shape != expected:
            raise TableError(
                f"the table between {' and '.join(self.names) or 'stations'} has shape "
                f"{table.shape}, its partition needs {expected}"
            )
        if not np.isfinite(table).all():
            raise TableError("a table needs finite values in every cell")
        return table.T if self.swapped else table


def ends_of(ctx: Context, partition: Cells, pair: Sequence[str]) -> Ends:
    """Canonical form of a pair: r(b, a) and r(a, b) share their columns. Stations are left out."""
    key = ("tables.spans", id(partition))
    if key not in ctx.memo:
        ctx.memo[key] = (spans_of(partition), partition)
    spans: Spans = ctx.memo[key][0]
    moving = tuple(name for name in pair if name in ctx.mission.agents)
    if len(moving) == 2 and moving[0] == moving[1]:
        raise TableError(f"a link needs two different radios, not {moving[0]} twice")
    swapped = len(moving) == 2 and moving[0] > moving[1]
    return Ends(spans, moving[::-1] if swapped else moving, swapped)
