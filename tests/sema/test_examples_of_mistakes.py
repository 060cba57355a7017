"""The examples of `stlc check --explain`: the wrong one gives its code, the right one no error."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from stlc.api import loads
from stlc.cli.check import check_command
from stlc.diagnostic_examples import EXAMPLES
from stlc.diagnostics import Diagnostic, catalogue
from stlc.errors import MissionError
from stlc.milp.compile import compile_mission
from stlc.mission import Mission
from stlc.sema import load_all_diagnostics

DECLARED = """step 1 s
workspace box [0, 10] x [0, 10]
agent r1 : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
agent r2 : double_integrator { start (9, 1); control |u| <= 1; speed <= 2 }
station base at (5, 0)
region dock = box [7, 8] x [3, 5]
region yard = box [1, 2] x [7, 8]
obstacle pillar = box [4, 6] x [4, 6] inflate 0.3 m
channel radio { path_loss L0 = -12 dBm, n = 3; partition 10 x 10 }
"""
USED = """require used: eventually[0, 5] (r1 in dock and r1 in yard and r1 outside pillar
  and rssi(r2, base, radio) >= -50 dBm)
"""
COMPILED = ("E0806", "E0807")  # told before a model is built
# need files, options, a search, another tool's language, or thousands of lines
UNSHOWN = {
    *(
        "E0106",
        "E0112",
        "E0113",
        "E0114",
        "E0212",
        "E0213",
        "E0215",
        "E0216",
        "E0220",
        "E0222",
        "E0224",
    ),
    *(
        "E0411",
        "E0513",
        "E0607",
        "E0608",
        "E0801",
        "E0802",
        "E0803",
        "E0804",
        "E0805",
        "E0809",
        "E0808",
        "W1007",
        "W1009",
        "W1101",
    ),
    *("E0901", "E0902", "E0903", "E0904", "E0905", "E0906", "W0901", "W0902", "W0903"),
}


def codes(example: str, context: str, folder: Path, compiled: bool = False) -> set[str]:
    """What the checker, or the compiler, says of the example after its context; its own `step`
    etc. stand."""
    own = {line.split()[0] for line in example.splitlines()} & {"step", "workspace"}
    lines = [line for line in context.splitlines() if line.split()[0] not in own]
    try:
        text = "\n".join([*lines, example]) + "\n"
        mission = loads(text, folder=folder)
        return {d.code for d in (*mission.warnings, *(_compiled(mission) if compiled else ()))}
    except MissionError as error:
        return {d.code for d in error.diagnostics}


def _compiled(mission: Mission) -> tuple[Diagnostic, ...]:
    return compile_mission(mission).warnings


@pytest.mark.parametrize("code", EXAMPLES)
def test_the_wrong_one_has_the_mistake_and_the_right_one_has_none(
    code: str, tmp_path: Path
) -> None:
    (tmp_path / "lib.stl").write_text("let visit(a) = a in dock\n", encoding="utf-8")
    context = DECLARED if code in ("E0505", *COMPILED) else DECLARED + USED
    wrong, right = EXAMPLES[code]
    assert code in codes(wrong, context, tmp_path, code in COMPILED)
    left = codes(right, context, tmp_path, code in COMPILED)
    assert code not in left
    assert not [c for c in left if c.startswith("E")]


def test_every_mistake_that_one_statement_can_show_has_an_example() -> None:
    load_all_diagnostics()
    known = {code for code, kind in catalogue().items() if kind.__module__.startswith("stlc.")}
    assert EXAMPLES.keys() == known - UNSHOWN


def test_explain_shows_the_example() -> None:
    text = CliRunner().invoke(check_command, ["--explain", "E0502"]).output
    assert "Wrong:\n  require a: eventually[5, 0] r1 in dock\n" in text
    assert "Right:\n  require a: eventually[0, 5] r1 in dock\n" in text
