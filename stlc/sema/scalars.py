"""Arithmetic of scalars: sums, products with constants, quotients, powers, and their units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import isfinite

from stlc.ir.signals import Signal
from stlc.sema import units
from stlc.sema.name_errors import DivisionByZero, Nonlinear, TooManyPieces
from stlc.sema.report import Mistake
from stlc.sema.unit_errors import BadExponent, LevelProduct, LevelSum, UnitMismatch
from stlc.sema.units import Unit
from stlc.sema.values import Atom, Fold, FoldKind, Scalar
from stlc.source import Span

MOST_PIECES = 4096


def constant(value: float, unit: Unit | None = None) -> Scalar:
    """A number."""
    return Scalar(value, unit=unit)


def add(a: Scalar, b: Scalar, span: Span, sign: float = 1.0) -> Scalar:
    """a + sign * b. Raises Mistake when the units don't go together."""
    unit = _sum_unit(a.unit, b.unit, span, sign)
    total = finite(a.constant + sign * b.constant, span)
    if a.is_constant and b.is_constant:
        return Scalar(total, unit=unit, index=a.index or b.index)
    return few(Scalar(total, _merge(a, b, sign), _merge_folds(a, b, sign), unit), span)


def total(first: Scalar, parts: Iterable[tuple[float, Scalar, Span]]) -> Scalar:
    """first + sum of sign * part, as `add` one after the other, in time linear in the terms.

    Raises Mistake as `add` does, at the span of the part.
    """
    for sign, part, span in (given := iter(parts)):
        first = add(first, part, span, sign)
        if len(first.terms) > _FEW:
            return _longer(first, given)
    return first


_FEW = 16  # terms that are copied sooner than counted in


def _longer(first: Scalar, parts: Iterable[tuple[float, Scalar, Span]]) -> Scalar:
    """`total` of a sum with many terms already."""
    constant, terms, folds, unit = first.constant, dict(first.terms), first.folds, first.unit
    for sign, part, span in parts:
        unit = _sum_unit(unit, part.unit, span, sign)
        constant = finite(constant + sign * part.constant, span)
        for atom, coefficient in part.terms:
            terms[atom] = terms.get(atom, 0.0) + sign * coefficient
        if part.folds:
            folds = few(Scalar(folds=_merge_folds(Scalar(folds=folds), part, sign)), span).folds
    return Scalar(constant, tuple((k, v) for k, v in terms.items() if v != 0.0), folds, unit)


def few(scalar: Scalar, span: Span) -> Scalar:
    """The scalar. Raises Mistake where it has more linear pieces than can be written out."""
    if scalar.pieces > MOST_PIECES:
        raise Mistake(TooManyPieces(span=span, limit=MOST_PIECES))
    return scalar


def _merge_folds(a: Scalar, b: Scalar, sign: float) -> tuple[tuple[Fold, float], ...]:
    """Folds of a + sign * b, equal ones together: `e + e` has no more pieces than `e`."""
    if not b.folds:
        return a.folds
    folds = dict(a.folds)
    for fold, coefficient in b.folds:
        folds[fold] = folds.get(fold, 0.0) + sign * coefficient
    return tuple((k, v) for k, v in folds.items() if v != 0.0)


def _merge(a: Scalar, b: Scalar, sign: float) -> tuple[tuple[Atom, float], ...]:
    terms = dict(a.terms)
    for atom, coefficient in b.terms:
        terms[atom] = terms.get(atom, 0.0) + sign * coefficient
    return tuple((k, v) for k, v in terms.items() if v != 0.0)


def _times_folds(
    folds: tuple[tuple[Fold, float], ...], factor: float
) -> tuple[tuple[Fold, float], ...]:
    return tuple((f, c * factor) for f, c in folds if c * factor != 0.0)


def _sum_unit(a: Unit | None, b: Unit | None, span: Span, sign: float) -> Unit | None:
    if a is None or b is None:
        return _bare_sum_unit(a, b, span, sign)
    if a.dims != b.dims:
        raise Mistake(mismatch(a, b, "added" if sign > 0 else "subtracted", span))
    level = a.level + (1 if sign > 0 else -1) * b.level
    if level not in (0, 1):
        raise Mistake(LevelSum(span=span))
    return Unit(a.dims, level)


def _bare_sum_unit(a: Unit | None, b: Unit | None, span: Span, sign: float) -> Unit | None:
    """A bare number beside a level counts as a ratio; a level can't be subtracted from it."""
    if b is not None and b.level and sign < 0:
        raise Mistake(LevelSum(span=span))
    return a if b is None else b


def mismatch(a: Unit, b: Unit, verb: str, span: Span) -> UnitMismatch:
    """The diagnostic for two units that don't go together."""
    left, right = (str(u) or "a pure number" for u in (a, b))
    return UnitMismatch(span=span, left=left, right=right, verb=verb)


def negate(a: Scalar, span: Span, literal: bool = False) -> Scalar:
    """-a; the sign of a literal such as `-70 dBm` belongs to its level."""
    if a.unit is not None and a.unit.level and not literal:
        raise Mistake(LevelProduct(span=span))
    return scale(a, -1.0, a.unit)


def scale(a: Scalar, factor: float, unit: Unit | None) -> Scalar:
    """factor * a, in the given unit."""
    if factor == 0.0:
        return Scalar(0.0, unit=unit, index=a.index)
    terms = tuple((k, v * factor) for k, v in a.terms)
    folds = _times_folds(a.folds, factor)
    return Scalar(a.constant * factor, terms, folds, unit, a.index)


def ahead(a: Scalar, steps: int) -> Scalar:
    """The value of `a` that many steps later."""
    terms = tuple((_later(atom, steps), v) for atom, v in a.terms)
    folds = tuple((Fold(f.kind, tuple(ahead(x, steps) for x in f.args)), c) for f, c in a.folds)
    return Scalar(a.constant, terms, folds, a.unit)


def _later(atom: Atom, steps: int) -> Atom:
    shift = atom.shift + steps
    return atom._replace(shift=shift) if isinstance(atom, Signal) else replace(atom, shift=shift)


def multiply(a: Scalar, b: Scalar, span: Span) -> Scalar:
    """a * b, one of which is a constant."""
    unit = _product_unit(a.unit, b.unit, span)
    if not (a.is_constant or b.is_constant):
        hint = "multiply by a constant, or use `abs`, `min`, `max`, `norm1` or `norminf`"
        raise Mistake(Nonlinear(span=span, what="a product of two signals", hint=hint))
    factor, rest = (a, b) if a.is_constant else (b, a)
    finite(factor.constant * rest.constant, span)
    product = scale(rest, factor.constant, unit)
    index = rest.is_constant and (a.index or b.index)
    return replace(product, index=index)


def _product_unit(a: Unit | None, b: Unit | None, span: Span) -> Unit | None:
    if any(u is not None and u.level for u in (a, b)):
        raise Mistake(LevelProduct(span=span))
    if a is None or b is None:
        return a if b is None else b
    return units.times(a, b)


def divide(a: Scalar, b: Scalar, span: Span) -> Scalar:
    """a / b with a constant b that isn't zero."""
    if not b.is_constant:
        hint = "multiply both sides by the divisor, if its sign is known"
        raise Mistake(Nonlinear(span=span, what="a division by a signal", hint=hint))
    if b.constant == 0.0:
        raise Mistake(DivisionByZero(span=span))
    inverse = None if b.unit is None else units.power(b.unit, -1)
    if b.unit is not None and b.unit.level:
        raise Mistake(LevelProduct(span=span))
    finite(a.constant / b.constant, span)
    quotient = scale(a, 1.0 / b.constant, _product_unit(a.unit, inverse, span))
    return replace(quotient, index=a.is_constant and (a.index or b.index))


def raise_to(a: Scalar, b: Scalar, span: Span) -> Scalar:
    """a ^ b of constants."""
    if not (a.is_constant and b.is_constant):
        hint = "`abs(x) <= c` says what `x^2 <= c^2` says"
        raise Mistake(Nonlinear(span=span, what="a power of a signal", hint=hint))
    try:
        value = a.constant**b.constant
    except (ArithmeticError, ValueError):
        raise Mistake(DivisionByZero(span=span)) from None
    if isinstance(value, complex):
        raise Mistake(DivisionByZero(span=span))
    unit = _power_unit(a.unit, b.constant, span)
    return Scalar(finite(float(value), span), unit=unit, index=a.index or b.index)


def _power_unit(a: Unit | None, exponent: float, span: Span) -> Unit | None:
    if a is None or not a.dims:
        return a
    if exponent != int(exponent):
        raise Mistake(BadExponent(span=span))
    if a.level:
        raise Mistake(LevelProduct(span=span))
    return units.power(a, int(exponent))


def finite(value: float, span: Span) -> float:
    """The value, if it is one."""
    if not isfinite(value):
        raise Mistake(DivisionByZero(span=span))
    return value


def same_unit(items: tuple[Scalar, ...], span: Span, verb: str = "compared") -> Unit | None:
    """The unit that all share, bare numbers aside."""
    known = [s.unit for s in items if s.unit is not None]
    for other in known[1:]:
        if other != known[0]:
            raise Mistake(mismatch(known[0], other, verb, span))
    return known[0] if known else None


def maximum(items: tuple[Scalar, ...], span: Span) -> Scalar:
    """The largest of scalars."""
    return _extreme(FoldKind.MAX, items, span)


def minimum(items: tuple[Scalar, ...], span: Span) -> Scalar:
    """The smallest of scalars."""
    return _extreme(FoldKind.MIN, items, span)


def _extreme(kind: FoldKind, items: tuple[Scalar, ...], span: Span) -> Scalar:
    unit = same_unit(items, span)
    if all(s.is_constant for s in items):
        pick = max if kind is FoldKind.MAX else min
        index = any(s.index for s in items)
        return Scalar(pick(s.constant for s in items), unit=unit, index=index)
    if len(items) == 1:
        return items[0]
    return few(Scalar(folds=((Fold(kind, items), 1.0),), unit=unit), span)


def absolute(a: Scalar, span: Span) -> Scalar:
    """|a|."""
    if a.unit is not None and a.unit.level:
        raise Mistake(LevelProduct(span=span))
    if a.is_constant:
        return Scalar(abs(a.constant), unit=a.unit, index=a.index)
    return maximum((a, scale(a, -1.0, a.unit)), span)
