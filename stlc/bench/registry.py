"""Finds a registry: a folder with `registry.py` (which says `SUITES`) and `missions/`."""

from __future__ import annotations

import runpy
from pathlib import Path

from stlc.bench.problem import Problem, Suite
from stlc.errors import UsageError, hinted

_FILE = "registry.py"


def default_folder() -> Path:
    """`benchmarks` of the checkout this package runs from, else of the current folder."""
    checkout = Path(__file__).resolve().parents[2] / "benchmarks"
    return checkout if (checkout / _FILE).is_file() else Path("benchmarks")


def load_suites(folder: Path) -> dict[str, Suite]:
    """Suites by name. The file is Python and is run: name only registries that you trust.

    UsageError when there is none, or when it says something else.
    """
    path = folder / _FILE
    if not path.is_file():
        raise UsageError(
            f"there is no registry of benchmarks at {path}; it comes with the source checkout of "
            "stlc (folder `benchmarks`): run there, or name the folder with --registry DIR"
        )
    suites = runpy.run_path(str(path)).get("SUITES")
    if not isinstance(suites, tuple) or not all(isinstance(s, Suite) for s in suites):
        raise UsageError(f"{path} must define SUITES, a tuple of stlc.bench.problem.Suite")
    return {suite.name: suite for suite in suites}


def chosen_suites(suites: dict[str, Suite], names: tuple[str, ...]) -> tuple[Suite, ...]:
    """The suites of these names, all if none; UsageError for an unknown one."""
    for name in names:
        if name not in suites:
            raise UsageError(f"there is no suite '{name}'; {hinted(name, suites)}")
    return tuple(suites[name] for name in dict.fromkeys(names or suites))


def read_files(folder: Path, problem: Problem) -> dict[str, bytes]:
    """The mission of a problem and the data it reads, by file name. UsageError if one is missing.

    Names are relative to `missions/`; data lies beside its mission.
    """
    files = {}
    for name in (problem.file, *problem.data):
        path = folder / "missions" / name
        try:
            files[path.name] = path.read_bytes()
        except OSError as error:
            raise UsageError(f"cannot read {path}: {error.strerror}") from error
    return files
