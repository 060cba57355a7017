"""`stlc verify`, `stlc plot`, `stlc read-solution`: what is done with a plan."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stlc.cli.answer import answer
from stlc.cli.common import check_outputs, compiled_model, load, mission_options
from stlc.cli.completion import offer_encodings
from stlc.cli.planned import load_planned
from stlc.errors import ViolationError

if TYPE_CHECKING:
    from stlc.milp.writers.sidecar import Made


@click.command("verify")
@mission_options
@click.argument("plan", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def verify_command(
    file: Path, plan: Path, define: tuple[str, ...], allow_path: tuple[Path, ...], as_json: bool
) -> int:
    """Judge PLAN against the mission in FILE, independently of every encoder and solver.

    Exit 6 when it violates the mission; the report says what, where and by how much.
    """
    from stlc.verify import verify

    report = verify(*load_planned(file, plan, define, allow_path))
    answer(report.as_dict()) if as_json else click.echo(report.text())
    return 0 if report.ok else ViolationError.exit_status


@click.command("plot")
@mission_options
@click.argument("plan", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(path_type=Path),
    help="The picture: .png, .svg or .pdf; .gif for one that moves.",
)
def plot_command(
    file: Path, plan: Path, define: tuple[str, ...], allow_path: tuple[Path, ...], output: Path
) -> int:
    """Draw PLAN: paths, obstacles, goals, inputs, link quality over time, the channel map."""
    from stlc.plot import plot_plan

    plot_plan(*load_planned(file, plan, define, allow_path), output)
    return 0


@click.command("read-solution")
@mission_options
@click.argument("solution", type=click.Path(path_type=Path))
@click.option("--encoding", shell_complete=offer_encodings, help="As given to `compile`.")
@click.option("--disable", multiple=True, metavar="PASS", help="As given to `compile`.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="The plan (JSON).")
def read_solution_command(
    file: Path,
    solution: Path,
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    encoding: str | None,
    disable: tuple[str, ...],
    output: Path | None,
) -> int:
    """Turn another solver's SOLUTION of the compiled FILE into a certified, verified plan.

    Reads the formats of HiGHS, CBC, SCIP, GLPK, CPLEX and Gurobi. Options of `compile` are those of
    the model beside it (model.sol, model.mps.names.json) unless they are given.
    """
    from stlc.backends.base import Solution, Status
    from stlc.milp.encodings import compile_options
    from stlc.milp.readers import read_solution
    from stlc.milp.writers import safe_names
    from stlc.solve.judge import Judge

    made = _made(file, solution)
    told = tuple(f"{name}={value}" for name, value in made.params.items())
    mission = load(file, (*told, *define), allow_path)
    options = compile_options(encoding or made.encoding, disable or made.disable)
    compiled = compiled_model(mission, options)
    x = read_solution(solution, safe_names(compiled.model)[0])
    check_outputs(output)
    claim = Solution(Status.FEASIBLE, x, compiled.model.objective(x), solver=solution.name)
    plan, report = Judge(mission, compiled).accept(claim)
    if output is not None:
        plan.write(output)
    click.echo(report.text())
    return 0


def _made(file: Path, solution: Path) -> Made:
    """How the model beside `solution` was compiled from FILE as it is now; else the defaults."""
    from stlc.milp.writers.sidecar import Made, made_before
    from stlc.plan import text_digest
    from stlc.syntax.read import read_source

    digest = text_digest(read_source(file).text)
    return made_before(solution, digest) or Made(digest)
