"""Names, units and shapes: from syntax to a checked mission."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stlc.source import Source

if TYPE_CHECKING:
    from stlc.mission import Mission
    from stlc.syntax.parse import ParseResult


def load_mission(
    source: Source,
    params: Mapping[str, str | float] | None = None,
    folder: Path | None = None,
    allow_paths: Iterable[Path] = (),
) -> Mission:
    """Parse and check a mission.

    `params` override `param` statements: numbers, or texts with units such as "3 m/s". Files that
    the mission names are read from under `folder` and `allow_paths` only; without a folder none.
    Raises MissionError with all diagnostics of syntax and meaning together; warnings alone end up
    in `Mission.warnings`.
    """
    from stlc.syntax.parse import parse

    with collector_paused():
        return check_parsed(parse(source), params, folder, allow_paths)


def check_parsed(
    result: ParseResult,
    params: Mapping[str, str | float] | None = None,
    folder: Path | None = None,
    allow_paths: Iterable[Path] = (),
) -> Mission:
    """Check what was parsed, as `load_mission` does."""
    from stlc.loader import FolderLoader, MemoryLoader
    from stlc.sema.analyse import analyse
    from stlc.sema.report import Report

    loader = MemoryLoader() if folder is None else FolderLoader(folder, tuple(allow_paths))
    report = Report()
    with collector_paused():
        for diagnostic in result.diagnostics:
            report.add(diagnostic)
        return analyse(result.file, params=params, loader=loader, report=report)


@contextmanager
def collector_paused() -> Iterator[None]:
    """No garbage collection inside: trees only grow there, and scanning them takes long."""
    import gc

    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def load_all_diagnostics() -> None:
    """Import every module that defines diagnostics, for the catalogue."""
    from importlib import import_module

    for name in (
        "stlc.syntax.errors",
        "stlc.sema.name_errors",
        "stlc.sema.unit_errors",
        "stlc.sema.number_errors",
        "stlc.sema.shape_errors",
        "stlc.sema.space_errors",
        "stlc.sema.robot_errors",
        "stlc.sema.time_errors",
        "stlc.sema.channel_errors",
        "stlc.sema.objective_errors",
        "stlc.sema.warnings",
        "stlc.dialects.errors",
        "stlc.analysis.doubles",
        "stlc.analysis.sizes",
        "stlc.analysis.table_sizes",
        "stlc.milp.big_m",
        "stlc.milp.unsolvable",
    ):
        import_module(name)
