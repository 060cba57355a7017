"""Warns about operators side by side that other STL tools read in another order."""

from __future__ import annotations

from collections.abc import Callable

from stlc.diagnostics import Diagnostic, Fix
from stlc.source import Source
from stlc.syntax import ast
from stlc.syntax.errors import AmbiguousMix

_SHOWN = 48  # characters of a formula quoted in a message


class Mixes:
    """Remembers which nodes stand in parentheses and collects the warnings."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.warnings: list[Diagnostic] = []
        self._grouped: dict[int, ast.Expr] = {}

    def in_parentheses(self, node: ast.Expr) -> None:
        """Note that the node was written in parentheses."""
        self._grouped[id(node)] = node

    def forget(self) -> None:
        """Forget the nodes of the statement that is complete."""
        self._grouped.clear()

    def _bare(self, node: ast.Expr) -> bool:
        return id(node) not in self._grouped

    def look_at_pair(self, node: ast.TemporalPair) -> None:
        """`not a until b`, `always a until b`, `a until b until c`."""
        left, right, word = node.left, node.right, node.operator
        if isinstance(left, ast.Not | ast.Temporal) and self._bare(left):
            name = "not" if isinstance(left, ast.Not) else left.operator
            self._warn(f"`{name}` beside `{word}`", left)
        elif isinstance(right, ast.TemporalPair) and self._bare(right):
            self._warn(f"`{word}` beside `{right.operator}`", right)

    def look_at_logical(self, node: ast.Logical) -> None:
        """`always a and b`, `a until b and c`, `a implies b implies c`: the first that is bare."""
        for position, arg in enumerate(node.args):
            if self._bare(arg) and unclear(node, position, self._bare):
                words = "before" if isinstance(arg, ast.Temporal) else "beside"
                inner = getattr(arg, "operator", "not")
                self._warn(f"`{inner}` {words} `{node.operator}`", arg)
                return

    def _warn(self, what: str, inner: ast.Expr) -> None:
        """Warns of a mix of operators whose reading is worth parentheses, which the fix puts in."""
        text = " ".join(inner.span.text.split())
        short = text if len(text) <= _SHOWN else text[: _SHOWN - 2] + ".."
        self.warnings.append(
            AmbiguousMix(
                span=inner.span,
                what=what,
                reading=f"({short})",
                inner=short,
                fix=Fix(inner.span, f"({inner.span.text})"),
            )
        )


def unclear(
    node: ast.Logical, position: int, bare: Callable[[ast.Expr], bool] = lambda _: True
) -> bool:
    """Whether the operand at this position, without parentheses, is grouped otherwise elsewhere.

    `bare` tells whether an operand stands without parentheses.
    """
    match node.args[position]:
        case ast.TemporalPair():
            return True
        case ast.Temporal():
            return _swallows(node, position, bare)
        case ast.Logical(operator="implies"):
            return node.operator == "implies"
        case _:
            return False


def _swallows(node: ast.Logical, position: int, bare: Callable[[ast.Expr], bool]) -> bool:
    """Whether a reader may take the next operand into the scope of this temporal one."""
    if position + 1 >= len(node.args):
        return False
    after = node.args[position + 1]
    return not (isinstance(after, ast.Temporal) and bare(after))
