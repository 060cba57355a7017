"""Records: fields of base and class, defaults, frozen, equal by value, picklable."""

from __future__ import annotations

import pickle

import pytest

from stlc.diagnostics import Fix, Note
from stlc.record import changed
from stlc.sema.objective_errors import BadObjective
from stlc.source import Source
from stlc.syntax import ast

SPAN = Source("t.stl", "x + 1").span(0, 1)


def test_fields_of_the_base_come_first_and_defaults_fill_up() -> None:
    number = ast.Number(SPAN, 1.0, "1")
    assert (number.span, number.value, number.text, number.unit) == (SPAN, 1.0, "1", None)
    assert ast.Number(SPAN, 1.0, text="1", unit="m") == changed(number, unit="m")
    assert number != changed(number, unit="m")
    assert ast.Name(SPAN, "x") != ast.String(SPAN, "x")
    assert len({ast.Name(SPAN, "x"), ast.Name(SPAN, "x")}) == 1


def test_wrong_fields_are_refused() -> None:
    with pytest.raises(TypeError, match="value"):
        ast.Number(SPAN)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="speed"):
        ast.Name(SPAN, "x", speed=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="Name"):
        ast.Name(SPAN, "x", "y")  # type: ignore[call-arg]


def test_records_are_frozen() -> None:
    name = ast.Name(SPAN, "x")
    with pytest.raises(AttributeError, match="frozen"):
        name.text = "y"  # type: ignore[misc]
    with pytest.raises(AttributeError, match="frozen"):
        del name.text
    with pytest.raises(AttributeError):
        name.other = 1  # type: ignore[attr-defined]


def test_records_survive_pickling() -> None:
    for record in (Note("why"), Fix(SPAN, "y"), BadObjective(problem="why")):
        again = pickle.loads(pickle.dumps(record))
        assert type(again) is type(record)
    assert pickle.loads(pickle.dumps(Note("why"))) == Note("why")
    assert repr(Note("why")) == "Note(text='why', span=None)"


def test_fields_can_be_taken_apart_by_match() -> None:
    match ast.Name(SPAN, "x"):
        case ast.Name(span, text):
            assert (span, text) == (SPAN, "x")
