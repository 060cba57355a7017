"""Why a mission has no plan: a minimal set of its clauses that cannot hold together.

Deletion filter (Chinneck and Dravnieks, Locating minimal infeasible constraint sets in linear
programs, 1991) over the mission's clauses: the requirements, and then the conjuncts inside those
that remain. Dynamics, bounds and the workspace always stay. A clause is dropped only when the rest
is *proven* infeasible without it; where a proof doesn't come within the limit, the clause is kept
and the answer says that it may not be minimal. The last infeasibility is confirmed by a second
solver.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING

from stlc import backends
from stlc.backends.base import Solution, SolveOptions, Status
from stlc.errors import InfeasibleError
from stlc.ir.nodes import Always, And, Link, Node, walk
from stlc.ir.requirement import Requirement
from stlc.mission import Bound, Mission
from stlc.solve.confirm import confirm_infeasible
from stlc.solve.deadline import Deadline
from stlc.solve.supervise import Supervisor

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stlc.source import Span


class Verdict(Enum):
    """What is known of a set of clauses."""

    INFEASIBLE = "infeasible"
    FEASIBLE = "feasible"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Conflict:
    """Clauses (pieces of requirements) that cannot hold together, in the order of the file.

    `minimal`: without any one of them the rest was shown to be satisfiable. `confirmation` names
    the solvers, or the interval analysis, that proved the conflict. `by_cells`: there is none
    when link predicates hold in every cell where they may at some point; the bound of theirs.
    """

    clauses: tuple[Requirement, ...]
    minimal: bool
    confirmation: str
    by_cells: Bound | None = None

    @property
    def spans(self) -> tuple[Span | None, ...]:
        """Where the clauses stand."""
        return tuple(c.formula.span or c.span for c in self.clauses)


def explain(
    mission: Mission,
    *,
    backend: str = "highs",
    time_limit: float = 60.0,
    total: float | None = None,
    proven: bool = False,
    grace: float | None = None,
) -> Conflict | Verdict:
    """A conflict; or FEASIBLE, or UNKNOWN when nothing was proven within the limit.

    `time_limit` [s] holds for each of the at most (clauses + 1) solves, `total` for all of them;
    `grace` is as in SolveSettings. `proven`: that the whole is infeasible is known already.
    """
    test = _Tester(mission, backend, time_limit, Deadline.after(total), grace)
    verdict = Verdict.INFEASIBLE if proven else test(mission.requirements)
    if verdict is not Verdict.INFEASIBLE:
        return verdict
    kept, _ = _shrink(test, mission.requirements)
    pieces = tuple(piece for clause in kept for piece in _conjuncts(clause))
    # Conjuncts say the same as their requirement, so splitting keeps the set infeasible; should
    # tolerances disagree, the whole requirements stand.
    if len(pieces) > len(kept) and test(pieces) is Verdict.INFEASIBLE:
        kept = pieces
    kept, minimal = _shrink(test, kept)
    return Conflict(tuple(kept), minimal, test.confirm(kept), test.by_cells(kept))


def _shrink(test: _Tester, clauses: Sequence[Requirement]) -> tuple[tuple[Requirement, ...], bool]:
    kept, minimal = list(clauses), True
    for clause in clauses:
        rest = [c for c in kept if c is not clause]
        verdict = test(rest)
        if verdict is Verdict.INFEASIBLE:
            kept = rest
        minimal = minimal and verdict is not Verdict.UNKNOWN
    return tuple(kept), minimal


def _conjuncts(requirement: Requirement) -> tuple[Requirement, ...]:
    return tuple(replace(requirement, formula=f) for f in _split(requirement.formula))


def _split(formula: Node) -> tuple[Node, ...]:
    """`and` splits, and so does `always` over `and`; every piece keeps its own span."""
    match formula:
        case And(args=args):
            return tuple(piece for arg in args for piece in _split(arg))
        case Always(arg=And(args=args)):
            pieces = (piece for arg in args for piece in _split(arg))
            return tuple(replace(formula, arg=p, span=p.span or formula.span) for p in pieces)
        case _:
            return (formula,)


@dataclass(slots=True)
class _Tester:
    """Is a set of clauses infeasible? Only proofs count."""

    mission: Mission
    backend: str
    time_limit: float
    deadline: Deadline  # from which on nothing more is proven
    grace: float | None

    def by_cells(self, clauses: Sequence[Requirement]) -> Bound | None:
        """The bound of link predicates that conflict by their cells only, as far as is proven."""
        channels = [n.channel for c in clauses for n in walk(c.formula) if isinstance(n, Link)]
        if not channels or self(clauses, hopeful=True) is not Verdict.FEASIBLE:
            return None
        bounds = [self.mission.channels[c].predicate_bound for c in channels]
        return Bound.WORST if Bound.WORST in bounds else bounds[0]

    def __call__(self, clauses: Sequence[Requirement], *, hopeful: bool = False) -> Verdict:
        from stlc.solve.blame import compile_or_blame

        try:
            compiled = compile_or_blame(self._with(clauses), hopeful=hopeful)
        except InfeasibleError:
            return Verdict.INFEASIBLE
        limit = min(self.time_limit, self.deadline.left)
        if limit <= 0:
            return Verdict.UNKNOWN
        backend, asked = backends.get(self.backend), SolveOptions(time_limit=limit, gap=1.0)
        work = partial(backend.solve, compiled.model)
        answer = Supervisor(work, asked, self.grace).run()
        match None if answer is None else answer.status:
            case Status.INFEASIBLE:
                return Verdict.INFEASIBLE
            case Status.OPTIMAL | Status.FEASIBLE:
                return Verdict.FEASIBLE
            case _:
                return Verdict.UNKNOWN

    def confirm(self, clauses: Sequence[Requirement]) -> str:
        """Who proved it, after a second solver has looked; SolverError when the second differs."""
        from stlc.solve.blame import compile_or_blame

        try:
            compiled = compile_or_blame(self._with(clauses))
        except InfeasibleError as error:
            return f"proven by interval analysis: {error}"
        claim = Solution(
            Status.INFEASIBLE, solver=self.backend,
            solver_version=backends.get(self.backend).version(),
        )  # fmt: skip
        options = SolveOptions(time_limit=self.time_limit)
        return str(confirm_infeasible(compiled.model, claim, options=options))

    def _with(self, clauses: Sequence[Requirement]) -> Mission:
        return replace(self.mission, requirements=tuple(clauses), objective=())
