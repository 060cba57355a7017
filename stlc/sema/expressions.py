"""The evaluator: what each form of expression means."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby

from stlc.ir.nodes import Const, Role, Signal
from stlc.sema import scalars, units
from stlc.sema.calls import call
from stlc.sema.formulas import formula
from stlc.sema.members import attribute, index
from stlc.sema.name_errors import WrongKind
from stlc.sema.quantifiers import domain_items, instances
from stlc.sema.report import Mistake, nearest, with_note
from stlc.sema.scope import Scope, wrong_unit
from stlc.sema.signals import known_signal
from stlc.sema.unit_errors import UnknownUnit
from stlc.sema.values import Env, Function, Items, Scalar, Tally, Text, Truth, Value
from stlc.syntax import ast


def evaluate(expr: ast.Expr, env: Env, scope: Scope) -> Value:
    """The value of an expression. Raises Mistake, or Reported when all is reported already."""
    match expr:
        case ast.Name():
            return name(expr, env, scope)
        case ast.Quantifier(kind="count"):
            return Tally(expr, env)
        case ast.Quantifier(kind="sum"):
            return sum_over(expr, env, scope)
        case ast.Call():
            return call(expr, env, scope)
        case ast.Attribute():
            return attribute(expr, env, scope)
        case ast.Index():
            return index(expr, env, scope)
        case ast.Range():
            return domain_items(expr, env, scope)
        case ast.Tuple() | ast.List():
            kind = "tuple" if isinstance(expr, ast.Tuple) else "list"
            return Items(tuple(scope.value(e, env) for e in expr.items), kind)
        case ast.Number() | ast.Arithmetic() | ast.Negate() | ast.Absolute():
            return _numeric(expr, env, scope)
        case ast.Bool(value=truth):
            return Truth(Const(truth, span=expr.span))
        case ast.String(value=text):
            return Text(text)
    return Truth(formula(expr, env, scope))


def _numeric(
    expr: ast.Number | ast.Arithmetic | ast.Negate | ast.Absolute, env: Env, scope: Scope
) -> Value:
    """A number, or arithmetic on numbers; the sign of a literal is part of it (`-3 dB`)."""
    match expr:
        case ast.Number():
            return number(expr)
        case ast.Arithmetic():
            return arithmetic(expr, env, scope)
        case ast.Negate():
            literal = isinstance(expr.arg, ast.Number)
            return scalars.negate(scope.scalar(expr.arg, env), expr.span, literal)
        case ast.Absolute():
            return scalars.absolute(scope.scalar(expr.arg, env), expr.span)


def number(expr: ast.Number) -> Scalar:
    """A literal, in SI units."""
    if expr.unit is None:
        return Scalar(scalars.finite(expr.value, expr.span))
    try:
        scaled = units.parse_unit(expr.unit)
    except units.UnknownUnitName as error:
        near = nearest(error.name, units.KNOWN)
        hint = f"did you mean `{near}`?" if near else "known: m, s, kg, N, Hz, rad, dB, dBm, .."
        raise Mistake(UnknownUnit(span=expr.span, unit=expr.unit, hint=hint)) from None
    value = scalars.finite(expr.value * scaled.scale + scaled.offset, expr.span)
    return Scalar(value, unit=scaled.unit)


def name(expr: ast.Name, env: Env, scope: Scope) -> Value:
    """A bound or declared name."""
    if expr.text in env.bound:
        return env.bound[expr.text]
    found = scope.lookup(expr.text, expr.span)
    match found:
        case ast.Param():
            return parameter(found, expr, scope)
        case ast.Let(parameters=()):
            return plain_let(found, expr, env, scope)
        case ast.Let():
            return Function(found)
        case ast.SignalDecl(file=ast.String()):
            return known_signal(expr, env, scope)
        case ast.SignalDecl():
            return Scalar(
                terms=((Signal(expr.text, Role.FREE, 0), 1.0),),
                unit=scope.signals.get(expr.text),
            )
        case ast.Statement():
            what = type(found).__name__.removesuffix("Decl").lower()
            raise Mistake(WrongKind(span=expr.span, expected="a value", found=f"a {what}"))
        case _:
            return found


def parameter(found: ast.Param, expr: ast.Name, scope: Scope) -> Value:
    """The value of a parameter, `-D` included; evaluated once."""
    with scope.expanding(expr.text, expr.span):
        value = scope.value(found.value)
    override = scope.overrides.get(expr.text)
    if override is not None and isinstance(value, Scalar):
        value = overridden(value, override, expr.text, found)
    scope.values[expr.text] = value
    return value


def overridden(value: Scalar, override: Scalar, name: str, found: ast.Param) -> Scalar:
    """The override in the parameter's unit; a bare number is in it already."""
    if override.unit is None or value.unit is None or override.unit == value.unit:
        return Scalar(override.constant, unit=override.unit or value.unit)
    diagnostic = wrong_unit(found.value.span, value.unit, override.unit)
    raise Mistake(with_note(diagnostic, f"overridden by `-D {name}=..`", None))


def plain_let(found: ast.Let, expr: ast.Name, env: Env, scope: Scope) -> Value:
    """A `let` without parameters; its value is kept for each polarity."""
    key = ("let", expr.text, env.positive, env.margin, env.clock)
    known = scope.known(key)
    if known is not None:
        return known if isinstance(known, Scalar) else Truth(known)
    inner = replace(env, bound={})
    try:
        with scope.expanding(expr.text, expr.span), scope.expanded(key):
            value = scope.value(found.body, inner)
    except Mistake as mistake:
        note = with_note(mistake.diagnostic, f"in this use of `{expr.text}`", expr.span)
        raise mistake.noted(note) from None
    return scope.keep(key, value)


def arithmetic(expr: ast.Arithmetic, env: Env, scope: Scope) -> Scalar:
    """A chain of operations, from the left; long chains don't nest."""
    chain = expr.spine
    result = scope.scalar(chain[0].left, env)
    for sum_, links in groupby(chain, lambda link: link.operator in _SIGNS):
        if sum_:
            parts = ((_SIGNS[k.operator], scope.scalar(k.right, env), k.span) for k in links)
            result = scalars.total(result, parts)
        else:
            for link in links:
                result = operation(link, result, scope.scalar(link.right, env))
    return result


_SIGNS = {"+": 1.0, "-": -1.0}


def operation(expr: ast.Arithmetic, left: Scalar, right: Scalar) -> Scalar:
    """One operation."""
    match expr.operator:
        case "+":
            return scalars.add(left, right, expr.span)
        case "-":
            return scalars.add(left, right, expr.span, sign=-1.0)
        case "*":
            return scalars.multiply(left, right, expr.span)
        case "/":
            return scalars.divide(left, right, expr.span)
        case "^":
            return scalars.raise_to(left, right, expr.span)


def sum_over(expr: ast.Quantifier, env: Env, scope: Scope) -> Scalar:
    """`sum a in agents: a.x`."""
    parts = [Scalar(0.0), *(scope.scalar(expr.body, i) for i in instances(expr, env, scope))]
    while len(parts) > 1:  # by halves: each term is copied a few times, not once for each other
        pairs = zip(parts[::2], parts[1::2], strict=False)
        rest = parts[-1:] if len(parts) % 2 else []
        parts = [*(scalars.add(a, b, expr.span) for a, b in pairs), *rest]
    return parts[0]
