"""Equality of syntax trees up to the places of their nodes."""

from __future__ import annotations

from stlc.record import Record
from stlc.source import Source, Span
from stlc.syntax.nodes import Arithmetic


def same_syntax(left: object, right: object) -> bool:
    """Whether two nodes (or tuples of nodes) say the same, wherever they were written."""
    if type(left) is not type(right):
        return False
    if isinstance(left, tuple) and isinstance(right, tuple):
        pairs = zip(left, right, strict=False)
        return len(left) == len(right) and all(same_syntax(a, b) for a, b in pairs)
    if isinstance(left, Span | Source):
        return True
    if isinstance(left, Arithmetic) and isinstance(right, Arithmetic):
        return _same_chain(left.spine, right.spine)
    if isinstance(left, Record):
        names = (name for name in type(left).record_fields if name != "comments")
        return all(same_syntax(getattr(left, name), getattr(right, name)) for name in names)
    return left == right


def _same_chain(left: list[Arithmetic], right: list[Arithmetic]) -> bool:
    """Flat chains of operations, without recursion along them."""
    pairs = list(zip(left, right, strict=False))
    return (
        len(left) == len(right)
        and same_syntax(left[0].left, right[0].left)
        and all(a.operator == b.operator and same_syntax(a.right, b.right) for a, b in pairs)
    )
