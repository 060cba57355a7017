"""Formulas as flat lists, so that pickling one is as deep as a node and not as the formula."""

from __future__ import annotations

from collections.abc import Sequence

from stlc.ir.nodes import Const, Node
from stlc.ir.rewrite import postorder, with_children

Flat = list[tuple[Node, tuple[int, ...]]]
"""Distinct nodes, children first: each over stand-ins for its children, with their numbers."""

_STAND_IN = Const(True)


def flattened(root: Node) -> tuple[Flat, dict[Node, int]]:
    """The nodes of a formula in a list, and the number of each."""
    flat: Flat = []
    numbers: dict[Node, int] = {}
    for node in postorder([root]):
        numbers[node] = len(flat)
        bare = with_children(node, [_STAND_IN] * len(node.children))
        flat.append((bare, tuple(numbers[child] for child in node.children)))
    return flat, numbers


def restored(flat: Sequence[tuple[Node, tuple[int, ...]]]) -> list[Node]:
    """The nodes of `flattened`, in its order."""
    built: list[Node] = []
    for bare, children in flat:
        built.append(with_children(bare, [built[k] for k in children]))
    return built
