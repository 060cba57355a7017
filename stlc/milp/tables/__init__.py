"""Link tables in the MILP: costs, values and thresholds between cells of two radios.

Cells are closed: at a border every cost takes the cheapest of the touching cells and every
predicate the best, each by itself. The first table of an agent at a step has the cell columns
to itself, the others have a choice of their own where the agent stands on a border (`users`).
Positions are held inside the partition at the steps where a table is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stlc.arrays import Floats
from stlc.milp.context import Affine, Context
from stlc.milp.tables.encoding import Encoding, Size
from stlc.milp.tables.errors import TableError
from stlc.milp.tables.link import Link, ends_of
from stlc.milp.tables.registry import ENCODINGS, Choice, choose
from stlc.milp.tables.simplex import Kind
from stlc.milp.tables.threshold import literal
from stlc.milp.tables.users import ALLOWED, COST, VALUE, turn_of, user_of

if TYPE_CHECKING:
    from stlc.mission import Channel

__all__ = [
    "ENCODINGS",
    "Choice",
    "Encoding",
    "Size",
    "TableError",
    "add_link_cost",
    "choose",
    "link_bound",
    "link_literal",
    "link_value",
    "reserve_link_cost",
]


def add_link_cost(
    ctx: Context,
    channel: Channel,
    pair: tuple[str, str],
    table: ArrayLike,
    steps: Sequence[int],
    weight: float,
    encoding: str = "auto",
) -> Choice:
    """Add weight * sum over steps of table[cell(a), cell(b)] to the objective.

    table (n, n) over the channel's cells for two agents, (n,) for an agent and a station, () for
    two stations. Returns the encoding taken and why. Raises TableError for a table that doesn't
    fit, UsageError for an unknown encoding.
    """
    ends = ends_of(ctx, channel.partition, pair)
    values = weight * ends.table(table)
    links = [ends.at(step, user_of(COST, ends.table(table))) for step in steps]
    choice = choose(ctx, links, encoding)
    for link in links:
        cost = choice.encoding.below(ctx, link, values)
        ctx.builder.add_cost(cost.cols, cost.values)
        ctx.builder.offset += cost.constant
    return choice


def link_value(
    ctx: Context,
    channel: Channel,
    pair: tuple[str, str],
    values: ArrayLike,
    step: int,
    encoding: str = "auto",
) -> Affine:
    """The table's value at a step as an expression, exact at integer points from both sides.

    Arguments and errors as in `add_link_cost`.
    """
    chosen, link, table = _valued(ctx, channel, pair, values, step, encoding)
    return chosen.value(ctx, link, table)


def link_bound(
    ctx: Context,
    channel: Channel,
    pair: tuple[str, str],
    values: ArrayLike,
    step: int,
    encoding: str = "auto",
) -> Affine:
    """An expression that is at least the table's value at a step, and may be the value itself.

    Arguments and errors as in `add_link_cost`.
    """
    chosen, link, table = _valued(ctx, channel, pair, values, step, encoding)
    return chosen.below(ctx, link, table)


def _valued(
    ctx: Context,
    channel: Channel,
    pair: tuple[str, str],
    values: ArrayLike,
    step: int,
    encoding: str,
) -> tuple[Encoding, Link, Floats]:
    """The encoding that is taken for a table's value at a step, the link, and its table."""
    ends = ends_of(ctx, channel.partition, pair)
    table = ends.table(values)
    link = ends.at(step, user_of(VALUE, table))
    return choose(ctx, [link], encoding).encoding, link, table


def link_literal(
    ctx: Context,
    channel: Channel,
    pair: tuple[str, str],
    allowed: ArrayLike,
    step: int,
) -> int:
    """Column z in {0, 1}: z = 1 puts the radios into cells (c_a, c_b) with allowed[c_a, c_b].

    allowed as the table of `add_link_cost`, true where the predicate holds. z = 0 says nothing.
    """
    ends = ends_of(ctx, channel.partition, pair)
    mask = ends.table(np.asarray(allowed)) > 0.5
    return literal(ctx, ends.at(step, user_of(ALLOWED, mask)), mask)


def reserve_link_cost(
    ctx: Context, channel: Channel, pair: tuple[str, str], table: ArrayLike, steps: Sequence[int]
) -> None:
    """Give a link cost that comes later the cell columns themselves; arguments as there.

    Its pair columns are many: they had better stand on columns that bear no second choice.
    """
    ends = ends_of(ctx, channel.partition, pair)
    user = user_of(COST, ends.table(table))
    for place in (p for step in steps for p in ends.at(step, user).places):
        turn_of(ctx, place, Kind.ORDERED)
