"""`(..) swept`: a formula that holds between the steps too.

Negations are moved to predicates and places first. Conjunctions hold at all times where each of
their parts does, so that `(r in a and r outside b) swept` is `r in a swept and r outside b swept`:
places move, touch others and are judged by their own shapes there as anywhere. Any other formula is
a condition on states and inputs.
"""

from __future__ import annotations

from dataclasses import replace

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Motion,
    Node,
    Not,
    Or,
    Release,
    Swept,
    Timed,
    Until,
    walk,
)
from stlc.sema.membership import opposite, swept_membership
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import NoSwept
from stlc.sema.swept import separation_claim, sweep
from stlc.source import Span

_LINKS = "leave out `swept` around links"
_HINT = "write `swept` behind each `outside` or `in` instead"


def between_steps(node: Node, scope: Scope, span: Span) -> Node:
    """`node`, a formula at the steps, as one that holds until the next. Raises Mistake (E0412)."""
    if node.swept is not None:
        return node
    if node.member is not None:
        return replace(swept_membership(node.member, scope), span=node.span)
    pushed = _pushed(node, True, scope, span, {})
    if pushed.member is not None:
        return between_steps(pushed, scope, span)
    placed = any(n.member is not None for n in walk(pushed))
    if isinstance(pushed, And) and placed:
        return replace(pushed, args=tuple(between_steps(a, scope, span) for a in pushed.args))
    claim = separation_claim(pushed, scope) or _condition(pushed if placed else node, span)
    return replace(sweep(pushed, scope, span), span=span, swept=claim)


_Done = dict[tuple[int, bool], Node]
"""By node and sign: formulas that use a part often have more paths than could be walked."""


def _pushed(node: Node, positive: bool, scope: Scope, span: Span, done: _Done) -> Node:
    """A condition, or its negation, without `not`, `implies` and `iff`. Raises Mistake (E0412).

    The negation of `in` is `outside`, which closes what touches, and the other way round.
    """
    key = id(node), positive
    if key not in done:
        done[key] = _push(node, positive, scope, span, done)
    return done[key]


def _push(node: Node, positive: bool, scope: Scope, span: Span, done: _Done) -> Node:
    """The same of a node that is met for the first time."""
    if node.member is not None:
        return node if positive else replace(opposite(node.member, scope), span=node.span)
    if node.swept is not None or (positive and isinstance(node, Linear | Const | Timed)):
        return node

    def pushed(part: Node, sign: bool = True) -> Node:
        return _pushed(part, positive is sign, scope, span, done)

    match node:
        case Linear(terms=terms, constant=constant):
            return replace(node, terms=tuple((s, -c) for s, c in terms), constant=-constant)
        case Const(value=value):
            return replace(node, value=not value)
        case Timed(cases=cases):
            return replace(node, cases=tuple(map(pushed, cases)))
        case Not(arg=arg):
            return pushed(arg, False)
        case And(args=args) | Or(args=args):
            kind = And if isinstance(node, And) is positive else Or
            norms = node.norms if positive or node.norms is None else node.norms.negated()
            return kind(tuple(map(pushed, args)), span=node.span, norms=norms)
        case Implies(left=left, right=right):
            kind = Or if positive else And
            return kind((pushed(left, False), pushed(right)), span=node.span)
        case Iff(left=left, right=right):
            ways = ((pushed(left, False), pushed(right)), (pushed(right, False), pushed(left)))
            # Under a negation: one of the sides and the other's negation.
            kind, inner = (And, Or) if positive else (Or, And)
            return kind(tuple(inner(way, span=node.span) for way in ways), span=node.span)
    raise Mistake(_refusal(node, span))


def _refusal(node: Node, span: Span) -> NoSwept:
    """Why a part of a formula has no meaning between the steps."""
    match node:
        case Always() | Eventually() | Until() | Release():
            problem = "it stands for one step at a time, and the brackets speak of several"
            return NoSwept(span=span, problem=problem, hint="put it inside: `always (..) swept`")
        case Link() | Network() | Count():
            return NoSwept(span=span, problem="links are judged at the steps", hint=_LINKS)
    return NoSwept(span=span, problem="this is not a condition on positions")


def _condition(node: Node, span: Span) -> Swept:
    """The claim of a condition, whose alternatives are of what stands still and touches nothing."""
    if any(isinstance(n, Timed) for n in walk(node)):
        raise Mistake(
            NoSwept(span=span, problem="a place that moves is an alternative", hint=_HINT)
        )
    if any(isinstance(n, And) and n.member is None and _avoids_two(n) for n in walk(node)):
        problem = "to keep out of two places at once is an alternative"
        raise Mistake(NoSwept(span=span, problem=problem, hint=_HINT))
    return Swept(Motion.CONDITION, condition=node)


def _avoids_two(node: Node) -> bool:
    return sum(n.member is not None and not n.member.inside for n in walk(node)) > 1
