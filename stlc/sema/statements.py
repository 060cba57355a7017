"""The statements of one kind."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from stlc.sema.name_errors import NotHere
from stlc.sema.report import Report
from stlc.syntax import ast

S = TypeVar("S", bound=ast.Statement)


def of(statements: Iterable[ast.Statement], kind: type[S]) -> list[S]:
    """Those of a kind, in their order."""
    return [s for s in statements if isinstance(s, kind)]


def single(statements: list[ast.Statement], kind: type[S], report: Report) -> S | None:
    """The first of a kind; any further one is reported."""
    found = of(statements, kind)
    for again in found[1:]:
        what = kind.__name__.lower()
        problem, hint = f"`{what}` stands twice", "keep one of the two"
        report.add(NotHere(span=again.span, problem=problem, hint=hint))
    return found[0] if found else None
