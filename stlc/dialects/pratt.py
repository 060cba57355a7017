"""One operator-precedence parser for the languages of Breach, rtamt and FalCAuN.

A language is a table of operators with their binding powers (higher binds tighter); `expression`
reads what binds at least as tight as asked (V. R. Pratt, Top down operator precedence, POPL 1973).
"""

from __future__ import annotations

from typing import ClassVar, Literal, NoReturn

from stlc.diagnostics import Diagnostic
from stlc.dialects.errors import DialectPast, DialectSyntax, ImportFailure
from stlc.dialects.language import ARITHMETIC_POWER, Infix, Language, Prefix
from stlc.dialects.tokens import Token, tokenize
from stlc.dialects.tree import (
    Binary,
    Bool,
    Bound,
    Call,
    Chain,
    Expr,
    Interval,
    Minus,
    Name,
    Not,
    Num,
    Pair,
    Temporal,
)
from stlc.source import Source, Span

MAX_DEPTH = 100
PAST_ADVICE = {
    "once": "say it forward: for `always (q implies once p)` write `not q until p`",
    "historically": "say it forward: `always[a, b]` over the steps before the moment in question",
    "since": "say it forward with `until`: what holds since p holds from p on",
    "prev": "say it forward: `next` of the later of the two steps",
    "rise": "say it forward: `not p and next p`, judged one step earlier",
    "fall": "say it forward: `p and next (not p)`, judged one step earlier",
}


class Parser:
    """Reads one source; subclasses add the statements and the signals of a language."""

    language: ClassVar[Language]

    def __init__(self, source: Source) -> None:
        self.source = source
        self.tokens = tokenize(source, self.language.scanner)
        self.at = 0
        self.depth = 0
        self.renamed: dict[str, str] = {}
        self.warnings: list[Diagnostic] = []

    # --- tokens ----------------------------------------------------------------------------

    @property
    def token(self) -> Token:
        """The next token."""
        return self.tokens[self.at]

    def peek(self, ahead: int = 1) -> Token:
        """A token further on."""
        return self.tokens[min(self.at + ahead, len(self.tokens) - 1)]

    def take(self) -> Token:
        """The next token, consumed."""
        token = self.token
        self.at = min(self.at + 1, len(self.tokens) - 1)
        return token

    def accept(self, *texts: str) -> Token | None:
        """The next token if it is one of these."""
        return self.take() if self.token.text in texts and self.token.text else None

    def expect(self, *texts: str) -> Token:
        """The next token, which must be one of these."""
        return self.accept(*texts) or self.fail(f"expected {' or '.join(f'`{t}`' for t in texts)}")

    def name(self) -> Token:
        """The next token, which must be a name."""
        return self.take() if self.token.kind == "name" else self.fail("expected a name")

    def fail(self, problem: str, advice: str = "") -> NoReturn:
        """Raise ImportFailure at the next token."""
        token = self.token
        place = "the file ends here" if token.kind == "end" else f"found `{token.text}`"
        raise ImportFailure(
            DialectSyntax(span=token.span, problem=problem, place=place, advice=advice)
        )

    def since(self, start: Span) -> Span:
        """From `start` to the last token that was consumed."""
        return start.to(self.tokens[max(self.at - 1, 0)].span)

    def end_of_statement(self) -> None:
        """After a statement comes the end, a `;`, or the next one on a line of its own."""
        last = self.tokens[max(self.at - 1, 0)]
        if self.token.kind == "end" or last.text == ";":
            return
        ended = self.source.position(last.span.end)[0]
        if self.token.span.line == ended:
            self.fail("expected an operator or the end of the formula")

    # --- expressions -----------------------------------------------------------------------

    def expression(self, power: int = 0) -> Expr:
        """Operators that bind at least as tight as `power`."""
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self.fail(f"more than {MAX_DEPTH} levels of nesting", "name parts of the formula")
        start, left = self.token.span, self._operand()
        links = 0
        while (infix := self._infix(power)) is not None:
            left = self._joined(left, infix, start)
            links += not isinstance(left, Chain)
            if links > MAX_DEPTH:
                self.fail(f"more than {MAX_DEPTH} operations in a row", "name parts of it")
        self.depth -= 1
        return left

    def _infix(self, power: int) -> Infix | None:
        token = self.token
        past = self.language.past.get(token.text)
        if past == "since":
            raise ImportFailure(_past(token, past))
        infix = self.language.infix.get(token.text)
        if infix is None or self._binding(infix) < power:
            return None
        self.take()
        return infix

    def _binding(self, infix: Infix) -> int:
        return infix.power if infix.timed is None or not self._interval_at(1) else infix.timed

    def _joined(self, left: Expr, infix: Infix, start: Span) -> Expr:
        """What an infix operator makes of `left` and what follows; `start` is where left begins."""
        operator = infix.operator
        if operator == "until" or operator == "release" or operator == "unless":
            timed = infix.timed is not None and self._interval_at(0)
            interval = self._interval()
            power = infix.timed if timed and infix.timed is not None else infix.power
            right = self.expression(power + 1)
            return Pair(self.since(start), operator, interval, left, right)
        first = self.token.span
        right = self.expression(infix.power + (not infix.right))
        span = self.since(start)
        if isinstance(right, Binary) and right.span.start == first.start:
            self.notice(infix.operator, right)
        if operator in ("and", "or"):
            kind: Literal["and", "or"] = "and" if operator == "and" else "or"
            args = (*_links(left, kind), *_links(right, kind))
            return Chain(span, kind, args)
        return Binary(span, operator, left, right)

    def _operand(self) -> Expr:
        """A prefixed formula, a literal, a name or a group; past operators are refused here."""
        token = self.token
        special = self.special()
        if special is not None:
            return special
        language, text = self.language, token.text
        if text in language.past and not (token.kind == "name" and self._is_name_here()):
            raise ImportFailure(_past(token, language.past[text]))
        prefix = language.prefix.get(text)
        if prefix is not None and not self._is_name_here():
            return self._prefixed(prefix)
        if token.kind == "number":
            return Num(self.take().span, token.text)
        if text in language.constants:
            return Bool(self.take().span, language.constants[text])
        if token.kind == "name":
            return self._named()
        if self.accept("("):
            inner = self.expression()
            self.expect(")")
            return inner
        return self.fail("expected a formula or a number")

    def notice(self, operator: str, right: Binary) -> None:
        """Called where a binary operation without parentheses is the right side of another."""

    def notice_prefix(self, operator: Span, first: Span, arg: Expr) -> None:
        """Called where a logical operation without parentheses follows a unary operator."""

    def special(self) -> Expr | None:
        """What a language writes in its own way; None if nothing of that kind comes next."""
        return None

    def _is_name_here(self) -> bool:
        """A word of the language that stands where only a name can: at the end, or compared."""
        if self.token.kind != "name":
            return False
        after = self.peek()
        ends = after.kind == "end" or after.text in (")", ";", ",")
        infix = self.language.infix.get(after.text)
        return ends or (infix is not None and after.text not in self.language.prefix)

    def _prefixed(self, prefix: Prefix) -> Expr:
        """A sign, `not` or a temporal operator, which may bind otherwise with an interval."""
        start = self.take().span
        if prefix.operator == "+":
            return self.expression(prefix.operand)
        if prefix.operator == "-":
            return _negative(self.expression(prefix.operand), start)
        if prefix.operator == "not":
            arg = self._operand_of(start, prefix.operand)
            return Not(self.since(start), arg)
        interval = None if prefix.operator == "next" else self._interval()
        power = prefix.operand if interval is None or prefix.timed is None else prefix.timed
        arg = self._operand_of(start, power)
        return Temporal(self.since(start), prefix.operator, interval, arg)

    def _operand_of(self, operator: Span, power: int) -> Expr:
        first = self.token.span
        arg = self.expression(power)
        joined = isinstance(arg, Chain | Pair) or (isinstance(arg, Binary) and arg.is_logical)
        if joined and arg.span.start == first.start:
            self.notice_prefix(operator, first, arg)
        return arg

    def _named(self) -> Expr:
        token = self.take()
        if token.text not in self.language.functions or not self.accept("("):
            return Name(token.span, self.renamed.get(token.text, token.text))
        args = [self.expression()]
        while self.accept(","):
            args.append(self.expression())
        self.expect(")")
        return Call(self.since(token.span), token.text, tuple(args))

    # --- intervals -------------------------------------------------------------------------

    def _interval_at(self, ahead: int) -> bool:
        first = self.peek(ahead)
        return first.text in ("[", "_")

    def _interval(self) -> Interval | None:
        """`[a, b]`, `_[a, b]` or nothing; the end `inf` is None."""
        before = self.accept("_")
        if not before and self.token.text != "[":
            return None
        start = self.expect("[").span
        first = self.bound()
        if not self.accept(*self.language.separators) and "" not in self.language.separators:
            self.fail("an interval has two ends", "write it as `[a, b]`")
        infinite = self.accept("inf", "Inf", "infinity")
        last = None if infinite else self.bound()
        self.expect("]")
        return Interval(self.since(start), first, last)

    def bound(self) -> Bound:
        """One end of an interval."""
        expr = self.expression(ARITHMETIC_POWER)
        unit = self.token.text if self.token.text in self.language.units else ""
        if unit:
            self.take()
        return Bound(expr, unit)


def _negative(arg: Expr, start: Span) -> Expr:
    span = start.to(arg.span)
    if isinstance(arg, Num) and not arg.text.startswith("-"):
        return Num(span, f"-{arg.text}")
    return Minus(span, arg)


def _links(expr: Expr, operator: Literal["and", "or"]) -> tuple[Expr, ...]:
    return expr.args if isinstance(expr, Chain) and expr.operator == operator else (expr,)


def _past(token: Token, key: str) -> DialectPast:
    return DialectPast(span=token.span, word=token.text, advice=PAST_ADVICE[key])
