"""Domains of quantifiers and the values that their variables take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import prod

from stlc.sema import props
from stlc.sema.name_errors import EmptyDomain, TooManyPieces, WrongKind
from stlc.sema.report import Mistake, Reported
from stlc.sema.scope import MOST_WORK, Scope
from stlc.sema.values import Env, Items, Scalar, Value, describe
from stlc.source import Span
from stlc.syntax import ast

MOST_MEMBERS = 100_000


def assignments(expr: ast.Quantifier, env: Env, scope: Scope) -> list[Mapping[str, Value]]:
    """One binding of the variables for each member of the domain."""
    props.distinct(expr.variables)
    domain = domain_items(expr.domain, env, scope)
    names = [v.text for v in expr.variables]
    if len(names) == 1:
        return [{names[0]: _index(item)} for item in domain.items]
    members = (_parts(item, names, expr.domain.span) for item in domain.items)
    return [dict(zip(names, map(_index, parts), strict=True)) for parts in members]


def _index(item: Value) -> Value:
    """A number of a domain tells which instance is meant."""
    if isinstance(item, Scalar) and item.is_constant:
        return replace(item, index=True)
    return item


def _parts(item: Value, names: list[str], span: Span) -> tuple[Value, ...]:
    if isinstance(item, Items) and len(item.items) == len(names):
        return item.items
    expected = f"tuples of {len(names)}"
    raise Mistake(WrongKind(span=span, expected=expected, found=describe(item)))


def instances(expr: ast.Quantifier, env: Env, scope: Scope) -> Iterator[Env]:
    """The environment of each instance of the body; the scope knows how many there are."""
    bindings = assignments(expr, env, scope)
    scope.instances.append((len(bindings), expr.span))
    try:
        if isinstance(expr.domain, ast.Name) and expr.domain.text not in env.bound:
            _check_size(scope)
        for bound in bindings:
            yield bound_with(env, bound)
    finally:
        scope.instances.pop()


def _check_size(scope: Scope) -> None:
    """Raise Mistake where the quantifiers around, all as large each time, are too many.

    Within a definition nothing is said: it is evaluated once for equal arguments.
    """
    count = prod(count for count, _ in scope.instances)
    if not scope.evaluating and count > MOST_WORK:
        scope.spend(MOST_WORK, scope.instances[0][1], f"{count:.3g} instances")


def bound_with(env: Env, bound: Mapping[str, Value]) -> Env:
    """The environment with more names bound."""
    return replace(env, bound={**env.bound, **bound})


def domain_items(expr: ast.Expr, env: Env, scope: Scope) -> Items:
    """The members of a domain."""
    if isinstance(expr, ast.Range):
        return _steps(expr, env, scope)
    value = scope.value(expr, env)
    if not isinstance(value, Items):
        raise Mistake(EmptyDomain(span=expr.span, problem=f"{describe(value)} has no members"))
    if not value.items and value.what != "list of pairs":
        if scope.report.errors and (scope.broken or _declared(expr, scope)):
            raise Reported  # its members have mistakes
        raise Mistake(EmptyDomain(span=expr.span, problem=f"this {value.what} is empty"))
    return value


_KINDS = {
    "agents": ast.AgentDecl,
    "stations": ast.StationDecl,
    "regions": ast.RegionDecl,
    "obstacles": ast.ObstacleDecl,
}


def _declared(expr: ast.Expr, scope: Scope) -> bool:
    """Whether the file has something of that kind, whatever came of it."""
    kind = _KINDS.get(expr.text) if isinstance(expr, ast.Name) else None
    return kind is not None and any(isinstance(d, kind) for d in scope.declarations.values())


def _steps(expr: ast.Range, env: Env, scope: Scope) -> Items:
    first, last = scope.whole(expr.start, env), scope.whole(expr.end, env)
    if last < first:
        raise Mistake(EmptyDomain(span=expr.span, problem=f"{first}..{last} is empty"))
    if last - first >= MOST_MEMBERS:
        raise Mistake(TooManyPieces(span=expr.span, limit=MOST_MEMBERS))
    return Items(tuple(Scalar(float(k)) for k in range(first, last + 1)), "range")
