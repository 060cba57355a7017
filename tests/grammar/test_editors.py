"""Editor grammars know every token of missions, and class the keywords as the parser does."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from pygments.token import Comment, Error, Keyword, Name, Number, Operator, String, _TokenType

from stlc import grammar
from stlc.grammar.build_textmate import render
from stlc.grammar.pygments_lexer import StlLexer

FOLDER = Path(grammar.__file__).parent
SAMPLE = """# a mission
step 1 s
workspace box [0, 10] x [0, 10] sampled
agent r1 : cart { start (1, 1); control |u| <= 1; turn_rate on; mass 1.5 kg }
channel radio {
  path_loss L0 = -12.89 dBm, n = 3
  samples "rssi.csv"  // measured
  partition 10 x 10
}
let home(a, g) = eventually[0, 8] a in g
require clear: always forall a in agents: a outside pillar swept
require old: G[0,5] (x > 0 -> y >= 1) && !z U_[0,3] w
minimize 0.1 * effort + 0.9 * link_cost(radio)
"""
EXAMPLES = sorted((FOLDER.parent / "examples").rglob("*.stl"))


def lexed(text: str) -> list[tuple[_TokenType, str]]:
    return list(StlLexer().get_tokens(text))


@pytest.mark.parametrize("text", [SAMPLE, *(path.read_text("utf-8") for path in EXAMPLES)])
def test_pygments_knows_every_token(text: str) -> None:
    assert [word for kind, word in lexed(text) if kind in Error] == []


@pytest.mark.parametrize(
    ("word", "kind"),
    [
        ("require", Keyword.Declaration), ("channel", Keyword.Declaration), ("always", Keyword),
        ("G", Keyword), ("U_", Keyword), ("eventually", Keyword), ("forall", Keyword),
        ("in", Operator.Word), ("outside", Operator.Word), ("swept", Operator.Word),
        ("sampled", Operator.Word),
        ("box", Keyword.Reserved), ("kg", Keyword.Type), ("dBm", Keyword.Type), ("1.5", Number),
        ('"rssi.csv"', String.Double), ("# a mission", Comment.Single), ("->", Operator),
        ("// measured", Comment.Single), ("home", Name.Function), ("pillar", Name),
        ("&&", Operator),
    ],
)  # fmt: skip
def test_pygments_classes_words(word: str, kind: _TokenType) -> None:
    found = {k for k, text in lexed(SAMPLE) if text == word}
    assert kind in found
    assert all(k in kind for k in found), found


def test_the_textmate_grammar_is_up_to_date() -> None:
    stored = (FOLDER / "vscode/syntaxes/stl.tmLanguage.json").read_text(encoding="utf-8")
    assert stored == render(), "run python -m stlc.grammar.build_textmate"


def scopes(text: str) -> dict[str, str]:
    """Scope of each word by the first rule that matches, as an editor would apply them."""
    rules = json.loads((FOLDER / "vscode/syntaxes/stl.tmLanguage.json").read_text())["patterns"]
    compiled = [(re.compile(rule["match"], re.M), rule) for rule in rules]
    found: dict[str, str] = {}
    at = 0
    while at < len(text):
        hits = ((pattern.match(text, at), rule) for pattern, rule in compiled)
        hit, rule = next(((m, r) for m, r in hits if m and m.end() > at), (None, None))
        if hit is None:
            assert text[at].isspace(), text[at : at + 20]
            at += 1
            continue
        found[hit.group().strip()] = rule.get("name", "number") if rule else ""
        at = hit.end()
    return found


@pytest.mark.parametrize("text", [SAMPLE, *(path.read_text("utf-8") for path in EXAMPLES)])
def test_textmate_knows_every_token(text: str) -> None:
    assert scopes(text)


def test_textmate_classes_words() -> None:
    found = scopes(SAMPLE)
    assert found["require"] == "keyword.control.stlc"
    assert found["always"] == found["G"] == "keyword.operator.temporal.stlc"
    assert found["outside"] == "keyword.operator.logical.stlc"
    assert found["# a mission"] == "comment.line.stlc"
    assert found["1.5 kg"] == "number"
    assert found["pillar"] == "variable.other.stlc"


def test_the_extension_points_at_files_that_exist() -> None:
    package = json.loads((FOLDER / "vscode/package.json").read_text())["contributes"]
    assert (FOLDER / "vscode" / package["grammars"][0]["path"]).is_file()
    assert (FOLDER / "vscode" / package["languages"][0]["configuration"]).is_file()
