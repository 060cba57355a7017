"""A lying solver is caught, and named."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stlc.backends import get
from stlc.backends.base import Capability, Solution, SolveOptions, Status
from stlc.backends.conformance_models import knapsack
from stlc.errors import SolverError
from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Model, Origin
from stlc.milp.violations import exact_objective, violations
from stlc.solve.certify import certify
from stlc.solve.confirm import RefutedError, confirm_infeasible, confirm_optimal, second_opinion
from stlc.source import Source

INF = float("inf")


def _mixed() -> Model:
    """min t, t >= |x - 5|, x <= 2 or x >= 7: optimum 2."""
    b = ModelBuilder("mixed", offset=1.0)
    b.origin = Origin("require away", Source("m.stl", "away\n").span(0, 4))
    x, side = b.add_columns("x", (1,), -10, 10), b.binary("side", (1,))
    t = b.add_columns("t", (1,), 0, 100, cost=1)
    pair, both = np.concatenate([x, side])[None, :], np.concatenate([t, x])[None, :]
    b.add_dense_rows("left", pair, [1, -20], -INF, 2)
    b.add_dense_rows("right", pair, [1, -20], -13, INF)
    b.add_dense_rows("over", both, [1, -1], -5, INF)
    b.add_dense_rows("under", both, [1, 1], 5, INF)
    return b.build()


MODEL = _mixed()
TRUTH = Solution(
    Status.OPTIMAL, np.array([7.0, 1.0, 2.0]), 3.0, 3.0, seconds=0.1, solver="fibber",
    solver_version="Fibber 1.0",
)  # fmt: skip


@dataclass(frozen=True)
class Fibber:
    """A backend that says what it was told to say."""

    answer: Solution
    name: str = "fibber"
    capabilities: Capability = Capability.NONE

    def available(self) -> str | None:
        return None

    def version(self) -> str:
        return "Fibber 1.0"

    def solve(self, model: Model, options: SolveOptions) -> Solution:
        return self.answer


LIES = {
    "fractional": (replace(TRUTH, x=np.array([4.5, 0.51, 0.5]), objective=1.5, bound=1.5), "side"),
    "violated row": (
        replace(TRUTH, x=np.array([5.0, 1.0, 0.0]), objective=1.0, bound=1.0),
        "right",
    ),
    "outside bounds": (replace(TRUTH, x=np.array([11.0, 1.0, 6.0]), objective=7.0), "x_0"),
    "wrong objective": (replace(TRUTH, objective=2.0, bound=2.0), "claims objective 2"),
    "no objective": (replace(TRUTH, objective=None), "without its objective"),
    "NaN in the point": (replace(TRUTH, x=np.array([7.0, 1.0, np.nan])), "t_0 is not a finite"),
    "NaN objective": (replace(TRUTH, objective=float("nan")), "objective is nan"),
    "NaN bound": (replace(TRUTH, bound=float("nan")), "bound is nan"),
    "wrong length": (replace(TRUTH, x=np.array([7.0, 1.0])), "2 values for 3 columns"),
    "no point": (replace(TRUTH, x=None), "returned no point"),
    "bound above its point": (replace(TRUTH, bound=3.5), "bound 3.5 exceeds"),
    "failed": (replace(TRUTH, status=Status.FAILED, message="out of memory"), "out of memory"),
}


@pytest.mark.parametrize("lie", LIES)
def test_lies_are_refused_and_named(lie: str) -> None:
    answer, message = LIES[lie]
    with pytest.raises(SolverError, match=r"Fibber 1\.0") as error:
        certify(MODEL, Fibber(answer).solve(MODEL, SolveOptions()))
    assert message in str(error.value)
    assert error.value.exit_status == 5


def test_the_truth_is_certified() -> None:
    certified = certify(MODEL, TRUTH)
    assert (certified.status, certified.objective, certified.gap) == (Status.OPTIMAL, 3.0, 0.0)
    assert certified.after is not None
    assert certified.after.rows == certified.after.bounds == certified.after.integrality == 0.0
    assert certified.checked().as_dict()["claim"] == {
        "status": "optimal", "objective": 3.0, "solver": "fibber", "solver_version": "Fibber 1.0",
    }  # fmt: skip


def test_optimal_at_a_time_limit_is_only_feasible() -> None:
    asked = SolveOptions(time_limit=5.0)
    worse = replace(TRUTH, x=np.array([8.0, 1.0, 3.0]), objective=4.0)
    by_bound = certify(MODEL, replace(worse, bound=1.0, seconds=5.1), options=asked)
    silent = certify(MODEL, replace(worse, bound=None, seconds=5.1), options=asked)
    for certified in (by_bound, silent):
        assert certified.status is Status.FEASIBLE
        assert certified.claim.status is Status.OPTIMAL
        assert "fibber claims to be optimal" in certified.warnings[0]


def test_a_suboptimal_claim_is_refuted_by_a_second_solver() -> None:
    worse = certify(MODEL, replace(TRUTH, x=np.array([8.0, 1.0, 3.0]), objective=4.0, bound=4.0))
    said = r"Fibber 1.0.* claims 4 is optimal, but HiGHS .* (3|2\.99999\d+)$"
    with pytest.raises(SolverError, match=said):  # HiGHS 1.16 may lean on its tolerance of 1e-6
        confirm_optimal(MODEL, worse, get("highs"))
    assert confirm_optimal(MODEL, certify(MODEL, TRUTH), get("highs")).confirmed


def test_a_false_infeasible_is_caught() -> None:
    lie = replace(TRUTH, status=Status.INFEASIBLE, x=None, objective=None, bound=None)
    assert certify(MODEL, lie).x is None
    with pytest.raises(RefutedError, match=r"Fibber 1.0.* claims infeasible, but HiGHS") as error:
        confirm_infeasible(MODEL, lie, get("highs"))
    assert error.value.exit_status == 5
    assert violations(MODEL, error.value.x).within(1e-6)


def test_a_true_infeasible_is_confirmed_by_another_solver() -> None:
    b = ModelBuilder()
    x = b.add_columns("x", (2,), -9, 9, integer=True)
    b.add_dense_rows("r", x[None, :], [2, 4], 1, 1)
    model = b.build()
    confirmed = confirm_infeasible(model, get("highs").solve(model, SolveOptions()))
    assert confirmed.confirmed
    assert "HiGHS" in str(confirmed)
    assert "HiGHS" not in confirmed.by


def test_a_second_solver_at_its_limit_confirms_nothing() -> None:
    lie = replace(TRUTH, status=Status.INFEASIBLE, x=None, objective=None, bound=None)
    tired = Fibber(replace(TRUTH, status=Status.NO_SOLUTION, x=None, objective=None, bound=None))
    assert not confirm_infeasible(MODEL, lie, tired).confirmed


def test_a_second_solver_whose_point_is_refused_confirms_nothing() -> None:
    claim = replace(TRUTH, status=Status.INFEASIBLE, x=None, objective=None, bound=None)
    liar = Fibber(replace(TRUTH, x=np.array([0.0, 0.5, 9.0])))
    said = confirm_infeasible(MODEL, claim, liar)
    assert not said.confirmed
    assert str(said) == "Fibber 1.0 says so; Fibber 1.0 gave no valid point"


@pytest.mark.parametrize("name", ["highs", "mip", "scip", "cvxpy", "scipy", "pulp"])
def test_second_opinion_is_another_solver(name: str) -> None:
    backend = second_opinion(name)
    assert backend is not None
    assert backend.version().split()[0] != get(name).version().split()[0]


def test_integers_are_rounded_and_the_rest_is_solved_again() -> None:
    """A binary within 1e-6 of 0 lets x leak by 20e-6: no longer so after certification."""
    leak = replace(TRUTH, x=np.array([2.00001, 5e-7, 2.99999]), objective=3.99999, bound=3.99999)
    certified = certify(MODEL, leak)
    assert certified.polished
    assert certified.before is not None
    assert certified.before.integrality == pytest.approx(5e-7)
    assert certified.x is not None
    assert certified.x[1] == 0.0
    assert certified.objective == pytest.approx(4.0, abs=1e-9)


def test_rounding_that_leaves_no_point_is_refused() -> None:
    b = ModelBuilder()
    n, x = b.binary("n", (1,)), b.add_columns("x", (1,), 0, 1)
    b.add_dense_rows("r", np.concatenate([n, x])[None, :], [1e4, 1], 1.5, 1.5)
    leak = replace(TRUTH, x=np.array([5e-5, 1.0]), objective=0.0, bound=None)
    with pytest.raises(SolverError, match=r"no point is feasible; row r_0 .* violated by 0\.5"):
        certify(b.build(), leak)


def test_an_optimum_that_gets_worse_is_not_proven() -> None:
    leak = replace(TRUTH, x=np.array([2.0019, 9.5e-5, 2.9981]), objective=3.9981, bound=3.9981)
    certified = certify(MODEL, leak)
    assert certified.status is Status.FEASIBLE
    assert "not proven" in certified.warnings[0]


@given(seed=st.integers(0, 10**6))
def test_violations_agree_with_fractions(seed: int) -> None:
    from fractions import Fraction

    rng = np.random.default_rng(seed)
    model = knapsack(6, 4, seed)
    x = rng.normal(size=6) * 10.0 ** rng.integers(-3, 4)
    x[rng.random(6) < 0.3] = 0.0
    exact = [Fraction(v) for v in x.tolist()]
    dense = model.A.toarray().tolist()
    sums = [sum(Fraction(a) * v for a, v in zip(row, exact, strict=True)) for row in dense]
    worst = max(
        [
            Fraction(0),
            *(s - Fraction(u) for s, u in zip(sums, model.row_upper.tolist(), strict=True)),
        ]
    )
    found = violations(model, x)
    assert found.rows == pytest.approx(float(worst), rel=1e-12, abs=1e-14)
    off = np.maximum(model.col_lower - x, x - model.col_upper).clip(min=0)
    assert found.bounds == pytest.approx(off.max())
    assert (found.worst_column is None) == (not off.any())
    value = sum(Fraction(c) * v for c, v in zip(model.c.tolist(), exact, strict=True))
    assert exact_objective(model, x) == pytest.approx(float(value), rel=1e-14, abs=1e-14)
