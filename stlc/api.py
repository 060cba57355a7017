"""The Python API: load a mission, compile it, solve it, verify a plan, explain why there is none.

    from stlc import api

    mission = api.load("mission.stl", params={"speed": "2 m/s"})
    outcome = api.solve(mission)
    print(outcome.plan.solve.objective, outcome.report.text())

Every function raises StlcError subclasses, each with its exit status and, where the mission is at
fault, the place in the file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from stlc.files import real

if TYPE_CHECKING:
    from stlc.arrays import Floats as Array
    from stlc.diagnostics import Diagnostic
    from stlc.explain.conflict import Conflict, Verdict
    from stlc.explain.edits import Change
    from stlc.explain.tight import Explained
    from stlc.milp.compile import Compiled, CompileOptions
    from stlc.mission import Mission
    from stlc.plan import Plan
    from stlc.radio.samples import Samples
    from stlc.renew.receding import Loop, Voyage, World
    from stlc.renew.replanning import Renewed
    from stlc.simulate import Simulation
    from stlc.solve.events import Listener
    from stlc.solve.outcome import Outcome, SolveSettings
    from stlc.verify import Report

__all__ = [
    "changes", "check", "compile", "explain", "explain_plan", "load", "loads", "receding", "replan",
    "simulate", "solve", "verify",
]  # fmt: skip

Params = Mapping[str, str | float]


def load(
    path: str | Path, *, params: Params | None = None, allow_paths: Sequence[Path] = ()
) -> Mission:
    """Check a mission file. UsageError when it isn't there, MissionError when it has mistakes.

    `params` override `param` statements (numbers, or texts with units such as "3 m/s"). Imports
    and data are read only from under the file's folder and `allow_paths`.
    """
    from stlc.sema import load_mission
    from stlc.syntax.read import read_source

    folder = real(path).parent
    return load_mission(read_source(Path(path)), params or {}, folder, tuple(allow_paths))


def loads(
    text: str,
    *,
    name: str = "<text>",
    params: Params | None = None,
    folder: Path | None = None,
    allow_paths: Sequence[Path] = (),
) -> Mission:
    """Check a mission given as text; files it names are read from under `folder`.

    Raises MissionError with every mistake found.
    """
    from stlc.sema import load_mission
    from stlc.source import Source

    return load_mission(Source(name, text), params or {}, folder, tuple(allow_paths))


def check(mission: Mission) -> tuple[Diagnostic, ...]:
    """The warnings; a mission with errors never comes to be."""
    return mission.warnings


def compile(mission: Mission, options: CompileOptions | None = None) -> Compiled:
    """The MILP of a mission. InfeasibleError where intervals prove that there is no plan."""
    from stlc.solve.blame import compile_or_blame

    return compile_or_blame(mission, options)


def solve(
    mission: Mission,
    settings: SolveSettings | None = None,
    listen: Listener | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Outcome:
    """A certified, verified plan; errors as `stlc.solve.driver.solve_mission`."""
    from stlc.solve.driver import solve_mission
    from stlc.solve.events import ignore

    return solve_mission(mission, settings, listen or ignore, should_stop)


def verify(mission: Mission, plan: Plan) -> Report:
    """Judge a plan independently of every encoder."""
    from stlc.verify import verify as judge

    return judge(mission, plan)


def simulate(mission: Mission, plan: Plan, *, draws: int = 10_000, seed: int = 0) -> Simulation:
    """How probable each requirement is; see `stlc.simulate.simulation.simulate`."""
    from stlc.simulate import simulate as carry_out

    return carry_out(mission, plan, draws=draws, seed=seed)


def replan(
    mission: Mission,
    plan: Plan,
    step: int,
    states: Mapping[str, Array],
    *,
    history: Mapping[str, tuple[Array, Array]] | None = None,
    headings: Mapping[str, float] | None = None,
    samples: Mapping[str, Samples] | None = None,
    refit: bool = False,
    settings: SolveSettings | None = None,
) -> Renewed:
    """Plan what is left after a plan was followed up to `step`, from the `states` (n,) there.

    `history` are states (step, n) and inputs (step, m) where they were others than planned,
    `headings` [rad] those of robots that were measured at `step`;
    `samples` were measured on the way, by channel; with `refit` their parameters are fitted anew
    where enough came. See `stlc.renew.replanning.replan`.
    """
    from stlc.renew.past import along
    from stlc.renew.replanning import replan as renew

    past = along(mission, plan, step, states, history, headings)
    return renew(mission, past, settings, old=plan, heard=samples, refit=refit)


def receding(
    mission: Mission, world: World, loop: Loop | None = None, *, plan: Plan | None = None
) -> Voyage:
    """Carry a mission out in a world, planning anew on events; see `stlc.renew.receding`."""
    from stlc.renew.receding import receding as carry_out

    return carry_out(mission, world, loop, plan=plan)


def explain(
    mission: Mission, *, backend: str = "highs", time_limit: float = 60.0
) -> Conflict | Verdict:
    """What cannot hold together, and why; `time_limit` [s] is for all solves together."""
    from stlc.explain.conflict import explain as look

    return look(mission, backend=backend, time_limit=time_limit)


def explain_plan(mission: Mission, plan: Plan) -> Explained:
    """Which requirements of a plan are tight, what decides them, what their margins cost."""
    from stlc.explain.tight import explain_plan as look

    return look(mission, plan)


def changes(
    path: str | Path,
    *,
    params: Params | None = None,
    allow_paths: Sequence[Path] = (),
    time_limit: float = 60.0,
    most: int = 5,
) -> tuple[Change, ...]:
    """The smallest changes of a mission file's numbers that give a plan, each shown by one.

    Nothing for a mission that has a plan, or where none was found within `time_limit` [s].
    """
    from stlc.explain.conflict import Verdict
    from stlc.explain.repair import Repairer
    from stlc.solve.deadline import Deadline

    def again(text: str) -> Mission:
        folder = real(path).parent
        return loads(text, name=str(path), params=params, folder=folder, allow_paths=allow_paths)

    deadline = Deadline.after(time_limit)
    mission = load(path, params=params, allow_paths=allow_paths)
    found = explain(mission, time_limit=time_limit)
    if isinstance(found, Verdict):
        return ()
    return Repairer(again, "highs", deadline).changes(mission, found, most)
