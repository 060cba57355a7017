"""Can a run meet these requirements? Only proofs count; what was answered once is kept.

An infeasible question settles every question that asks for more; a run that was found settles all
that it satisfies. Agents that a question doesn't speak of are left out of it, since each of them
can do something by itself. Link tables are made once for all questions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import partial

import numpy as np

from stlc import backends
from stlc.analysis.unreachable import NoState, Unreachable
from stlc.backends.base import Solution, SolveOptions, Status
from stlc.channels import TableMemo
from stlc.errors import InfeasibleError, MissionError, NoPlanError
from stlc.explain.givens import Given, Kind, without
from stlc.explain.still import still
from stlc.ir.nodes import Always, Link, Role, walk
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import named
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.mission import Mission
from stlc.solve.bounded import by_deadline
from stlc.solve.deadline import Deadline, Stopwatch
from stlc.solve.supervise import Supervisor
from stlc.trajectories import Trajectories
from stlc.verify.robustness import TOLERANCE, Evaluator
from stlc.verify.trace import Trace

PATIENCE, LEAST = 5.0, 10.0
"""A later question may take so many times as long as the first proof, and at least so many
seconds: a part of a mission that takes longer than all of it tells little."""


class Verdict(Enum):
    """What is known of a set of clauses."""

    INFEASIBLE = "infeasible"
    FEASIBLE = "feasible"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Question:
    """Requirements (or weaker parts of them), and what is not given."""

    pieces: frozenset[Requirement]
    free: frozenset[Given] = frozenset()

    def asks_less(self, other: Question) -> bool:
        """Whether every run that answers the other answers this."""
        return self.pieces <= other.pieces and self.free >= other.free


@dataclass(slots=True, eq=False)
class _Found:
    """A run of some agents, made with `question`'s givens free, and what it satisfies."""

    question: Question
    agents: frozenset[str]
    judge: Evaluator

    def answers(self, asked: Question, agents: frozenset[str]) -> bool:
        if not (asked.free >= self.question.free and agents <= self.agents):
            return False
        return all(p in self.question.pieces or self._meets(p) for p in asked.pieces)

    def _meets(self, piece: Requirement) -> bool:
        """Links are looked up by whoever has tables: here they count as unmet."""
        if any(isinstance(n, Link) for n in walk(piece.formula)):
            return False
        values = self.judge.robustness(piece.formula)
        return len(values) > 0 and bool(values[0] >= piece.margin - TOLERANCE)


@dataclass(slots=True, eq=False)
class Oracle:
    """Answers questions about one mission until the deadline; `grace` is as in SolveSettings."""

    mission: Mission
    backend: str
    deadline: Deadline
    grace: float | None = None
    tables: TableMemo = field(default_factory=dict)
    asked: int = 0  # questions that a model was made for
    sure: bool = True  # none of them was left open (since somebody said so)
    open: int = 0  # how many were
    blamed: str | None = None  # the requirement that the last proof by intervals names
    stuck: str | None = None  # the agent that it leaves no state
    together: tuple[Requirement, ...] = ()  # can hold beside each other, where no more is known
    _known: dict[Question, Verdict] = field(default_factory=dict)
    _runs: list[_Found] = field(default_factory=list)
    _first: float | None = None  # seconds of the first answer

    def __call__(self, pieces: Iterable[Requirement], free: Iterable[Given] = ()) -> Verdict:
        """Whether some run meets the pieces with `free` not given."""
        question = Question(frozenset(pieces), frozenset(free))
        verdict = self._settled(question)
        if verdict is None:
            verdict = self._answer(question)
            if verdict is not Verdict.UNKNOWN:  # more time may tell
                self._known[question] = verdict
        if verdict is Verdict.UNKNOWN:
            self.sure, self.open = False, self.open + 1
        return verdict

    def infeasible(self, pieces: Iterable[Requirement], free: Iterable[Given] = ()) -> bool:
        """Whether it is proven that no run does."""
        return self(pieces, free) is Verdict.INFEASIBLE

    def broken(
        self, piece: Requirement, others: Iterable[Requirement], free: Iterable[Given] = ()
    ) -> tuple[int, int] | None:
        """First and last step at which a run that meets the others breaks the body of an `always`
        that is judged from step 0: where it is worth looking. None where no such run is known."""
        formula = piece.formula
        if not isinstance(formula, Always) or any(isinstance(n, Link) for n in walk(formula)):
            return None
        asked = Question(frozenset(others), frozenset(free))
        agents = self.agents((piece, *asked.pieces))
        for run in reversed(self._runs):
            if run.answers(asked, agents):
                values = run.judge.robustness(formula.arg)[formula.start :]
                values = (
                    values if formula.end is None else values[: formula.end + 1 - formula.start]
                )
                steps = np.flatnonzero(values < piece.margin - TOLERANCE) + formula.start
                return (int(steps[0]), int(steps[-1])) if len(steps) else None
        return None

    @contextmanager
    def within(self, part: float, most: float = math.inf) -> Iterator[None]:
        """Ask for a part (0..1) of the time that is left, and at most so many seconds."""
        end, self.deadline = self.deadline, self.deadline.share(part, most)
        try:
            yield
        finally:
            self.deadline = end

    def rest(self) -> None:
        """Know the run of agents that do nothing, if it is one."""
        run = still(self.mission)
        if run is not None:
            self._keep(Question(frozenset()), run)

    def note(self, pieces: Iterable[Requirement], verdict: Verdict) -> None:
        """Learn what was proven elsewhere."""
        self._known.setdefault(Question(frozenset(pieces)), verdict)

    def compiled(self, question: Question) -> Compiled:
        """The model of a question; raises as `made`."""
        return self.made(self.part(question), self.options(question), self.deadline)

    def options(self, question: Question) -> CompileOptions:
        """How to compile a question."""
        hopeful = any(g.kind is Kind.PARTITION for g in question.free)
        return CompileOptions(hopeful=hopeful, tables=self.tables)

    def part(self, question: Question) -> Mission:
        """The mission that a question is about."""
        kept = self.agents(question.pieces) or frozenset(list(self.mission.agents)[:1])
        agents = {n: a for n, a in self.mission.agents.items() if n in kept}
        renamed = tuple(replace(p, name=self.name_in(question, p)) for p in _ordered(question))
        part = replace(
            self.mission, agents=agents, requirements=renamed, objective=(), preferences=()
        )
        return without(part, question.free)

    def name_in(self, question: Question, piece: Requirement) -> str:
        """The name of a piece in `part`: several of one requirement are told apart."""
        return f"{piece.name}#{_ordered(question).index(piece)}"

    def agents(self, pieces: Iterable[Requirement]) -> frozenset[str]:
        """The agents that requirements speak of."""
        return frozenset(self.mission.agents) & owners_of(pieces)

    def everybody(self, names: Iterable[str] | None = None) -> Verdict:
        """Whether these agents (None: all) have runs that keep what they are given."""
        every = self.mission.agents
        asked = frozenset(every if names is None else names)
        nothing = Question(frozenset())
        if any(run.answers(nothing, asked) for run in self._runs):
            return Verdict.FEASIBLE
        agents = {n: a for n, a in every.items() if n in asked}
        bare = replace(self.mission, agents=agents, requirements=(), objective=(), preferences=())
        verdict, run = self._solve(bare, CompileOptions(tables=self.tables))
        if run is not None:
            self._keep(nothing, run)
        return verdict

    def _settled(self, question: Question) -> Verdict | None:
        if question in self._known:
            return self._known[question]
        for known, verdict in self._known.items():
            if verdict is Verdict.INFEASIBLE and known.asks_less(question):
                return verdict
        agents = self.agents(question.pieces)
        if any(run.answers(question, agents) for run in self._runs):
            return Verdict.FEASIBLE
        return None

    def _answer(self, question: Question) -> Verdict:
        try:
            verdict, run = self._solve(self.part(question), self.options(question))
        except MissionError:
            if not question.free:
                raise
            return Verdict.UNKNOWN  # what is taken out kept numbers within doubles
        if run is not None:
            self._keep(question, run)
        return verdict

    def _solve(
        self, mission: Mission, options: CompileOptions
    ) -> tuple[Verdict, Trajectories | None]:
        """Compile and solve one part, without an objective."""
        if self.deadline.over():
            return Verdict.UNKNOWN, None
        self.asked, watch, self.blamed = self.asked + 1, Stopwatch(), None
        brief = self.brief()
        try:
            compiled = self.made(mission, options, brief)
            answer = self._run(compiled, brief)
        except InfeasibleError as error:
            if isinstance(error, Unreachable):
                self.blamed = error.requirement.name.rpartition("#")[0]
            self.stuck = error.agent if isinstance(error, NoState) else None
            self._first = self._first or watch.seconds
            return Verdict.INFEASIBLE, None
        except NoPlanError:
            answer = None
        self._first = self._first or watch.seconds
        match None if answer is None else answer.status:
            case Status.INFEASIBLE:
                return Verdict.INFEASIBLE, None
            case Status.OPTIMAL | Status.FEASIBLE:
                assert answer is not None
                x = answer.x
                return Verdict.FEASIBLE, None if x is None else compiled.decode(x)
            case _:
                return Verdict.UNKNOWN, None

    def made(self, mission: Mission, options: CompileOptions, deadline: Deadline) -> Compiled:
        """The model of a mission; raises as `compile_mission` and `by_deadline`."""
        return by_deadline(
            lambda stop: compile_mission(mission, replace(options, should_stop=stop)),
            deadline, self.grace,
        )  # fmt: skip

    def brief(self) -> Deadline:
        """How long a later question may take."""
        if self._first is None:
            return self.deadline
        return self.deadline.within(max(LEAST, PATIENCE * self._first))

    def _run(self, compiled: Compiled, deadline: Deadline) -> Solution | None:
        backend, asked = backends.get(self.backend), deadline.bind(SolveOptions(gap=1.0))
        return Supervisor(partial(backend.solve, compiled.model), asked, self.grace).run()

    def _keep(self, question: Question, run: Trajectories) -> None:
        """Remember a run, so that what it satisfies isn't asked again."""
        signals = {(n, Role.STATE): x for n, x in run.states.items()}
        signals |= {(n, Role.INPUT): u for n, u in run.inputs.items()}
        judge = Evaluator(Trace(self.mission.horizon + 1, signals), faces=True)
        self._runs.append(_Found(question, frozenset(run.states), judge))


def _ordered(question: Question) -> list[Requirement]:
    return sorted(question.pieces, key=lambda p: (p.name, str(p.span), str(p.formula.span)))


def owners_of(pieces: Iterable[Requirement]) -> frozenset[str]:
    """Owners of the signals, and ends of the links, that requirements speak of."""
    return frozenset(n for p in pieces for node in walk(p.formula) for n in named(node))


def channels_of(pieces: Iterable[Requirement]) -> frozenset[str]:
    """Channels whose links requirements speak of."""
    return frozenset(n.channel for p in pieces for n in walk(p.formula) if isinstance(n, Link))
