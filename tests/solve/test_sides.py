"""Models in which what runs satisfy is decided, and what they violate is left open."""

from __future__ import annotations

import numpy as np
import pytest

from stlc import backends
from stlc.api import loads
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled, compile_mission
from stlc.solve.alone.run import Run
from stlc.solve.judge import Judge
from stlc.solve.teams.sides import decided, left_out

HIGHS = backends.get("highs")
TEXT = """
horizon 4
workspace box [0, 10] x [0, 10]
agent r1 : single_integrator { start (1, 5); control |u| <= 2.5 }
agent r2 : single_integrator { start (9, 5); control |u| <= 2.5 }
region east = box [8, 10] x [4, 6]
region west = box [0, 2] x [4, 6]
obstacle rock = box [4, 6] x [7, 8]
require reach1: always[4, 4] r1 in east
require reach2: always[4, 4] r2 in west
require clear: always forall a in agents: a outside rock swept
require apart: always separation(r1, r2) >= 0.4 m swept
minimize effort
"""


@pytest.fixture(scope="module")
def compiled() -> Compiled:
    return compile_mission(loads(TEXT))


def straight() -> dict[str, Run]:
    """Two agents head-on along y = 5: below the rock, and through each other."""
    runs = {}
    for name, start, end in (("r1", 1.0, 8.0), ("r2", 9.0, 2.0)):
        x = np.linspace(start, end, 5)
        states = np.column_stack([x, np.full(5, 5.0)])
        runs[name] = (states, np.diff(states, axis=0))
    return runs


def test_of_runs_that_collide_only_that_is_left_to_decide(compiled: Compiled) -> None:
    model = decided(compiled.model, left_out(compiled, straight()))
    free = (model.integrality == 1) & (model.col_upper > model.col_lower)
    before = (compiled.model.integrality == 1) & (
        compiled.model.col_upper > compiled.model.col_lower
    )
    assert 0 < free.sum() < before.sum()
    found = HIGHS.solve(model, SolveOptions(gap=1e-6))
    best = HIGHS.solve(compiled.model, SolveOptions(gap=1e-6))
    assert found.status is Status.OPTIMAL
    assert found.objective == pytest.approx(best.objective, rel=0.05)
    assert found.objective >= best.objective - 1e-6
    assert Judge(compiled.mission, compiled).judge(found)[1].ok


def test_a_run_that_gets_along_stays_possible(compiled: Compiled) -> None:
    """The optimum is as good where its own sides are decided."""
    best = HIGHS.solve(compiled.model, SolveOptions(gap=1e-6))
    made = compiled.decode(best.x)
    runs = {name: (made.states[name], made.inputs[name]) for name in made.states}
    again = HIGHS.solve(decided(compiled.model, left_out(compiled, runs)), SolveOptions(gap=1e-6))
    assert again.objective == pytest.approx(best.objective, abs=1e-5)


def test_a_literal_that_two_disjunctions_share_is_kept_for_either(compiled: Compiled) -> None:
    """Closing one's alternative must not close what the other is satisfied by."""
    model = decided(compiled.model, left_out(compiled, straight()))
    closed = set(np.flatnonzero(model.col_upper < compiled.model.col_upper).tolist())
    for encoded in compiled.layout.encoded:
        for _, alternatives in encoded.choices:
            assert not alternatives or {c for _, c in alternatives} - closed
