"""Calls: the built-in functions of the language, and parametrised `let`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from stlc.diagnostics import Diagnostic
from stlc.mission import Array
from stlc.sema import clock, link_calls, networks, scalars
from stlc.sema.deliveries import delivered
from stlc.sema.lets import expand
from stlc.sema.members import flies, point
from stlc.sema.name_errors import Nonlinear, UnknownName, WrongArity, WrongKind
from stlc.sema.report import Mistake, suggested_fix, suggestion
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.space_errors import NotInSpace
from stlc.sema.units import PURE, Unit
from stlc.sema.values import (
    Env,
    Fold,
    FoldKind,
    Function,
    Items,
    Members,
    Scalar,
    Separation,
    Truth,
    Value,
    describe,
)
from stlc.source import Span
from stlc.sphere import directions, shrink
from stlc.syntax import ast
from stlc.syntax.past import PAST, past_operator

SIDES = 16
"""Faces of the polygon that stands for a Euclidean distance, unless said otherwise."""

SIDES_IN_SPACE = 12
"""The same in space, around each elevation: 62 faces, which lose at most 7 %. 16 would make 114,
each a choice for `>=`, and lose 4 %."""

MOST_SIDES = 256

Builtin = Callable[[ast.Call, tuple[Value, ...], Scope], Value]


def call(expr: ast.Call, env: Env, scope: Scope) -> Value:
    """The value of a call."""
    name = expr.function.text
    target = env.bound.get(name)
    if target is None and name in scope.declarations:
        found = scope.lookup(name, expr.function.span)
        target = Function(found) if isinstance(found, ast.Let) else None
    if isinstance(target, Function):
        return expand(target.let, expr, env, scope)
    if name == "P":
        return link_calls.chance(expr, env, scope)
    if name in networks.CALLS:
        return Truth(networks.CALLS[name](expr, env, scope))
    builtin = BUILTINS.get(name)
    if builtin is None:
        raise Mistake(_no_function(expr, scope))
    return builtin(expr, tuple(scope.value(a, _when(expr, k, env, scope)) for k, a in
                               enumerate(expr.args)), scope)  # fmt: skip


def _when(expr: ast.Call, place: int, env: Env, scope: Scope) -> Env:
    """The step at which an argument has its value: known signals are ahead of their time too."""
    if place or env.clock is None or expr.function.text != "ahead" or len(expr.args) != 2:
        return env
    return replace(env, clock=env.clock + clock.steps(expr.args[1], scope, env))


def _no_function(expr: ast.Call, scope: Scope) -> Diagnostic:
    """The mistake of a call of what is no function, with what it may have meant."""
    name, span = expr.function.text, expr.function.span
    if name in PAST:
        return past_operator(span)
    if name in scope.declarations:
        return WrongKind(span=span, expected="a function", found=f"`{name}`, which takes nothing")
    known = [
        *BUILTINS,
        *networks.CALLS,
        "P",
        "count",
        *(n for n, d in scope.declarations.items() if isinstance(d, ast.Let)),
    ]
    hint = suggestion(name, known, "functions are abs, min, max, separation, distance, rssi, ..")
    return UnknownName(span=span, name=name, hint=hint, fix=suggested_fix(span, name, known))


def need(expr: ast.Call, counts: tuple[int, ...], usage: str) -> None:
    """Raise Mistake unless the call has one of these numbers of arguments."""
    if len(expr.args) not in counts:
        expected = " or ".join(str(c) for c in counts) + " arguments"
        name = expr.function.text
        raise Mistake(
            WrongArity(
                span=expr.span, name=name, expected=expected, found=len(expr.args), usage=usage
            )
        )


def _spread(expr: ast.Call, args: tuple[Value, ...]) -> tuple[Scalar, ...]:
    """Arguments as scalars; one list or vector counts as its members."""
    if len(args) == 1 and isinstance(args[0], Items | Members):
        args = tuple(args[0].items)
        return tuple(as_scalar(a, expr.span) for a in args)
    return tuple(as_scalar(a, e.span) for a, e in zip(args, expr.args, strict=True))


def _abs(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    need(expr, (1,), "abs(x)")
    return scalars.absolute(as_scalar(args[0], expr.span), expr.span)


def _ahead(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    need(expr, (2,), "ahead(x, 1 s)")
    time = as_scalar(args[1], expr.args[1].span)
    if not time.is_constant:
        found = "one that depends on signals"
        raise Mistake(WrongKind(span=expr.args[1].span, expected="a fixed time", found=found))
    later = clock.as_steps(time, expr.args[1].span, scope)
    return scalars.ahead(as_scalar(args[0], expr.args[0].span), later)


def _extreme(pick: Callable[[tuple[Scalar, ...], Span], Scalar]) -> Builtin:
    def builtin(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
        items = _spread(expr, args)
        if not items:
            need(expr, (2,), f"{expr.function.text}(x, y)")
        return pick(items, expr.span)

    return builtin


def _norm1(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    total = Scalar(0.0)
    for item in _spread(expr, args):
        total = scalars.add(total, scalars.absolute(item, expr.span), expr.span)
    return total


def _norm_inf(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    items = tuple(scalars.absolute(a, expr.span) for a in _spread(expr, args))
    return scalars.maximum(items, expr.span)


def _norm2(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    """`norm2` of two or three numbers, by faces that are sound for the sign it stands under."""
    items = _spread(expr, args)
    if len(items) not in (2, 3):
        raise Mistake(
            Nonlinear(
                span=expr.span,
                what=f"the Euclidean norm of {len(items)} numbers",
                hint="use `norm1` or `norminf`; the Euclidean norm is that of two or three signals",
            )
        )
    return euclidean(items, None, expr.span)


def euclidean(parts: tuple[Scalar, ...], sides: int | None, span: Span) -> Scalar:
    """sqrt(x^2 + y^2 + ..) of two or three parts, to be compared through faces that are sound on
    both sides."""
    unit = scalars.same_unit(parts, span, "measured together")
    if all(part.is_constant for part in parts):
        return Scalar(math.hypot(*(part.constant for part in parts)), unit=unit)
    if len(parts) == 3:
        around = sides or SIDES_IN_SPACE
        normals = directions(around)
        faces = tuple(_along(parts, normal, span) for normal in normals)
        least = shrink(around)
    else:
        x, y = parts
        count = sides or SIDES
        faces = tuple(_face(x, y, 2.0 * math.pi * h / count, span) for h in range(count))
        least = math.cos(math.pi / count)
    return Scalar(folds=((Fold(FoldKind.DISTANCE, faces, parts, least), 1.0),), unit=unit)


def _along(parts: tuple[Scalar, ...], normal: Array, span: Span) -> Scalar:
    """How far x, y and z reach along a direction (3,)."""
    weighted = [scalars.scale(p, float(n), p.unit) for p, n in zip(parts, normal, strict=True)]
    total = weighted[0]
    for part in weighted[1:]:
        total = scalars.add(total, part, span)
    return total


def _face(x: Scalar, y: Scalar, angle: float, span: Span) -> Scalar:
    cosine, sine = (0.0 if abs(v) < 1e-15 else v for v in (math.cos(angle), math.sin(angle)))
    return scalars.add(scalars.scale(x, cosine, x.unit), scalars.scale(y, sine, y.unit), span)


def _difference(expr: ast.Call, args: tuple[Value, ...]) -> tuple[Scalar, ...]:
    """Along x and y; along z too where one of both flies. Mistake for a point without a height
    then."""
    ends = [point(value, e.span) for value, e in zip(args[:2], expr.args, strict=False)]
    axes = 3 if any(flies(value) for value in args[:2]) else 2
    for end, e in zip(ends, expr.args, strict=False):
        if len(end) < axes:
            problem = "this point has no height, and the other end has one"
            hint = f"write a third coordinate: `{e.span.text.rstrip(')')}, 0 m)`"
            raise Mistake(NotInSpace(span=e.span, problem=problem, hint=hint))
    pairs = list(zip(*ends, strict=False))[:axes]
    return tuple(scalars.add(a, b, expr.span, sign=-1.0) for a, b in pairs)


def _separation(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    need(expr, (2,), "separation(a, b)")
    return Separation(_difference(expr, args))


def _distance(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    need(expr, (2, 3), "distance(a, b)")
    sides = scope.whole(expr.args[2]) if len(args) == 3 else None
    if sides is not None and not 4 <= sides <= MOST_SIDES:
        expected = f"4 to {MOST_SIDES} sides"
        raise Mistake(WrongKind(span=expr.args[2].span, expected=expected, found=str(sides)))
    return euclidean(_difference(expr, args), sides, expr.span)


def _function(compute: Callable[[float], float]) -> Builtin:
    """A function of one constant, such as `sqrt`; a Mistake where it has no finite value."""

    def builtin(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
        need(expr, (1,), f"{expr.function.text}(x)")
        x = as_scalar(args[0], expr.span)
        if not x.is_constant:
            raise Mistake(_not_linear(expr))
        try:
            value = scalars.finite(compute(x.constant), expr.span)
            return Scalar(value, unit=_plain(x.unit), index=x.index)
        except (ValueError, OverflowError):
            raise Mistake(
                WrongKind(span=expr.span, expected="a value in its domain", found=str(x.constant))
            ) from None

    return builtin


def _plain(unit: Unit | None) -> Unit | None:
    return None if unit is None or unit.dims in ((), (("rad", 1),)) else PURE


def _not_linear(expr: ast.Call) -> Nonlinear:
    name = expr.function.text
    hint = "apply it to constants, or use `abs`, `min`, `max`, `norm1`, `norminf`, `distance`"
    return Nonlinear(span=expr.span, what=f"`{name}` of a signal", hint=hint)


def _scale(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    what = "`scale` outside `robustness(scale(..))`"
    found = ", ".join(describe(a) for a in args)
    raise Mistake(WrongKind(span=expr.span, expected="a number", found=f"{what} of {found}"))


BUILTINS: dict[str, Builtin] = {
    "abs": _abs,
    "ahead": _ahead,
    "delivered": delivered,
    "min": _extreme(scalars.minimum),
    "max": _extreme(scalars.maximum),
    "norm1": _norm1,
    "norminf": _norm_inf,
    "norm_inf": _norm_inf,
    "norm": _norm2,
    "norm2": _norm2,
    "separation": _separation,
    "distance": _distance,
    "rssi": link_calls.quality,
    "snr": link_calls.quality,
    "ber": link_calls.quality,
    "ber_at_mean": link_calls.quality,
    "prr": link_calls.quality,
    "link_cost": link_calls.cost,
    "scale": _scale,
    **{n: _function(getattr(math, n)) for n in ("sin", "cos", "tan", "exp", "log", "log10")},
    **{n: _function(getattr(math, n)) for n in ("sqrt", "floor", "ceil")},
}
