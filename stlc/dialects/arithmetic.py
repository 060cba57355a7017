"""Exact values of constant expressions, and their form as sums of parameters."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from stlc.dialects.errors import DialectUnsupported, ImportFailure
from stlc.dialects.tree import Binary, Expr, Minus, Name, Num

MOST_DIGITS = 60
Sum = tuple[Fraction, dict[str, Fraction]]


def value(expr: Expr, params: Mapping[str, Fraction]) -> Fraction:
    """The number that an expression of constants means. Raises ImportFailure."""
    match expr:
        case Num():
            return literal(expr)
        case Name(text=name) if name in params:
            return params[name]
        case Minus(arg=arg):
            return -value(arg, params)
        case Binary(operator="+", left=a, right=b):
            return value(a, params) + value(b, params)
        case Binary(operator="-", left=a, right=b):
            return value(a, params) - value(b, params)
        case Binary(operator="*", left=a, right=b):
            return value(a, params) * value(b, params)
        case Binary(operator="/", left=a, right=b) if value(b, params) != 0:
            return value(a, params) / value(b, params)
    raise ImportFailure(
        DialectUnsupported(
            span=expr.span,
            what="this is no constant made of numbers, parameters, +, -, * and /",
            advice="write the number itself",
        )
    )


def literal(number: Num) -> Fraction:
    """The exact value, of a size that floating point can hold."""
    mantissa, _, exponent = number.text.lower().partition("e")
    if abs(int(exponent or 0)) > 300 or len(mantissa) > MOST_DIGITS:
        raise ImportFailure(
            DialectUnsupported(
                span=number.span, what="a number beyond all measure", advice="write it shorter"
            )
        )
    return number.value


def as_sum(expr: Expr) -> Sum | None:
    """constant + sum of coefficient * parameter; None if it has another form."""
    match expr:
        case Num():
            return literal(expr), {}
        case Name(text=name):
            return Fraction(0), {name: Fraction(1)}
        case Minus(arg=arg):
            return _scaled(as_sum(arg), Fraction(-1))
        case Binary(operator="+" | "-" as operator, left=left, right=right):
            sign = Fraction(1 if operator == "+" else -1)
            return _added(as_sum(left), _scaled(as_sum(right), sign))
        case Binary(operator="*", left=left, right=right):
            return _product(as_sum(left), as_sum(right))
        case Binary(operator="/", left=left, right=right):
            divisor = as_sum(right)
            if divisor is None or divisor[1] or divisor[0] == 0:
                return None
            return _scaled(as_sum(left), 1 / divisor[0])
    return None


def _product(a: Sum | None, b: Sum | None) -> Sum | None:
    if a is None or b is None or (a[1] and b[1]):
        return None
    return _scaled(a, b[0]) if a[1] else _scaled(b, a[0])


def _scaled(a: Sum | None, factor: Fraction) -> Sum | None:
    if a is None:
        return None
    return a[0] * factor, {name: c * factor for name, c in a[1].items()}


def _added(a: Sum | None, b: Sum | None) -> Sum | None:
    if a is None or b is None:
        return None
    names = dict(a[1])
    for name, coefficient in b[1].items():
        names[name] = names.get(name, Fraction(0)) + coefficient
    return a[0] + b[0], {n: c for n, c in names.items() if c}


def decimal(number: Fraction) -> str:
    """The shortest text of a number: decimal where it ends, else a quotient."""
    if number.denominator == 1:
        return str(number.numerator)
    rest = number.denominator
    for prime in (2, 5):
        while rest % prime == 0:
            rest //= prime
    if rest == 1 and number.denominator < 10**15:
        digits = 0
        while (number * 10**digits).denominator != 1:
            digits += 1
        whole = str(abs(number.numerator * 10**digits // number.denominator)).rjust(digits + 1, "0")
        return f"{'-' if number < 0 else ''}{whole[:-digits]}.{whole[-digits:]}"
    return f"{number.numerator} / {number.denominator}"


def greatest_common(values: list[Fraction]) -> Fraction:
    """The largest number of which 1 and all values are whole multiples."""
    from math import gcd, lcm

    denominator = lcm(*(v.denominator for v in values), 1)
    return Fraction(gcd(*(int(v * denominator) for v in values), denominator), denominator)
