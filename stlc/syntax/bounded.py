"""What a property that is a bare comparison bounds."""

from __future__ import annotations

from stlc.syntax import ast


def bounded_name(comparison: ast.Expr) -> ast.Name | None:
    """What a chain such as `-1 <= vx <= 1` or `|vx| <= most` bounds; None where no name stands.

    An absolute value before all, then what stands between two limits, then a name without a sign:
    in `-most <= vx` the other name is a limit.
    """
    operands = comparison.operands if isinstance(comparison, ast.Comparison) else ()
    last = len(operands) - 1
    ranked = sorted(
        (not isinstance(o, ast.Absolute), k in (0, last), isinstance(o, ast.Negate), k)
        for k, o in enumerate(operands)
        if _name(o) is not None
    )
    return _name(operands[ranked[0][-1]]) if ranked else None


def _name(operand: ast.Expr) -> ast.Name | None:
    """The name of a signal, of its absolute value, or of what it is a component of."""
    while isinstance(operand, ast.Absolute | ast.Negate | ast.Index):
        operand = operand.base if isinstance(operand, ast.Index) else operand.arg
    return operand if isinstance(operand, ast.Name) else None
