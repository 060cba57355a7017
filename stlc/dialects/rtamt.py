"""rtamt's STL, as its discrete-time monitor reads it (version 0.4).

Statements: `float x`, `input real y`, `const float c = 5`, assignments `name = expression` and
expressions alone, ended by `;`. Every expression is a formula whose robustness is its value, so a
bare `a + b` says `a + b >= 0`, and a formula may be compared with a number. Times without a unit
are seconds; one without beside one with a unit takes that.

rtamt's until (StlDiscreteTimeOfflineAstVisitor.visitTimedUntil) leaves out the step at which the
right side holds. Its `iff` and `xor` measure -|p - q| and |p - q| of the two robustness values.
Addition binds tighter than
subtraction there, and multiplication tighter than division, so `a - b + c` is `a - (b + c)`.
Windows that reach past the end of a trace are cut short by rtamt; here they aren't judged.
"""

from __future__ import annotations

from typing import ClassVar

from stlc.dialects.errors import OddGrouping
from stlc.dialects.language import Infix, Language, Prefix, compared
from stlc.dialects.pratt import Parser
from stlc.dialects.tokens import pattern
from stlc.dialects.tree import Binary, Definition, Item, Operator, Param, Signals

_TYPES = frozenset(("float", "real", "int", "long", "complex", "bool"))
_SYMBOLS = (
    "<->", "->", "=>", "!==", "!=", "==", "<=", ">=", "&&", "||", "&", "|", "!", "<", ">", "=", "+",
    "-", "*", "/", "(", ")", "[", "]", ",", ":", ";", "@", "{", "}", "'", '"', ".",
)  # fmt: skip


_ARITHMETIC: tuple[Operator, ...] = ("*", "/", "+", "-")  # each binds tighter than the next


class RtamtParser(Parser):
    """Reads an rtamt specification."""

    language: ClassVar = Language(
        scanner=pattern(r"//[^\n]*|\#[^\n]*|/\*(?s:.*?)\*/", r"[A-Za-z_$][\w$./]*", _SYMBOLS),
        prefix={
            **{word: Prefix("not", 21) for word in ("not", "!")},
            **{word: Prefix("always", 13) for word in ("always", "G")},
            **{word: Prefix("eventually", 13) for word in ("eventually", "F")},
            **{word: Prefix("next", 13) for word in ("next", "X", "s_next", "sX")},
            "-": Prefix("-", 47),
            "+": Prefix("+", 47),
        },
        infix={
            **compared(22, {"<": "<", "<=": "<=", ">": ">", ">=": ">=", "==": "=="}),
            **compared(22, {"!==": "!=", "!=": "!="}),
            **{word: Infix("until", 12) for word in ("until", "U")},
            **{word: Infix("unless", 11) for word in ("unless", "W")},
            **{word: Infix("and", 9) for word in ("and", "&", "&&")},
            **{word: Infix("or", 8) for word in ("or", "|", "||")},
            **{word: Infix("implies", 7) for word in ("implies", "->", "=>")},
            **{word: Infix("iff", 6) for word in ("iff", "<->")},
            "xor": Infix("xor", 5),
            **{text: Infix(text, 44 - k) for k, text in enumerate(_ARITHMETIC)},
        },
        past={
            **{word: "historically" for word in ("historically", "H")},
            **{word: "once" for word in ("once", "O")},
            **{word: "since" for word in ("since", "S")},
            **{word: "prev" for word in ("prev", "Y", "s_prev", "sY")},
            "rise": "rise",
            "fall": "fall",
        },
        functions=frozenset(("abs", "sqrt", "exp", "pow", "log", "ln", "min", "max")),
        separators=(":", ","),
        units=frozenset(("s", "ms", "us", "ns")),
        constants={"true": True, "TRUE": True, "false": False, "FALSE": False},
    )

    def items(self) -> list[Item]:
        """The statements of the next declaration or assertion; headers give none."""
        if self._skip_header():
            return []
        found: list[Item] = self._declaration() if self._declares() else [self._assertion()]
        self.accept(";")
        return found

    def notice(self, operator: str, right: Binary) -> None:
        """`a - b + c` and `a / b * c` group from the right, unlike elsewhere."""
        if (operator, right.operator) in (("-", "+"), ("/", "*")):
            whole = f".. {operator} {right.span.text}"
            reading = f".. {operator} ({right.span.text})"
            self.warnings.append(
                OddGrouping(span=right.span, tool="rtamt", whole=whole, reading=reading)
            )

    def skip(self) -> None:
        """Go on after the next `;`, or at the next line that starts a statement."""
        line = self.take().span.line
        while self.token.kind != "end" and self.token.text != ";":
            if self.token.span.line > line and (self._declares() or self.peek().text == "="):
                return
            self.take()
        self.accept(";")

    def _skip_header(self) -> bool:
        """`specification name`, `from module import type`, `@ topic(..)`, stray semicolons."""
        if self.accept(";"):
            return True
        if self.token.text == "specification" and self.peek().kind == "name":
            self.at += 2
            return True
        if self.token.text == "from" and self.peek(2).text == "import":
            self.at += 4
            return True
        if self.token.text == "@":
            while self.token.kind != "end" and not self.accept(")"):
                self.take()
            return True
        return False

    def _declares(self) -> bool:
        first, second = self.token, self.peek()
        if first.kind != "name" or second.kind != "name" or second.text in self.language.infix:
            return False
        if first.text in _TYPES or first.text in ("const", "input", "output", "internal"):
            return True
        is_operator = first.text in self.language.prefix or first.text in self.language.past
        ends = self.peek(2).text in (";", "=", "")
        return ends and not is_operator and second.text not in self.language.past

    def _declaration(self) -> list[Item]:
        """`const T c = 1`, `input T x`, `T f = formula`; unknown types declare fields only."""
        start = self.token
        constant = self.accept("const")
        self.accept("input", "output", "internal")
        type_name, name = self.name(), self.name()
        value = self.expression() if self.accept("=") else None
        span = self.since(start.span)
        if constant:
            return [Param(span, name.text, value)]
        if value is not None:
            return [Definition(span, name.text, value)]
        # Of a message the formulas use fields, `req.value`, and those are the signals.
        return [Signals(span, (name.text,))] if type_name.text in _TYPES else []

    def _assertion(self) -> Definition:
        start, name = self.token, None
        if start.kind == "name" and self.peek().text == "=":
            name = self.take().text
            self.take()
        body = self.expression()
        return Definition(self.since(start.span), name, body)
