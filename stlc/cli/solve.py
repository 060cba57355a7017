"""`stlc solve`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.common import interruptible, load, mission_options
from stlc.cli.progress import listener

if TYPE_CHECKING:
    from stlc.solve.driver import Outcome


@click.command("solve")
@mission_options
@click.option("--backend", default="highs", show_default=True, help="See `stlc backends`.")
@click.option("--encoding", default="auto", show_default=True, help="See `stlc encodings`.")
@click.option("--disable", multiple=True, metavar="PASS", help="Leave a pass out (ablation).")
@click.option("--strategy", type=click.Choice(["auto", "milp"]), default="auto", show_default=True,
              help="`milp`: one solve of the compiled model, no bounding ahead of it.")  # fmt: skip
@click.option("--time-limit", type=click.FloatRange(min=0), metavar="S")
@click.option("--gap", type=click.FloatRange(min=0), default=1e-4, show_default=True)
@click.option("--threads", type=click.IntRange(min=1))
@click.option("--seed", type=click.IntRange(min=0))
@click.option("--start", type=click.Path(path_type=Path), help="A plan to start from.")
@click.option("--shift", type=click.IntRange(min=0), default=0, help="Shift the start by steps.")
@click.option("--confirm", is_flag=True, help="Have a second solver confirm optimality.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="plan.json, kept up to date.")
@click.option("--csv", "csv_path", type=click.Path(path_type=Path), help="Waypoints as CSV.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--progress", "style", default="auto", show_default=True,
              type=click.Choice(["auto", "line", "ndjson", "none"]))  # fmt: skip
def solve_command(file: Path, define: tuple[str, ...], allow_path: tuple[Path, ...],
                  **words: Any) -> int:  # fmt: skip
    """Plan the mission in FILE; the plan is certified and verified before anybody sees it."""
    from stlc.solve.driver import solve_mission

    mission = load(file, define, allow_path)
    settings = _settings(mission, words)
    with interruptible() as stop:
        outcome = solve_mission(mission, settings, listener(words["style"]), stop)
    if words["csv_path"]:
        outcome.plan.write_csv(words["csv_path"])
    click.echo(json.dumps(outcome.as_dict(), indent=2) if words["as_json"] else _summary(outcome))
    return 0


def _settings(mission: Any, words: dict[str, Any]) -> Any:
    from stlc.milp.encodings import compile_options
    from stlc.plan import read_plan, shifted
    from stlc.solve.driver import SolveSettings

    start = read_plan(words["start"]) if words["start"] else None
    if start is not None and words["shift"]:
        start = shifted(start, words["shift"], mission.agents)
    options = compile_options(words["encoding"], words["disable"])
    return SolveSettings(
        words["backend"], options, words["strategy"], words["time_limit"], words["gap"],
        words["threads"], words["seed"], start, words["confirm"], words["output"],
    )  # fmt: skip


def _summary(outcome: Outcome) -> str:
    info = outcome.plan.solve
    gap = "" if info.gap is None else f", gap {info.gap:.2%}"
    bound = "" if info.bound is None else f", bound {info.bound:.6g}"
    lines = [f"{info.status}: objective {info.objective:.6g}{bound}{gap}  ({info.solver})"]
    lines += [
        f"  {r.name:20} robustness {'-' if r.robustness is None else format(r.robustness, '.6g')}"
        for r in outcome.plan.requirements
    ]
    took = ", ".join(f"{k} {v:.2f} s" for k, v in outcome.seconds.items())
    return "\n".join([*lines, f"  certified and verified; {took}"])
