"""Pygments lexer of mission files (`stl`), its keywords taken from the grammar."""

from __future__ import annotations

from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text

from stlc.grammar import tables
from stlc.grammar.units import UNITS

_PUNCTUATION = frozenset("()[]{},;:.=") | {".."}


def _words(*kinds: str) -> tuple[str, ...]:
    """Spellings of these terminals that are words of more than one letter."""
    spellings = tables().spellings
    return tuple(w for kind in kinds for w in spellings[kind] if w.isidentifier() and len(w) > 1)


def _statements() -> tuple[str, ...]:
    return _words(*(name for name in tables().spellings if name.startswith("ST_")))


def _symbols() -> tuple[str, ...]:
    found = {w for group in tables().spellings.values() for w in group if not w[0].isalpha()}
    return tuple(sorted(found - _PUNCTUATION, key=len, reverse=True))


_TEMPORAL = _words("ALWAYS", "EVENTUALLY", "NEXT", "UNTIL", "RELEASE")
_LOGIC = _words("NOT", "AND", "OR", "IMPLIES", "IFF", "IN", "OUTSIDE", "SWEPT", "SAMPLED")
_BINDERS = _words("FORALL", "EXISTS", "SUM")
_SHAPES = (
    "box",
    "polygon",
    "hole",
    "geojson",
    "feature",
    "moving",
    "inflate",
    "velocity",
    "line",
    "loss",
)
_UNIT = "|".join(sorted(UNITS, key=len, reverse=True))


class StlLexer(RegexLexer):
    """Highlights missions: statements, temporal operators, numbers with units, comments."""

    name = "stlc mission"
    aliases: ClassVar[list[str]] = ["stl", "stlc"]
    filenames: ClassVar[list[str]] = ["*.stl"]
    mimetypes: ClassVar[list[str]] = ["text/x-stlc"]

    tokens: ClassVar[dict[str, list[object]]] = {
        "root": [
            (r"(?:#|//)[^\n]*", Comment.Single),
            (r"\s+", Text.Whitespace),
            (r'"(?:[^"\\\n]|\\[^\n])*"', String.Double),
            (
                rf"((?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][+-]?\d+)?)([ \t]*)"
                rf"((?:{_UNIT})(?:\^-?\d+)?(?:[/*](?:{_UNIT})(?:\^-?\d+)?)*)(?!\w)",
                bygroups(Number, Text.Whitespace, Keyword.Type),
            ),
            (r"(?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][+-]?\d+)?", Number),
            (
                rf"(^[ \t]*)({'|'.join(_statements())})\b",
                bygroups(Text.Whitespace, Keyword.Declaration),
            ),
            (words(_TEMPORAL, prefix=r"\b", suffix=r"(?:_(?=\[)|\b)"), Keyword),
            (r"\b[GFXUR](?:_?(?=\[)|(?=\s*\(|\s+[\w(]))", Keyword),
            (words(_LOGIC, prefix=r"\b", suffix=r"\b"), Operator.Word),
            (words(_BINDERS, prefix=r"\b", suffix=r"(?=[ \t]+[\w(])"), Keyword),
            (words(_SHAPES, prefix=r"\b", suffix=r"(?=\s*[\[({\"\d.-])"), Keyword.Reserved),
            (r"\b(?:true|false|inf)\b", Keyword.Constant),
            (r"\bx(?=\s*\[)|(?<=\d )x(?= \d)", Operator.Word),
            (r"[^\W\d]\w*(?=\()", Name.Function),
            (r"[^\W\d]\w*", Name),
            (words(_symbols()), Operator),
            (r"\.\.|[()\[\]{},;:.=]", Punctuation),
        ],
    }
