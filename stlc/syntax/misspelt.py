"""Words that a person meant otherwise: misspelt operators, unknown units, shapes there are not."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Final

from stlc.diagnostics import Diagnostic, Fix
from stlc.grammar.units import nearest_unit
from stlc.source import Source
from stlc.syntax.errors import BadNumber, SyntaxMistake
from stlc.syntax.neighbours import BINARY, SHAPED, TEMPORAL, UNARY, word_terminals
from stlc.syntax.tokens import NAME, Token

_PAIRS: Final = {"RSQB": ("INDEX", "LSQB", "IVL"), "RPAR": ("CALL", "LPAR")}
_SHAPES: Final = {"box": "box [x0, x1] x [y0, y1]", "polygon": "polygon (x, y) (x, y) (x, y)"}
_OUTSIDE, _IN, _ONCE = "`a outside p`", "`a in p`", "`eventually[0, 8] a in p`"
_SAID: Final = {
    "avoid": _OUTSIDE, "avoids": _OUTSIDE, "avoiding": _OUTSIDE,
    "inside": _IN, "within": f"{_IN} of a place, `eventually[0, 8]` before it of a time",
    "stays": f"`always` before {_IN}", "stay": f"`always` before {_IN}",
    "remains": f"`always` before {_IN}",
    "reach": _ONCE, "reaches": _ONCE, "visit": _ONCE, "visits": _ONCE, "enters": _ONCE,
    "near": "`distance(a, b) <= 2 m`", "sees": "`distance(a, b) <= 2 m`",
    "hears": "`rssi(a, b) >= -70 dBm`",
    "before": "`(not q) until p`", "after": "`eventually (q and eventually p)`",
}  # fmt: skip
"""What people say instead of an operator, and how it is said here."""
_AFTER_UNIT: Final = frozenset(
    {"$END", "AND", "OR", "IMPLIES", "IFF", "RPAR", "RSQB", "RBRACE", "SEP", "COMMA", "COLON"}
)


def misspelt(source: Source, tokens: list[Token], index: int) -> Diagnostic | None:
    """A better word for the token that the parser can't use, or for the one before it."""
    if not 0 < index < len(tokens):
        return None
    found = _unit(source, tokens, index) or _shape(source, tokens, index)
    if found is not None or not _in_formula(tokens, index):
        return found
    return _binary(source, tokens[index]) or _unary(source, tokens, index)


def _in_formula(tokens: list[Token], index: int) -> bool:
    """Whether the token stands in a formula of `require`, `prefer` or `let`, not in its head."""
    formulas = tokens[0].kind in ("ST_REQUIRE", "ST_PREFER", "ST_LET")
    return formulas and any(t.kind in ("COLON", "EQ") for t in tokens[: index - 1])


def _unit(source: Source, tokens: list[Token], index: int) -> Diagnostic | None:
    """`5 sec`, `0.4 mtr`: a word that ends a comparison, right after a number."""
    before, token = tokens[index - 1], tokens[index]
    if token.kind != NAME or before.kind != "NUMBER":
        return None
    after = tokens[index + 1].kind if index + 1 < len(tokens) else "$END"
    if after not in _AFTER_UNIT:
        return None
    near = nearest_unit(token.text)
    advice = f"did you mean `{near}`?" if near else "units are m, s, kg, dB, dBm, ..."
    place = source.span(token.start, token.end)
    fix = Fix(place, near) if near else None
    text = source.text[before.start : token.end]
    return BadNumber(span=place, text=text, tail=token.text, advice=advice, fix=fix)


def _shape(source: Source, tokens: list[Token], index: int) -> Diagnostic | None:
    """`region g = circle (1, 2) 3`: a word with numbers where a shape is due."""
    before, kind = tokens[index - 1], tokens[index].kind
    due = tokens[index - 2].kind in ("EQ", "ST_WORKSPACE", "PLUS") if index > 1 else False
    if tokens[0].kind not in SHAPED or before.kind != NAME or not due:
        return None
    usage = _SHAPES.get(before.text)
    if usage is not None:
        return SyntaxMistake(
            span=source.span(tokens[index].start, tokens[index].end),
            what=f"`{tokens[index].text}` can't begin a {before.text}",
            place=f"expected `{usage.split()[1][0]}`",
            advice=f"write `{usage}`",
        )
    if kind not in ("CALL", "LPAR", "LSQB", "INDEX", "NUMBER"):
        return None
    return SyntaxMistake(
        span=source.span(before.start, before.end),
        what=f"there is no shape `{before.text}`",
        place="not a shape",
        advice="shapes are `box [x0, x1] x [y0, y1]` and `polygon (x, y) (x, y) (x, y)`; "
        "write a disc as a polygon with 8 corners or more",
    )


def _binary(source: Source, token: Token) -> Diagnostic | None:
    """`x > 0 adn y > 0`, `r avoids pillar`."""
    if token.kind != NAME:
        return None
    advice = _SAID.get(token.text)
    if advice is None:
        return _operator(source, token, BINARY)
    return SyntaxMistake(
        span=source.span(token.start, token.end),
        what=f"`{token.text}` is no operator",
        place="read as a name",
        advice=f"write {advice}",
    )


def _unary(source: Source, tokens: list[Token], index: int) -> Diagnostic | None:
    """`evntually[0, 5] x > 0`, and `eventually(0, 5) x > 0`."""
    start = index - 1
    if tokens[start].kind == "NUMBER" and tokens[start - 1].kind in TEMPORAL:
        return _bare_time(source, tokens[start - 1], tokens[start])
    opening = _PAIRS.get(tokens[start].kind, ())
    while opening and start > 0 and tokens[start].kind not in opening:
        start -= 1
    word = tokens[start - 1] if opening and start > 0 else tokens[start]
    if word.kind != NAME:
        return None
    if "CALL" in opening and word_terminals().get(word.text) in UNARY:
        return SyntaxMistake(
            span=source.span(tokens[start].start, tokens[index - 1].end),
            what=f"the interval of `{word.text}` stands in round brackets",
            place="expected `[` and `]`",
            advice=f"write `{word.text}[0, 5]`",
        )
    return _operator(source, word, UNARY)


def _bare_time(source: Source, operator: Token, time: Token) -> Diagnostic:
    """`eventually 15 x > 0`."""
    return SyntaxMistake(
        span=source.span(time.start, time.end),
        what=f"the interval of `{operator.text}` stands in square brackets",
        place="read as a formula",
        advice=f"write `{operator.text}[0, {time.text}]`, from now until then",
    )


def _operator(source: Source, word: Token, kinds: frozenset[str]) -> Diagnostic | None:
    """A hint at the operator that a misspelt name is near to (`alwys`, `Until`), or None."""
    known = [text for text, kind in word_terminals().items() if kind in kinds and len(text) > 2]
    near = get_close_matches(word.text.lower(), known, 1, 0.65)
    if not near or word.text == near[0]:
        return None
    span = source.span(word.start, word.end)
    return SyntaxMistake(
        span=span,
        what=f"`{word.text}` is no operator",
        place="read as a name",
        advice=f"did you mean `{near[0]}`?",
        fix=Fix(span, near[0]),
    )
