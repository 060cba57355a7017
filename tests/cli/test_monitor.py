"""`stlc import` and `stlc monitor` as a person calls them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import click
import pytest

from stlc.cli import cli
from stlc.cli.common import run_guarded

SPEC = """step 0.5 s
signal speed, gear
param top = 80
require calm: always[0 s, 2 s] (speed < top)
require shift: always (gear >= 3 implies eventually[0 s, 1 s] speed > 30)
"""


Row = tuple[object, ...]


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "spec.stl"
    path.write_text(SPEC)
    return path


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    return write_trace(
        tmp_path / "trace.csv", [(0.5 * k, 40 + 5 * k, 2 + k // 4) for k in range(12)]
    )


def write_trace(
    path: Path, rows: list[tuple[object, ...]], header: str = "time,speed,gear"
) -> Path:
    path.write_text("\n".join([header, *(",".join(map(str, r)) for r in rows)]) + "\n")
    return path


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    """Exit status of `stlc` with these arguments."""
    assert isinstance(cli, click.Command)
    monkeypatch.setattr("sys.argv", ["stlc", *map(str, arguments)])
    return run_guarded(cli)


Capture = pytest.CaptureFixture[str]
Patch = pytest.MonkeyPatch


def test_requirements_that_hold(
    spec: Path, trace: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    assert run(monkeypatch, "monitor", spec, trace) == 0
    out = capsys.readouterr().out
    assert "ok  calm   robustness 20; holds at 5 of 8 samples, not at 2.5 s" in out
    assert "ok  shift  robustness 20; holds at 10 of 10 samples" in out


def test_a_violated_requirement(
    spec: Path, trace: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    assert run(monkeypatch, "monitor", spec, trace, "-D", "top=55") == 6
    assert "NO  calm   robustness -5" in capsys.readouterr().out
    assert run(monkeypatch, "monitor", spec, trace, "--at", "3.5") == 6


def test_by_subformula(spec: Path, trace: Path, monkeypatch: Patch, capsys: Capture) -> None:
    assert run(monkeypatch, "monitor", spec, trace, "--by-subformula") == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["40", "4:33", "speed", "<", "top"] in lines
    assert ["20", "5:42", "eventually[0", "s,", "1", "s]", "speed", ">", "30"] in lines


def test_json(spec: Path, trace: Path, monkeypatch: Patch, capsys: Capture) -> None:
    assert run(monkeypatch, "monitor", spec, trace, "--json", "--at", 1) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["at"], found["satisfied"], found["samples"]) == (1.0, True, 12)
    calm = found["formulas"][0]
    assert calm["robustness"] == [20, 15, 10, 5, 0, -5, -10, -15]
    assert calm["satisfied"] == [True] * 5 + [False] * 3
    assert "parts" not in calm
    run(monkeypatch, "monitor", spec, trace, "--json", "--by-subformula")
    assert json.loads(capsys.readouterr().out)["formulas"][0]["parts"][0]["text"] == "speed < top"


def test_csv(spec: Path, trace: Path, tmp_path: Path, monkeypatch: Patch) -> None:
    output = tmp_path / "out.csv"
    assert run(monkeypatch, "monitor", spec, trace, "-o", output) == 0
    rows = list(csv.reader(output.read_text().splitlines()))
    assert rows[0] == ["time", "calm", "calm satisfied", "shift", "shift satisfied"]
    assert rows[6] == ["2.5", "-5.0", "0", "45.0", "1"]
    assert rows[12] == ["5.5", "", "", "", ""]


BAD = [
    ([(0, 1), (0.5, 2)], "time,speed", "has no column 'gear'"),
    ([(0, 1, 1), (0.5, "nan", 1)], "time,speed,gear", "trace.csv:3: speed is not finite"),
    ([(0, 1, 1), (0.5, "x", 1)], "time,speed,gear", "trace.csv:3: speed is no number"),
    ([(0, 1, 1), (0.5, 1, 1), (1.2, 1, 1)], "time,speed,gear", "trace.csv:4: 0.7 s after"),
    ([(0, 1, 1), (1, 1, 1)], "time,speed,gear", "the specification's step is 0.5 s"),
    ([(0, 1, 1), (0.5, 1)], "time,speed,gear", "trace.csv:3: expected 3 fields, found 2"),
    ([(0, 1, 1)], "when,speed,gear", "with a column `time`"),
    ([], "time,speed,gear", "needs a header and at least one sample"),
]


@pytest.mark.parametrize(("rows", "header", "reason"), BAD)
def test_bad_recordings(
    rows: list[Row],
    header: str,
    reason: str,
    spec: Path,
    tmp_path: Path,
    monkeypatch: Patch,
    capsys: Capture,
) -> None:
    trace = write_trace(tmp_path / "trace.csv", rows, header)
    assert run(monkeypatch, "monitor", spec, trace) == 1
    assert reason in capsys.readouterr().err


def test_a_recording_that_is_too_short(
    spec: Path, tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    trace = write_trace(tmp_path / "trace.csv", [(0, 1, 1), (0.5, 1, 1), (1, 1, 1)])
    assert run(monkeypatch, "monitor", spec, trace) == 1
    out = capsys.readouterr().out
    assert "--  calm   can't be judged: the recording is too short" in out
    assert "ok  shift" in out


def test_wrong_calls(spec: Path, trace: Path, tmp_path: Path, monkeypatch: Patch) -> None:
    assert run(monkeypatch, "monitor", spec, tmp_path / "nowhere.csv") == 2
    assert run(monkeypatch, "monitor", spec, tmp_path) == 2
    assert run(monkeypatch, "monitor", tmp_path / "nowhere.stl", trace) == 2
    assert run(monkeypatch, "monitor", spec, trace, "--at", "0.7") == 2
    assert run(monkeypatch, "monitor", spec, trace, "--at", "nan") == 2


def test_nothing_to_judge(tmp_path: Path, trace: Path, monkeypatch: Patch) -> None:
    empty = tmp_path / "empty.stl"
    empty.write_text("signal speed\n")
    assert run(monkeypatch, "monitor", empty, trace) == 1


def test_import_to_monitor(
    tmp_path: Path, trace: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    source, result = tmp_path / "spec.breach", tmp_path / "out.stl"
    source.write_text("low := speed[t] < 55\nphi := alw_[0, 1] low\n")
    call = ["import", "--dialect", "breach", source, "--step", "500ms"]
    assert run(monkeypatch, *call) == 0
    text = capsys.readouterr().out
    assert run(monkeypatch, *call, "-o", result) == 0
    assert result.read_text() == text
    assert "step 0.5 s" in text
    assert run(monkeypatch, "check", result) == 0
    assert run(monkeypatch, "monitor", result, trace) == 0
    assert run(monkeypatch, "monitor", result, trace, "--at", 1) == 6


def test_import_from_standard_input(monkeypatch: Patch, capsys: Capture) -> None:
    class Input:
        class buffer:
            @staticmethod
            def read(most: int) -> bytes:
                return b"always[0,5] (x >= 3)"

    monkeypatch.setattr("sys.stdin", Input)
    assert run(monkeypatch, "import", "--dialect", "rtamt", "-") == 0
    assert "require: always[0 s, 5 s] (x >= 3)" in capsys.readouterr().out


def test_import_refuses_with_place_and_reason(
    tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    source = tmp_path / "past.stl"
    source.write_text("a >= 2;\nout = historically[0,5] (x >= 3);\n")
    assert run(monkeypatch, "import", "--dialect", "rtamt", source) == 1
    found = capsys.readouterr()
    assert found.out == ""
    assert "E0902" in found.err
    assert "past.stl:2:7" in found.err


@pytest.mark.parametrize("step", ["0", "-1", "1/0", "fast", "1 hour", "1e99"])
def test_steps_that_are_none(step: str, tmp_path: Path, monkeypatch: Patch) -> None:
    source = tmp_path / "spec.stl"
    source.write_text("x >= 3")
    assert run(monkeypatch, "import", "--dialect", "rtamt", source, f"--step={step}") == 2


def test_bytes_that_are_no_text(tmp_path: Path, monkeypatch: Patch) -> None:
    source = tmp_path / "spec.stl"
    source.write_bytes(b"always \xff\xfe x")
    assert run(monkeypatch, "import", "--dialect", "rtamt", source) == 1


def test_nothing_has_a_sign_at_zero(tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    spec = tmp_path / "low.stl"
    spec.write_text("step 0.5 s\nsignal speed\nrequire low: not (speed >= 3)\n")
    trace = write_trace(tmp_path / "low.csv", [(0, 3), (0.5, 1)], "time,speed")
    assert run(monkeypatch, "monitor", spec, trace, "--by-subformula") == 0
    assert "robustness 0;" in capsys.readouterr().out
