"""`stlc race`: several backends and encodings against each other."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.common import (
    check_outputs,
    load,
    mission_options,
    parse_solver_options,
    plain,
    solver_options,
)
from stlc.cli.interrupt import interruptible
from stlc.cli.progress import listener
from stlc.errors import DisagreementError, InfeasibleError, NoPlanError
from stlc.solve.events import Listener, ProgressEvent, StatusEvent

if TYPE_CHECKING:
    from stlc.backends.base import Progress
    from stlc.milp.compile import Compiled
    from stlc.mission import Mission
    from stlc.solve.race import Race, Racer


@click.command("race")
@mission_options
@click.option("--with", "entrants", default="highs:auto,scip:auto", show_default=True,
              metavar="BACKEND:ENCODING,...")  # fmt: skip
@click.option("--cluster", metavar="ADDRESS", help="Run on a dask.distributed cluster.")
@click.option("--time-limit", type=click.FloatRange(min=0), metavar="S", help="For each racer.")
@click.option("--memory", type=click.FloatRange(min=0), metavar="GB", help="For each racer.")
@click.option("--gap", type=click.FloatRange(min=0), default=1e-4, show_default=True)
@click.option("--threads", type=click.IntRange(min=1), default=1, show_default=True)
@solver_options
@click.option("-o", "--output", type=click.Path(path_type=Path), help="plan.json")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--progress", "style", default="auto", show_default=True,
              type=click.Choice(["auto", "line", "ndjson", "none"]))  # fmt: skip
def race_command(file: Path, define: tuple[str, ...], allow_path: tuple[Path, ...],
                 **words: Any) -> int:  # fmt: skip
    """Solve FILE with several solvers and encodings at once; the first certified proof wins."""
    from stlc.solve.race import Finish

    mission = load(file, define, allow_path)
    check_outputs(words["output"])
    compiled, racers = _enter(mission, words)
    with interruptible() as stop:
        result = _run(racers, words["cluster"], listener(words["style"]), stop)
    winner = result.winner
    if winner is None or winner.certified is None:
        raise NoPlanError(f"no racer found a plan\n{_laps(result)}")
    if winner.certified.x is None:
        raise InfeasibleError(f"no run satisfies the mission (proven by {winner.name})")
    plan, report = _judge(mission, compiled[winner.name], winner.certified, winner.name)
    if not report.ok:
        raise DisagreementError(f"{winner.name}: the verifier refuses the plan\n{report.text()}")
    if words["output"]:
        plan.write(words["output"])
    proof = winner.finish is Finish.PROOF
    click.echo(
        json.dumps(_as_dict(result, plan.solve.objective, proof), indent=2)
        if words["as_json"]
        else f"{winner.name} wins: objective {plain(plan.solve.objective)}"
        f"{', proven optimal' if proof else ', not proven'}; verified\n{_laps(result)}"
    )
    return 0


def _enter(mission: Mission, words: dict[str, Any]) -> tuple[dict[str, Compiled], list[Racer]]:
    from stlc import backends
    from stlc.backends.base import SolveOptions
    from stlc.milp.compile import compile_mission
    from stlc.milp.encodings import compile_options
    from stlc.solve.race import Racer

    options = SolveOptions(words["time_limit"], words["gap"], words["threads"])
    memory = None if words["memory"] is None else int(words["memory"] * 2**30)
    compiled: dict[str, Compiled] = {}
    racers = []
    options = replace(options, extra=parse_solver_options(words["option"]))
    for name in filter(None, (part.strip() for part in words["entrants"].split(","))):
        backend, _, encoding = name.partition(":")
        backends.get(backend)  # an unknown name is a mistake; a missing solver only loses
        compiled[name] = compile_mission(mission, compile_options(encoding or "auto"))
        racers.append(Racer(name, backend, compiled[name].model, options, memory))
    return compiled, racers


def _run(racers: list[Racer], cluster: str | None, listen: Listener, stop: Any) -> Race:
    from stlc.solve.cluster import race_on_cluster
    from stlc.solve.race import race

    listen(StatusEvent("solve", "racing " + ", ".join(r.name for r in racers)))
    if cluster is not None:
        return race_on_cluster(cluster, racers, should_stop=stop)

    def tell(name: str, p: Progress) -> None:
        listen(ProgressEvent(p.seconds, p.objective, p.bound, p.gap, p.nodes))

    return race(racers, on_progress=tell, should_stop=stop)


def _judge(mission: Mission, compiled: Compiled, certified: Any, name: str) -> Any:
    from stlc.solve.driver import judge_point

    claim = replace(certified.claim, x=certified.x, objective=certified.objective)
    return judge_point(mission, compiled, claim, encoding=name.partition(":")[2] or "auto")


def _laps(result: Race) -> str:
    return "\n".join(
        f"  {lap.name:24} {lap.finish.value:8} {lap.seconds:7.1f} s  {lap.message}".rstrip()
        for lap in result.laps
    )


def _as_dict(result: Race, objective: float | None, proof: bool) -> dict[str, Any]:
    return {
        "winner": result.winner.name if result.winner else None,
        "objective": objective,
        "proven": proof,
        "laps": [
            {"name": p.name, "finish": p.finish.value, "seconds": p.seconds, "message": p.message}
            for p in result.laps
        ],
    }
