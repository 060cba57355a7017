"""Syntax trees that the importers share: formulas and arithmetic of other tools' languages."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from stlc.source import Span

Operator = Literal[
    "+", "-", "*", "/", "^",
    "<", "<=", ">", ">=", "==", "!=",
    "and", "or", "implies", "iff", "xor",
]  # fmt: skip
ARITHMETIC = ("+", "-", "*", "/", "^")
COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")


@dataclass(frozen=True, slots=True)
class Num:
    """A literal, with its text as written (digits and exponent only)."""

    span: Span
    text: str

    @property
    def value(self) -> Fraction:
        """The exact number."""
        return Fraction(self.text)


@dataclass(frozen=True, slots=True)
class Bool:
    """`true` or `false`."""

    span: Span
    value: bool


@dataclass(frozen=True, slots=True)
class Name:
    """A name whose kind follows from its declaration, or from where it stands."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Sample:
    """A signal, `shift` later: Breach's `x[t]` and `x[t + dt]`, FalCAuN's `signal(0)`."""

    span: Span
    signal: str
    shift: Expr | None = None


@dataclass(frozen=True, slots=True)
class Call:
    """A function of numbers."""

    span: Span
    function: str
    args: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Minus:
    """-arg."""

    span: Span
    arg: Expr


@dataclass(frozen=True, slots=True)
class Not:
    """Negation."""

    span: Span
    arg: Expr


@dataclass(frozen=True, slots=True)
class Chain:
    """`a and b and ..` or `a or b or ..`: two operands or more."""

    span: Span
    operator: Literal["and", "or"]
    args: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Binary:
    """Arithmetic, a comparison, implies, iff or xor."""

    span: Span
    operator: Operator
    left: Expr
    right: Expr

    @property
    def is_logical(self) -> bool:
        """Whether it joins formulas."""
        return self.operator in ("implies", "iff", "xor")


@dataclass(frozen=True, slots=True)
class Bound:
    """One end of an interval; `unit` is "" where none is written."""

    expr: Expr
    unit: str


@dataclass(frozen=True, slots=True)
class Interval:
    """[start, end]; `end` None is unbounded."""

    span: Span
    start: Bound
    end: Bound | None


@dataclass(frozen=True, slots=True)
class Temporal:
    """always, eventually, next."""

    span: Span
    operator: Literal["always", "eventually", "next"]
    interval: Interval | None
    arg: Expr


@dataclass(frozen=True, slots=True)
class Pair:
    """until, release, unless."""

    span: Span
    operator: Literal["until", "release", "unless"]
    interval: Interval | None
    left: Expr
    right: Expr


Expr = Num | Bool | Name | Sample | Call | Minus | Not | Chain | Binary | Temporal | Pair


@dataclass(frozen=True, slots=True)
class Param:
    """A named constant; `value` None where the file gives none."""

    span: Span
    name: str
    value: Expr | None


@dataclass(frozen=True, slots=True)
class Signals:
    """Declared signals."""

    span: Span
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Definition:
    """A formula (or number), with a name or without."""

    span: Span
    name: str | None
    body: Expr


Item = Param | Signals | Definition


def children(expr: Expr) -> tuple[Expr, ...]:
    """Direct operands; those of intervals and shifts are not among them."""
    match expr:
        case Call(args=args) | Chain(args=args):
            return args
        case Minus(arg=arg) | Not(arg=arg) | Temporal(arg=arg):
            return (arg,)
        case Binary(left=left, right=right) | Pair(left=left, right=right):
            return (left, right)
        case _:
            return ()
