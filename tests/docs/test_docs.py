"""Every code block of README and docs: missions are checked, commands and Python are run."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.markdown import Block, blocks, borrowed, preludes

import stlc
from stlc.api import loads
from stlc.errors import MissionError

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
ENTRY = "import sys; from stlc.cli import main; sys.argv[0] = 'stlc'; main()"
LIMIT = 300  # s for one command, on a busy machine
ELSEWHERE = {"import.md"}  # its commands are run by tests/dialects/test_docs.py


NAMED = re.compile(r"`((?:stlc|grammar|backends|tests|examples|benchmarks)/[\w./]+)`")


def _missions() -> list[tuple[Path, Block]]:
    return [(p, b) for p in DOCUMENTS for b in blocks(p) if b.language == "stl"]


def _id(value: object) -> str:
    return value.name if isinstance(value, Path) else f"line{getattr(value, 'line', value)}"


def _fill(folder: Path, document: Path) -> None:
    """The files that the blocks of a document need; a whole mission is `mission.stl`."""
    found = blocks(document)
    for name in ("examples", "benchmarks"):
        (folder / name).symlink_to(ROOT / name)
    for name, path in borrowed(found).items():
        (folder / name).write_bytes((ROOT / path).read_bytes())
    whole = [b for b in found if b.info == ("stl",)]
    if whole:
        (folder / "mission.stl").write_text(whole[0].text, encoding="utf-8")
    for block in found:
        if block.file:
            (folder / block.file).write_text(block.text, encoding="utf-8")


@pytest.mark.parametrize("document", DOCUMENTS, ids=_id)
def test_files_named_are_there(document: Path) -> None:
    named = set(NAMED.findall(document.read_text(encoding="utf-8")))
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


def test_every_public_name_is_in_the_reference() -> None:
    text = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"^\.\. auto\w+:: stlc\.(\w+)$", text, re.M))
    assert set(stlc.__all__) - {"__version__"} <= shown


@pytest.mark.parametrize(("document", "block"), _missions(), ids=_id)
def test_missions(document: Path, block: Block, tmp_path: Path) -> None:
    _fill(tmp_path, document)
    name = block.word_after("in")
    text = block.text if name is None else preludes(blocks(document))[name] + "\n" + block.text
    error, warning = block.word_after("error"), block.word_after("warning")
    if error is not None:
        with pytest.raises(MissionError) as caught:
            loads(text, folder=tmp_path)
        assert [d.code for d in caught.value.diagnostics] == error.split(",")
        return
    mission = loads(text, folder=tmp_path)
    codes = {d.code for d in mission.warnings}
    if name is None:
        assert codes == set(warning.split(",") if warning else ())
    else:
        assert warning is None or warning in codes  # a prelude has names that nobody uses


def _run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A line of a shell, with `stlc` being this one."""
    line = re.sub(r"^stlc\b", f'{sys.executable} -c "{ENTRY}"', command)
    return subprocess.run(
        line, shell=True, cwd=folder, capture_output=True, text=True, timeout=LIMIT, check=False,
        env={**os.environ, "COLUMNS": "100"},
    )  # fmt: skip


def _check_command(command: str, folder: Path, place: str) -> str:
    """Run it; a comment `exit N` says which status is right."""
    status = re.search(r"#.*\bexit (\d+)", command)
    done = _run(command, folder)
    output = done.stdout + done.stderr
    assert done.returncode == (int(status[1]) if status else 0), f"{place}: {command}\n{output}"
    return output


def _steps(block: Block) -> list[tuple[str, list[str]]]:
    """Commands, each with the lines of output that it shows."""
    steps: list[tuple[str, list[str]]] = []
    for line in block.text.splitlines():
        if block.language == "console" and not line.startswith("$ "):
            steps[-1][1].append(line)
        elif line.strip():
            steps.append((line.removeprefix("$ "), []))
    return [(c, shown) for c, shown in steps if c.startswith("stlc ") and block.runs(c)]


def _compare(shown: list[str], output: str, place: str) -> None:
    """The lines shown come in this order; `...` stands for anything within a line."""
    at = 0
    for line in shown:
        if not line.strip() or line.strip() == "...":
            continue
        pattern = ".*".join(re.escape(part) for part in line.rstrip().split("..."))
        match = re.compile(pattern).search(output, at)
        assert match, f"{place}: `{line}` is not in\n{output[at:]}"
        at = match.end()


@pytest.mark.parametrize("document", [d for d in DOCUMENTS if d.name not in ELSEWHERE], ids=_id)
def test_commands_and_python(document: Path, tmp_path: Path) -> None:
    _fill(tmp_path, document)
    for block in blocks(document):
        place = f"{document.name}:{block.line}"
        if block.language in ("sh", "console"):
            for command, shown in _steps(block):
                _compare(shown, _check_command(command, tmp_path, place), place)
        elif block.language == "python" and block.runs(""):
            command = [sys.executable, "-c", block.text]
            done = subprocess.run(
                command, cwd=tmp_path, capture_output=True, text=True, timeout=LIMIT, check=False
            )
            assert done.returncode == 0, f"{place}\n{done.stderr}"
