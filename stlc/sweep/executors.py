"""Where tasks are made: in this process, in a few of their own, or on a cluster."""

from __future__ import annotations

import queue
import uuid
from collections.abc import Callable, Iterator, Sequence

from stlc.errors import SolverError
from stlc.solve.racing.child import Child
from stlc.solve.racing.cluster import Future, connect, distributed, result_of, stop_event
from stlc.sweep.work import Done, InterruptedSweepError, Keep, Task, run

Stop = Callable[[], bool]
Finished = Iterator[tuple[int, Done]]

_POLL = 0.2  # s


def run_here(tasks: Sequence[Task], should_stop: Stop, keep: Keep) -> Finished:
    """One after the other in this process; `keep` is told of each answer the moment it is there."""
    for number, task in enumerate(tasks):
        if should_stop():
            return
        try:
            yield number, run(task, should_stop, keep)
        except InterruptedSweepError:
            return


def run_apart(tasks: Sequence[Task], workers: int, should_stop: Stop, keep: Keep) -> Finished:
    """`workers` processes at a time, in whatever order they end. SolverError when one dies."""
    waiting = list(enumerate(tasks))[::-1]
    open_: dict[int, Child] = {}
    said: queue.Queue[tuple[int, object | None]] = queue.Queue()
    try:
        while (waiting or open_) and not should_stop():
            while waiting and len(open_) < workers:
                number, task = waiting.pop()
                open_[number] = Child(
                    "stlc.sweep.worker", "a point of the sweep", task, _teller(said, number)
                )
            try:
                number, message = said.get(timeout=_POLL)
            except queue.Empty:
                continue
            if number not in open_:
                continue  # it has no more to say, as expected
            child = open_.pop(number)
            why = "" if isinstance(message, Done) else child.why()
            child.end()
            if not isinstance(message, Done):
                raise SolverError(f"a point of the sweep: {why}; try fewer --workers")
            _keep_all(message, keep)
            yield number, message
    finally:
        for child in open_.values():
            child.end()


def _teller(
    said: queue.Queue[tuple[int, object | None]], number: int
) -> Callable[[object | None], None]:
    return lambda message: said.put((number, message))


def run_on_cluster(address: str, tasks: Sequence[Task], should_stop: Stop, keep: Keep) -> Finished:
    """One task a point; workers need the same sources and see the mission's files at the same
    paths. SolverError when the cluster can't be reached, or gives up on a task."""
    word = f"stlc-sweep-{uuid.uuid4().hex}"
    if not tasks:
        return
    with connect(address) as client:
        futures = {
            client.submit(run_remotely, task, word, key=f"{word}-{k}", priority=-k, pure=False): k
            for k, task in enumerate(tasks)
        }
        open_ = set(futures)
        try:
            while open_ and not should_stop():
                try:
                    waited = distributed().wait(open_, _POLL, return_when="FIRST_COMPLETED")
                except TimeoutError:
                    continue
                open_ -= waited.done
                for future in waited.done:
                    if (done := _result(future)) is not None:
                        _keep_all(done, keep)
                        yield futures[future], done
        finally:
            stop_event(word, client).set()


def run_remotely(task: Task, word: str) -> Done | None:
    """On a worker: make the task, unless the event `word` is set."""
    event = stop_event(word, distributed().get_client())
    try:
        return None if event.is_set() else run(task, event.is_set)
    except InterruptedSweepError:
        return None


def _result(future: Future) -> Done | None:
    result = result_of(future, "a point of the sweep")
    assert result is None or isinstance(result, Done)
    return result


def _keep_all(done: Done, keep: Keep) -> None:
    for question, answer in done.new:
        keep(question, answer)
