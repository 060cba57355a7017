"""The MILP against exhaustive search over all runs of small systems."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.worlds import SYSTEMS, agent, atoms, formulas, mission, most_robust, runs, value

from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.errors import InfeasibleError, MissionError
from stlc.ir.requirement import Requirement
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.milp.formulas.selectors import SELECTORS
from stlc.mission import Mission, ObjectiveTerm, TermKind
from stlc.passes import PIPELINE
from stlc.passes.horizon import last_steps
from stlc.solve.heuristics.dive import find_start
from stlc.trajectories import Trajectories

OPTIONAL = sorted(p.name for p in PIPELINE if not p.lowering)
NEAR = 1e-5


@st.composite
def worlds(draw: st.DrawFn, objective: tuple[ObjectiveTerm, ...]) -> Mission:
    """One agent for 4 steps or two for 2, one or two requirements that can be judged."""
    names = draw(st.sampled_from([("a",), ("a", "b")]))
    agents = tuple(
        agent(n, draw(st.sampled_from(sorted(SYSTEMS))), draw(st.integers(-2, 2)), 4.5)
        for n in names
    )
    horizon = 4 if len(agents) == 1 else 2
    inner = formulas(atoms(agents))
    count = draw(st.integers(1, 2))
    margin = draw(st.sampled_from([0.0, 0.0, 0.5, -0.5]))
    found = tuple(Requirement(f"r{k}", draw(inner), margin) for k in range(count))
    last = last_steps(tuple(r.formula for r in found), horizon)
    assume(all(last[r.formula] >= 0 for r in found))
    return mission(agents, horizon, found, objective)


@st.composite
def options(draw: st.DrawFn) -> CompileOptions:
    """Any selector, any passes switched off."""
    off = draw(st.sets(st.sampled_from(OPTIONAL)))
    return CompileOptions(draw(st.sampled_from(["auto", *SELECTORS])),
                          disabled_passes=frozenset(off))  # fmt: skip


def solve(world: Mission, how: CompileOptions) -> tuple[float, Trajectories, Compiled] | None:
    """Objective, run and model; None when infeasible."""
    try:
        compiled = compile_mission(world, how)
    except InfeasibleError:
        return None
    solution = get("highs").solve(compiled.model, SolveOptions(threads=1, gap=0.0))
    if solution.status is Status.INFEASIBLE:  # HiGHS 1.15.1's presolve is wrong on a few: ask again
        plain = SolveOptions(threads=1, gap=0.0, extra={"presolve": "off"})
        solution = get("highs").solve(compiled.model, plain)
    assert solution.status in (Status.OPTIMAL, Status.INFEASIBLE)
    if solution.x is None:
        return None
    assert solution.objective is not None
    return solution.objective, compiled.decode(solution.x), compiled


def slack(world: Mission, run: Trajectories) -> float:
    """Least robustness over its margin."""
    return min(value(r.formula, run) - r.margin for r in world.requirements)


@given(worlds(()), options())
def test_feasible_exactly_when_a_run_satisfies(world: Mission, how: CompileOptions) -> None:
    best = max((slack(world, run) for run in runs(world)), default=-math.inf)
    assume(not -NEAR < best < 0)
    found = solve(world, how)
    assert (found is not None) == (best >= 0)
    if found is not None:
        assert slack(world, found[1]) >= -NEAR


@given(worlds(most_robust()), options())
def test_maximum_robustness(world: Mission, how: CompileOptions) -> None:
    values = [
        min(value(r.formula, run) for r in world.requirements)
        for run in runs(world)
        if slack(world, run) >= -NEAR
    ]
    best = max(values, default=-math.inf)
    assume(best != math.inf)
    found = solve(world, how)
    if best == -math.inf:
        assert found is None
        return
    assert found is not None
    objective, run, compiled = found
    assert objective == pytest.approx(-best, abs=NEAR)
    assert min(value(r.formula, run) for r in world.requirements) == pytest.approx(best, abs=NEAR)
    low, high = compiled.robustness[None][1:]
    assert low - NEAR <= best <= high + NEAR


@given(worlds((ObjectiveTerm(TermKind.EFFORT, 1.0),)), options(), options())
def test_least_effort(world: Mission, one: CompileOptions, other: CompileOptions) -> None:
    costs = [
        sum(float(np.abs(u).sum()) for u in run.inputs.values())
        for run in runs(world)
        if slack(world, run) >= -NEAR
    ]
    assume(all(not -NEAR < slack(world, run) < 0 for run in runs(world)))
    for how in (one, other):
        found = solve(world, how)
        assert (found is None) == (not costs)
        if found is not None:
            assert found[0] == pytest.approx(min(costs), abs=NEAR)


@given(worlds(most_robust()), options())
def test_continuous_inputs_have_one_optimum(world: Mission, how: CompileOptions) -> None:
    free = {n: replace(a, integer_inputs=False) for n, a in world.agents.items()}
    world = replace(world, agents=free)
    try:
        plain = solve(world, CompileOptions(disabled_passes=frozenset(OPTIONAL)))
    except MissionError:
        assume(False)  # robustness without an upper bound: a formula that is always true
    other = solve(world, how)
    assert (plain is None) == (other is None)
    if plain is None or other is None:
        return
    assert other[0] == pytest.approx(plain[0], abs=NEAR)
    reached = min(value(r.formula, other[1]) for r in world.requirements)
    assert reached == pytest.approx(-other[0], abs=NEAR)
    start = find_start(other[2], most_lps=60)
    if start is not None:
        model = other[2].model
        rows = model.A @ start.x
        assert (rows >= model.row_lower - NEAR).all()
        assert (rows <= model.row_upper + NEAR).all()
        assert start.objective >= plain[0] - NEAR
        assert start.bound <= plain[0] + NEAR
        run = other[2].decode(start.x)
        reached = min(value(r.formula, run) for r in world.requirements)
        assert reached >= -start.objective - NEAR
