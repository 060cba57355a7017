"""`stlc compile`: LP and MPS files for any solver, statistics, the IR after a pass."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stlc.cli.answer import answer
from stlc.cli.common import check_outputs, compiled_model, load, mission_options
from stlc.cli.completion import encoding_option

if TYPE_CHECKING:
    from stlc.milp.model import Model
    from stlc.mission import Mission


@click.command("compile")
@mission_options
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="The model, by its ending: .lp, .mps, .lp.gz or .mps.gz.",
)
@encoding_option
@click.option(
    "--max-size", type=click.IntRange(1), metavar="PARTS", help="Build models up to this size."
)
@click.option("--disable", multiple=True, metavar="PASS", help="Leave a pass out (ablation).")
@click.option(
    "--print-after",
    multiple=True,
    metavar="PASS",
    help="Print the IR after this pass ('all': each).",
)
@click.option("--stats", is_flag=True, help="Sizes by requirement and by pass, and the LP bound.")
@click.option("--json", "as_json", is_flag=True, help="Print the statistics as one JSON object.")
@click.option("-v", "--verbose", is_flag=True, help="Say why each encoding was chosen.")
def compile_command(
    file: Path,
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    output: Path | None,
    encoding: str,
    max_size: int | None,
    disable: tuple[str, ...],
    print_after: tuple[str, ...],
    stats: bool,
    as_json: bool,
    verbose: bool,
) -> int:
    """Compile FILE to one exact MILP, for an external solver or for a look at it.

    Beside OUT stands OUT.names.json, which maps every row and column to its place in FILE;
    `stlc read-solution FILE SOL` turns the solver's answer back into a plan.
    """
    from stlc.milp.encodings import compile_options
    from stlc.solve.statistics import Statistics

    mission = load(file, define, allow_path)
    check_outputs(output)
    compiled = compiled_model(
        mission, compile_options(encoding, disable, print_after, partial(_show, as_json), max_size)
    )
    if output is not None:
        _write(mission, compiled.model, output, encoding, disable)
        _report(compiled.model, output, quiet=as_json)
    if as_json:
        answer(Statistics.of(compiled).as_dict())
    elif stats:
        click.echo(Statistics.of(compiled).text())
    if verbose:
        for note in compiled.stats.notes:
            click.echo(note, err=True)
    return 0


def _write(
    mission: Mission, model: Model, output: Path, encoding: str, disable: tuple[str, ...]
) -> None:
    """The model's file, and beside it how it was made."""
    from stlc.milp.writers import write_model
    from stlc.milp.writers.sidecar import Made
    from stlc.plan import mission_digest

    made = Made(mission_digest(mission), dict(mission.params), encoding, disable)
    write_model(model, output, made=made)


def _show(quiet: bool, name: str, text: str) -> None:
    click.echo(f"; after {name}\n{text}", err=quiet)


def _report(model: Model, output: Path, quiet: bool) -> None:
    if quiet:
        return
    click.echo(
        f"{output}: {model.columns} columns ({model.binaries} binary), {model.rows} rows, "
        f"{model.nonzeros} nonzeros"
    )
