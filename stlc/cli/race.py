"""`stlc race`: several backends and encodings against each other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.amount import THREADS, Amount
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
from stlc.cli.completion import offer_entries
from stlc.cli.interrupt import interruptible
from stlc.cli.progress import listener
from stlc.errors import SolverError

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled
    from stlc.mission import Mission
    from stlc.solve.racing.mission_race import Result
    from stlc.solve.racing.race import Racer


@dataclass(frozen=True, slots=True)
class _Words:
    """The options of `stlc race` as click hands them over; seconds, GB, and a relative gap."""

    entrants: str
    cluster: str | None
    time_limit: float | None
    memory: float | None
    gap: float
    threads: int
    option: tuple[str, ...]
    output: Path | None
    as_json: bool
    style: str


@click.command("race")
@mission_options
@click.option("--with", "entrants", default="highs:auto,scip:auto", show_default=True,
              shell_complete=offer_entries,
              metavar="BACKEND:ENCODING,...", help="Who races.")  # fmt: skip
@click.option("--cluster", metavar="ADDRESS", help="Run on a dask.distributed cluster.")
@click.option("--time-limit", type=Amount(min=0), metavar="S", help="For each racer.")
@click.option("--memory", type=Amount(min=0), metavar="GB", help="For each racer.")
@click.option("--gap", type=Amount(min=0), default=1e-4, show_default=True,
              help="Relative distance from the optimum that is good enough.")  # fmt: skip
@click.option("--threads", type=THREADS, default=1, show_default=True,
              help="Of each racer.")  # fmt: skip
@solver_options
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="The plan (JSON), kept up to date."
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--progress", "style", default="auto", show_default=True,
              type=click.Choice(["auto", "line", "text", "ndjson", "none"]),
              help="`auto`: a live line at a terminal, else lines of text.")  # fmt: skip
def race_command(file: Path, define: tuple[str, ...], allow_path: tuple[Path, ...],
                 **words: Any) -> int:  # fmt: skip
    """Solve FILE with several solvers and encodings at once; the first certified proof wins."""
    from stlc.solve.racing.mission_race import MissionRace

    given = _Words(**words)
    mission = load(file, define, allow_path)
    check_outputs(given.output)
    compiled, racers = _enter(mission, given)
    tell = listener(given.style)
    with interruptible() as stop:
        race = MissionRace(mission, compiled, racers, tell, given.output, given.cluster)
        result = race.run(stop)
    answer(_as_dict(result)) if given.as_json else click.echo(_summary(result))
    if result.refused is not None:
        complain(result.refused)
        return SolverError.exit_status
    return 0


def _enter(mission: Mission, given: _Words) -> tuple[dict[str, Compiled], list[Racer]]:
    """Compiles the mission for each entrant `backend[:encoding]`, before any of them starts."""
    from stlc import backends
    from stlc.backends.base import SolveOptions
    from stlc.milp.encodings import compile_options
    from stlc.solve.blame import compile_or_blame
    from stlc.solve.racing.race import Racer

    options = SolveOptions(given.time_limit, given.gap, given.threads)
    memory = None if given.memory is None else int(given.memory * 2**30)
    compiled: dict[str, Compiled] = {}
    racers = []
    options = replace(options, extra=parse_solver_options(given.option))
    for name in filter(None, (part.strip() for part in given.entrants.split(","))):
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
    """The race as JSON; objective in the mission's own sense, seconds on the wall clock."""
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
