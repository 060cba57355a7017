"""The examples of docs/import.md are what the importers and the monitor give."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from stlc.api import loads
from stlc.dialects import DIALECTS, import_text
from stlc.monitor import monitor_formulas
from stlc.recording import Recording
from stlc.source import Source

TEXT = (Path(__file__).parents[2] / "docs" / "import.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", TEXT, flags=re.DOTALL)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_imported_examples(dialect: str) -> None:
    (at,) = [k for k, (kind, _) in enumerate(BLOCKS) if kind == dialect]
    kind, expected = BLOCKS[at + 1]
    imported = import_text(Source("example", BLOCKS[at][1]), dialect).text
    assert kind == "stl"
    assert imported.split("\n", 1)[1] == expected


def test_missions_of_the_page_check() -> None:
    missions = [text for kind, text in BLOCKS if kind == "stl"]
    assert len(missions) == 4
    for text in missions:
        assert loads(text).requirements


def test_monitor_example() -> None:
    mission = loads([text for kind, text in BLOCKS if kind == "stl"][-1])
    steps = np.arange(12)
    columns = {"speed": 40.0 + 5 * steps, "gear": 2.0 + steps // 4}
    report = monitor_formulas(
        mission.requirements, Recording("drive.csv", 0.5 * steps, columns), mission
    )
    assert [f.robustness[0] for f in report.formulas] == [20, 20]
    assert "robustness 20; holds at 5 of 8 samples" in TEXT


def test_python_example() -> None:
    (code,) = [text for kind, text in BLOCKS if kind == "python"]
    exec(compile(code, "docs/import.md", "exec"), {})
