"""Preferences in tiers: one solve for each priority, what came before held by caps.

Tier 1 is minimised first; what its plan reaches becomes a cap for all that follow; the
objective, with the preferences that are weighed against it, comes last (lexicographic goal
programming; Ignizio, Goal Programming and Extensions, 1976).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from stlc.errors import InterruptedSolveError, NoPlanError
from stlc.mission import Cap, Mission, ObjectiveTerm, TermKind
from stlc.sense import Sense
from stlc.solve.deadline import Deadline
from stlc.solve.events import DiagnosticEvent, Listener, StatusEvent
from stlc.solve.outcome import Outcome, SolveSettings

SLACK = 1e-7
"""What a cap leaves above a tier's value. Later tiers use it up: well below the 1e-6 within which a
preference is kept, well above the rounding that would leave no plan. It is no part of the value:
where one wish lacks 0.5, that would be 5e-5 for later tiers to break another by."""

_ROUNDING = 1e-9
"""What it leaves at least, as a part of a value of thousands."""

_FIRST = 0.5
"""Part of a tier's time to find a plan by what it minimises alone, and then by the objective: of a
team with two deadlines in its first tier the tier found none in 20 s, the objective one in 3 s."""

Solve = Callable[[Mission, SolveSettings, Deadline], Outcome]


def priorities(mission: Mission) -> list[int]:
    """The tiers in their order."""
    return sorted({p.priority for p in mission.preferences if p.priority is not None})


def solve_in_tiers(
    mission: Mission, settings: SolveSettings, listen: Listener, deadline: Deadline, solve: Solve
) -> Outcome:
    """The plan of the last tier, best in every tier before it.

    Each tier starts from the plan before it and has an equal part of the time that is left. Raises
    as `solve`.
    """
    stages = list(_stages(mission))
    caps: list[Cap] = list(mission.caps)
    start = settings.start
    for number, (label, terms) in enumerate(stages):
        last = number == len(stages) - 1
        asked = replace(settings, start=start)
        share = deadline if last else deadline.share(1.0 / (len(stages) - number))
        if last:
            listen(StatusEvent("tier", "the objective"))
            return solve(replace(mission, caps=tuple(caps)), asked, deadline)
        listen(StatusEvent("tier", label))
        held = replace(mission, caps=tuple(caps))
        found = _tier(held, terms, _of_tier(asked), listen, share, solve)
        if found.plan.solve.status != "optimal":
            text = f"{label} is not proven best within its part of the time"
            listen(DiagnosticEvent("warning", text))
        value = found.plan.solve.objective or 0.0
        caps.append(Cap(label, terms, value + max(SLACK, _ROUNDING * abs(value))))
        start = found.plan
    raise AssertionError("the objective is always the last stage")


def _of_tier(settings: SolveSettings) -> SolveSettings:
    """What a tier before the last is solved with: its plan is nobody's yet."""
    gap = settings.gap if settings.tier_gap is None else settings.tier_gap
    return replace(settings, save_to=None, gap=gap)


def _tier(
    mission: Mission,
    terms: tuple[ObjectiveTerm, ...],
    settings: SolveSettings,
    listen: Listener,
    deadline: Deadline,
    solve: Solve,
) -> Outcome:
    """The best plan by `terms`. What a tier minimises guides to no plan at all: where none is found
    in half of the time, one by the mission's own objective is where the tier starts. Raises as
    `solve`."""
    tier = replace(mission, objective=terms, sense=Sense.MINIMIZE)
    if settings.start is not None:
        return solve(tier, settings, deadline)
    try:
        return solve(tier, settings, deadline.share(_FIRST))
    except InterruptedSolveError:
        raise
    except NoPlanError:
        if deadline.over():
            raise
    listen(StatusEvent("tier", "a plan to start from"))
    start = solve(mission, settings, deadline.share(_FIRST)).plan
    return solve(tier, replace(settings, start=start), deadline)


def _stages(mission: Mission) -> Iterator[tuple[str, tuple[ObjectiveTerm, ...]]]:
    """What each solve is called and minimises, in order."""
    for tier in priorities(mission):
        yield (
            f"priority {tier:g}",
            tuple(
                ObjectiveTerm(TermKind.VIOLATION, p.weight, requirement=p.name, span=p.span)
                for p in mission.preferences
                if p.priority == tier and p.weight
            ),
        )
    yield "the objective", mission.objective
