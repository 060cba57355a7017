"""A wheel of stlc has every module and data file, and works where there is no checkout."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import stlc

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ("stlc", "grammar", "backends")
LEFT_OUT = ("README.md", "vscode/")  # of the packages: what only a checkout needs
MISSION = """\
step 1 s
horizon 3
workspace box [0, 10] x [0, 10]
agent r : single_integrator { start (1, 1); control |u| <= 2 }
region goal = box [4, 5] x [1, 2]
require reach: eventually r in goal
minimize effort
"""


def _run(*words: str | Path, cwd: Path, env: dict[str, str] | None = None) -> str:
    done = subprocess.run(words, cwd=cwd, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from a copy: setuptools leaves `build/` behind and takes what it finds there."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    for name in SOURCES:
        shutil.copytree(
            ROOT / name, source / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__")
        )
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    options = ("--quiet", "--no-deps", "--no-index", "--no-build-isolation", "-w", folder)
    _run(sys.executable, "-m", "pip", "wheel", *options, ".", cwd=source)
    (made,) = folder.glob("*.whl")
    return made


@pytest.fixture(scope="module")
def site(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel unpacked: first on the path, it goes before the checkout that is installed."""
    folder = tmp_path_factory.mktemp("site")
    options = ("--quiet", "--no-deps", "--no-index", "--target", folder)
    _run(sys.executable, "-m", "pip", "install", *options, wheel, cwd=folder)
    return folder


def _expected() -> set[str]:
    """Every tracked file of the packages, under the name it is imported by."""
    listed = _run("git", "ls-files", "-s", *SOURCES, cwd=ROOT).splitlines()
    files = [line.split("\t")[1] for line in listed if not line.startswith("120000")]  # no links
    wanted = [f for f in files if not f.partition("/")[2].startswith(LEFT_OUT)]
    return {f if f.startswith("stlc/") else f"stlc/{f}" for f in wanted}


def test_every_module_and_data_file_is_in_it(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert packed == _expected()


def test_its_version_is_the_one_of_the_package(wheel: Path, site: Path, tmp_path: Path) -> None:
    assert wheel.name.split("-")[:2] == ["stlc", stlc.__version__]
    assert _stlc(site, "--version", folder=tmp_path) == f"stlc, version {stlc.__version__}\n"


def test_the_command_plans_and_verifies_far_from_the_checkout(site: Path, tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    where = _run(sys.executable, "-c", "import stlc; print(stlc.__file__)", cwd=tmp_path,
                 env=_environment(site))  # fmt: skip
    assert Path(where.strip()).is_relative_to(site)
    said = json.loads(_stlc(site, "solve", "m.stl", "--json", "-o", "p.json", folder=tmp_path))
    assert said["status"] == "optimal"
    _stlc(site, "verify", "m.stl", "p.json", folder=tmp_path)
    _stlc(site, "plot", "m.stl", "p.json", "-o", "p.png", folder=tmp_path)
    assert (tmp_path / "p.png").stat().st_size > 0


def _environment(site: Path) -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(site), "PYTHONSAFEPATH": "1"}


def _stlc(site: Path, *words: str, folder: Path) -> str:
    command = site / "bin" / "stlc"
    return _run(sys.executable, command, *words, cwd=folder, env=_environment(site))
