"""Blocks of properties: look-up, unknown names, and the common forms of values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.mission import Array
from stlc.sema.name_errors import BadProperty, Redeclared, UnknownProperty
from stlc.sema.report import Mistake, nearest, suggested_fix, suggestion, with_note
from stlc.sema.scope import EMPTY, Scope, as_scalar, wrong_unit
from stlc.sema.shape_errors import MatrixShape
from stlc.sema.units import Unit
from stlc.sema.values import Env, Items, Value
from stlc.source import Span
from stlc.syntax import ast


@dataclass(frozen=True, slots=True)
class Block:
    """The properties of one declaration, each key at most once."""

    owner: str
    by_key: dict[str, ast.Property]

    def get(self, *keys: str) -> ast.Property | None:
        """The property of the first key that is there."""
        return next((self.by_key[k] for k in keys if k in self.by_key), None)


def block(
    owner: str, properties: Iterable[ast.Property], known: Sequence[str], scope: Scope
) -> Block:
    """Properties by key; unknown and repeated keys are reported."""
    by_key: dict[str, ast.Property] = {}
    for item in properties:
        key = item.key.text
        if key not in known:
            scope.report.add(unknown_property(owner, item, known))
        elif key in by_key:
            twice = Redeclared(span=item.key.span, name=key, hint="leave one of the two out")
            scope.report.add(with_note(twice, "declared here before", by_key[key].key.span))
        else:
            by_key[key] = item
    return Block(owner, by_key)


def distinct(names: Sequence[ast.Ident]) -> None:
    """Raise Mistake at the first name that stands twice."""
    first: dict[str, Span] = {}
    for name in names:
        if name.text in first:
            twice = Redeclared(span=name.span, name=name.text)
            raise Mistake(with_note(twice, "declared here before", first[name.text]))
        first[name.text] = name.span


def unknown_property(owner: str, item: ast.Property, known: Sequence[str]) -> UnknownProperty:
    """The diagnostic for a key that the block doesn't know."""
    key = item.key
    if key.text in _VECTORS and "control" in known:
        hint = f"bounds of all {_VECTORS[key.text]}"
        return UnknownProperty(span=key.span, owner=owner, name=key.text, hint=hint)
    hint = suggestion(key.text, list(known), f"known: {', '.join(known)}")
    fix = suggested_fix(key.span, key.text, list(known))
    return UnknownProperty(span=key.span, owner=owner, name=key.text, hint=hint, fix=fix)


_VECTORS = {
    "u": "inputs are written `control |u| <= 1`, of the speed `speed <= 2`",
    "v": "velocities are written `state |v| <= 2`, of their Euclidean norm `speed <= 2`",
}


def bad(item: ast.Property, problem: str, usage: str, span: Span | None = None) -> Mistake:
    """A Mistake about the form of a property."""
    place = span or item.span
    return Mistake(BadProperty(span=place, name=item.key.text, problem=problem, usage=usage))


def only(item: ast.Property, usage: str) -> ast.Expr:
    """The one argument of a property."""
    if len(item.args) != 1:
        advice = "is a `;` missing?" if item.args else "it has none"
        raise bad(item, f"needs one value, not {len(item.args)}: {advice}", usage)
    return item.args[0]


def number(item: ast.Property, unit: Unit, usage: str, scope: Scope) -> float:
    """The one number of a property, in the given unit."""
    return scope.number(only(item, usage), unit)


def word(item: ast.Property, choices: Sequence[str], usage: str) -> str:
    """The one word of a property, out of `choices`."""
    expr = only(item, usage)
    text = expr.text if isinstance(expr, ast.Name) else expr.span.text.strip()
    if text not in choices:
        near = nearest(text, choices)
        otherwise = "" if near else f": one of {', '.join(choices)}"
        usage = f"{item.key.text} {near}" if near else usage
        raise bad(item, f"can't be `{text}`{otherwise}", usage, expr.span)
    return text


def names(item: ast.Property, usage: str) -> tuple[ast.Name, ...]:
    """Names one after the other, or in a tuple."""
    args = item.args
    if len(args) == 1 and isinstance(args[0], ast.Tuple | ast.List):
        args = args[0].items
    if not args or not all(isinstance(a, ast.Name) for a in args):
        raise bad(item, "needs names", usage)
    return tuple(a for a in args if isinstance(a, ast.Name))


def numbers(expr: ast.Expr, scope: Scope, units: Sequence[Unit | None], env: Env = EMPTY) -> Array:
    """A tuple or list of constants, each in its unit; `len(units)` of them."""
    value = scope.value(expr, env)
    items = value.items if isinstance(value, Items) else (value,)
    if len(items) != len(units):
        raise Mistake(
            MatrixShape(
                span=expr.span,
                name=expr.span.text[:20],
                found=f"{len(items)} numbers",
                expected=f"{len(units)} numbers",
                hint="give one number for each",
            )
        )
    out = np.zeros(len(units))
    for k, (item, unit) in enumerate(zip(items, units, strict=True)):
        scalar = as_scalar(item, expr.span)
        if not scalar.is_constant:
            raise Mistake(BadProperty(span=expr.span, name=expr.span.text[:20],
                                      problem="must be constants", usage="(1, 2)"))  # fmt: skip
        if unit is not None and scalar.unit not in (None, unit):
            raise Mistake(wrong_unit(expr.span, unit, scalar.unit or unit))
        out[k] = scalar.constant
    return out


def matrix(item: ast.Property, scope: Scope) -> Array:
    """`[[1, 0], [0, 1]]`."""
    return _table(scope.value(only(item, _matrix_usage(item))), item)


def matrices(item: ast.Property, scope: Scope) -> list[Array]:
    """`[[1, 0], [0, 1]]`, or a list of such: one for each step."""
    value = scope.value(only(item, _matrix_usage(item)))
    if isinstance(value, Items) and value.items and all(map(_holds_rows, value.items)):
        return [_table(each, item) for each in value.items]
    return [_table(value, item)]


def _holds_rows(value: Value) -> bool:
    return isinstance(value, Items) and any(isinstance(row, Items) for row in value.items)


def _matrix_usage(item: ast.Property) -> str:
    return f"{item.key.text} = [[1, 0], [0, 1]]"


def _table(value: Value, item: ast.Property) -> Array:
    """A matrix of constants. Raises Mistake."""
    usage = _matrix_usage(item)
    if not isinstance(value, Items):
        value = Items((Items((value,)),))
    rows = [r.items if isinstance(r, Items) else (r,) for r in value.items]
    widths = {len(r) for r in rows}
    if len(widths) != 1 or 0 in widths:
        raise bad(item, "has rows of different length", usage)
    scalars = [[as_scalar(v, item.span) for v in row] for row in rows]
    if not all(s.is_constant for row in scalars for s in row):
        raise bad(item, "must hold constants", usage)
    return np.array([[s.constant for s in row] for row in scalars])
