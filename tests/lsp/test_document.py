"""What the language server knows of a text, without a server."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lsprotocol import types

from stlc.lsp.completion import complete
from stlc.lsp.document import glance, read_document
from stlc.lsp.hints import hints
from stlc.lsp.hover import hover
from stlc.lsp.positions import offset, place, position
from stlc.lsp.words import STATEMENTS
from stlc.source import Source

FAMILY = """horizon 9
param wide = 2
agent uav[1..3] : double_integrator { start (2 * i, wide); control |u| <= wide }
obstacle one = box [0, 1] x [5, 6]
obstacle two = one
require a: forall k in 1..3: eventually[2 s, 3 s] uav[k].x >= k
require b: always (sum a in uav: a.x) >= 0 and always uav[1] outside two
"""


def names(text: str, needle: str, inside: int = 0) -> list[int]:
    """Offsets of all that is named as the word at a place."""
    found = read_document(text, None)
    one = found.index.at(text.index(needle) + inside)
    assert one is not None
    return [o.span.start for o in found.index.same(one)]


@pytest.mark.parametrize(
    ("text", "offered"),
    [
        ("agent r : unicycle { start (1, 1); he", True),
        ("dynamics van = car { whe", True),
        ("dynamics van = car { speed <= 1 }\nagent r : van { lo", True),
        ("agent r : double_integrator { he", False),
    ],
)
def test_robots_have_properties_of_their_own(text: str, offered: bool) -> None:
    found = {o.text for o in complete(read_document(text, None), len(text))}
    assert ({"heading", "lookahead", "steering"} <= found) is offered
    assert "start" in found


def test_hover_tells_the_tube_of_a_robot() -> None:
    text = "agent r : unicycle { start (1, 1); speed <= 1; turn_rate <= 2 }\n"
    text += "require a: eventually[0, 4] r.x >= 3\n"
    said, _ = hover(read_document(text, None), text.index("r :"))
    assert "a unicycle within 0.5001 m of its plan" in said


def test_names_are_told_apart_by_what_binds_them():
    assert len(names(FAMILY, "wide")) == 3
    assert len(names(FAMILY, "uav")) == 4
    assert names(FAMILY, "k in") == [FAMILY.index(n) for n in ("k in", "k].x", "k\nrequire")]
    assert len(names(FAMILY, "one")) == 2
    assert len(names(FAMILY, "a in uav")) == 2
    assert len(names(FAMILY, "a: forall")) == 1


def test_members_of_families_are_known():
    found = read_document(FAMILY, None)
    said = hover(found, FAMILY.index("].x") + 2)
    assert said is not None
    assert "position along x" in said[0]
    text = FAMILY + "require c: eventually uav[2].\n"
    half = read_document(text, None, found)
    assert half.mission is found.mission
    assert "vx" in {o.text for o in complete(half, len(text) - 1)}


def test_times_are_told_in_steps():
    text = FAMILY.replace("horizon 9", "step 500 ms\nhorizon 9")
    assert [label for _, label in hints(read_document(text, None))] == [" steps 4..6"]


def test_statements_of_the_grammar_are_all_offered():
    from stlc.grammar import tables

    spelt = tables().spellings
    known = {words[0] for kind, words in spelt.items() if kind.startswith("ST_")}
    assert set(STATEMENTS) == known


def test_imports_are_followed_and_circles_end(tmp_path: Path):
    (tmp_path / "a.stl").write_text('import "m.stl"\nlet far = 3 m\n')
    text = 'import "a.stl"\nagent r : single_integrator { start (0, 0) }\nrequire r.x >= far\n'
    (tmp_path / "m.stl").write_text(text)
    found = read_document(text, tmp_path / "m.stl")
    assert {i.path.name for i in found.imports} == {"a.stl", "m.stl"}
    said = hover(found, text.index("far"))
    assert said is not None
    assert "let far = 3 m" in said[0]


@pytest.mark.parametrize("cut", range(0, len(FAMILY), 7))
def test_any_half_of_a_text_has_answers(cut):
    text = FAMILY[:cut]
    found = read_document(text, None)
    complete(found, cut)
    hover(found, cut)
    hints(found)


@given(st.text(alphabet="ab\n–𝔸\r", max_size=30), st.integers(0, 30))
def test_positions_come_back(text, at):
    source = Source("t", text)
    at = min(at, len(text))
    where = position(source, at)
    back = offset(source, where)
    assert back == at or text[back:at].strip("\r") == ""


def test_positions_count_utf16_units():
    source = Source("t", "𝔸b\nc")
    assert place(source.span(1, 2)).start == types.Position(0, 2)
    assert offset(source, types.Position(0, 3)) == 2
    assert offset(source, types.Position(7, 0)) == 4
    assert offset(source, types.Position(0, 99)) == 2


def test_between_keys_a_text_is_not_checked(monkeypatch):
    before = read_document(FAMILY, None)
    monkeypatch.setattr("stlc.sema.load_mission", None)
    found = glance(FAMILY + "require c: eventually uav[2].\n", None, before)
    assert found.mission is before.mission
    assert not found.readable
    assert "px" in [o.text for o in complete(found, len(found.text) - 1)]
    assert glance(FAMILY, None, before).diagnostics == ()
