"""One solve of a sweep: what is asked, and what came of it. Both travel between processes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from stlc import api
from stlc.diagnostics import Severity
from stlc.errors import (
    InfeasibleError,
    InterruptedSolveError,
    MissionError,
    NoPlanError,
    StlcError,
)
from stlc.files import real
from stlc.inputs import inputs_so_far, note_input, read_input, recorded_inputs
from stlc.mission import Cap, Mission
from stlc.plan import Plan, SolveInfo
from stlc.plan_json import to_json
from stlc.plan_reader import parse
from stlc.sense import Sense
from stlc.solve.outcome import Outcome, SolveSettings
from stlc.sweep.axes import Point
from stlc.sweep.costs import priced

FORMAT = 1
"""Of keys and answers: another one means that stored answers are not these."""

_NO_PLAN = "E0705"  # a requirement can never hold: told by the mission's check already


@dataclass(frozen=True, slots=True)
class Question:
    """A mission file with parameters; `minimise` and `cap` are costs in the mission's words.

    `minimise` None is the mission's own objective. `cap` (cost, limit) holds another cost at most
    at a limit. `files` is the digest of all that the mission reads; `seconds` and `gap` are limits
    of the solve.
    """

    path: str
    params: Point
    files: str
    minimise: str | None = None
    cap: tuple[str, float] | None = None
    seconds: float | None = None
    gap: float = 1e-4
    backend: str = "highs"
    allow_paths: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """What tells this question from others: all that its answer depends on."""
        told = [FORMAT, self.params, self.files, self.minimise, self.cap]
        told += [self.seconds, self.gap, self.backend]
        return hashlib.sha256(json.dumps(told).encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class Answer:
    """`status`: optimal, feasible, infeasible, no_plan, mistakes, failed, or interrupted, which is
    never stored. `objective` and `bound` go the mission's way; `costs` are verified values by name:
    `minimise` and `cap`. `plan` is JSON, "" for none; `given_up` are preferences."""

    status: str
    objective: float | None = None
    bound: float | None = None
    seconds: float = 0.0
    costs: Mapping[str, float] | None = None
    plan: str = ""
    given_up: tuple[str, ...] = ()
    message: str = ""

    @property
    def found(self) -> bool:
        """There is a certified, verified plan."""
        return bool(self.plan)

    def to_json(self) -> str:
        """As a store keeps it."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_json(text: str) -> Answer:
        """What `to_json` wrote. ValueError, KeyError or TypeError for anything else."""
        given = json.loads(text)
        return Answer(**{**given, "given_up": tuple(given["given_up"])})


def is_proof(error: MissionError) -> bool:
    """Whether all that is wrong is that no plan can exist: an answer, and no slip of the pen."""
    wrong = [d for d in error.diagnostics if d.severity is Severity.ERROR]
    return bool(wrong) and all(d.code == _NO_PLAN for d in wrong)


def digest(path: Path, params: Point, allow_paths: tuple[Path, ...]) -> str:
    """Of all files that a mission reads, in the order of their contents. Raises as `api.load`,
    but where it only says that there is no plan."""
    with recorded_inputs():
        try:
            api.load(path, params=dict(params), allow_paths=allow_paths)
        except MissionError as error:
            if not is_proof(error):
                raise
        files = inputs_so_far()
    for file in files:
        note_input(file)
    contents = sorted(hashlib.sha256(read_input(file)).hexdigest() for file in files)
    return hashlib.sha256("".join(contents).encode()).hexdigest()


def answer(
    question: Question,
    start: Answer | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Answer:
    """Solve; every outcome becomes an answer. `start` has a plan to start from."""
    try:
        mission = _mission(question)
        outcome = api.solve(mission, _settings(question, start), None, should_stop)
    except InfeasibleError as error:
        return Answer("infeasible", message=str(error))
    except InterruptedSolveError as error:
        return Answer("interrupted", message=str(error))
    except NoPlanError as error:
        return Answer("no_plan", bound=error.bound, message=str(error))
    except MissionError as error:
        return Answer("infeasible" if is_proof(error) else "mistakes", message=str(error))
    except StlcError as error:
        return Answer("failed", message=str(error))
    if should_stop is not None and should_stop() and outcome.plan.solve.status != "optimal":
        return Answer("interrupted", message="stopped before it was proven")
    return _answer(question, mission, outcome)


def _mission(question: Question) -> Mission:
    """The mission with the objective and the cap that are asked for."""
    path, allowed = Path(question.path), tuple(map(Path, question.allow_paths))
    mission = api.load(path, params=dict(question.params), allow_paths=allowed)
    folder = real(path).parent
    if question.cap is not None:
        cost, limit = question.cap
        mission, terms = priced(mission, cost, folder, allowed)
        mission = replace(mission, caps=(Cap(cost, terms, limit),))
    if question.minimise is not None:
        mission, terms = priced(mission, question.minimise, folder, allowed)
        mission = replace(mission, objective=terms, sense=Sense.MINIMIZE)
    return mission


def _settings(question: Question, start: Answer | None) -> SolveSettings:
    """Limits, and the plan to start from if there is one."""
    plan = parse(start.plan) if start is not None and start.found else None
    return SolveSettings(
        question.backend, time_limit=question.seconds, gap=question.gap, start=plan
    )


def _answer(question: Question, mission: Mission, outcome: Outcome) -> Answer:
    """The outcome in few words, both costs as the verifier adds them up."""
    info = outcome.plan.solve
    costs = {}
    if question.minimise is not None and outcome.report.objective is not None:
        costs[question.minimise] = outcome.report.objective[0]
    for cap in mission.caps:
        costs[cap.name] = _value(mission, cap, outcome.plan)
    return Answer(
        info.status, info.objective, info.bound, sum(info.seconds.values()), costs,
        to_json(outcome.plan),
        tuple(r.name for r in outcome.report.preferences if not r.kept),
    )  # fmt: skip


def _value(mission: Mission, cap: Cap, plan: Plan) -> float:
    """What a plan's capped cost really is, as the verifier adds it up."""
    alone = replace(mission, objective=cap.terms, sense=Sense.MINIMIZE, caps=())
    report = api.verify(alone, replace(plan, solve=SolveInfo()))
    return float("nan") if report.objective is None else report.objective[0]
