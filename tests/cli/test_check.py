"""`stlc check` and `stlc fmt` as a person calls them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from stlc.api import loads
from stlc.cli import cli
from stlc.cli.check import check_command, fmt_command

MISSION = """agent r : double_integrator { start (0, 0); control |u| <= 1 }
require a: always r.x >= 3 dB
require b: eventually[8, 3] r.x >= 1 m
require c: eventually r.q >= 1 m
"""
CODES = ["E0303", "E0502", "E0206"]


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "m.stl"
    path.write_text(MISSION, encoding="utf-8")
    return path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(check_command, arguments, standalone_mode=False)


def test_three_mistakes_are_shown_in_one_run(mission: Path) -> None:
    result = call(str(mission))
    assert result.return_value == 1
    places = [result.output.index(f"error[{code}]") for code in CODES]
    assert places == sorted(places)


def test_machines_read_the_same_mistakes(mission: Path) -> None:
    found = json.loads(call(str(mission), "--format", "json").output)["diagnostics"]
    assert [d["code"] for d in found] == CODES
    (run,) = json.loads(call(str(mission), "--format", "sarif").output)["runs"]
    assert [r["ruleId"] for r in run["results"]] == CODES
    lines = call(str(mission), "--format", "github").output.strip().splitlines()
    assert [line.split(",")[1] for line in lines] == ["line=2", "line=3", "line=4"]


def test_explanations_leave_out_what_each_case_fills_in() -> None:
    text = call("--explain", "e0502").output
    assert text.startswith("E0502 (error)\n  the interval ends before it begins\n")
    assert "Remedy: swap the two ends" in text
    unknown = call("--explain", "E0201").output
    assert "{" not in unknown
    assert "Remedy" not in unknown
    for shown_elsewhere in ("E0801", "E0808", "E0809"):
        assert shown_elsewhere in call("--explain", shown_elsewhere).output
    assert "there is no diagnostic" in str(call("--explain", "E9999").exception)


def test_format_check_changes_nothing(mission: Path) -> None:
    mission.write_text("step   1 s\n", encoding="utf-8")
    runner = CliRunner()
    checked = runner.invoke(fmt_command, ["--check", str(mission)], standalone_mode=False)
    assert checked.return_value == 1
    assert mission.read_text(encoding="utf-8") == "step   1 s\n"
    runner.invoke(fmt_command, [str(mission)], standalone_mode=False)
    assert mission.read_text(encoding="utf-8") == "step 1 s\n"
    again = runner.invoke(fmt_command, ["--check", str(mission)], standalone_mode=False)
    assert again.return_value == 0


def test_a_mistyped_command_is_recognised() -> None:
    result = CliRunner().invoke(cli, ["chekc", "m.stl"])
    assert result.exit_code == 2
    assert "did you mean 'check'?" in result.output
    stranger = CliRunner().invoke(cli, ["xyzzy"])
    assert stranger.exit_code == 2
    assert "did you mean" not in stranger.output


def test_every_command_has_its_own_line_in_the_help_and_every_option_a_text() -> None:
    context = click.Context(cli)
    text = CliRunner().invoke(cli, ["--help"]).output
    for name in cli.list_commands(context):
        assert f"\n  {name} " in text
        command = cli.get_command(context, name)
        assert command is not None
        options = [p for p in command.params if isinstance(p, click.Option)]
        assert all(option.help for option in options), name


def test_one_step_is_no_steps() -> None:
    agent = "agent r : double_integrator { start (0, 0); control |u| <= 1 }\n"
    summaries = [loads(f"horizon {n}\n{agent}require a: always r.x <= 9").summary() for n in (1, 2)]
    assert summaries == [f"1 agent, 1 requirement, {n} of 1 s" for n in ("1 step", "2 steps")]


def test_the_package_runs_as_a_module() -> None:
    """`python -m stlc`, for those whose path doesn't have the script."""
    done = subprocess.run(
        [sys.executable, "-m", "stlc", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("stlc")
