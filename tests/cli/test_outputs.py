"""An output never takes the place of an input, whatever path or link names it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from support.command import MISSION
from support.command import inside as stlc

IMPORTING = 'import "lib.stl"\n' + MISSION
SPEC = "signal v\nrequire low: always[0, 1] v <= 5\n"
TRACE = "time,v\n0,1\n1,2\n2,3\n"
BREACH = "phi := alw (x[t] < 3)\n"
WRITERS = {
    "solve": ("solve", "m.stl", "--progress", "none", "-o"),
    "csv": ("solve", "m.stl", "--progress", "none", "--csv"),
    "race": ("race", "m.stl", "--with", "highs:auto", "--progress", "none", "-o"),
    "read-solution": ("read-solution", "m.stl", "m.sol", "-o"),
    "monitor": ("monitor", "spec.stl", "trace.csv", "-o"),
    "import": ("import", "breach.stl", "--dialect", "breach", "-o"),
}
INPUTS = {
    "solve": "m.stl", "csv": "lib.stl", "race": "m.stl", "read-solution": "m.stl",
    "monitor": "trace.csv", "import": "breach.stl",
}  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    texts = {"m.stl": IMPORTING, "lib.stl": "param k = 1\n", "spec.stl": SPEC,
             "trace.csv": TRACE, "breach.stl": BREACH}  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "m.sol").write_text("# Objective value = 0\n")
    (tmp_path / "sub").mkdir()
    return tmp_path


@pytest.mark.parametrize("link", ["same", "path", "symbolic", "hard"])
@pytest.mark.parametrize("name", WRITERS)
def test_an_input_is_no_output(name: str, link: str, folder: Path) -> None:
    source, target = folder / INPUTS[name], folder / "sub" / "link.stl"
    match link:
        case "same":
            target = source
        case "path":
            target = folder / "sub" / ".." / source.name
        case "symbolic":
            target.symlink_to(source)
        case _:
            os.link(source, target)
    before = source.read_text()
    done = stlc(*WRITERS[name], target, folder=folder)
    assert done.returncode == 2, done.stderr
    assert "is an input" in done.stderr
    assert source.read_text() == before


def test_two_outputs_are_two_files(folder: Path) -> None:
    words = ("solve", "m.stl", "-o", "p.json", "--csv", "./p.json")
    done = stlc(*words, folder=folder)
    assert done.returncode == 2
    assert not (folder / "p.json").exists()


def test_fmt_may_rewrite_what_it_reads(folder: Path) -> None:
    (folder / "spec.stl").write_text("signal v\nrequire   low: always[0,1] v<=5\n")
    assert stlc("fmt", "spec.stl", folder=folder).returncode == 0
    assert (folder / "spec.stl").read_text() == SPEC


def test_a_folder_that_is_missing(folder: Path) -> None:
    for words in WRITERS.values():
        if words[0] != "read-solution":
            done = stlc(*words, "gone/out.json", folder=folder)
            assert done.returncode == 74, done.stderr
            assert "the folder gone does not exist" in done.stderr


def test_a_pipe_gets_one_plan(folder: Path) -> None:
    """Every better plan went into it: its reader left after the first, and the solve hung."""
    os.mkfifo(folder / "pipe")
    end = os.open(folder / "pipe", os.O_RDWR | os.O_NONBLOCK)
    words = ("solve", "m.stl", "--progress", "none", "-o", "pipe")
    assert stlc(*words, folder=folder).returncode == 0
    told = os.read(end, 1 << 16)
    os.close(end)
    assert json.loads(told)["solve"]["status"] == "optimal"


def test_links_in_a_circle_are_no_input(folder: Path) -> None:
    (folder / "x.stl").symlink_to("y.stl")
    (folder / "y.stl").symlink_to("x.stl")
    assert stlc("check", "x.stl", folder=folder).returncode == 2
    (folder / "m.stl").write_text('import "x.stl"\n' + MISSION)
    done = stlc("check", "m.stl", folder=folder)
    assert done.returncode == 1
    assert "m.stl:1:" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("solve", "m.stl", "--time-limit"), ("solve", "m.stl", "--gap"),
        ("race", "m.stl", "--memory"), ("explain", "m.stl", "--time-limit"),
        ("sweep", "m.stl", "--gap"), ("simulate", "m.stl", "p.json", "--confidence"),
    ],
)  # fmt: skip
def test_no_number_is_no_limit(words: tuple[str, ...], folder: Path) -> None:
    done = stlc(*words, "nan", folder=folder)
    assert done.returncode == 2
    assert "'nan' is not a number" in done.stderr
