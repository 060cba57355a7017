"""Reports arrive in the caller's thread; whatever happens there stops the solver."""

import threading

import pytest

from stlc.backends import get
from stlc.backends.base import Progress, SolveOptions
from stlc.backends.conformance_models import knapsack

HARD = knapsack(200, 30)
LIVE = ("highs", "scip", "gurobi")


class _StopError(Exception):
    """Raised by a listener."""


@pytest.mark.parametrize("name", LIVE)
@pytest.mark.parametrize("error", [_StopError, KeyboardInterrupt])
def test_an_exception_in_the_listener_ends_the_solve(name: str, error: type[BaseException]) -> None:
    threads = []

    def listen(progress: Progress) -> None:
        threads.append(threading.current_thread())
        raise error

    with pytest.raises(error):
        get(name).solve(HARD, SolveOptions(on_progress=listen))  # else it would go on for hours
    assert set(threads) == {threading.current_thread()}


@pytest.mark.parametrize("name", LIVE)
def test_bounds_and_objectives_close_in(name: str) -> None:
    seen: list[Progress] = []
    get(name).solve(HARD, SolveOptions(time_limit=1.5, on_progress=seen.append))
    values = [p.objective for p in seen if p.incumbent is not None and p.objective is not None]
    assert values == sorted(values, reverse=True)
    assert all(p.bound <= min(values) + 1e-6 for p in seen if p.bound is not None)


def test_highs_changes_threads_between_solves() -> None:
    for threads in (1, 2, None, 1):
        solution = get("highs").solve(knapsack(), SolveOptions(threads=threads))
        assert solution.ignored == ()


def test_highs_says_when_another_solve_holds_the_threads() -> None:
    inner = []

    def listen(progress: Progress) -> None:
        if not inner:
            inner.append(get("highs").solve(knapsack(), SolveOptions(threads=2)))

    asked = SolveOptions(threads=1, time_limit=1.0, on_progress=listen)
    assert get("highs").solve(HARD, asked).ignored == ()
    assert inner[0].ignored == ("threads",)


def test_highs_repeats_for_the_same_seed() -> None:
    model = knapsack(30, 8)
    runs = [get("highs").solve(model, SolveOptions(threads=1, seed=5)) for _ in range(2)]
    assert runs[0].nodes == runs[1].nodes
    first, second = (run.x for run in runs)
    assert first is not None
    assert second is not None
    assert first.tolist() == second.tolist()
