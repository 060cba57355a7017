"""What people see: each `NAME.stl` beside this file gives exactly the text of `NAME.err`.

A new diagnostic joins by a file that starts with its code. `UPDATE_GOLDEN=1` writes the texts.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from stlc.api import loads
from stlc.diagnostics import Diagnostic, catalogue
from stlc.errors import MissionError
from stlc.milp.compile import compile_mission
from stlc.render import render
from stlc.source import Source
from stlc.syntax import errors
from stlc.syntax.parse import parse
from stlc.syntax.read import decode

FOLDER = Path(__file__).parent
CASES = sorted(FOLDER.glob("*.stl"))
COMPILED = {"E0806", "E0807", "E0809"}
ELSEWHERE = {"E0113", "E0114"}  # too large for a file here: tests/syntax/test_limits.py


def diagnose(path: Path) -> tuple[Diagnostic, ...]:
    """Every diagnostic of a file; those named E01 and W01 stop at the syntax, some are
    told before a model is built."""
    try:
        source: Source = decode(path.name, path.read_bytes())
        result = parse(source)
        if not result.ok or path.name[1:3] == "01":
            return result.diagnostics
        mission = loads(source.text, name=path.name, folder=FOLDER)
        compiled = compile_mission(mission).warnings if path.stem[:5] in COMPILED else ()
        return (*mission.warnings, *compiled)
    except MissionError as error:
        return error.diagnostics


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_the_message_is_as_it_was(path: Path) -> None:
    found = diagnose(path)
    text = render(found) + "\n"
    expected = path.with_suffix(".err")
    if os.environ.get("UPDATE_GOLDEN"):
        expected.write_text(text, encoding="utf-8")
    assert text == expected.read_text(encoding="utf-8")
    assert path.stem.split("_")[0] in {d.code for d in found}


def test_every_diagnostic_of_the_syntax_has_a_file() -> None:
    codes = {code for code, kind in catalogue().items() if kind.__module__ == errors.__name__}
    assert codes - ELSEWHERE <= {path.stem.split("_")[0] for path in CASES}


def test_every_expected_text_has_its_file() -> None:
    assert {path.stem for path in FOLDER.glob("*.err")} == {path.stem for path in CASES}
