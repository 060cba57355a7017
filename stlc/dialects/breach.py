"""Breach's `.stl` files (and those of STLRom, its C++ sibling).

Statements: `param a=1, b=2`, `signal x, y` (also `input signal`, `output signal`), and
`name := formula`. Signals are written `x[t]`, or `x[t+dt]` for their value dt later; every other
name is a parameter or a formula. Times are seconds.

Breach splits a formula at the loosest operator first: or, =>, and, until, then the unary ones
(STL_Formula.m, STL_Parse); repeated `=>` group from the right. Robustness follows A. Donze,
T. Ferrere and O. Maler, Efficient robust monitoring for STL, CAV 2013: in `p until_[a,b] q`, p must
hold up to and including the moment at which q does, as here. Breach judges signals between their
samples too; here the samples count.
"""

from __future__ import annotations

from typing import ClassVar

from stlc.dialects.errors import DialectUnsupported, ImportFailure
from stlc.dialects.language import ARITHMETIC, SIGNS, Infix, Language, Prefix, compared
from stlc.dialects.pratt import Parser
from stlc.dialects.tokens import pattern
from stlc.dialects.tree import (
    Binary,
    Definition,
    Expr,
    Item,
    Minus,
    Name,
    Num,
    Param,
    Sample,
    Signals,
)
from stlc.source import Source, Span

_ALWAYS, _EVENTUALLY = Prefix("always", 15), Prefix("eventually", 15)
_SYMBOLS = (
    "[]_", "[]", "<>_", "<>", ":=", "=>", "->", "<=", ">=", "==", "~=", "!=", "&&", "||",
    ".*", "./", ".^", "{", "}", "|", "&", "!", "~", "<", ">", "=", "+", "-", "*", "/", "^", "(",
    ")", "[", "]", ",", ";", ":", "'", '"',
)  # fmt: skip
_CONSTANT_FUNCTIONS = ("sqrt", "exp", "log", "log10", "sin", "cos", "tan", "floor", "ceil")
_FUNCTIONS = frozenset(("abs", "min", "max", "norm", "mod", "sign", "power", *_CONSTANT_FUNCTIONS))
_DECLARATIONS = ("param", "signal", "input", "output")


class BreachParser(Parser):
    """Reads a Breach file."""

    language: ClassVar = Language(
        scanner=pattern(r"#[^\n]*|%[^\n]*|\.\.\.[^\n]*", r"[A-Za-z_]\w*", _SYMBOLS),
        prefix={
            **{word: _ALWAYS for word in ("alw", "alw_", "always", "always_", "[]", "[]_")},
            **{word: _ALWAYS for word in ("G", "G_")},
            **{word: _EVENTUALLY for word in ("ev", "ev_", "eventually", "eventually_", "<>")},
            **{word: _EVENTUALLY for word in ("<>_", "F", "F_")},
            **{word: Prefix("not", 16) for word in ("not", "!", "~")},
            **SIGNS,
        },
        infix={
            **{word: Infix("or", 11) for word in ("or", "|", "||")},
            **{word: Infix("implies", 12, right=True) for word in ("=>", "->", "implies")},
            **{word: Infix("and", 13) for word in ("and", "&", "&&")},
            **{word: Infix("until", 14) for word in ("until", "until_", "U", "U_")},
            **compared(17, {"<": "<", "<=": "<=", ">": ">", ">=": ">=", "==": "==", "=": "=="}),
            **compared(17, {"~=": "!=", "!=": "!="}),
            **ARITHMETIC,
            ".*": ARITHMETIC["*"],
            "./": ARITHMETIC["/"],
            ".^": ARITHMETIC["^"],
        },
        past={
            **{word: "once" for word in ("once", "once_")},
            **{word: "historically" for word in ("hist", "hist_", "historically", "historically_")},
            **{word: "since" for word in ("since", "since_")},
        },
        functions=_FUNCTIONS,
        separators=(",", ""),
        constants={"true": True, "false": False},
    )

    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self._declared: dict[str, list[str]] = {}

    def items(self) -> list[Item]:
        """The statements of the next declaration or definition."""
        token = self.token
        if token.text == "test" and self.peek(2).text == ":":
            what = "`test` blocks describe simulations, not requirements"
            raise ImportFailure(
                DialectUnsupported(span=token.span, what=what, advice="remove them from the file")
            )
        if token.text in _DECLARATIONS and self.peek().kind == "name":
            return list(self._params()) if token.text == "param" else [self._signals()]
        if token.kind == "name" and self.peek().text == ":=":
            self.take()
            self.take()
            body = self.expression()
            return [Definition(self.since(token.span), token.text, body)]
        body = self.expression()
        return [Definition(self.since(token.span), None, body)]

    def skip(self) -> None:
        """Go on to where the next statement starts."""
        self.take()
        while self.token.kind != "end" and not self._at_statement():
            self.take()

    def end_of_statement(self) -> None:
        """A formula may go on over several lines, so a statement must follow it."""
        if self.token.kind != "end" and not self._at_statement():
            self.fail("expected an operator, or a statement such as `name := formula`")

    def _at_statement(self) -> bool:
        declares = self.token.text in _DECLARATIONS and self.peek().kind == "name"
        return self.token.kind == "name" and (declares or self.peek().text == ":=")

    def _params(self) -> list[Param]:
        self.take()
        found = [self._param()]
        while self.accept(","):
            found.append(self._param())
        self.accept(";")
        return found

    def _param(self) -> Param:
        name = self.name()
        value = self.expression(18) if self.accept("=") else None
        text = "" if value is None else value.span.text
        return Param(self.since(name.span), self._fresh(name.text, text), value)

    def _fresh(self, name: str, value: str) -> str:
        """A parameter that is given another value is another one for the formulas that follow."""
        values = self._declared.setdefault(name, [])
        if not values or values[-1] != value:
            values.append(value)
        if len(values) > 1:
            self.renamed[name] = f"{name}_{len(values)}"
        return self.renamed.get(name, name)

    def _signals(self) -> Signals:
        start = self.take().span
        if self.token.text == "signal" and self.peek().kind == "name":
            self.take()
        names = [self.name().text]
        while self.accept(","):
            names.append(self.name().text)
        self.accept(";")
        return Signals(self.since(start), tuple(names))

    def special(self) -> Expr | None:
        """`x[t]` and `x[t + dt]`: an index that speaks of the time `t`."""
        token = self.token
        if token.kind != "name" or self.peek().text != "[" or not self._speaks_of_time():
            return None
        self.take()
        self.take()
        index = self.expression(18)
        self.expect("]")
        return Sample(self.since(token.span), token.text, _later(index))

    def _speaks_of_time(self) -> bool:
        ahead = 2
        while (token := self.peek(ahead)).kind != "end" and token.text not in ("]", ","):
            if token.text == "t":
                return True
            ahead += 1
        return False


def _later(index: Expr) -> Expr | None:
    """The `dt` of an index `t + dt`; None for `t` itself."""
    if isinstance(index, Name) and index.text == "t":
        return None
    shift = _without_t(index)
    if shift is None:
        what = "a sample at a time other than `t`, or `t` plus a constant"
        raise ImportFailure(
            DialectUnsupported(span=index.span, what=what, advice="write it as `x[t + dt]`")
        )
    return shift


def _without_t(index: Expr) -> Expr | None:
    """index - t, if t is one of its summands."""
    if not isinstance(index, Binary) or index.operator not in ("+", "-"):
        return None
    left, right, span = index.left, index.right, index.span
    if index.operator == "+" and isinstance(right, Name) and right.text == "t":
        return left
    if isinstance(left, Name) and left.text == "t":
        return right if index.operator == "+" else _negated(right, span)
    rest = _without_t(left)
    return None if rest is None else Binary(span, index.operator, rest, right)


def _negated(expr: Expr, span: Span) -> Expr:
    if isinstance(expr, Num):
        return Num(span, f"-{expr.text}")
    return Minus(span, expr)
