"""Walking and rebuilding formulas without recursion, one visit for each distinct node."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import replace

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Release,
    Timed,
    Until,
)


def postorder(roots: Iterable[Node], known: Container[Node] = ()) -> Iterator[Node]:
    """Every distinct node, children before parents; none that is `known`, and nothing below it."""
    seen: set[Node] = set()
    todo: list[Node | tuple[Node]] = []  # a tuple: its children have been seen
    todo += [*roots][::-1]
    while todo:
        node = todo.pop()
        if isinstance(node, tuple):
            yield node[0]
            continue
        if node in seen or node in known:
            continue
        seen.add(node)
        children = node.children
        if not children:
            yield node
            continue
        todo.append((node,))
        todo += children[::-1]


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


def measures(root: Node) -> bool:
    """Whether faces stand for a Euclidean length in a formula: they are sufficient only."""
    return any(node.norms is not None for node in postorder([root]))


def keeps_to_faces(root: Node) -> bool:
    """Whether a formula asks for alternatives over a time between steps: one of them holds through
    all of it there, where a run may take one after the other."""
    swept = (node for node in postorder([root]) if node.swept is not None)
    return any(isinstance(part, Or) for node in swept for part in postorder([node]))


def named(node: Node) -> frozenset[str]:
    """Owners of a predicate's signals, ends of a link; nobody for any other node."""
    match node:
        case Linear(terms=terms):
            return frozenset(signal.owner for signal, _ in terms)
        case Link(sender=sender, receiver=receiver):
            return frozenset((sender, receiver))
    return frozenset()
