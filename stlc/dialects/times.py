"""Times of an imported file: the step that fits them, and how they are written."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from stlc.dialects.arithmetic import as_sum, decimal, greatest_common, value
from stlc.dialects.errors import DialectTime, ImportFailure
from stlc.dialects.scope import ParamUse, Scope
from stlc.dialects.tree import Bound, Expr, Interval
from stlc.source import Span

SECONDS = {"s": Fraction(1), "ms": Fraction(1, 10**3), "us": Fraction(1, 10**6),
           "ns": Fraction(1, 10**9)}  # fmt: skip
MOST_STEPS = 1_000_000


class Times:
    """Writes times as the language here reads them, each checked against the step."""

    def __init__(self, scope: Scope, step: Fraction | None) -> None:
        self.scope = scope
        self.values = scope.values()
        self.unit = scope.dialect.unit
        self.step = step or self._fitting_step()

    def _fitting_step(self) -> Fraction:
        """The largest step that fits all times and is not longer than a second."""
        if not self.unit:
            return Fraction(1)
        found: list[Fraction] = []
        for interval in self.scope.intervals:
            found += self._known(b for b in (interval.start, interval.end) if b is not None)
        found += self._known(Bound(shift, "s") for shift in self.scope.shifts)
        return greatest_common(found)

    def _known(self, bounds: Iterable[Bound]) -> list[Fraction]:
        known = []
        for bound in bounds:
            try:
                known.append(value(bound.expr, self.values) * SECONDS[bound.unit or self.unit])
            except ImportFailure:
                continue  # told where it is written
        return known

    # --- checked values --------------------------------------------------------------------

    def steps(self, bound: Bound) -> int:
        """A time in steps. Raises ImportFailure unless it is whole and not negative."""
        number = value(bound.expr, self.values)
        scale = SECONDS[bound.unit or self.unit] / self.step if self.unit else Fraction(1)
        count, span = number * scale, bound.expr.span
        if count < 0:
            advice = "give the parameters other values, or write the moment as 0 and shift the rest"
            raise _mistake(span, f"the time {decimal(number)} is before the moment itself", advice)
        if count.denominator != 1:
            raise self._not_whole(count, span)
        if count > MOST_STEPS:
            problem = f"{count} steps are more than {MOST_STEPS}"
            raise _mistake(span, problem, "choose a longer `--step`")
        return int(count)

    def _not_whole(self, count: Fraction, span: Span) -> ImportFailure:
        below = int(count) * self.step if self.unit else Fraction(int(count))
        above = below + (self.step if self.unit else 1)
        unit = " s" if self.unit else ""
        advice = f"the nearest times are {decimal(below)}{unit} and {decimal(above)}{unit}"
        if self.unit:
            advice += ", or choose another `--step`"
            return _mistake(span, f"not a whole number of steps of {decimal(self.step)} s", advice)
        return _mistake(span, "not a whole number of steps", advice)

    def window(self, interval: Interval) -> tuple[int, int | None]:
        """[start, end] in steps; an unbounded end is None."""
        first = self._with_unit(interval)
        start = self.steps(first)
        if interval.end is None:
            return start, None
        end = self.steps(interval.end)
        if end < start:
            advice = "give the parameters other values, or swap the two"
            problem = f"the interval ends at step {end}, before its start at step {start}"
            raise _mistake(interval.span, problem, advice)
        return start, end

    def _with_unit(self, interval: Interval) -> Bound:
        """A start without a unit takes that of the end (rtamt)."""
        if interval.start.unit or interval.end is None:
            return interval.start
        return Bound(interval.start.expr, interval.end.unit)

    # --- texts -----------------------------------------------------------------------------

    def interval(self, interval: Interval | None, earlier: int = 0) -> str:
        """` [a, b]`, both ends moved `earlier` steps towards now; "" for none."""
        if interval is None:
            return ""
        self.window(interval)
        start = self.text(self._with_unit(interval), earlier)
        end = "inf" if interval.end is None else self.text(interval.end, earlier)
        return f"[{start}, {end}]"

    def shift(self, expr: Expr) -> str:
        """How much later a sample is taken."""
        bound = Bound(expr, self.unit)
        if value(expr, self.values) < 0:
            advice = "shift the whole formula, so that its earliest sample is the present one"
            raise _mistake(expr.span, "a sample from the past", advice)
        self.steps(bound)
        return self.text(bound, 0)

    def text(self, bound: Bound, earlier: int) -> str:
        """One time, `earlier` steps less."""
        unit = bound.unit or self.unit
        less = earlier * self.step / SECONDS[unit] if unit else Fraction(earlier)
        form = as_sum(bound.expr)
        if form is None:
            return self._product(bound.expr, unit, less)
        constant, terms = form[0] - less, form[1]
        texts = [self._term(c, self.scope.params[n], unit) for n, c in terms.items()]
        if constant or not texts:
            number = decimal(constant)
            texts.append(f"({number}) * 1 {unit}" if "/" in number and unit else f"{number} {unit}")
        return " + ".join(texts).replace("+ -", "- ").rstrip()

    def _term(self, coefficient: Fraction, use: ParamUse, unit: str) -> str:
        """A parameter in seconds stands as it is; a pure number is given the unit."""
        name = f"{use.emitted} * 1 {unit}" if unit and not use.is_time else use.emitted
        if abs(coefficient) == 1:
            return name if coefficient == 1 else f"-{name}"
        return f"{_factor(coefficient)} * {name}"

    def _product(self, expr: Expr, unit: str, less: Fraction) -> str:
        """A time that isn't a sum of parameters; all its parameters are pure numbers."""
        from stlc.dialects.numbers import PRODUCT, constant_number

        number = constant_number(expr, self.scope)
        text = f"({number.text} - {decimal(less)})" if less else number.at(PRODUCT)
        return f"{text} * 1 {unit}" if unit else text


def _factor(number: Fraction) -> str:
    text = decimal(number)
    return f"({text})" if "/" in text else text


def _mistake(span: Span, problem: str, advice: str) -> ImportFailure:
    return ImportFailure(DialectTime(span=span, problem=problem, advice=advice))
