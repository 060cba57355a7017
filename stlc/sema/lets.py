"""Definitions with parameters: `let home(a, g) = eventually[0, 8] a in g`."""

from __future__ import annotations

from dataclasses import replace

from stlc.sema.name_errors import WrongArity
from stlc.sema.report import Mistake, with_note
from stlc.sema.scope import Scope
from stlc.sema.values import Env, Scalar, Truth, Value
from stlc.syntax import ast


def expand(let: ast.Let, expr: ast.Call, env: Env, scope: Scope) -> Value:
    """The body of a `let` with its parameters bound; the body sees no other bound names."""
    if len(expr.args) != len(let.parameters):
        raise Mistake(_let_arity(let, expr))
    values = tuple(scope.value(a, env) for a in expr.args)
    key = ("call", let.name.text, values, env.positive, env.margin, env.clock)
    known = scope.known(key)
    if known is not None:
        return known if isinstance(known, Scalar) else Truth(known)
    bound = {p.text: v for p, v in zip(let.parameters, values, strict=True)}
    inner = replace(env, bound=bound)
    try:
        with scope.expanding(let.name.text, expr.span), scope.expanded(key):
            value = scope.value(let.body, inner)
    except Mistake as mistake:
        note = with_note(mistake.diagnostic, f"in this use of `{let.name.text}`", expr.span)
        raise mistake.noted(note) from None
    return scope.keep(key, value)


def _let_arity(let: ast.Let, expr: ast.Call) -> WrongArity:
    usage = f"{let.name.text}({', '.join(p.text for p in let.parameters)})"
    expected = f"{len(let.parameters)} argument{'s' * (len(let.parameters) != 1)}"
    return WrongArity(
        span=expr.span, name=let.name.text, expected=expected, found=len(expr.args), usage=usage
    )
