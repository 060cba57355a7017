"""`stlc solve`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.amount import SEED, THREADS, Amount
from stlc.cli.answer import answer, answer_end
from stlc.cli.common import (
    GRACE,
    check_outputs,
    complain,
    load,
    mission_options,
    parse_solver_options,
    plain,
    solver_options,
)
from stlc.cli.completion import backend_option, encoding_option, offer_strategies
from stlc.cli.interrupt import interruptible
from stlc.cli.lengths import metres
from stlc.cli.progress import listener
from stlc.errors import InfeasibleError, SolverError

if TYPE_CHECKING:
    from stlc.mission import Mission
    from stlc.solve.events import Listener
    from stlc.solve.given_up import Price
    from stlc.solve.outcome import Outcome, SolveSettings

_KEEPING = 10.0  # s for each preference that was given up: a reply is worth no longer wait
_EXPLAIN = 20.0  # s for all solves that look for a conflict


@dataclass(frozen=True, slots=True)
class _Words:
    """The options of `stlc solve` as click hands them over; seconds, and a relative gap."""

    backend: str
    encoding: str
    max_size: int | None
    disable: tuple[str, ...]
    strategy: str
    time_limit: float | None
    gap: float
    threads: int | None
    seed: int | None
    cluster: str | None
    start: Path | None
    shift: int
    option: tuple[str, ...]
    solutions: int
    different: float
    no_explain: bool
    confirm: bool
    output: Path | None
    csv_path: Path | None
    as_json: bool
    style: str


@click.command("solve")
@mission_options
@backend_option
@encoding_option
@click.option(
    "--max-size", type=click.IntRange(1), metavar="PARTS", help="Build models up to this size."
)
@click.option("--disable", multiple=True, metavar="PASS", help="Leave a pass out (ablation).")
@click.option("--strategy", default="auto", show_default=True, metavar="NAME",
              shell_complete=offer_strategies,
              help="`milp`: one plain solve; another's name: it, then `milp`.")  # fmt: skip
@click.option("--time-limit", type=Amount(min=0), metavar="S",
              help="Seconds for the solver; the best plan so far stands.")  # fmt: skip
@click.option("--gap", type=Amount(min=0), default=1e-4, show_default=True,
              help="Relative distance from the optimum that is good enough.")  # fmt: skip
@click.option("--threads", type=THREADS, help="Of the solver, processes of searches; else one.")
@click.option("--cluster", metavar="ADDRESS",
              help="Small solves of searches run on a dask.distributed cluster.")  # fmt: skip
@click.option("--seed", type=SEED, help="Of the solver's random choices.")
@click.option("--start", type=click.Path(path_type=Path), help="A plan to start from.")
@click.option("--shift", type=click.IntRange(min=0), default=0, help="Shift the start by steps.")
@solver_options
@click.option("--solutions", type=click.IntRange(1, 1000), default=1, show_default=True,
              metavar="K", help="So many plans that really differ, best first.")  # fmt: skip
@click.option("--different", callback=metres, default="1 m", show_default=True, metavar="LENGTH",
              help="Some agent is so far from every other plan at some step.")  # fmt: skip
@click.option("--no-explain", is_flag=True, help="Don't look for what conflicts if infeasible.")
@click.option("--confirm", is_flag=True, help="Have a second solver confirm optimality.")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="The plan (JSON), kept up to date."
)
@click.option("--csv", "csv_path", type=click.Path(path_type=Path), help="Waypoints as CSV.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--progress", "style", default="auto", show_default=True,
              type=click.Choice(["auto", "line", "text", "ndjson", "none"]),
              help="`auto`: a live line at a terminal, else lines of text.")  # fmt: skip
def solve_command(file: Path, define: tuple[str, ...], allow_path: tuple[Path, ...],
                  **words: Any) -> int:  # fmt: skip
    """Plan the mission in FILE; the plan is certified and verified before anybody sees it."""
    given = _Words(**words)
    mission = load(file, define, allow_path)
    settings = _settings(mission, given)
    places = _places(given.output, given.solutions)
    check_outputs(*places, given.csv_path)
    tell = listener(given.style)
    with interruptible() as stop:
        try:
            (outcome, *others), fewer = _solve(mission, settings, given, tell, stop)
        except InfeasibleError as error:
            if given.no_explain:
                raise
            complain(str(error))
            return _explain(mission, settings, tell, str(error))
        priced = () if given.no_explain else _prices(mission, outcome, settings, stop)
    if given.csv_path:
        outcome.plan.write_csv(given.csv_path)
    for place, other in zip(places[1:], others, strict=False):
        other.plan.write(place)
    stale = _left_over(given, 1 + len(others))
    if given.as_json:
        more: dict[str, Any] = {"keeping": [asdict(price) for price in priced]}
        if given.solutions > 1:
            more["others"] = [other.as_dict() for other in others]
            more |= {"fewer": fewer, "left_over": [str(path) for path in stale]}
        answer(outcome.as_dict() | more)
    else:
        click.echo("\n".join([_summary(outcome, priced), *(_summary(o, ()) for o in others)]))
        _tell_fewer(fewer, stale)
    if outcome.refused is not None:
        complain(outcome.refused)
        return SolverError.exit_status
    return 0


def _places(output: Path | None, count: int) -> list[Path]:
    """Where plans go: plan.json, plan-2.json, plan-3.json, .."""
    if output is None:
        return []
    further = (output.with_stem(f"{output.stem}-{k}") for k in range(2, count + 1))
    return [output, *further]


def _left_over(given: _Words, count: int) -> list[Path]:
    """Files named like a further plan that aren't any of the `count` plans."""
    if given.output is None or given.solutions == 1:
        return []
    places = _places(given.output, 1000)[count:]
    return [path for path in places if path.is_file()]


def _tell_fewer(fewer: str | None, stale: list[Path]) -> None:
    """Why there are fewer plans than were asked for, and which files are none of them."""
    if fewer is not None:
        click.echo(f"note: {fewer}")
    for path in stale:
        click.echo(f"note: {path} is of an earlier run, none of these plans")


def _solve(
    mission: Mission,
    settings: SolveSettings,
    given: _Words,
    tell: Listener,
    stop: Callable[[], bool],
) -> tuple[tuple[Outcome, ...], str | None]:
    """The plans asked for, the best one first, one at least; and why there are fewer."""
    if given.solutions > 1:
        from stlc.solve.several import solve_several

        found = solve_several(mission, settings, given.solutions, given.different, tell, stop)
        return found.plans, found.fewer
    from stlc.solve.driver import solve_mission

    return (solve_mission(mission, settings, tell, stop),), None


def _prices(
    mission: Mission, outcome: Outcome, settings: SolveSettings, stop: Callable[[], bool]
) -> tuple[Price, ...]:
    """What keeping the preferences that were given up would have cost."""
    if all(r.kept for r in outcome.report.preferences):
        return ()
    from stlc.solve.given_up import prices

    return prices(mission, outcome, settings, _KEEPING, stop)


def _explain(mission: Mission, settings: SolveSettings, tell: Listener, told: str) -> int:
    """Which lines conflict, as far as a bounded time tells."""
    from stlc.cli.conflicts import show_conflict
    from stlc.solve.events import StatusEvent

    tell(StatusEvent("explain", "looking for the requirements that conflict"))
    clauses = show_conflict(mission, settings.backend, _EXPLAIN, told)
    answer_end(InfeasibleError.exit_status, told, conflict=clauses)
    return InfeasibleError.exit_status


def _settings(mission: Mission, given: _Words) -> SolveSettings:
    """Options as settings; unknown names and a `--shift` without start are usage errors."""
    from stlc.milp.encodings import compile_options
    from stlc.plan import read_plan, shifted
    from stlc.solve.outcome import SolveSettings
    from stlc.solve.strategies import strategies_named

    strategies_named(given.strategy)  # an unknown name is told before the mission is compiled
    start = read_plan(given.start) if given.start else None
    if given.shift and start is None:
        raise click.UsageError("--shift needs --start")
    if start is not None and given.shift:
        start = shifted(start, given.shift, mission.agents)
    options = compile_options(given.encoding, given.disable, max_size=given.max_size)
    return SolveSettings(
        given.backend, options, given.strategy, given.time_limit, given.gap,
        given.threads, given.seed, start, given.confirm, given.output,
        parse_solver_options(given.option), GRACE, given.cluster,
    )  # fmt: skip


def _summary(outcome: Outcome, priced: tuple[Price, ...]) -> str:
    """What a person sees of a solve: status, robustness of each requirement, notes, seconds."""
    from stlc.verify.requirement_report import tight_words

    info = outcome.plan.solve
    gap = "" if info.gap is None else f", gap {info.gap:.2%}"
    bound = "" if info.bound is None else f", bound {plain(info.bound)}"
    lines = [f"{info.status}: objective {plain(info.objective)}{bound}{gap}  ({info.solver})"]
    lines += [
        f"  {r.name:20} robustness {'-' if r.robustness is None else plain(r.robustness)}"
        for r in outcome.plan.requirements
    ]
    lines += [f"  {p}" for p in outcome.report.preferences]
    lines += [f"    {price.text(info.objective or 0.0)}" for price in priced]
    tight = tight_words(outcome.report.requirements)
    lines += [f"  {tight}"] if tight else []
    lines += [f"  note: {c}" for c in outcome.report.clearances if c.is_cut]
    if outcome.confirmation is not None:
        lines.append(f"  second solver: {outcome.confirmation}")
    took = ", ".join(f"{k} {v:.2f} s" for k, v in outcome.seconds.items())
    lines += [f"  note: {note}" for note in outcome.report.notes]
    return "\n".join([*lines, f"  certified and verified; {took}"])
