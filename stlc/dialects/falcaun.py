"""FalCAuN's formulas: one on a line, over `signal(i)`, `output(i)` and `input(i)`.

All steps are discrete and intervals count them. FalCAuN's grammar (STL.g4) gives `&&`, `||`,
`->`, `U` and `R` one precedence, grouped from the left; unary operators bind more loosely, so
`[] p -> q` is `[] (p -> q)`. Until and release are those of LTL, to which FalCAuN translates its
formulas: in `p U q`, p may end one step before q. `==` and `!=` compare discrete values (gears),
so that exactly one of them holds. Shell variables (`$speed`) name signals on the left of a
comparison and parameters on the right.
"""

from __future__ import annotations

from typing import ClassVar

from stlc.dialects.errors import OddGrouping
from stlc.dialects.language import ARITHMETIC, SIGNS, Infix, Language, Prefix, compared
from stlc.dialects.pratt import Parser
from stlc.dialects.tokens import pattern
from stlc.dialects.tree import Definition, Expr, Item, Sample
from stlc.source import Span

_ALWAYS, _EVENTUALLY = Prefix("always", 13, timed=12), Prefix("eventually", 13, timed=12)
_SYMBOLS = (
    "[]_", "[]", "<>_", "<>", "&&", "||", "->", "=>", "==", "!=", "<=", ">=", "<", ">", "!", "&",
    "|", "_", "+", "-", "*", "/", "^", "(", ")", "[", "]", ",", ";", "{", "}", "'", '"',
)  # fmt: skip


class FalcaunParser(Parser):
    """Reads FalCAuN formulas."""

    language: ClassVar = Language(
        scanner=pattern(r"//[^\n]*|\#[^\n]*|/\*.*?\*/", r"\$?[A-Za-z]\w*|\$\{\w+\}", _SYMBOLS),
        prefix={
            **{word: _ALWAYS for word in ("[]", "[]_", "alw", "alw_", "G", "G_")},
            **{word: _EVENTUALLY for word in ("<>", "<>_", "ev", "ev_", "F", "F_")},
            "X": Prefix("next", 13),
            **{word: Prefix("not", 13) for word in ("!", "not")},
            **SIGNS,
        },
        infix={
            **{word: Infix("and", 14) for word in ("&&", "&", "and")},
            **{word: Infix("or", 14) for word in ("||", "|", "or")},
            **{word: Infix("implies", 14) for word in ("->", "=>")},
            **{word: Infix("until", 14, timed=11) for word in ("U", "U_")},
            **{word: Infix("release", 14, timed=11) for word in ("R", "R_")},
            **compared(30, {"<": "<", "<=": "<=", ">": ">", ">=": ">=", "==": "==", "!=": "!="}),
            **ARITHMETIC,
        },
        past={"once": "once", "historically": "historically", "since": "since"},
        functions=frozenset(("abs", "min", "max")),
    )

    def items(self) -> list[Item]:
        """The next formula."""
        start = self.token.span
        body = self.expression()
        span = self.since(start)
        self.accept(";", ",")
        return [Definition(span, None, body)]

    def skip(self) -> None:
        """Go on to the next line."""
        line = self.take().span.line
        while self.token.kind != "end" and self.token.span.line == line:
            self.take()

    def notice_prefix(self, operator: Span, first: Span, arg: Expr) -> None:
        """`[] p -> q` takes in the whole implication."""
        text = " ".join(self.since(first).text.split())
        word = " ".join(self.source.text[operator.start : first.start].split())
        shown = text if len(text) <= 40 else f"{text[:40]} .."
        self.warnings.append(
            OddGrouping(
                span=self.since(first), tool="FalCAuN",
                whole=f"{word} {shown}", reading=f"{word} ({shown})",
            )
        )  # fmt: skip

    def special(self) -> Expr | None:
        """`signal(0)`, which is `output(0)`, and `input(0)`."""
        token = self.token
        if token.text not in ("signal", "output", "input") or self.peek().text != "(":
            return None
        self.take()
        self.take()
        if self.token.kind != "number" or not self.token.text.isdigit():
            self.fail("expected the number of a signal")
        number = self.take().text
        self.expect(")")
        kind = "input" if token.text == "input" else "signal"
        return Sample(self.since(token.span), f"{kind}{number}")
