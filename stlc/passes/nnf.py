"""Negation normal form.

    not (f and g)        = not f or not g            not always f     = eventually not f
    f implies g          = not f or g                not (f until g)  = not f release not g
    f iff g              = (not f or g) and (not g or f)
    not (k of f, g, ..)  = all but k - 1 of not f, ..
    not network of f, .. = cut of not f, ..          (see `ir/networks.py`)
    not (mu >= 0)        = -mu >= 0                  not (q >= c)     = q <= c

Needs: nothing. Guarantees: negation only at chance links, no implies, no iff; the robustness is
unchanged (each line is an identity of min, max and minus).
"""

from __future__ import annotations

from dataclasses import replace

from stlc.ir.networks import Count, Network, negated_count, negated_network
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Relation,
    Release,
    Timed,
    Until,
)
from stlc.ir.verify import Stage
from stlc.passes.base import Pass, Program

_Key = tuple[Node, bool]


def run(program: Program) -> Program:
    """Push negations inward in every requirement."""
    done: dict[_Key, Node] = {}
    return program.with_formulas([_normalise(f, done) for f in program.formulas])


def _normalise(root: Node, done: dict[_Key, Node]) -> Node:
    """Normal form of a formula by (node, polarity), children first and without recursion."""
    todo: list[tuple[Node, bool]] = [(root, True)]
    while todo:
        key = todo[-1]
        missing = [need for need in _needs(*key) if need not in done]
        if missing:
            todo.extend(missing)
            continue
        todo.pop()
        done[key] = _build(*key, done)
    return done[root, True]


def _needs(node: Node, positive: bool) -> list[_Key]:
    match node:
        case Not(arg=arg):
            return [] if isinstance(arg, Link) else [(arg, not positive)]
        case Implies(left=left, right=right):
            return [(left, not positive), (right, positive)]
        case Iff(left=left, right=right):
            return [(left, True), (left, False), (right, True), (right, False)]
    return [(child, positive) for child in node.children]


def _build(node: Node, positive: bool, done: dict[_Key, Node]) -> Node:
    """Normal form of a node, or of its negation, over those of its children in `done`."""
    span = node.span
    match node:
        case Const() | Linear() | Link():
            return node if positive else negated(node)
        case Not(arg=Link() as link):
            return negated(link) if positive else link
        case Iff(left=left, right=right):
            ways = [((left, False), (right, positive)), ((left, True), (right, not positive))]
            return And(tuple(Or((done[a], done[b]), span=span) for a, b in ways), span=span)
    parts = tuple(done[need] for need in _needs(node, positive))
    match node:
        case Not():
            return parts[0]
        case Timed():
            return Timed(parts, span=span)
        case And() | Or():
            kind = And if isinstance(node, And) is positive else Or
            return kind(parts, span=span)
        case Count():
            return replace(node, args=parts) if positive else negated_count(node, parts)
        case Network():
            return replace(node, args=parts) if positive else negated_network(node, parts)
        case Implies():
            return (Or if positive else And)(parts, span=span)
        case Always(start=a, end=b) | Eventually(start=a, end=b):
            operator = Always if isinstance(node, Always) is positive else Eventually
            return operator(parts[0], a, b, span=span)
        case Until(start=a, end=b) | Release(start=a, end=b):
            binary = Until if isinstance(node, Until) is positive else Release
            return binary(parts[0], parts[1], a, b, span=span)
    raise TypeError(f"no normal form of {type(node).__name__}")


def negated(node: Const | Linear | Link) -> Node:
    """The negation of a leaf."""
    match node:
        case Const(value=value):
            return Const(not value, span=node.span)
        case Linear(terms=terms):
            flipped = tuple((signal, -value) for signal, value in terms)
            return replace(node, terms=flipped, constant=-node.constant)
        case Link(probability=None, relation=relation):
            other = Relation.AT_MOST if relation is Relation.AT_LEAST else Relation.AT_LEAST
            return replace(node, relation=other)
        case Link():
            return Not(node, span=node.span)


PASS = Pass("nnf", run, stage=Stage.NNF, lowering=True)
