"""Completion, standard input, several files, progress as text, 'did you mean'."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support.command import MISSION, command, inside, stlc

from stlc.cli import _COMMANDS, cli
from stlc.cli.progress import EVERY, listener
from stlc.cli.shells import completer
from stlc.solve.events import ProgressEvent, SolutionEvent, StatusEvent

WRONG = "agent r : double_integrator { start (0, 0) }\nrequire a: always r.x >= 3 dB\n"


def offered(line: str, folder: Path) -> list[str]:
    """What bash is offered at the end of a line."""
    done = stlc(folder=folder, env={"COMP_WORDS": line, "_STLC_COMPLETE": "bash_complete"})
    assert (done.returncode, done.stderr) == (0, "")
    return [line.split(",", 1)[1] for line in done.stdout.splitlines()]


def test_commands_options_and_names_are_completed(tmp_path):
    assert offered("stlc so", tmp_path) == ["solve"]
    assert "--time-limit" in offered("stlc solve --t", tmp_path)
    assert offered("stlc solve m.stl --backend hi", tmp_path) == ["highs"]
    assert "milp" in offered("stlc solve m.stl --strategy m", tmp_path)
    assert offered("stlc completion z", tmp_path) == ["zsh"]
    assert offered("stlc solve m.stl --progress nd", tmp_path) == ["ndjson"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
@pytest.mark.parametrize(
    ("line", "whole", "in_bash"),
    [
        ("stlc solve m.stl --encoding stl=un", "stl=unary", "unary"),
        ("stlc solve m.stl --encoding=stl=un", "stl=unary", "unary"),
        ("stlc solve m.stl --backend=hi", "highs", "highs"),
        ("stlc race m.stl --with highs:auto,gur", "highs:auto,gurobi", "auto,gurobi"),
        ("stlc race m.stl --with highs:big", "highs:bigm", "bigm"),
    ],
)
def test_bash_ends_words_where_others_do_not(shell, line, whole, in_bash, monkeypatch):
    words = line.split(" ")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1) if shell == "zsh" else words[-1])
    answer = completer(cli, shell).complete().replace("\n", ",").split(",", 1)[1]
    assert answer.removesuffix(",_") == (in_bash if shell == "bash" else whole)


def test_every_command_is_offered(tmp_path):
    assert set(_COMMANDS) <= set(offered("stlc ", tmp_path))


def test_a_shell_takes_the_script(tmp_path):
    bash = shutil.which("bash")
    assert bash is not None
    (tmp_path / "mission.stl").write_text(MISSION)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "stlc").write_text(
        f"#!{bash}\nexec {sys.executable} -c 'from stlc.cli import main; main()' \"$@\"\n"
    )
    (tmp_path / "bin" / "stlc").chmod(0o755)
    script = inside("completion", "bash", folder=tmp_path).stdout
    ask = (
        "\nCOMP_LINE='stlc solve m' COMP_POINT=12; _stlc_completion stlc m solve\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
        "compopt() { :; }; COMP_LINE='stlc expl' COMP_POINT=9; _stlc_completion stlc expl stlc\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
    )
    env = {**os.environ, "PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run([bash, "-c", script + ask], cwd=tmp_path, env=env, capture_output=True,
                          text=True, check=False, timeout=60)  # fmt: skip
    assert "explain" in done.stdout.split()


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_has_a_script(shell, tmp_path):
    done = inside("completion", shell, folder=tmp_path)
    assert done.returncode == 0
    assert re.search(rf"_STLC_COMPLETE[= ]{shell}_complete", done.stdout)
    assert inside("completion", "cmd", folder=tmp_path).returncode == 2


def piped(text: str, *words: object, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command(*words), cwd=folder, input=text, capture_output=True, text=True,
                          timeout=120, check=False)  # fmt: skip


def test_a_mission_comes_by_standard_input(tmp_path):
    done = piped(MISSION, "check", "-", folder=tmp_path)
    assert (done.returncode, done.stdout) == (0, "-: 1 agent, 2 requirements, 4 steps of 1 s\n")
    wrong = piped(WRONG, "check", "-", folder=tmp_path)
    assert wrong.returncode == 1
    assert "<stdin>:2:" in wrong.stderr
    solved = piped(MISSION, "solve", "-", "-o", "p.json", "--progress", "none", folder=tmp_path)
    assert solved.returncode == 0
    told = piped(MISSION, "verify", "-", "p.json", folder=tmp_path)
    assert told.returncode == 0
    assert "satisfies" in told.stdout


def test_standard_input_is_read_once_and_asked_for_often(tmp_path, monkeypatch):
    text = "param v = 1 m\n" + MISSION
    (tmp_path / "m.stl").write_text(text)
    words = ("solve", "m.stl", "-D", "v=2", "-o", "p.json", "--progress", "none")
    assert inside(*words, folder=tmp_path).returncode == 0
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    # the parameters of the plan are those of the text it was made of, which is read for them first
    assert inside("verify", "-", "p.json", folder=tmp_path).returncode == 0


def test_a_plan_comes_by_standard_input(tmp_path):
    (tmp_path / "m.stl").write_text(MISSION)
    inside("solve", "m.stl", "-o", "p.json", "--progress", "none", folder=tmp_path)
    plan = (tmp_path / "p.json").read_text()
    assert piped(plan, "verify", "m.stl", "-", folder=tmp_path).returncode == 0


def test_fmt_of_standard_input_goes_to_standard_output(tmp_path):
    done = piped("require   a : x>=1", "fmt", "-", folder=tmp_path)
    assert (done.returncode, done.stdout) == (0, "require a: x >= 1\n")


def test_check_takes_several_files(tmp_path):
    (tmp_path / "a.stl").write_text(MISSION)
    (tmp_path / "b.stl").write_text(WRONG)
    done = inside("check", "a.stl", "b.stl", "a.stl", folder=tmp_path)
    assert done.returncode == 1
    assert done.stdout.count("a.stl: 1 agent") == 2
    assert "b.stl:2:" in done.stderr
    missing = inside("check", "none.stl", "b.stl", "a.stl", folder=tmp_path)
    assert missing.returncode == 2
    assert "none.stl" in missing.stderr
    assert "b.stl:2:" in missing.stderr
    machine = inside("check", "--format", "json", "b.stl", "b.stl", "a.stl", folder=tmp_path)
    found = json.loads(machine.stdout)["diagnostics"]
    assert [d["code"] for d in found].count("E0303") == 2


def test_progress_without_a_terminal_is_text_unless_asked_for(tmp_path):
    (tmp_path / "m.stl").write_text(MISSION)
    done = stlc("solve", "m.stl", folder=tmp_path)
    assert done.returncode == 0
    assert done.stderr.startswith("compile: m.stl\n")
    assert "{" not in done.stderr
    assert "\x1b" not in done.stderr
    asked = stlc("solve", "m.stl", "--progress", "ndjson", folder=tmp_path)
    assert all(json.loads(line) for line in asked.stderr.splitlines())


def test_a_log_has_one_line_of_progress_in_a_while(capsys):
    tell = listener("text")
    for second in range(31):
        tell(ProgressEvent(float(second), 3.0, 2.0, 0.5, None))
    tell(SolutionEvent(31.0, 2.5, "p.json"))
    tell(StatusEvent("done", "optimal"))
    lines = capsys.readouterr().err.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == ["10.0", "20.0", "30.0", "31.0"]
    assert lines[-1] == "done: optimal"
    assert EVERY == 10.0


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("slove", "m.stl"), "did you mean 'solve'?"),
        (("solve", "m.stl", "--timelimit", "3"), "Did you mean '--time-limit'?"),
        (("solve", "m.stl", "--backend", "hihgs"), "did you mean 'highs'?"),
        (("solve", "m.stl", "--encoding", "hul"), "did you mean 'hull'?"),
        (("solve", "m.stl", "--encoding", "stl=unari"), "did you mean 'unary'?"),
        (("solve", "m.stl", "--strategy", "mlip"), "did you mean 'milp'?"),
        (("solve", "m.stl", "--disable", "decid"), "did you mean 'decide'?"),
    ],
)
def test_names_near_others_are_meant(words, meant, tmp_path):
    (tmp_path / "m.stl").write_text(MISSION)
    done = inside(*words, folder=tmp_path)
    assert done.returncode == 2
    assert meant in done.stderr
