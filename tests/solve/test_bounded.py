"""Work that ends by a deadline, by itself or left behind."""

from __future__ import annotations

import threading

import pytest

from stlc.api import loads, solve
from stlc.errors import InfeasibleError, InterruptedSolveError, NoPlanError
from stlc.milp.compile import CompileOptions, compile_mission
from stlc.solve.bounded import Stop, by_deadline
from stlc.solve.deadline import Deadline
from stlc.solve.outcome import SolveSettings

TEXT = """horizon 4
agent a : single_integrator { start (1, 1); control |u| <= 1 }
require go: eventually a.x >= 3
"""


def _until_told(should_stop: Stop) -> int:
    wait = threading.Event()
    while not should_stop():
        wait.wait(0.005)
    raise InterruptedSolveError("told to")


@pytest.mark.parametrize("limit", [None, 60.0])
def test_what_is_there_in_time_is_returned_or_raised(limit: float | None) -> None:
    assert by_deadline(lambda stop: 7, Deadline.after(limit)) == 7

    def fails(stop: Stop) -> int:
        raise InfeasibleError("no")

    with pytest.raises(InfeasibleError, match="no"):
        by_deadline(fails, Deadline.after(limit))


def test_the_deadline_ends_who_looks_at_it() -> None:
    with pytest.raises(NoPlanError) as caught:
        by_deadline(_until_told, Deadline.after(0.05))
    assert not isinstance(caught.value, InterruptedSolveError)


def test_a_wish_to_stop_is_told_from_the_deadline() -> None:
    with pytest.raises(InterruptedSolveError):
        by_deadline(_until_told, Deadline.after(60.0, lambda: True))
    with pytest.raises(InterruptedSolveError):
        by_deadline(_until_told, Deadline.after(None, lambda: True))


def test_who_does_not_look_is_left_behind() -> None:
    over = threading.Event()

    def deaf(stop: Stop) -> bool:
        return over.wait(60.0)

    with pytest.raises(NoPlanError):
        by_deadline(deaf, Deadline.after(0.05), grace=0.05)
    over.set()


def test_compiling_stops_when_asked() -> None:
    with pytest.raises(InterruptedSolveError):
        compile_mission(loads(TEXT), CompileOptions(should_stop=lambda: True))


def test_a_solve_without_time_to_compile_has_no_plan() -> None:
    with pytest.raises(NoPlanError):
        solve(loads(TEXT), SolveSettings(time_limit=0.0, grace=0.0))
