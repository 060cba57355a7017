"""Gives the tokens of one statement their terminals, by their neighbours.

Words are names unless they stand where an operator stands: `G` is the operator before `[` or an
operand, and a signal before a comparison, an arithmetic operator, `.`, `,`, `)` or the end.
Brackets know what they open: a call, an index, an interval, a tuple or a list; a bar opens an
absolute value where an operand is due and closes it otherwise.
"""

from __future__ import annotations

from stlc.syntax.neighbours import (
    AFTER_SHAPES,
    NAMED,
    NOTHING,
    QUANTIFIERS,
    SHAPED,
    TEMPORAL,
    WISHES,
    Neighbours,
    plain,
    symbol_terminals,
    word_terminals,
)
from stlc.syntax.split import statement_words
from stlc.syntax.tokens import NAME, NEWLINE, NUMBER, STRING, SYMBOL, Token

_BEFORE_SHAPE = {"EQ", "PLUS", "COLON", "LPAR", "ST_WORKSPACE"}


def classify(tokens: list[Token]) -> list[Token]:
    """Tokens of one statement with the grammar's terminals as kinds.

    The first token is a statement keyword, or the text is an expression by itself.
    """
    return _Context(tokens).run()


class _Context(Neighbours):
    """One walk over a statement."""

    __slots__ = ()

    def run(self) -> list[Token]:
        """Every token with the terminal that its context gives it."""
        self._header()
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            kind = token.kind
            if kind == NAME:
                self._word(token)
            elif kind == SYMBOL:
                self._symbol(token)
            elif kind == NEWLINE:
                self._newline()
            else:
                self._emit(kind, token, operand=True)
                self.key_due = False
            self.at += 1
        return self.out

    # --- the first words of a statement ------------------------------------------------------

    def _header(self) -> None:
        """The statement's keyword and the name behind it, which is a name whatever it spells."""
        first = self.tokens[0]
        kind = statement_words().get(first.text, "") if first.kind == NAME else ""
        if not kind:
            return
        self._emit(kind, first, operand=False)
        self.at = 1
        self.shaped = kind in SHAPED
        if kind == "ST_SIGNAL":
            self._signal()
        elif kind == "ST_REQUIRE":
            self._require()
        elif kind == "ST_PREFER":
            self.wishing = True
            if self._here().text not in WISHES or self._peek().text == ":":
                self._plain_name()
        elif kind in NAMED:
            self._plain_name()
            if kind == "ST_STATION" and self._here().text == "at":
                self._take("AT", operand=False)

    def _require(self) -> None:
        after = self._peek()
        if after.text == ":" or (after.kind == NAME and after.text == "margin"):
            self._plain_name()
        if self._here().text == "margin" and self._peek().text not in (":", "=="):
            self._take("MARGIN", operand=False)

    # --- words -------------------------------------------------------------------------------

    def _word(self, token: Token) -> None:
        """A word: key of a property, name, part of a shape, or operator, in this order."""
        if self.key_due:
            self.key_due = False
            self._emit("KEY", token, operand=False)
            return
        if self._last == "DOT" or self._last in QUANTIFIERS:
            self._emit(NAME, token, operand=True)
            return
        if self.wishing and not self.frames and token.text in WISHES:
            self._emit(WISHES[token.text], token, operand=False)
            return
        in_list = bool(self.frames) and self.frames[-1] == "["
        if self.shaped and not in_list and self._shape_word(token):
            return
        placed = self.operand or self._last == "KEY"
        if self._in_property and placed and self._property_word(token):
            return
        kind = word_terminals().get(token.text)
        if kind is None and token.text[-1] == "_" and self._underscore(token):
            return
        if kind is None or not self._is_operator(kind, token):
            self._emit(NAME, token, operand=True)
            return
        self._emit(kind, token, operand=kind in ("TRUE", "FALSE", "SWEPT"))

    def _underscore(self, token: Token) -> bool:
        """`G_[0,5]`, `alw_[0,5]`, and the `_` of `[]_[0,5]`."""
        if self._peek().text != "[":
            return False
        kind = word_terminals().get(token.text[:-1], "")
        if token.text == "_" and self._last in TEMPORAL:
            return True
        if kind in TEMPORAL:
            self._emit(kind, token, operand=False)
            return True
        return False

    def _shape_word(self, token: Token) -> bool:
        """Words that are keywords in shapes only; False leaves the token to others."""
        text, after = token.text, self._peek()
        opener = {"box": "[", "polygon": "(", "moving": "{"}
        due = self._last in _BEFORE_SHAPE - {"LPAR"} and (
            after.text in ("", "+", ";", "}", *AFTER_SHAPES) and text not in ("true", "false")
        )
        tall = after.text == "x" and self._peek(2).text == "[" and text not in ("true", "false")
        line = self._last == "EQ" and text == "line" and self.out[0].kind == "ST_WALL"
        if line or (not self.operand and after.text == opener.get(text) and self._of_shape):
            self._emit(text.upper(), token, operand=False)
        elif not self.operand and text == "geojson" and after.kind == STRING:
            self._emit("GEOJSON", token, operand=False)
        elif self.operand and text == "x" and after.text == "[":
            self._emit("TIMES", token, operand=False)
        elif text == "linear" and self._last == "RBRACE":
            self._emit("LINEAR", token, operand=True)
        elif self.operand and text in ("hole", "feature", "velocity", "inflate", "loss"):
            self._emit(text.upper(), token, operand=False)
            self.shaped = text not in ("inflate", "loss")
        elif self.operand and text in ("swept", "sampled") and self._of_workspace:
            self._emit(text.upper(), token, operand=True)
        elif (tall and not self.operand) or (due and "(" not in self.frames):
            self._emit(NAME, token, operand=True)
        else:
            return False
        return True

    @property
    def _of_workspace(self) -> bool:
        return not self.frames and self.out[0].kind == "ST_WORKSPACE"

    def _property_word(self, token: Token) -> bool:
        """`x` between two sizes; a name with its own `=` starts the next property."""
        after = self._peek()
        if after.text == "=":
            self.out.append(Token("SEP", "", token.start, token.start))
            self._emit("KEY", token, operand=False)
            return True
        sizes = self._last in (NUMBER, "RSQB") and (after.kind == NUMBER or after.text == "[")
        if token.text == "x" and sizes:
            self._emit("TIMES", token, operand=False)
            return True
        return False

    # --- symbols -----------------------------------------------------------------------------

    def _symbol(self, token: Token) -> None:
        """A symbol, with what it does to the open brackets."""
        text = token.text
        if text in ("(", "["):
            self._open(token)
        elif text in (")", "]"):
            self._close(token)
        elif text in ("|", "||"):
            self._bar(token)
        elif text[0] == "[" and self._last in TEMPORAL and self.out[-1].text.isalpha():
            self._emit("IVL", Token(SYMBOL, "[", token.start, token.start + 1), operand=False)
            self._emit("RSQB", Token(SYMBOL, "]", token.end - 1, token.end), operand=False)
        elif text == "{":
            self.frames.append("M" if self._last == "MOVING" else "{")
            self._emit("LBRACE", token, operand=False)
            self.key_due = self.frames[-1] == "{"
        elif text == "}":
            self._close_block(token)
        elif self.frames and self.frames[-1] in "{M" and text in (";", ","):
            if text == ";" or not self._listing():
                self._separate(token)
        else:
            kind = symbol_terminals()[plain(text)]
            self.wishing = self.wishing and (kind != "COLON" or bool(self.frames))
            self._emit(kind, token, operand=False)
            self.key_due = False

    def _open(self, token: Token) -> None:
        """An opening bracket: call or group, index or list, or a temporal operator's interval."""
        blank = bool(self.out) and self.out[-1].end < token.start
        apart = self._in_property and blank
        self.key_due = False
        if token.text == "(":
            called = self.operand and self._last == NAME and not apart
            group = not called and self._last in _BEFORE_SHAPE and self._of_shape
            self.frames.append("S" if group else "(")
            self._emit("CALL" if called else "LPAR", token, operand=False)
        elif self._last in TEMPORAL:
            self.frames.append("I")
            self._emit("IVL", token, operand=False)
        else:
            joined = self._last in (NAME, "RPAR") or (self._last == "RSQB" and not blank)
            indexed = self.operand and joined and not apart
            self.frames.append("[")
            self._emit("INDEX" if indexed else "LSQB", token, operand=False)

    def _close(self, token: Token) -> None:
        while self.frames and self.frames[-1] == "|":
            self.frames.pop()
        frame = self.frames.pop() if self.frames else ""
        self._emit("RPAR" if token.text == ")" else "RSQB", token, operand=frame != "I")

    def _bar(self, token: Token) -> None:
        """`|` is `or` or one side of an absolute value, by whether an operand stands before it."""
        closes = self.operand and bool(self.frames) and self.frames[-1] == "|"
        opens = not self.operand or (self._in_property and self._hugs_here(token))
        if not closes and not opens:
            self._emit("OR", token, operand=False)
            return
        for k in range(len(token.text)):
            bar = Token(SYMBOL, "|", token.start + k, token.start + k + 1)
            if closes:
                if self.frames and self.frames[-1] == "|":
                    self.frames.pop()
                self._emit("ABS_CLOSE", bar, operand=True)
            else:
                self.frames.append("|")
                self._emit("ABS_OPEN", bar, operand=False)
                self.key_due = False

    def _hugs_here(self, bar: Token) -> bool:
        return self.out[-1].end < bar.start and self._peek().start == bar.end

    # --- blocks ------------------------------------------------------------------------------

    def _newline(self) -> None:
        """Within braces a newline ends a property that is complete, unless an operator follows."""
        if not self.frames or self.frames[-1] not in "{M":
            return
        if not self.operand and self._last != "KEY":
            return
        after = self._peek()
        if after.kind in (NAME, NUMBER) or after.text == "}" or self._begins_chain(after):
            self._separate(self.tokens[self.at])

    def _listing(self) -> bool:
        """Whether a comma stands within a list of bare words: `states px, vx, py, vy`."""
        after = self._peek()
        beyond = self.tokens[self.at + 2] if self.at + 2 < len(self.tokens) else NOTHING
        ends = beyond.kind == NEWLINE or beyond.text in (",", ";", "}")
        if self._last != NAME or after.kind != NAME or not ends:
            return False
        kinds = (token.kind for token in reversed(self.out))
        return next((kind for kind in kinds if kind != NAME), "") == "KEY"

    def _separate(self, token: Token) -> None:
        if self._last not in ("SEP", "LBRACE"):
            self._emit("SEP", token, operand=False)
        self.key_due = self.frames[-1] == "{"

    def _close_block(self, token: Token) -> None:
        while self.frames and self.frames[-1] == "|":
            self.frames.pop()
        if self.frames:
            self.frames.pop()
        if self._last == "SEP":
            self.out.pop()
        self.key_due = False
        self._emit("RBRACE", token, operand=True)
