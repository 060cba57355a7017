"""Every diagnostic of meaning is explained, and shown by a golden file or by a test here."""

from __future__ import annotations

from pathlib import Path

import pytest

from stlc.api import loads
from stlc.diagnostics import Diagnostic, catalogue
from stlc.errors import MissionError
from stlc.sema import load_all_diagnostics

GOLDEN = Path(__file__).parents[1] / "golden"
BY_CALL = {"E0220", "E0222", "W1009"}  # need overrides, or a fit: test_parameters, test_channels

load_all_diagnostics()
OURS = {c: k for c, k in catalogue().items() if k.__module__.startswith("stlc.sema")}


def test_every_diagnostic_is_shown() -> None:
    shown = {path.stem.split("_")[0] for path in GOLDEN.glob("*.stl")}
    assert OURS.keys() - BY_CALL <= shown


@pytest.mark.parametrize("kind", OURS.values(), ids=OURS.keys())
def test_every_diagnostic_is_explained(kind: type[Diagnostic]) -> None:
    assert kind.__doc__ is not None
    assert not kind.__doc__.startswith(kind.__name__ + "(")
    assert kind.help
    assert kind.code[0] == ("E" if kind.severity.value == "error" else "W")


def test_all_mistakes_are_reported_together() -> None:
    text = """
workspace box [0, 10] x [0, 10]
agent r1 : double_integrator { start (1, 1); sped <= 2 }
region far = box [3, 1] x [0, 1]
require: always[0, 3] (r1 in gaol and rssi(r1, r1) >= 3 dBm)
require: always[0, 3] r1 in far
"""
    with pytest.raises(MissionError) as caught:
        loads(text)
    codes = [d.code for d in caught.value.diagnostics]
    assert codes == ["E0207", "E0402", "E0201", "E0606"]


def test_syntax_and_meaning_are_reported_together_without_echoes() -> None:
    text = """
agent r1 : double_integrator { start (1, 1) }
region goal = box [3, 4] x [0 1]
require: always[0, 3] r1 in goal
require: always[0, 3] r1.q >= 1
"""
    with pytest.raises(MissionError) as caught:
        loads(text)
    codes = [d.code for d in caught.value.diagnostics]
    assert codes[0].startswith("E01")
    assert codes[1:] == ["E0206"]
