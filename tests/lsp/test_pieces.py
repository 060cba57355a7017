"""Texts in pieces: what they say is what the parser says of the whole."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stlc.lsp import pieces
from stlc.lsp.document import glance, read_document
from stlc.lsp.pieces import cut
from stlc.source import Source
from stlc.syntax.parse import parse
from stlc.syntax.tokens import Token, tokenize

ROOT = Path(__file__).parents[2]
MISSIONS = sorted(
    p for f in ("examples", "tests/cases", "tests/golden") for p in (ROOT / f).rglob("*.stl")
)

LONG = "step 1 s\nagent r : double_integrator { start (1, 1) } # who moves\n" + "".join(
    f"param p{k} = {k} m\nrequire a{k}: always r.x >= p{k}\n" for k in range(60)
)
BEFORE = cut(Source("m.stl", LONG))


@pytest.mark.parametrize("path", MISSIONS, ids=lambda p: p.name)
def test_pieces_say_what_the_whole_says(path: Path) -> None:
    source = Source(path.name, path.read_text(errors="replace"))
    whole, found = parse(source), cut(source)
    assert found.ok == whole.ok
    if whole.ok:
        assert found.result == whole
    else:
        assert {d.code for d in found.mistakes()} >= {d.code for d in whole.diagnostics}


def test_what_still_stands_is_not_read_again(monkeypatch: pytest.MonkeyPatch) -> None:
    read = []
    monkeypatch.setattr(pieces, "parse", lambda source: read.append(source.text) or parse(source))
    before = read_document(LONG, None)
    assert len(read) == 122
    read.clear()
    edited = LONG.replace("require a30: always r.x", "# here\nrequire a30: always r.y")
    first = glance(edited, None, before)
    assert read == ["require a30: always r.y >= p30"]
    second = glance(edited + "horizon 9\n", None, before, first)
    assert read[1:] == ["horizon 9"]
    assert first.index.declarations["a59"].span.text == "require a59: always r.x >= p59"
    assert len(second.index.same(second.index.occurrences[0])) == 61
    fresh = read_document(second.text, None).index.occurrences
    known = read_document(second.text, None, second).index.occurrences
    assert [(o.name, str(o.span)) for o in known] == [(o.name, str(o.span)) for o in fresh]
    assert len(read) == 2 + 123


def test_an_edited_text_is_checked_as_if_it_were_read_for_the_first_time() -> None:
    before = read_document(LONG, None)
    for edited in (
        LONG.replace("p7 = 7 m", "p7 = 7 dB"),
        "# a\n" + LONG,
        LONG + "require b: r.q >= 1\n",
    ):
        again, fresh = read_document(edited, None, before), read_document(edited, None)
        told = [
            [(str(d), str(d.span), d.notes and str(d.notes[0].span)) for d in x.diagnostics]
            for x in (again, fresh)
        ]
        assert told[0] == told[1]
        assert all(d.span.source.text == edited for d in again.diagnostics if d.span)


TOKENS = [
    "x",
    "require",
    "a:",
    "\n",
    " ",
    "(",
    ")",
    "{",
    "}",
    ";",
    "# c",
    '"',
    "3 m",
    "always",
    "\n",
    "param p = 1\n",
]


@given(st.integers(0, len(LONG)), st.integers(0, 40), st.lists(st.sampled_from(TOKENS), max_size=4))
@settings(max_examples=150, deadline=None)
def test_a_patched_text_is_cut_as_if_it_were_whole(at: int, gone: int, put: list[str]) -> None:
    edited = LONG[:at] + "".join(put) + LONG[at + gone :]
    source = Source("m.stl", edited)
    patched, fresh = cut(source, BEFORE), cut(source)
    assert patched.starts == fresh.starts
    assert patched.comments == fresh.comments
    assert [p.read.file.source.text for p in patched.pieces] == [
        p.read.file.source.text for p in fresh.pieces
    ]


def test_only_what_is_around_a_change_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[int] = []

    def counted(text: str, start: int = 0) -> Iterator[Token]:
        looked.append(len(text) - start)
        return tokenize(text, start)

    monkeypatch.setattr(pieces, "tokenize", counted)
    cut(Source("m.stl", LONG.replace("always r.x >= p30", "always r.y >= p30")), BEFORE)
    assert sum(looked) < 400
