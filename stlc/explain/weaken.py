"""Formulas made weaker: conjuncts apart, parts left out, windows narrowed.

Whatever satisfies a formula satisfies every weaker form of it, so that what is proven of the weaker
forms together is proven of the formulas. Parts are left out by polarity:

    phi and psi            phi                  where it counts positively
    not (phi or psi)       not phi
    always[a,b] phi        always[c,d] phi      a <= c <= d <= b
    phi until[a,b] psi     eventually[a,b] psi, always[0,a] phi
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Eventually,
    Implies,
    Node,
    Not,
    Or,
    Until,
)
from stlc.ir.requirement import Requirement


def conjuncts(requirement: Requirement) -> tuple[Requirement, ...]:
    """What has to hold together, each with its own span: `and`, and `always` over `and`, split."""
    return tuple(replace(requirement, formula=f) for f in _split(requirement.formula))


def _split(formula: Node) -> tuple[Node, ...]:
    """Parts that hold together exactly when the formula does, each with a span of its own."""
    if is_atom(formula):
        return (formula,)
    match formula:
        case And(args=args):
            return tuple(piece for arg in args for piece in _split(arg))
        case Always(arg=inner) if isinstance(inner, And | Always) and not is_atom(inner):
            parts = _split(inner)
            if len(parts) < 2:
                return (formula,)
            return tuple(replace(formula, arg=p, span=p.span or formula.span) for p in parts)
        case _:
            return (formula,)


def is_atom(node: Node) -> bool:
    """Whether a node is one condition of the file, whatever it is made of."""
    if node.member or node.swept or node.norms or not node.children:
        return True
    if isinstance(node, Count | Network) or _is_chance(node):
        return True
    return isinstance(node, And | Or) and all(c.span == node.span for c in node.children)


def _is_chance(node: Node) -> bool:
    """`P(always ..) >= p` whose risk the plan shares out: floors of all shares, and their sum."""
    return isinstance(node, And) and any(isinstance(c, Count) and c.weights for c in node.args)


def drops(node: Node, positive: bool = True) -> Iterator[Node]:
    """The formula with one part left out, in every way; outer parts first, left to right."""
    if is_atom(node):
        return
    match node:
        case And(args=args) | Or(args=args):
            if isinstance(node, And) is positive and len(args) > 1:
                for k in range(len(args)):
                    yield _joined(node, args[:k] + args[k + 1 :])
            for k, arg in enumerate(args):
                for less in drops(arg, positive):
                    yield replace(node, args=(*args[:k], less, *args[k + 1 :]))
        case Not(arg=arg):
            yield from (replace(node, arg=less) for less in drops(arg, not positive))
        case Always(arg=arg) | Eventually(arg=arg):
            yield from (replace(node, arg=less) for less in drops(arg, positive))
        case Implies(left=left, right=right):
            yield from (replace(node, left=less) for less in drops(left, not positive))
            yield from (replace(node, right=less) for less in drops(right, positive))
        case Until(left=left, right=right, start=a, end=b):
            if positive:
                yield Eventually(right, a, b, span=node.span)
                yield Always(left, 0, a, span=node.span)
            yield from (replace(node, left=less) for less in drops(left, positive))
            yield from (replace(node, right=less) for less in drops(right, positive))
        case _:
            return


def _joined(node: And | Or, args: tuple[Node, ...]) -> Node:
    return args[0] if len(args) == 1 else replace(node, args=args)


def window(formula: Node, last: int) -> tuple[int, int] | None:
    """First and last step of an `always` that is judged from step 0; `last` of its body's steps."""
    if not isinstance(formula, Always):
        return None
    return formula.start, last if formula.end is None else formula.end


def narrowed(requirement: Requirement, first: int, last: int) -> Requirement:
    """The `always` of a requirement over other steps."""
    formula = requirement.formula
    assert isinstance(formula, Always)
    return replace(requirement, formula=replace(formula, start=first, end=last))
