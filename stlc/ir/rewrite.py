"""Walking and rebuilding formulas without recursion, one visit for each distinct node."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Eventually,
    Iff,
    Implies,
    Node,
    Not,
    Or,
    Release,
    Timed,
    Until,
)


def postorder(roots: Iterable[Node]) -> Iterator[Node]:
    """Every distinct node, children before parents."""
    seen: set[Node] = set()
    todo: list[tuple[Node, bool]] = [(root, False) for root in reversed(list(roots))]
    while todo:
        node, ready = todo.pop()
        if ready:
            yield node
            continue
        if node in seen:
            continue
        seen.add(node)
        todo.append((node, True))
        todo.extend((child, False) for child in reversed(node.children))


def with_children(node: Node, children: Sequence[Node]) -> Node:
    """The node over other children; the node itself where nothing changed."""
    old = node.children
    if len(old) == len(children) and all(a is b for a, b in zip(old, children, strict=True)):
        return node
    match node:
        case And() | Or() | Count() | Network():
            return replace(node, args=tuple(children))
        case Timed():
            return replace(node, cases=tuple(children))
        case Not() | Always() | Eventually():
            return replace(node, arg=children[0])
        case Implies() | Iff() | Until() | Release():
            return replace(node, left=children[0], right=children[1])
    raise TypeError(f"{type(node).__name__} has no children")


def rewrite(roots: Sequence[Node], visit: Callable[[Node], Node]) -> tuple[Node, ...]:
    """Apply `visit` bottom-up: it sees each node over its rewritten children."""
    done: dict[Node, Node] = {}
    for node in postorder(roots):
        done[node] = visit(with_children(node, [done[c] for c in node.children]))
    return tuple(done[root] for root in roots)


def conjuncts(node: Node) -> tuple[Node, ...]:
    """What has to hold together: the arguments of a conjunction, anything else alone."""
    return node.args if isinstance(node, And) else (node,)
