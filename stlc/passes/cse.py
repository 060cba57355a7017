"""Common sub-formulas: structurally equal nodes become one object (hash-consing).

Needs: nothing. Guarantees: equal sub-formulas are identical objects, so that every later stage
compares them in constant time; robustness unchanged. Spans take no part in equality: the shared
node keeps the span of its first occurrence.
"""

from __future__ import annotations

from stlc.ir.nodes import Node
from stlc.ir.rewrite import rewrite
from stlc.passes.base import Pass, Program


def run(program: Program) -> Program:
    """Share equal nodes across all requirements."""
    known: dict[Node, Node] = {}
    return program.with_formulas(
        rewrite(program.formulas, lambda node: known.setdefault(node, node))
    )


PASS = Pass("cse", run)
