"""Builds the TextMate grammar: run `python -m stlc.grammar.build_textmate` after a change.

Keywords, symbols and units come from the same lists as the parser's; a test fails when the file
is stale.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

from stlc.grammar import tables
from stlc.grammar.units import UNITS

FILE = Path(__file__).resolve().parent / "vscode" / "syntaxes" / "stl.tmLanguage.json"


_SHAPES = [
    "BOX", "POLYGON", "HOLE", "GEOJSON", "FEATURE", "MOVING", "INFLATE", "VELOCITY", "LINE", "LOSS",
]  # fmt: skip


def _alternatives(kinds: list[str], *, letters: bool = False) -> str:
    """The words of these terminals; `letters` also takes those of one letter."""
    spellings = tables().spellings
    found = [w for kind in kinds for w in spellings[kind] if w.isidentifier()]
    return "|".join(w for w in found if letters or len(w) > 1)


def _match(scope: str, pattern: str) -> dict[str, Any]:
    return {"name": f"{scope}.stlc", "match": pattern}


def patterns() -> list[dict[str, Any]]:
    """Rules in the order in which they are tried."""
    spellings = tables().spellings
    statements = _alternatives([name for name in spellings if name.startswith("ST_")])
    temporal = ["ALWAYS", "EVENTUALLY", "NEXT", "UNTIL", "RELEASE"]
    logic = ["NOT", "AND", "OR", "IMPLIES", "IFF", "IN", "OUTSIDE", "SWEPT", "SAMPLED"]
    unit = "|".join(map(re.escape, sorted(UNITS, key=lambda word: (-len(word), word))))
    symbols = {w for group in spellings.values() for w in group if not w[0].isalpha()}
    operators = symbols - set("()[]{},;:.=") - {".."}
    ordered = "|".join(map(re.escape, sorted(operators, key=lambda word: (-len(word), word))))
    one_unit = rf"(?:{unit})(?:\^-?\d+)?"
    return [
        _match("comment.line", r"(?:#|//).*$"),
        _match("string.quoted.double", r'"(?:[^"\\]|\\.)*"'),
        {
            "match": rf"((?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][+-]?\d+)?)[ \t]*"
            rf"({one_unit}(?:[/*]{one_unit})*(?!\w))?",
            "captures": {
                "1": {"name": "constant.numeric.stlc"},
                "2": {"name": "keyword.other.unit.stlc"},
            },
        },
        _match("keyword.control", rf"^\s*(?:{statements})\b"),
        _match("keyword.operator.temporal", rf"\b(?:{_alternatives(temporal)})(?:_(?=\[)|\b)"),
        _match("keyword.operator.temporal", r"\b[GFXUR](?:_?(?=\[)|(?=\s*\(|\s+[\w(]))"),
        _match("keyword.operator.logical", rf"\b(?:{_alternatives(logic)})\b"),
        _match("keyword.other.quantifier", r"\b(?:forall|exists|sum)\b(?=[ \t]+[\w(])"),
        _match("storage.type.shape", rf"\b(?:{_alternatives(_SHAPES)})\b(?=\s*[\[({{\"\d.-])"),
        _match("constant.language", r"\b(?:true|false|inf)\b"),
        _match("entity.name.function", r"\b[A-Za-z_]\w*(?=\()"),
        _match("variable.other", r"\b[A-Za-z_]\w*\b"),
        _match("keyword.operator", ordered),
        _match("punctuation", r"\.\.|[()\[\]{},;:.=]"),
    ]


def render() -> str:
    """The content of the file."""
    grammar = {"name": "stlc mission", "scopeName": "source.stlc", "patterns": patterns()}
    return json.dumps(grammar, ensure_ascii=False, indent=2) + "\n"


def main() -> None:
    """Write the TextMate grammar of the editor extension."""
    scratch = FILE.with_suffix(".tmp")
    scratch.write_text(render(), encoding="utf-8")
    os.replace(scratch, FILE)


if __name__ == "__main__":
    main()
