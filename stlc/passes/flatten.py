"""Flattening and idempotence.

    (f and g) and h = f and g and h        (f or g) or h = f or g or h        f and f = f

A child with several parents is opened only where it is small, so that the DAG never grows by more
than a constant factor.

Needs: nothing. Guarantees: no unshared `and` directly below `and`, no unshared `or` directly below
`or`, no argument twice; robustness unchanged.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from stlc.ir.nodes import And, Node, Or
from stlc.ir.rewrite import postorder, with_children
from stlc.passes.base import Pass, Program

_SMALL = 4  # arguments of a shared child that are copied into each parent


def run(program: Program) -> Program:
    """Flatten every requirement."""
    parents = Counter(c for node in postorder(program.formulas) for c in node.children)
    done: dict[Node, Node] = {}
    for node in postorder(program.formulas):
        built = with_children(node, [done[c] for c in node.children])
        if isinstance(built, And | Or):
            built = _flat(built, node, parents, done)
        done[node] = built
    return program.with_formulas([done[f] for f in program.formulas])


def _flat(built: And | Or, node: Node, parents: Counter[Node], done: dict[Node, Node]) -> Node:
    kept = tuple(dict.fromkeys(_opened(built, node, parents, done)))
    return built if kept == built.args else type(built)(kept, span=built.span)


def _opened(
    built: And | Or, node: Node, parents: Counter[Node], done: dict[Node, Node]
) -> Iterator[Node]:
    for child in node.children:
        part = done[child]
        same = type(part) is type(built)
        if same and (parents[child] == 1 or len(part.children) <= _SMALL):
            yield from part.children
        else:
            yield part


PASS = Pass("flatten", run, after=("nnf",))
