"""The compiled table is the grammar's, the messages fit it, and start-up needs no lark."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis.extra.lark import from_lark
from lark import Lark

from stlc import grammar
from stlc.grammar.build import render
from stlc.grammar.message import Message
from stlc.grammar.messages import MESSAGES
from stlc.source import Source
from stlc.syntax.friendly import message_for, stuck_at
from stlc.syntax.parse import parse

LARK = Lark(grammar.grammar_text(), parser="lalr", start="statement", keep_all_tokens=True)


def test_the_table_is_up_to_date() -> None:
    stored = (Path(grammar.__file__).parent / "tables.json").read_text(encoding="utf-8")
    assert stored == render(grammar.grammar_text()), "run python -m stlc.grammar.build"


@pytest.mark.parametrize("message", MESSAGES, ids=lambda m: m.samples[0])
def test_every_sample_is_malformed_and_gets_its_message(message: Message) -> None:
    for sample in message.samples:
        place = stuck_at(sample)
        assert place is not None, f"{sample!r} is valid"
        assert message_for(place) is message, sample


def test_parsing_imports_neither_lark_nor_numpy() -> None:
    code = (
        "import sys; from stlc.source import Source; from stlc.syntax.parse import parse;"
        "parse(Source('t', 'require a: x > > 1'));"
        "print(*sorted({'lark', 'numpy', 'pygments', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


# Names that are keywords are filtered out, now and then many in a row.
@settings(suppress_health_check=list(HealthCheck))
@given(from_lark(LARK, start="statement"))
def test_texts_of_the_grammar_are_read_or_refused_with_a_place(text: str) -> None:
    result = parse(Source("t.stl", text))
    assert all(d.span is not None for d in result.diagnostics)
    assert result.ok or not result.file.statements or len(result.diagnostics) > 0
