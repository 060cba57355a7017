"""Structural equality of formulas, whose parts may be shared and deep, in linear time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol


class Part(Protocol):
    """What nodes are here: `own` is all that makes two equal beside their children."""

    @property
    def _hash(self) -> int:
        """Equal nodes have equal ones."""

    @property
    def _same(self) -> Any:
        """A node that equals this one and stands for it, or None."""

    @property
    def own(self) -> tuple[object, ...]:
        """What is compared of the node itself."""

    @property
    def children(self) -> Sequence[Any]:
        """Its parts."""


def equal(one: Part, other: Part) -> bool:
    """Structural equality without recursion, each pair of parts compared once, ever.

    A formula that uses its parts often, told twice, has more paths than could ever be walked; and a
    chain of such formulas is compared at every level. So nodes that are equal are joined: each
    class of them has one `_first` (union-find).
    """
    seen: set[tuple[int, int]] = set()
    pairs: list[tuple[Part, Part]] = []
    todo = [(one, other)]
    while todo:
        a, b = (_first(node) for node in todo.pop())
        if a is b or (id(a), id(b)) in seen:
            continue
        if type(a) is not type(b) or a._hash != b._hash or a.own != b.own:
            return False
        seen.add((id(a), id(b)))
        pairs.append((a, b))
        todo += zip(a.children, b.children, strict=True)
    for a, b in pairs:
        first, second = _first(a), _first(b)
        if first is not second:
            object.__setattr__(second, "_same", first)
    return True


def _first(node: Part) -> Part:
    """The node that stands for all that are known to equal this one."""
    while node._same is not None:
        if node._same._same is not None:
            object.__setattr__(node, "_same", node._same._same)
        node = node._same
    return node
