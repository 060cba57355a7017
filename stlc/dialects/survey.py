"""Finds the names and times of an imported file, before anything of it is written."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from stlc.dialects.arithmetic import as_sum, value
from stlc.dialects.errors import ImportFailure, NotDefined, NoValue
from stlc.dialects.scope import Dialect, ParamUse, Scope
from stlc.dialects.tree import (
    ARITHMETIC,
    COMPARISONS,
    Binary,
    Bool,
    Bound,
    Call,
    Chain,
    Definition,
    Expr,
    Interval,
    Item,
    Minus,
    Name,
    Not,
    Num,
    Pair,
    Param,
    Sample,
    Signals,
    Temporal,
    children,
)


def survey(items: Sequence[Item], dialect: Dialect) -> Scope:
    """Every name and time of a file. Raises ImportFailure for a value that is no number."""
    scope = Scope(dialect)
    defined = {item.name for item in items if isinstance(item, Definition)}
    for item in items:
        match item:
            case Signals(names=names):
                for name in names:
                    if name not in defined:  # rtamt declares the names of assertions too
                        _signal(scope, name)
            case Param():
                _declare_param(scope, item)
            case Definition():
                scope.definitions.append(item)
    _see_definitions(scope)
    for at, definition in enumerate(scope.definitions):
        _Survey(scope, at).formula(definition.body)
    _give_values(scope)
    for use in scope.params.values():
        use.emitted = scope.names.pick(use.name)
    for at, definition in enumerate(scope.definitions):
        if definition.name is not None:
            scope.emitted[at] = scope.names.pick(definition.name)
    return scope


def _declare_param(scope: Scope, item: Param) -> None:
    known = None if item.value is None else value(item.value, scope.values())
    scope.params[item.name] = ParamUse(item.name, item.span, known)


def _see_definitions(scope: Scope) -> None:
    """A name means its latest definition before the place of use, else the first one after it."""
    named = [(k, d.name) for k, d in enumerate(scope.definitions) if d.name is not None]
    for at in range(len(scope.definitions)):
        after = {name: k for k, name in reversed(named) if k > at}
        before = {name: k for k, name in named if k < at}
        own = scope.definitions[at].name
        scope.visible[at] = {n: k for n, k in {**after, **before}.items() if n != own or k < at}


def _signal(scope: Scope, name: str) -> None:
    if name not in scope.signals:
        scope.signals[name] = scope.names.pick(name)


class _Survey:
    """Walks one definition."""

    def __init__(self, scope: Scope, at: int) -> None:
        self.scope, self.at = scope, at

    def formula(self, expr: Expr) -> None:
        """An expression where a formula stands."""
        match expr:
            case Name():
                self.proposition(expr)
            case Binary(operator=operator, left=left, right=right) if operator in COMPARISONS:
                self.number(left)
                self.number(right, compared=True)
            case Temporal(interval=interval) | Pair(interval=interval):
                self.interval(interval)
                self.formulas(expr)
            case Chain() | Not() | Binary(operator="implies" | "iff" | "xor"):
                self.formulas(expr)
            case Bool():
                pass
            case _:
                self.number(expr)

    def formulas(self, expr: Expr) -> None:
        for child in children(expr):
            self.formula(child)

    def proposition(self, name: Name) -> None:
        """A bare name as a formula: a definition, or a signal that is its robustness."""
        known = self.mark(name)
        if not known:
            if not self.scope.dialect.formulas_are_numbers:
                self.scope.warnings.append(NotDefined(span=name.span, name=name.text))
            _signal(self.scope, name.text)

    def mark(self, name: Name) -> bool:
        """Note the use of a name that is declared; False if it isn't."""
        scope = self.scope
        if name.text in scope.visible[self.at]:
            scope.used.add(scope.visible[self.at][name.text])
            return True
        if name.text in scope.params:
            scope.params[name.text].elsewhere = True
            return True
        return name.text in scope.signals

    def number(self, expr: Expr, compared: bool = False) -> None:
        """An expression where a number stands; `compared`: on the right of a comparison."""
        match expr:
            case Name():
                self.loose(expr, compared)
            case Sample(signal=signal, shift=shift):
                _signal(self.scope, signal)
                if shift is not None:
                    self.scope.shifts.append(shift)
                    self.time(shift)
                    self.mark_factor(shift)  # a shift of 0 would compare a sample with itself
            case Num():
                pass
            case Binary(operator=operator) if operator in ARITHMETIC:
                for child in children(expr):
                    self.number(child, compared)
                self.factors(expr)
            case Minus() | Call():
                for child in children(expr):
                    self.number(child, compared)
            case _:
                self.formula(expr)

    def loose(self, name: Name, compared: bool) -> None:
        """A bare name as a number."""
        if self.mark(name):
            return
        dialect = self.scope.dialect
        is_param = compared if dialect.loose is None else dialect.loose
        if is_param:
            self.param(name).elsewhere = True
        else:
            _signal(self.scope, name.text)

    def param(self, name: Name) -> ParamUse:
        return self.scope.params.setdefault(name.text, ParamUse(name.text, name.span))

    def factors(self, expr: Expr) -> None:
        """Undeclared factors and divisors become 1, so that nothing vanishes or overflows."""
        match expr:
            case Binary(operator="*" | "/" | "^", left=left, right=right):
                operands = [x for x in (left, right) if not isinstance(x, Num)]
                for operand in operands if len(operands) == 2 else ():
                    self.mark_factor(operand)
                if isinstance(left, Num) and expr.operator == "/":
                    self.mark_factor(right)

    def mark_factor(self, operand: Expr) -> None:
        if isinstance(operand, Name) and operand.text in self.scope.params:
            self.scope.params[operand.text].is_factor = True
        for child in children(operand):
            self.mark_factor(child)

    def interval(self, interval: Interval | None) -> None:
        if interval is None:
            return
        self.scope.intervals.append(interval)
        for bound in _bounds(interval):
            self.time(bound.expr, bound.unit)

    def time(self, expr: Expr, unit: str = "") -> None:
        """Parameters in times; those that are more than summands can't carry a unit."""
        form = as_sum(expr)
        for name in _names(expr):
            use = self.param(name)
            use.in_times = True
            use.elsewhere |= form is None or unit not in ("", "s") or not self.scope.dialect.unit
        if form is None:
            self.factors_of_time(expr)

    def factors_of_time(self, expr: Expr) -> None:
        self.factors(expr)
        for child in children(expr):
            self.factors_of_time(child)


def _bounds(interval: Interval) -> tuple[Bound, ...]:
    return (interval.start,) if interval.end is None else (interval.start, interval.end)


def _names(expr: Expr) -> Iterator[Name]:
    if isinstance(expr, Name):
        yield expr
    for child in children(expr):
        yield from _names(child)


# --- parameters without a value ----------------------------------------------------------------


def _give_values(scope: Scope) -> None:
    """1 for factors and divisors, 0 for others, then later ends where an interval is empty."""
    missing = [use for use in scope.params.values() if use.value is None]
    for use in missing:
        use.no_value, use.value = True, Fraction(1 if use.is_factor else 0)
    free = {use.name for use in missing}
    for interval in scope.intervals:
        _lengthen(interval, free, scope)
    for use in missing:
        text = str(use.value)
        scope.warnings.append(NoValue(span=use.span, name=use.name, value=text))


def _lengthen(interval: Interval, free: set[str], scope: Scope) -> None:
    """Raise free parameters that stand in the end alone, until the end isn't before the start."""
    if interval.end is None:
        return
    early = {n.text for n in _names(interval.start.expr)}
    late = [n.text for n in _names(interval.end.expr) if n.text in free and n.text not in early]
    for size in (1, 10, 100, 1000):
        try:
            start = value(interval.start.expr, scope.values())
            end = value(interval.end.expr, scope.values())
        except ImportFailure:
            return  # told where the interval is written
        if 0 <= start <= end:
            return
        for name in late:
            scope.params[name].value = Fraction(size)
