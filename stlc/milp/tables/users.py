"""Who uses the cell columns of an agent at a step: at a border every table has its own choice.

A user is one table or allowed set between certain ends. The first to ask has the columns that say
in which cell the agent is; whoever comes later is told its turn.
"""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stlc.milp.context import Context
from stlc.milp.tables.simplex import Kind

if TYPE_CHECKING:
    from stlc.milp.tables.cells import Place


COST, VALUE, ALLOWED = b"cost", b"value", b"allowed"
"""What a user looks up."""


def user_of(kind: bytes, table: NDArray[Any]) -> bytes:
    """Name of a user: what it looks up, and in which table."""
    return kind + blake2b(np.ascontiguousarray(table).tobytes(), digest_size=16).digest()


def turn_of(ctx: Context, place: Place, kind: Kind) -> int:
    """0 for the first user that asked for columns of this kind at a place, then 1, 2, ..."""
    if not place.user:
        return 0
    turns: dict[bytes, int] = ctx.memo.setdefault(
        ("tables.users", kind, place.spans.key, place.agent, place.step), {}
    )
    return turns.setdefault(place.user, len(turns))
