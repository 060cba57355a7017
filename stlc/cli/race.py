"""`stlc race`: several backends and encodings against each other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.answer import answer
from stlc.cli.common import (
    check_outputs,
    complain,
    load,
    mission_options,
    parse_solver_options,
    plain,
    solver_options,
)
from stlc.cli.interrupt import interruptible
from stlc.cli.progress import listener
from stlc.errors import SolverError

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled
    from stlc.mission import Mission
    from stlc.solve.racing.mission_race import Result
    from stlc.solve.racing.race import Racer


@click.command("race")
@mission_options
@click.option("--with", "entrants", default="highs:auto,scip:auto", show_default=True,
              metavar="BACKEND:ENCODING,...", help="Who races.")  # fmt: skip
@click.option("--cluster", metavar="ADDRESS", help="Run on a dask.distributed cluster.")
@click.option("--time-limit", type=click.FloatRange(min=0), metavar="S", help="For each racer.")
@click.option("--memory", type=click.FloatRange(min=0), metavar="GB", help="For each racer.")
@click.option("--gap", type=click.FloatRange(min=0), default=1e-4, show_default=True,
              help="Relative distance from the optimum that is good enough.")  # fmt: skip
@click.option("--threads", type=click.IntRange(min=1), default=1, show_default=True,
              help="Of each racer.")  # fmt: skip
@solver_options
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="The plan (JSON), kept up to date."
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--progress", "style", default="auto", show_default=True,
              type=click.Choice(["auto", "line", "ndjson", "none"]),
              help="`auto`: a line at a terminal, else one JSON object a line.")  # fmt: skip
def race_command(file: Path, define: tuple[str, ...], allow_path: tuple[Path, ...],
                 **words: Any) -> int:  # fmt: skip
    """Solve FILE with several solvers and encodings at once; the first certified proof wins."""
    from stlc.solve.racing.mission_race import MissionRace

    mission = load(file, define, allow_path)
    check_outputs(words["output"])
    compiled, racers = _enter(mission, words)
    tell = listener(words["style"])
    with interruptible() as stop:
        race = MissionRace(mission, compiled, racers, tell, words["output"], words["cluster"])
        result = race.run(stop)
    answer(_as_dict(result)) if words["as_json"] else click.echo(_summary(result))
    if result.refused is not None:
        complain(result.refused)
        return SolverError.exit_status
    return 0


def _enter(mission: Mission, words: dict[str, Any]) -> tuple[dict[str, Compiled], list[Racer]]:
    from stlc import backends
    from stlc.backends.base import SolveOptions
    from stlc.milp.encodings import compile_options
    from stlc.solve.blame import compile_or_blame
    from stlc.solve.racing.race import Racer

    options = SolveOptions(words["time_limit"], words["gap"], words["threads"])
    memory = None if words["memory"] is None else int(words["memory"] * 2**30)
    compiled: dict[str, Compiled] = {}
    racers = []
    options = replace(options, extra=parse_solver_options(words["option"]))
    for name in filter(None, (part.strip() for part in words["entrants"].split(","))):
        backend, _, encoding = name.partition(":")
        backends.get(backend)  # an unknown name is a mistake; a missing solver only loses
        compiled[name] = compile_or_blame(mission, compile_options(encoding or "auto"))
        racers.append(Racer(name, backend, compiled[name], options, memory))
    return compiled, racers


def _summary(result: Result) -> str:
    proof = "proven optimal" if result.proven else "not proven"
    value = plain(result.plan.solve.objective)
    return f"{result.winner} wins: objective {value}, {proof}; verified\n{result.race.text()}"


def _as_dict(result: Result) -> dict[str, Any]:
    return {
        "winner": result.winner,
        "sense": result.plan.solve.sense.value,
        "objective": result.plan.solve.objective,
        "proven": result.proven,
        "refused": result.refused,
        "laps": [
            {"name": p.name, "finish": p.finish.value, "seconds": p.seconds, "message": p.message}
            for p in result.race.laps
        ],
    }
