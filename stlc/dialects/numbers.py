"""Arithmetic of other tools as text of the language here, checked to be piecewise linear."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.dialects.errors import DialectNonlinear, DialectSyntax, DialectUnsupported, ImportFailure
from stlc.dialects.scope import Kind, Scope
from stlc.dialects.times import Times
from stlc.dialects.tree import (
    ARITHMETIC,
    Binary,
    Call,
    Chain,
    Expr,
    Minus,
    Name,
    Not,
    Num,
    Sample,
    Temporal,
)
from stlc.source import Span

SUM, PRODUCT, ATOM = 1, 2, 3
MOST_TEXT = 20_000
_OF_SIGNALS = ("abs", "min", "max")
_OF_CONSTANTS = {"sqrt": "sqrt", "exp": "exp", "log": "log", "ln": "log", "log10": "log10",
                 "sin": "sin", "cos": "cos", "tan": "tan", "floor": "floor",
                 "ceil": "ceil"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Number:
    """A number's text, how tight it binds, and whether signals are in it."""

    text: str
    level: int = ATOM
    varies: bool = False

    def at(self, level: int) -> str:
        """The text, in parentheses if it binds less tight than `level`."""
        return self.text if self.level >= level else f"({self.text})"


def constant_number(expr: Expr, scope: Scope) -> Number:
    """An expression of constants."""
    return Numbers(scope, None, 0).number(expr)


class Numbers:
    """Writes the numbers of one definition, the `at`-th of the file."""

    def __init__(self, scope: Scope, times: Times | None, at: int) -> None:
        self.scope, self.times, self.at = scope, times, at

    def number(self, expr: Expr) -> Number:
        """The text of a number. Raises ImportFailure where it isn't piecewise linear."""
        match expr:
            case Num(text=text):
                plain = _plain(text)
                return Number(plain, SUM if plain.startswith("-") else ATOM)
            case Name():
                return self._name(expr)
            case Sample(signal=signal, shift=shift):
                name = self.scope.signals[signal]
                if shift is None or self.times is None:
                    return Number(name, varies=True)
                return Number(f"ahead({name}, {self.times.shift(shift)})", varies=True)
            case Call():
                return self._call(expr)
            case Minus(arg=arg):
                inner = self.number(arg)
                return Number(f"-{inner.at(PRODUCT)}", SUM, inner.varies)
            case Binary(operator=operator) if operator in ARITHMETIC:
                return self._arithmetic(expr)
        return self._robustness(expr)

    def _name(self, name: Name) -> Number:
        """A parameter, signal or definition as a number; a formula stands for its robustness."""
        kind = self.scope.kind(name.text, self.at)
        if kind is Kind.PARAM:
            return Number(self.scope.params[name.text].emitted)
        if kind is Kind.SIGNAL or kind is None:
            return Number(self.scope.signals[name.text], varies=True)
        target = self.scope.visible[self.at][name.text]
        if kind is Kind.NUMBER:
            return Number(self.scope.emitted[target], varies=True)
        self._only_where_formulas_are_numbers(name.span)
        body = self.scope.definitions[target].body
        number = Numbers(self.scope, self.times, target).number(body)
        if len(number.text) > MOST_TEXT:
            what = (
                f"`{name.text}` as a number: its text would be longer than {MOST_TEXT} characters"
            )
            advice = "compare a signal with the number instead of a formula"
            raise ImportFailure(DialectUnsupported(span=name.span, what=what, advice=advice))
        return number

    def _arithmetic(self, expr: Binary) -> Number:
        """Sums, and products with one constant factor; what isn't linear in signals is refused."""
        left, right = self.number(expr.left), self.number(expr.right)
        varies = left.varies or right.varies
        match expr.operator:
            case "+":
                return Number(f"{left.at(SUM)} + {right.at(PRODUCT)}", SUM, varies)
            case "-":
                return Number(f"{left.at(SUM)} - {right.at(PRODUCT)}", SUM, varies)
            case "*" if left.varies and right.varies:
                raise _nonlinear(expr.span, "a product of two signals")
            case "*":
                return Number(f"{left.at(PRODUCT)} * {right.at(ATOM)}", PRODUCT, varies)
            case "/" if right.varies:
                raise _nonlinear(expr.span, "a quotient by a signal")
            case "/":
                return Number(f"{left.at(PRODUCT)} / {right.at(ATOM)}", PRODUCT, varies)
        return self._power(left, right, expr.span)

    def _power(self, base: Number, exponent: Number, span: Span) -> Number:
        if base.varies or exponent.varies:
            raise _nonlinear(span, "a power of a signal")
        return Number(f"{base.at(ATOM)}^{exponent.at(ATOM)}", PRODUCT)

    def _call(self, call: Call) -> Number:
        """A function of numbers: abs, min and max take signals, all others constants only."""
        args = [self.number(a) for a in call.args]
        varies, name = any(a.varies for a in args), call.function
        least, most = (1, 1) if name == "abs" or name in _OF_CONSTANTS else (2, 2)
        if name == "log" and len(args) == 2:
            least = most = 2
        if name in ("min", "max"):
            most = 99
        if not least <= len(args) <= most:
            problem = f"`{name}` takes {least} argument{'s' * (least > 1)}, not {len(args)}"
            raise ImportFailure(DialectSyntax(span=call.span, problem=problem))
        if name in _OF_SIGNALS:
            return Number(f"{name}({', '.join(a.text for a in args)})", varies=varies)
        if varies:
            raise _nonlinear(call.span, f"`{name}` of a signal")
        return self._constant_call(call, args)

    def _constant_call(self, call: Call, args: list[Number]) -> Number:
        """Functions of constants under our names; log(x, b) becomes a quotient."""
        name = call.function
        if name in ("pow", "power"):
            return self._power(args[0], args[1], call.span)
        if name == "log" and len(args) == 2:
            return Number(f"log({args[0].text}) / log({args[1].text})", PRODUCT)
        if name in _OF_CONSTANTS:
            return Number(f"{_OF_CONSTANTS[name]}({args[0].text})")
        what = f"the function `{name}`"
        advice = "record its value as a signal and compare that"
        raise ImportFailure(DialectUnsupported(span=call.span, what=what, advice=advice))

    # --- formulas as numbers ---------------------------------------------------------------

    def _robustness(self, expr: Expr) -> Number:
        """The robustness of a formula, as a number to compute with."""
        self._only_where_formulas_are_numbers(expr.span)
        match expr:
            case Not(arg=arg):
                return Number(f"-{self.number(arg).at(PRODUCT)}", SUM, True)
            case Chain(operator=operator, args=args):
                texts = ", ".join(self.number(a).text for a in args)
                return Number(f"{'min' if operator == 'and' else 'max'}({texts})", varies=True)
            case Temporal(operator="next", arg=arg):
                return Number(f"ahead({self.number(arg).text}, 1)", varies=True)
            case Binary():
                return self._relation(expr)
        what = "a temporal operator inside of arithmetic"
        advice = "compare its operand with the number, and apply the operator to the comparison"
        raise ImportFailure(DialectUnsupported(span=expr.span, what=what, advice=advice))

    def _relation(self, expr: Binary) -> Number:
        """A comparison, or `implies`, as the number that is its robustness."""
        left, right = self.number(expr.left), self.number(expr.right)
        difference = f"{left.at(SUM)} - {right.at(PRODUCT)}"
        match expr.operator:
            case ">" | ">=":
                return Number(difference, SUM, True)
            case "<" | "<=":
                return Number(f"{right.at(SUM)} - {left.at(PRODUCT)}", SUM, True)
            case "==" | "iff":
                return Number(f"-abs({difference})", SUM, True)
            case "!=" | "xor":
                return Number(f"abs({difference})", varies=True)
        return Number(f"max(-{left.at(PRODUCT)}, {right.text})", varies=True)

    def _only_where_formulas_are_numbers(self, span: Span) -> None:
        if not self.scope.dialect.formulas_are_numbers:
            problem = "a formula where a number is needed"
            raise ImportFailure(DialectSyntax(span=span, problem=problem, place="this formula"))


def _plain(text: str) -> str:
    """A literal as the language here spells it: digits on both sides of the point."""
    sign = "-" if text.startswith("-") else ""
    mantissa, mark, exponent = text.lstrip("-").lower().partition("e")
    whole, point, decimals = mantissa.partition(".")
    body = (whole or "0") + (f".{decimals}" if point and decimals else "")
    return f"{sign}{body}{mark}{exponent}"


def _nonlinear(span: Span, what: str) -> ImportFailure:
    return ImportFailure(DialectNonlinear(span=span, what=what))
