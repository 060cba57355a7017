"""HiGHS's thread pool belongs to the process: others in it may have used another size."""

import highspy

from stlc import api
from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.backends.conformance_models import knapsack
from stlc.solve.heuristics.dive import find_start

_MISSION = """step 1 s
horizon 7
workspace box [0, 8] x [0, 4]
agent r : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
region goal = box [6, 7.5] x [1, 3]
obstacle low = box [3, 4] x [0, 2.5]
require reach: eventually[3, 7] r in goal
require clear: always r outside low
maximize robustness
"""


def _solve_with(threads: int) -> None:
    highspy.Highs.resetGlobalScheduler(True)
    other = highspy.Highs()
    other.setOptionValue("output_flag", False)
    other.setOptionValue("threads", threads)
    other.addVar(0.0, 1.0)
    assert other.run() == highspy.HighsStatus.kOk


def test_the_start_search_after_another_pool() -> None:
    compiled = api.compile(api.loads(_MISSION))
    for threads in (2, 1, 2):
        _solve_with(threads)
        assert find_start(compiled) is not None


def test_the_backend_after_another_pool() -> None:
    highs, model = get("highs"), knapsack(10, 3)
    first = highs.solve(model, SolveOptions())
    _solve_with(2)
    again = highs.solve(model, SolveOptions())
    assert (again.status, again.objective) == (Status.OPTIMAL, first.objective)
