"""One point of a sweep's grid, as a task that goes to another process or machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from stlc.sweep.ask import Answer, Question, answer
from stlc.sweep.frontier import Frontier, frontier

Keep = Callable[[Question, Answer], None]
Found = Answer | Frontier


@dataclass(frozen=True, slots=True)
class Task:
    """A question; with `costs`, `count` points of their trade-off curve. `known` are answers, by
    key, that need no solve."""

    question: Question
    costs: tuple[str, str] | None = None
    count: int = 0
    known: Mapping[str, Answer] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Done:
    """What came of a task, and every answer that was solved for on the way."""

    found: Found
    new: tuple[tuple[Question, Answer], ...]


class MissingAnswerError(Exception):
    """A question whose answer isn't known, where nothing may be solved."""


class InterruptedSweepError(Exception):
    """A solve was cut short: what depends on it isn't known."""


def run(
    task: Task, should_stop: Callable[[], bool] | None = None, keep: Keep | None = None
) -> Done:
    """Make a task; `keep` is told of each answer at once. InterruptedSweepError when stopped."""
    known = dict(task.known)
    new: list[tuple[Question, Answer]] = []

    def ask(question: Question, start: Answer | None) -> Answer:
        """Know, or solve."""
        found = known.get(question.key)
        if found is not None:
            return found
        if should_stop is not None and should_stop():
            raise InterruptedSweepError
        found = answer(question, start, should_stop)
        if found.status == "interrupted":
            raise InterruptedSweepError
        known[question.key] = found
        new.append((question, found))
        if keep is not None:
            keep(question, found)
        return found

    return Done(_found(task, ask), tuple(new))


def recalled(task: Task, recall: Callable[[Question], Answer | None]) -> tuple[Task, Found | None]:
    """The task with what is known of it, and its result if that is all."""
    known: dict[str, Answer] = {}

    def ask(question: Question, start: Answer | None) -> Answer:
        """Know, or give up."""
        found = recall(question)
        if found is None:
            raise MissingAnswerError
        known[question.key] = found
        return found

    try:
        return task, _found(task, ask)
    except MissingAnswerError:
        return Task(task.question, task.costs, task.count, known), None


def _found(task: Task, ask: Callable[[Question, Answer | None], Answer]) -> Found:
    if task.costs is None:
        return ask(task.question, None)
    return frontier(task.question, task.costs, task.count, ask)
