"""`(..) swept`: a formula that holds between the steps too.

Conjunctions hold at all times where each of their parts does, so that `(r in a and r outside b)
swept` is `r in a swept and r outside b swept`: places move, touch others and are judged by their
own shapes there as anywhere. Any other formula is a condition on states and inputs.
"""

from __future__ import annotations

from dataclasses import replace

from stlc.ir.nodes import And, Motion, Node, Swept, Timed, walk
from stlc.sema.membership import swept_membership
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import NoSwept
from stlc.sema.swept import separation_claim, sweep
from stlc.source import Span

_HINT = "write `swept` behind each `outside` or `in` instead"


def between_steps(node: Node, scope: Scope, span: Span) -> Node:
    """`node`, a formula at the steps, as one that holds until the next. Raises Mistake (E0412)."""
    if node.swept is not None:
        return node
    if node.member is not None:
        return replace(swept_membership(node.member, scope), span=node.span)
    if isinstance(node, And) and any(n.member is not None for n in walk(node)):
        return replace(node, args=tuple(between_steps(a, scope, span) for a in node.args))
    claim = separation_claim(node, scope) or _condition(node, span)
    return replace(sweep(node, scope, span), span=span, swept=claim)


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
