"""`stlc report`."""

from __future__ import annotations

from pathlib import Path

import click

from stlc.cli.common import check_outputs, mission_options
from stlc.cli.planned import load_planned


@click.command("report")
@mission_options
@click.argument("plan", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", required=True, type=click.Path(path_type=Path), help="The page (.html)."
)
def report_command(
    file: Path, plan: Path, define: tuple[str, ...], allow_path: tuple[Path, ...], output: Path
) -> int:
    """Show PLAN in one HTML page: the map in motion, what decides each requirement, every signal.

    The page needs nothing else: no network, no other file. The mission's text stands beside the
    map, each requirement green or red.
    """
    from stlc.report import write_report

    check_outputs(output)
    write_report(*load_planned(file, plan, define, allow_path), output)
    return 0
