"""Absorption and dominated predicates.

    f and (f or g) = f                 f or (f and g) = f
    mu and mu + c = mu for c >= 0      mu or mu + c = mu + c       (one normal, two constants)

Needs: nnf. Guarantees: robustness unchanged (identities of min and max).
"""

from __future__ import annotations

from dataclasses import replace

from stlc.ir.nodes import And, Linear, Node, Or
from stlc.ir.rewrite import rewrite
from stlc.passes.base import Pass, Program


def run(program: Program) -> Program:
    """Absorb in every requirement."""
    return program.with_formulas(rewrite(program.formulas, _absorbed))


def _absorbed(node: Node) -> Node:
    if not isinstance(node, And | Or):
        return node
    kept = _without_dominated(node)
    dual = Or if isinstance(node, And) else And
    present = set(kept)
    kept = [arg for arg in kept if not (isinstance(arg, dual) and not present.isdisjoint(arg.args))]
    if len(kept) == len(node.args):
        return node
    return kept[0] if len(kept) == 1 else replace(node, args=tuple(kept))


def _without_dominated(node: And | Or) -> list[Node]:
    """Of predicates with one normal only the tightest (under or the loosest) stays."""
    sign = 1.0 if isinstance(node, And) else -1.0
    best: dict[object, Linear] = {}
    for arg in node.args:
        if isinstance(arg, Linear):
            key = (arg.terms, arg.unit)
            if key not in best or sign * arg.constant < sign * best[key].constant:
                best[key] = arg
    return [a for a in node.args if not isinstance(a, Linear) or best[a.terms, a.unit] is a]


PASS = Pass("absorb", run, after=("nnf",))
