"""Why a mission has no plan: few and short parts of it that cannot hold together.

Requirements first, a lone one before several; then what is inside them, conjuncts, parts of
formulas and steps; then what is given beside them, bounds, starts, the workspace and partitions. A
part is dropped only when the rest is *proven* infeasible without it; where a proof doesn't come in
time, it is kept and the answer says that it may not be minimal. The last infeasibility is confirmed
by a second solver.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from stlc import backends
from stlc.backends.base import Solution, SolveOptions, Status
from stlc.errors import InfeasibleError, NoPlanError
from stlc.explain import shrink
from stlc.explain.cause import Cause, cause_of
from stlc.explain.givens import Given, Kind, givens_of
from stlc.explain.marco import conflicts
from stlc.explain.oracle import Oracle, Question, Verdict, channels_of
from stlc.explain.whole import begin
from stlc.explain.words import clause, place, steps_of
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import keeps_to_faces, measures
from stlc.milp.compile import CompileOptions
from stlc.mission import Bound, Mission, PolygonKind
from stlc.solve.bounded import by_deadline
from stlc.solve.confirm import confirm_infeasible
from stlc.solve.deadline import Deadline

if TYPE_CHECKING:
    from stlc.milp.model import Model
    from stlc.source import Span

__all__ = ["Conflict", "Verdict", "explain"]

_OPINION = 10.0  # s for the second solver


@dataclass(frozen=True, slots=True)
class Conflict:
    """Clauses (weaker parts of requirements) that cannot hold together, in the order of the file.

    `givens` are the bounds, starts, workspace and partitions that they conflict with; without one
    of them, as without one of the clauses, the rest can hold, where it is `minimal`. `confirmation`
    names the solvers, or the interval analysis, that proved the conflict. `by_cells`: there is none
    when link predicates hold in every cell where they may at some point; the bound of theirs.
    `questions` is how many models were asked, `rounded` whether a bound given is an inscribed
    polygon of a norm.
    """

    clauses: tuple[Requirement, ...]
    minimal: bool
    confirmation: str
    by_cells: Bound | None = None
    givens: tuple[Given, ...] = ()
    cause: Cause = field(default_factory=lambda: Cause(""))
    agents: tuple[str, ...] = ()
    questions: int = 0
    rounded: bool = False

    @property
    def by_faces(self) -> bool:
        """Whether polygons stand for lengths in a member: the true ones may have a run still."""
        return self.rounded or any(measures(c.formula) for c in self.clauses)

    @property
    def by_steps(self) -> bool:
        """Whether a member is `swept` and holds by one alternative for a step: a run that takes
        several in one may be there still."""
        return any(keeps_to_faces(c.formula) for c in self.clauses)

    @property
    def spans(self) -> tuple[Span | None, ...]:
        """Where the clauses stand."""
        return tuple(c.formula.span or c.span for c in self.clauses)

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values; steps count from 0, None is to the end."""
        return {
            "cause": self.cause.text,
            "earliest": self.cause.earliest,
            "short": self.cause.short,
            "unit": self.cause.unit,
            "clauses": [
                {"requirement": c.name, "says": clause(c), "steps": steps_of(c), "place": place(s)}
                for c, s in zip(self.clauses, self.spans, strict=True)
            ],
            "givens": [
                {"kind": g.kind.value, "of": g.owner or None, "place": place(g.span)}
                for g in self.givens
            ],
            "agents": list(self.agents),
            "minimal": self.minimal,
            "polygons": self.by_faces,
            "steps": self.by_steps,
            "partition": None if self.by_cells is None else self.by_cells.value,
            "proof": self.confirmation,
        }


def explain(
    mission: Mission,
    *,
    backend: str = "highs",
    time_limit: float | None = 60.0,
    proven: bool = False,
    grace: float | None = None,
) -> Conflict | Verdict:
    """A conflict; or FEASIBLE, or UNKNOWN when nothing was proven within the limit.

    `time_limit` [s] is for all of it; `grace` is as in SolveSettings. `proven`: that the whole is
    infeasible is known already. MissionError for recorded signals, and where a model is too large.
    """
    oracle = Oracle(mission, backend, Deadline.after(time_limit), grace)
    verdict = begin(oracle, proven)
    return conflict_of(oracle, mission.requirements) if verdict is None else verdict


def conflict_of(oracle: Oracle, requirements: tuple[Requirement, ...]) -> Conflict:
    """A minimal conflict among requirements that are infeasible together."""
    oracle.sure = True
    oracle.note((), Verdict.FEASIBLE)  # unless it is known better; looked at below
    found = shrink.core(oracle, requirements)
    if not found or oracle.everybody(oracle.agents(found)) is Verdict.INFEASIBLE:
        return _without_requirements(oracle)
    return finished(oracle, found)


def all_conflicts(oracle: Oracle) -> Iterator[Conflict]:
    """Every minimal conflict among the conjuncts of an infeasible mission's requirements.

    Each is then followed into parts of formulas and steps. Ends with the oracle's deadline.
    """
    if oracle.everybody() is Verdict.INFEASIBLE:
        yield _without_requirements(oracle)
        return
    oracle.note((), Verdict.FEASIBLE)
    for pieces in conflicts(oracle, oracle.mission.requirements):
        oracle.sure = True
        yield finished(oracle, pieces)


def finished(oracle: Oracle, pieces: tuple[Requirement, ...]) -> Conflict:
    """The conflict that minimal pieces make, with what is given, its cause and its proof.

    What isn't needed goes before the pieces are cut down, lest steps fewer than those of a plain
    contradiction bring in a start and a speed. What is kept stays needed: less is asked then.
    """
    every = shrink.given(oracle, pieces)
    givens = shrink.minimal_givens(oracle, pieces, every)
    pieces = shrink.inside(oracle, pieces, set(every) - set(givens))
    minimal = oracle.sure
    cause = cause_of(oracle, pieces, givens)
    bound = _bound(oracle.mission, pieces) if shrink.by_cells(givens) else None
    agents = tuple(n for n in oracle.mission.agents if n in oracle.agents(pieces))
    order = sorted(pieces, key=lambda p: _offset(p, oracle.mission))
    return Conflict(
        tuple(order), minimal, _proof(oracle, pieces), bound, givens, cause, agents, oracle.asked,
        any(_is_rounded(g, oracle.mission) for g in givens),
    )  # fmt: skip


def _is_rounded(given: Given, mission: Mission) -> bool:
    """Whether a bound is that of a norm, which a polygon within it stands for."""
    agent = mission.agents.get(given.owner)
    if agent is None or given.kind not in (Kind.SPEED, Kind.CONTROL):
        return False
    norms = agent.state_norms if given.kind is Kind.SPEED else agent.input_norms
    return any(norm.kind is PolygonKind.INSCRIBED for norm in norms)


def _offset(piece: Requirement, mission: Mission) -> int:
    return [r.name for r in mission.requirements].index(piece.name)


def _without_requirements(oracle: Oracle) -> Conflict:
    """Starts, dynamics, bounds and the workspace alone leave some agent no run."""
    mission = oracle.mission
    for name in mission.agents:
        alone = Alone(oracle, name)
        every = givens_of(mission, [name], [])
        if alone(every):
            kept = tuple(shrink.one_by_one(every, alone))
            proof = _proof(oracle, ())
            text = f"{name} has no run at all: {_reason(oracle, alone.mission)}"
            return Conflict((), True, proof, None, kept, Cause(text), (name,), oracle.asked)
    return Conflict((), True, _proof(oracle, ()), agents=tuple(mission.agents))


@dataclass(frozen=True, slots=True)
class Alone:
    """Whether one agent has no run with some of what it is given."""

    oracle: Oracle
    name: str

    @property
    def mission(self) -> Mission:
        """The agent by itself, with nothing required."""
        whole = self.oracle.mission
        return replace(whole, agents={self.name: whole.agents[self.name]}, requirements=())

    def __call__(self, kept: object) -> bool:
        assert isinstance(kept, list)
        free = set(givens_of(self.oracle.mission, [self.name], [])) - set(kept)
        asked = Oracle(self.mission, self.oracle.backend, self.oracle.deadline, self.oracle.grace)
        return asked.infeasible((), free)


def _reason(oracle: Oracle, lone: Mission) -> str:
    """What interval analysis says of the bounds of an agent, if it does."""
    bare = replace(lone, objective=(), preferences=())
    try:
        oracle.made(bare, CompileOptions(tables=oracle.tables), oracle.deadline)
    except InfeasibleError as error:
        return str(error)
    except NoPlanError:
        pass  # for want of time
    return "its start, dynamics and bounds rule out every one"


def _bound(mission: Mission, pieces: tuple[Requirement, ...]) -> Bound:
    bounds = [mission.channels[c].predicate_bound for c in channels_of(pieces)]
    return Bound.WORST if Bound.WORST in bounds else bounds[0]


def _proof(oracle: Oracle, pieces: tuple[Requirement, ...]) -> str:
    """Who proved it, after a second solver has looked; SolverError when the second differs."""
    claim = Solution(
        Status.INFEASIBLE, solver=oracle.backend,
        solver_version=backends.get(oracle.backend).version(),
    )  # fmt: skip
    late = f"{claim.solver_version} says so; no second solver was asked, for want of time"
    try:
        model = _model(oracle, _told(oracle, pieces))
    except InfeasibleError as error:
        return f"proven by interval analysis: {error}"
    except NoPlanError:
        return late
    if oracle.deadline.over():
        return late
    limit = max(1.0, min(_OPINION, oracle.deadline.left))
    return str(confirm_infeasible(model, claim, options=SolveOptions(time_limit=limit)))


def _told(oracle: Oracle, pieces: tuple[Requirement, ...]) -> Mission:
    """The mission of some pieces, by the names that the file gives them where they are distinct."""
    if not pieces:
        return replace(oracle.mission, requirements=(), objective=(), preferences=())
    part = oracle.part(Question(frozenset(pieces)))
    told = tuple(replace(r, name=r.name.rpartition("#")[0]) for r in part.requirements)
    distinct = len({r.name for r in told}) == len(told)
    return replace(part, requirements=told) if distinct else part


def _model(oracle: Oracle, mission: Mission) -> Model:
    """Its model, by the oracle's deadline; raises as `compile_or_blame` and `by_deadline`."""
    from stlc.solve.blame import compile_or_blame

    options = CompileOptions(tables=oracle.tables)
    return by_deadline(
        lambda stop: compile_or_blame(mission, replace(options, should_stop=stop)).model,
        oracle.deadline, oracle.grace,
    )  # fmt: skip
