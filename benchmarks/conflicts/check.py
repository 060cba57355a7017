"""What an explanation of a planted conflict has to hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from conflicts.planted import Planted
from stlc.api import loads, solve
from stlc.errors import StlcError
from stlc.explain.conflict import Conflict
from stlc.explain.edits import Change
from stlc.explain.givens import Given, givens_of
from stlc.explain.oracle import Oracle, Verdict, channels_of
from stlc.explain.repair import Repairer
from stlc.explain.weaken import conjuncts
from stlc.ir.requirement import Requirement
from stlc.mission import Mission
from stlc.solve.deadline import Deadline
from stlc.solve.outcome import SolveSettings

LIMIT = 120.0  # s


def names_of(conflict: Conflict) -> frozenset[str]:
    """The requirements that a conflict takes its clauses from."""
    return frozenset(c.name for c in conflict.clauses)


def faults(case: Planted, mission: Mission, conflict: Conflict) -> Iterator[str]:
    """What is wrong with a conflict: other than what was planted, or with a member too many."""
    names = names_of(conflict)
    if not names or not any(names <= cause for cause in case.causes):
        yield f"names {sorted(names)}, planted {[sorted(c) for c in case.causes]}"
    if case.given and case.given not in {g.kind.value for g in conflict.givens}:
        yield f"doesn't name the {case.given}"
    if not conflict.minimal:
        yield "isn't known to be minimal"
    if not conflict.cause.text:
        yield "has no cause"
    yield from _kept(case, mission, conflict)


def _kept(case: Planted, mission: Mission, conflict: Conflict) -> Iterator[str]:
    """Members without which the rest still cannot hold.

    Without a clause all of the mission can hold, or, where several conflicts are planted, the
    other clauses; without a given, the clauses with the other givens.
    """
    others = (
        ()
        if len(case.causes) > 1
        else tuple(r for r in mission.requirements if r.name not in names_of(conflict))
    )
    oracle = Oracle(mission, "highs", Deadline.after(LIMIT))
    for piece in conflict.clauses:
        rest = (*others, *_others(conflict, piece))
        if oracle(rest) is not Verdict.FEASIBLE:
            yield f"{piece.name} is not needed"
    every = givens_of(mission, conflict.agents, sorted(channels_of(conflict.clauses)))
    spare = set(every) - set(conflict.givens)
    for given in conflict.givens:
        if oracle(conflict.clauses, {given, *spare}) is not Verdict.FEASIBLE:
            yield f"{given} is not needed"


def freeing(mission: Mission, conflict: Conflict) -> tuple[int, int]:
    """How many members give the whole mission a plan when they alone go, and how many leave another
    conflict, as proven: a second bound that is too tight as well, or one of other clauses."""
    oracle = Oracle(mission, "highs", Deadline.after(LIMIT))
    whole = tuple(p for r in mission.requirements for p in conjuncts(r))
    known = {r.name for r in mission.requirements}
    asked: list[tuple[tuple[Requirement, ...], set[Given]]] = []
    for piece in conflict.clauses:  # its requirement without it, as far as the conflict knows it
        names = known - {piece.name}
        rest = (*(p for p in whole if p.name in names), *_others(conflict, piece))
        asked.append((rest, set()))
    asked += [(mission.requirements, {given}) for given in conflict.givens]
    verdicts = [oracle(pieces, free) for pieces, free in asked]
    return verdicts.count(Verdict.FEASIBLE), verdicts.count(Verdict.INFEASIBLE)


def _others(conflict: Conflict, piece: Requirement) -> tuple[Requirement, ...]:
    return tuple(c for c in conflict.clauses if c is not piece)


def offered(case: Planted, mission: Mission, conflict: Conflict) -> tuple[Change, ...]:
    """The changes that `stlc explain --fix` offers."""
    return Repairer(loads, "highs", Deadline.after(LIMIT)).changes(mission, conflict)


def broken(changes: tuple[Change, ...]) -> Iterator[str]:
    """Changes that give no verified plan, by a solve of the changed text as it stands."""
    settings = SolveSettings(time_limit=LIMIT, gap=0.5)
    for change in changes:
        try:
            solve(replace(loads(change.text), objective=(), preferences=()), settings)
        except StlcError as error:
            yield f"{change}: {error}"
