"""What a word or bracket is, judged by its neighbours; the walk itself is in `context.py`."""

from __future__ import annotations

from functools import cache
from itertools import dropwhile, takewhile
from typing import Final

from stlc.grammar import tables
from stlc.syntax.tokens import NAME, NEWLINE, STRING, SYMBOL, Token

UNARY: Final = frozenset({"ALWAYS", "EVENTUALLY", "NEXT", "NOT"})
TEMPORAL: Final = frozenset({"ALWAYS", "EVENTUALLY", "NEXT", "UNTIL", "RELEASE"})
BINARY: Final = frozenset(
    {"UNTIL", "RELEASE", "AND", "OR", "IMPLIES", "IFF", "IN", "OUTSIDE", "SWEPT"}
)
_CONNECTIVES: Final = frozenset({"AND", "OR", "IMPLIES", "IFF"})
QUANTIFIERS: Final = frozenset({"FORALL", "EXISTS", "SUM"})
SHAPED: Final = frozenset({"ST_WORKSPACE", "ST_REGION", "ST_OBSTACLE", "ST_WALL"})
NAMED: Final = frozenset(
    {"ST_PARAM", "ST_DYNAMICS", "ST_AGENT", "ST_STATION", "ST_REGION", "ST_OBSTACLE"}
    | {"ST_CHANNEL", "ST_LET", "ST_WALL"}
)
AFTER_SHAPES: Final = frozenset({"inflate", "velocity", "swept", "sampled", "loss"})
WISHES: Final = {
    word: word.upper() for word in ("weight", "priority", "margin", "scale", "late", "share")
}
"""Words in the head of a `prefer`, and their terminals."""
# Symbols after which a word in front of them was a name, not an operator.
_NAME_BEFORE: Final = frozenset(
    {"LE", "LT", "GE", "GT", "EQEQ", "NE", "PLUS", "STAR", "SLASH", "CARET", "EQ", "COLON"}
    | {"COMMA", "DOT", "DOTS", "RPAR", "RSQB", "LBRACE", "RBRACE", "SEP"}
    | {"AND", "OR", "IMPLIES", "IFF"}
)
_NORMED: Final = frozenset({"control", "speed", "state"})  # a magnitude may follow on the next line
_COMPARED: Final = frozenset({"LE", "LT", "GE", "GT", "EQEQ", "NE"})
NOTHING: Final = Token("$END", "", 0, 0)


@cache
def symbol_terminals() -> dict[str, str]:
    """Terminal of each symbol; brackets and bars are refined by their place."""
    special = {"CALL", "INDEX", "IVL", "ABS_OPEN", "ABS_CLOSE"}
    return {
        word: name
        for name, words in tables().spellings.items()
        if name not in special
        for word in words
        if not word[0].isalpha()
    }


@cache
def word_terminals() -> dict[str, str]:
    """Terminal of each word that can be an operator within an expression."""
    kinds = UNARY | BINARY | QUANTIFIERS | {"TRUE", "FALSE"}
    return {word: kind for kind in kinds for word in tables().spellings[kind] if word[0].isalpha()}


def plain(symbol: str) -> str:
    """`[ ]` is `[]`."""
    return "[]" if symbol[0] == "[" and symbol[-1] == "]" else symbol


class Neighbours:
    """A place in a statement's tokens: what is behind (`out`, `frames`) and what is ahead.

    `frames` are the open brackets, bars included: `S` for one around a shape, `M` for the brace of
    a moving one, `I` for that of an interval.
    """

    __slots__ = ("at", "frames", "key_due", "operand", "out", "shaped", "tokens", "wishing")

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens = tokens
        self.out: list[Token] = []
        self.frames: list[str] = []
        self.at = 0
        self.operand = False  # the last token completes an operand
        self.key_due = False  # a property starts here
        self.wishing = False  # in the head of a `prefer`
        self.shaped = False

    def _emit(self, kind: str, token: Token, *, operand: bool) -> None:
        if token.kind != kind:
            token = Token(kind, token.text, token.start, token.end)
        self.out.append(token)
        self.operand = operand

    def _signal(self) -> None:
        """Names and commas, the unit between square brackets as one token, the file."""
        while self._here().kind in (NAME, SYMBOL) and self._here().text != "[":
            if self._here().text == "from" and self._peek().kind == STRING:
                break
            if self._here().kind == NAME:
                self._plain_name()
            else:
                self._take(symbol_terminals().get(self._here().text, "BAD"), operand=False)
        rest = self.tokens[self.at :]
        size = next((k for k, token in enumerate(rest) if token.text == "]"), 0)
        if size > 1 and rest[0].text == "[":
            text = "".join(token.text for token in rest[1:size])
            self.out.append(Token("UNIT", text, rest[0].start, rest[size].end))
            self.at += size + 1
        if self._here().text == "from" and self._peek().kind == STRING:
            self._take("FROM", operand=False)

    def _here(self) -> Token:
        return self.tokens[self.at] if self.at < len(self.tokens) else NOTHING

    def _take(self, kind: str, *, operand: bool) -> None:
        self._emit(kind, self._here(), operand=operand)
        self.at += 1

    def _plain_name(self) -> None:
        if self._here().kind == NAME:
            self._take(NAME, operand=True)

    def _peek(self, ahead: int = 1) -> Token:
        """The raw token that many places on, newlines not counted."""
        position = self.at
        while ahead:
            position += 1
            if position >= len(self.tokens):
                return NOTHING
            ahead -= self.tokens[position].kind != NEWLINE
        return self.tokens[position]

    @property
    def _last(self) -> str:
        return self.out[-1].kind if self.out else ""

    @property
    def _in_property(self) -> bool:
        """Directly within the braces of a block, where words and values stand side by side."""
        return bool(self.frames) and self.frames[-1] == "{"

    def _is_operator(self, kind: str, token: Token) -> bool:
        """Whether a word that can be an operator is one here, and not a name."""
        if kind in ("TRUE", "FALSE"):
            return True
        if kind in QUANTIFIERS:
            return not self.operand and self._quantifies(kind)
        if self.operand:
            return not (self._in_property and self._peek().kind == "$END")
        if kind in UNARY:
            return self._takes_operand(token)
        # Where an operand is due a binary word is a name; if an operand follows, it is a mistake
        # that the parser reports at the operator.
        after = self._peek()
        wanting = len(token.text) > 1 and after.text not in ("-", "−")
        return wanting and self._begins_operand(after, self._peek(2))

    def _quantifies(self, kind: str) -> bool:
        first, second = self._peek(), self._peek(2)
        if kind == "SUM" and first.text == "(":
            return self._after_bracket(1).text == "in"
        if kind == "SUM":
            return first.kind == NAME and second.text == "in"
        named = first.kind == NAME and (first.text != "in" or second.text == "in")
        return named or first.text == "("

    def _takes_operand(self, token: Token) -> bool:
        """Whether a unary operator's word is the operator here, and not a name."""
        after = self._peek()
        long = len(token.text) > 2
        if self._in_property and not long and self._line_ends():
            return False
        if after.text == "[":
            return long or self._is_interval()
        if after.text in ("|", "||"):
            return long or self._hugs(after)
        if after.text == "(" and after.start == token.end and self._several_arguments():
            return False
        if after.text in ("-", "−"):
            return long
        if long and (after.kind == "$END" or word_terminals().get(after.text) in _CONNECTIVES):
            return word_terminals().get(self._peek(2).text) not in BINARY
        return self._begins_operand(after, self._peek(2))

    def _line_ends(self) -> bool:
        beyond = self.tokens[self.at + 1 : self.at + 2]
        return not beyond or beyond[0].kind == NEWLINE

    def _several_arguments(self) -> bool:
        """Whether the parentheses that follow hold nothing, or values with commas between them."""
        depth = 0
        for position in range(self.at + 1, len(self.tokens)):
            text = self.tokens[position].text
            depth += (text in ("(", "[", "{")) - (text in (")", "]", "}"))
            if depth == 0:
                return position == self.at + 2
            if depth == 1 and text == ",":
                return True
        return False

    def _is_interval(self) -> bool:
        """Whether the bracket that follows is an interval and not the index of a family."""
        beyond = self._after_bracket(1)
        if self._peek(2).text in ("]", "") or self._peek(3).text == "]":
            minus = beyond.text in ("-", "−")
            return not minus and self._begins_operand(beyond, NOTHING)
        return self._begins_operand(beyond, NOTHING) or beyond.kind == "$END"

    def _hugs(self, bar: Token) -> bool:
        """A bar with a blank before and none after it opens an absolute value."""
        spaced = self.tokens[self.at].end < bar.start
        return spaced and self._peek(2).start == bar.end

    def _begins_operand(self, first: Token, second: Token) -> bool:
        """Whether an operand can begin with these tokens; two are needed as words can be names."""
        if first.kind == "$END":
            return False
        if first.kind == SYMBOL:
            kind = symbol_terminals()[plain(first.text)]
            return kind not in _NAME_BEFORE or first.text == "|"
        if first.kind != NAME:
            return True
        word = word_terminals().get(first.text)
        if word not in BINARY:
            return True
        # A binary word as first word of an operand is a name: `always in > 3`.
        kind = symbol_terminals().get(second.text, "")
        if word == "SWEPT":
            return kind in _COMPARED
        if len(first.text) == 1 and second.kind == "$END":
            return True
        if len(second.text) > 1 and word_terminals().get(second.text) in BINARY:
            return True
        return kind in _NAME_BEFORE - {"LBRACE"} and second.text != "|"

    def _after_bracket(self, ahead: int) -> Token:
        """The raw token after the bracket that opens `ahead` tokens on is closed."""
        depth = 0
        position = self.at + ahead
        while position < len(self.tokens):
            text = self.tokens[position].text
            depth += (text in ("(", "[", "{")) - (text in (")", "]", "}"))
            position += 1
            if depth == 0:
                break
        while position < len(self.tokens) and self.tokens[position].kind == NEWLINE:
            position += 1
        return self.tokens[position] if position < len(self.tokens) else NOTHING

    @property
    def _of_shape(self) -> bool:
        """Whether a word here is of a shape, not of a point or of the time of a frame."""
        if not self.shaped or not set(self.frames) <= {"M", "S"}:
            return False
        parts = (t.kind for t in reversed(self.out) if t.kind in ("COLON", "SEP", "LBRACE"))
        return "M" not in self.frames or next(parts) == "COLON"

    def _begins_chain(self, first: Token) -> bool:
        """Whether the next line is a property such as `-1 <= vx <= 1` or `|vx| <= 1`."""
        bar = first.text == "|"
        if not self._in_property or not (bar or first.text in ("-", "−", "(")):
            return False
        if bar and (self._peek(2).start > first.end or self.out[-1].text in _NORMED):
            return False
        return self._line_compares()

    def _line_compares(self) -> bool:
        """Whether the next line with words has a comparison outside of brackets."""
        ahead = dropwhile(lambda token: token.kind == NEWLINE, self.tokens[self.at :])
        depth = 0
        for token in takewhile(lambda token: token.kind != NEWLINE, ahead):
            if token.kind != SYMBOL:
                continue
            depth += (token.text in ("(", "[", "{")) - (token.text in (")", "]", "}"))
            if depth < 0 or (depth == 0 and token.text in (";", ",")):
                return False
            if depth == 0 and symbol_terminals().get(token.text) in _COMPARED:
                return True
        return False
