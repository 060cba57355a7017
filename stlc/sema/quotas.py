"""How many polygons moving obstacles may have over all their steps."""

from __future__ import annotations

from collections.abc import Sequence

from stlc.places import Track
from stlc.sema import tracks
from stlc.sema.name_errors import TooLarge
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.source import Span
from stlc.syntax import ast

MOST_PLACED = 30_000
"""Polygons of four corners that moving obstacles have over all steps: some two seconds. What they
touch and what keeps out of them is counted where it is written out (`Scope.spend`)."""

_FRAME = 12  # evaluations that placing a polygon takes as long as


def check_all(statements: Sequence[ast.ObstacleDecl], scope: Scope) -> None:
    """Raise Mistake where obstacles that are known already will have too many polygons."""
    known = [(s, scope.obstacles.get(s.name.text)) for s in statements]
    counts = [(_count(o.track, scope), s) for s, o in known if o is not None and o.track]
    count = sum(count for count, _ in counts)
    if count > MOST_PLACED:
        raise _too_many(count, max(counts, key=lambda each: each[0])[1].span)


def count_in(track: Track, statement: ast.ObstacleDecl, scope: Scope) -> None:
    """Count an obstacle's polygons in. Raises Mistake where there are too many."""
    count = _count(track, scope)
    if scope.placed + count > MOST_PLACED:
        raise _too_many(scope.placed + count, statement.span)
    scope.placed += count
    scope.spend(_FRAME * count, statement.span)


def _count(track: Track, scope: Scope) -> int:
    """Polygons at all steps, those of more than four corners for more; none at rest."""
    steps = tracks.count(track, scope.last_step)
    if steps == 1:
        return 0
    corners = [[len(r) for o in f for r in (o.ring, *o.holes)] for _, f in track.frames]
    return steps * max(sum(-(-n // 4) for n in each) for each in corners)


def _too_many(count: int, span: Span) -> Mistake:
    size = f"{count:,} polygons of moving obstacles over all steps"
    hint = "use a longer `step` or a shorter horizon, or fewer polygons that move"
    return Mistake(TooLarge(span=span, size=size, hint=hint))
