"""Constant folding.

    f and true = f     f and false = false     f or true = true     f or false = f
    op[a,b] true = true, op[a,b] false = false for always, eventually
    f until false = false, false until g = false, true until[a,b] g = eventually[a,b] g
    f release true = true, true release g = true, false release[a,b] g = always[a,b] g
    a predicate without terms is true or false only where its sign decides it for all margins,
    so it stays; `and` of one formula is that formula, and of nothing is true.

Needs: nnf. Guarantees: no constant below any other node than `timed`; robustness unchanged.
"""

from __future__ import annotations

from stlc.ir.networks import Count, counted
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Node,
    Or,
    Release,
    Timed,
    Until,
)
from stlc.ir.rewrite import rewrite
from stlc.passes.base import Pass, Program


def run(program: Program) -> Program:
    """Fold every requirement."""
    return program.with_formulas(rewrite(program.formulas, fold))


def fold(node: Node) -> Node:
    """Fold one node whose children are folded."""
    match node:
        case And(args=args):
            return _lattice(node, args, neutral=True)
        case Or(args=args):
            return _lattice(node, args, neutral=False)
        case Count():
            return counted(node)
        case Always(arg=Const() as arg) | Eventually(arg=Const() as arg):
            return arg
        case Until(left=left, right=right, start=a, end=b):
            if left == Const(False) or right == Const(False):
                return Const(False, span=node.span)
            return Eventually(right, a, b, span=node.span) if left == Const(True) else node
        case Release(left=left, right=right, start=a, end=b):
            if left == Const(True) or right == Const(True):
                return Const(True, span=node.span)
            return Always(right, a, b, span=node.span) if left == Const(False) else node
        case Timed(cases=cases) if all(c == cases[0] for c in cases):
            return cases[0]
    return node


def _lattice(node: And | Or, args: tuple[Node, ...], *, neutral: bool) -> Node:
    if any(isinstance(a, Const) and a.value is not neutral for a in args):
        return Const(not neutral, span=node.span)
    kept = tuple(a for a in args if not isinstance(a, Const))
    if not kept:
        return Const(neutral, span=node.span)
    if len(kept) == 1:
        return kept[0]
    return node if len(kept) == len(args) else type(node)(kept, span=node.span)


PASS = Pass("fold", run, after=("nnf",))
