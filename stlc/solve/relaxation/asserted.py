"""Disjunctions that a compiled mission asserts outright, with their literals."""

from __future__ import annotations

from collections.abc import Iterator

from stlc.ir.nodes import Or
from stlc.ir.rewrite import conjuncts
from stlc.milp.compile import Compiled


def asserted(compiled: Compiled) -> Iterator[tuple[Or, tuple[int, ...], float]]:
    """Disjunctions that must hold, their exclusive literals (if all have one), the margin."""
    for one in compiled.layout.encoded:
        if one.level.goals:
            continue
        top = conjuncts(one.formula)
        known = dict(one.choices)
        for node in top:
            if not isinstance(node, Or):
                continue
            pairs = known.get(node, ())
            whole = len(pairs) == len(node.args)
            order = {alternative: column for alternative, column in pairs}
            yield node, tuple(order[a] for a in node.args) if whole else (), one.level.margin
