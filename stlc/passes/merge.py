"""Merges temporal operators.

    always[a,b] always[c,d] f          = always[a+c,b+d] f             (eventually likewise)
    always[a,b] f and always[c,d] f    = always[min(a,c),max(b,d)] f   where the windows touch
                                                                       (eventually under or)
    op[0,0] f                          = f                             for always, eventually

Needs: horizon (windows are closed). Guarantees: robustness unchanged (min and max over the same
steps).
"""

from __future__ import annotations

from dataclasses import replace

from stlc.ir.nodes import Always, And, Eventually, Node, Or
from stlc.ir.rewrite import rewrite
from stlc.passes.base import Pass, Program


def run(program: Program) -> Program:
    """Merge in every requirement."""
    return program.with_formulas(rewrite(program.formulas, _merged))


def _merged(node: Node) -> Node:
    match node:
        case Always() | Eventually():
            return _nested(node)
        case And():
            return _joined(node, Always)
        case Or():
            return _joined(node, Eventually)
    return node


def _nested(node: Always | Eventually) -> Node:
    inner = node.arg
    if node.start == 0 and node.end == 0:
        return inner
    if not isinstance(inner, Always | Eventually) or type(inner) is not type(node):
        return node
    if node.end is None or inner.end is None:
        return node
    return replace(node, arg=inner.arg, start=node.start + inner.start, end=node.end + inner.end)


def _joined(node: And | Or, kind: type[Always] | type[Eventually]) -> Node:
    """Arguments whose windows touch or overlap, and whose formulas are equal, as one."""
    kept: list[Node] = []
    for arg in node.args:
        place = next((k for k, other in enumerate(kept) if _touch(other, arg, kind)), None)
        if place is None:
            kept.append(arg)
        else:
            kept[place] = _union(kept[place], arg)
    if len(kept) == len(node.args):
        return node
    return kept[0] if len(kept) == 1 else replace(node, args=tuple(kept))


def _touch(one: Node, other: Node, kind: type[Always] | type[Eventually]) -> bool:
    if not (isinstance(one, kind) and isinstance(other, kind)) or one.arg != other.arg:
        return False
    if one.end is None or other.end is None:
        return False
    return max(one.start, other.start) <= min(one.end, other.end) + 1


def _union(one: Node, other: Node) -> Node:
    assert isinstance(one, Always | Eventually)
    assert isinstance(other, Always | Eventually)
    ends = [node.end for node in (one, other) if node.end is not None]
    return replace(one, start=min(one.start, other.start), end=max(ends))


PASS = Pass("merge", run, after=("nnf", "horizon"))
