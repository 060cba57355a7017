"""Warns about operators side by side that other STL tools read in another order."""

from __future__ import annotations

from stlc.diagnostics import Diagnostic, Fix
from stlc.source import Source, Span
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
        """`always a and b`, `a until b and c`, `a implies b implies c`."""
        for position, arg in enumerate(node.args):
            if not self._bare(arg):
                continue
            match arg:
                case ast.TemporalPair():
                    self._warn(f"`{arg.operator}` beside `{node.operator}`", arg)
                case ast.Temporal() if self._swallows(node, position):
                    self._warn(f"`{arg.operator}` before `{node.operator}`", arg)
                case ast.Logical(operator="implies") if node.operator == "implies":
                    self._warn("`implies` beside `implies`", arg)
                case _:
                    continue
            return

    def _swallows(self, node: ast.Logical, position: int) -> bool:
        """Whether a reader may take the next operand into the scope of this temporal one."""
        if position + 1 >= len(node.args):
            return False
        after = node.args[position + 1]
        return not (isinstance(after, ast.Temporal | ast.TemporalPair) and self._bare(after))

    def _warn(self, what: str, inner: ast.Expr) -> None:
        text = " ".join(inner.span.text.split())
        short = text if len(text) <= _SHOWN else text[: _SHOWN - 2] + ".."
        self.warnings.append(
            AmbiguousMix(
                span=inner.span,
                what=what,
                reading=f"({short})",
                inner=short,
                fix=Fix(_whole(inner.span), f"({inner.span.text})"),
            )
        )


def _whole(span: Span) -> Span:
    return span
