"""Several good plans that really differ.

The second plan is the best of those that are, at some step, some agent's position at least a
distance away from the first along an axis; the third differs so from both, and so on. What a plan
must differ by is a requirement like any other: it is encoded, certified and verified as such.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from stlc.errors import InfeasibleError, InterruptedSolveError, NoPlanError, UsageError
from stlc.ir.nodes import Always, Linear, Node, Or, Role, Signal
from stlc.ir.requirement import Requirement
from stlc.mission import Agent, Mission
from stlc.plan import Plan, Run
from stlc.solve.deadline import Deadline
from stlc.solve.driver import solve_mission
from stlc.solve.events import Listener, StatusEvent, ignore
from stlc.solve.outcome import Outcome, SolveSettings


@dataclass(frozen=True, slots=True)
class Several:
    """Plans, best first; `fewer` says why there are not as many as were asked for."""

    plans: tuple[Outcome, ...]
    fewer: str | None = None


def solve_several(
    mission: Mission,
    settings: SolveSettings,
    count: int,
    distance: float,
    listen: Listener = ignore,
    should_stop: Callable[[], bool] | None = None,
) -> Several:
    """At most `count` plans, best first, each pair `distance` [m] apart along an axis at some step.

    Each has an equal part of the time that is left. Fewer where there are no more, or none is found
    in time. The first raises as `solve_mission`; UsageError where nothing of
    the mission has a position.
    """
    deadline = Deadline.after(settings.time_limit, should_stop)
    found: list[Outcome] = []
    while len(found) < count and not (found and deadline.over()):
        part = deadline.share(1.0 / (count - len(found)))
        asked = replace(settings, time_limit=part.limit)
        if found:
            asked = replace(asked, start=None, save_to=None)
            listen(StatusEvent("solve", f"plan {len(found) + 1} of {count}"))
        try:
            rules = different(mission, [o.plan for o in found], distance)
            outcome = solve_mission(_with(mission, rules), asked, listen, should_stop)
        except (InfeasibleError, NoPlanError) as error:
            if not found:
                raise
            return _fewer(found, count, _no_more(error, len(found), distance))
        found.append(_own(mission, outcome))
    return _fewer(found, count, "the time is up")


def _fewer(found: list[Outcome], count: int, why: str) -> Several:
    """The plans, and `why` there are no more where they are fewer than `count`."""
    if len(found) == count:
        return Several(tuple(found))
    plans = "1 plan" if len(found) == 1 else f"{len(found)} plans"
    return Several(tuple(found), f"{plans} of the {count} asked for: {why}")


def _no_more(error: InfeasibleError | NoPlanError, count: int, distance: float) -> str:
    if isinstance(error, InfeasibleError):
        them = "it" if count == 1 else "each of them"
        return f"no other differs from {them} by {distance:g} m"
    return "interrupted" if isinstance(error, InterruptedSolveError) else str(error)


def _with(mission: Mission, rules: list[Requirement]) -> Mission:
    return replace(mission, requirements=(*mission.requirements, *rules)) if rules else mission


def _own(mission: Mission, outcome: Outcome) -> Outcome:
    """With the values of the mission's own requirements alone."""
    names = {r.name for r in mission.requirements}
    plan = outcome.plan
    kept = tuple(value for value in plan.requirements if value.name in names)
    judged = tuple(r for r in outcome.report.requirements if r.name in names)
    report = replace(outcome.report, requirements=judged)
    return replace(outcome, plan=replace(plan, requirements=kept), report=report)


def different(mission: Mission, plans: list[Plan], distance: float) -> list[Requirement]:
    """One requirement for each plan: some position is `distance` [m] away from the plan's, along
    an axis, at a step after the start. UsageError where nothing has a position."""
    taken = {r.name for r in mission.requirements} | {p.name for p in mission.preferences}
    rules = []
    for number, plan in enumerate(plans, start=1):
        name = f"different_{number}"
        while name in taken:
            name += "_"
        ways = tuple(_ways(mission, plan, distance))
        if not ways:
            raise UsageError("plans can't differ: no agent has a position")
        rules.append(Requirement(name, Or(ways)))
    return rules


def _ways(mission: Mission, plan: Plan, distance: float) -> Iterator[Node]:
    """Each step at which a run may differ."""
    for step in range(1, mission.horizon + 1):
        sides = [
            side
            for name, agent in mission.agents.items()
            if agent.dynamics.space is not None
            for side in _sides(agent, agent.dynamics.space, plan.runs[name], step, distance)
        ]
        if sides:
            yield Always(Or(tuple(sides)), step, step)


def _sides(
    agent: Agent, rows: np.ndarray, run: Run, step: int, distance: float
) -> Iterator[Linear]:
    """The position lies `distance` beyond the run's, on either side along an axis; rows (3, n)."""
    for row in rows:
        there = float(row @ run.states[step])
        used = [int(k) for k in np.flatnonzero(row)]
        if not used:
            continue  # the height of who is on the ground
        for sign in (1.0, -1.0):
            terms = tuple((Signal(agent.name, Role.STATE, k), sign * float(row[k])) for k in used)
            yield Linear(terms, -sign * there - distance, "m")
