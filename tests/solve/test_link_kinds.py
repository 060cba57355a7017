"""The search for link costs on every kind of mission: the plain MILP's optimum and no more."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from support.link_kinds import KINDS, Kind, write_kind
from support.outside import commands

from stlc import backends
from stlc.backends.base import Backend, Progress, SolveOptions
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.radio.partition import Partition
from stlc.solve.relaxation.problem import Axis, Body, Place
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.states.tubes import boxes_meet, tubes
from stlc.solve.strategies import run_strategy

FULL = os.environ.get("HYPOTHESIS_PROFILE") == "full"
SEEDS = range(5) if FULL else (1,)
QUICK = (
    "quadtree station", "uneven", "lone third", "mixed signs", "two windows", "normalised", "etx",
    "one of each", "mass", "turn rate", "stay", "together", "nested", "moving", "heavy tails",
    "only talk", "only hush", "talk to a station",
)  # fmt: skip
ASKED = [name for name in KINDS if FULL or name in QUICK or not KINDS[name].known]
SOLVERS: dict[str, Backend] = {
    name: backends.get(name) for name in ("mip", "pulp", "cvxpy", "scipy", "scip", "gurobi")
} | commands()


def _compiled(
    folder: Path, kind: Kind, seed: int, options: CompileOptions | None = None
) -> Compiled:
    """The first draw from `seed` on that has a plan."""
    for draw in range(seed, seed + 20):
        try:
            return compile_mission(write_kind(folder, kind, draw), options)
        except InfeasibleError:
            continue
    raise AssertionError("no draw of this kind has a plan")


def _agree(compiled: Compiled, backend: Backend | None = None) -> None:
    """One optimum with the plain MILP, and no bound on the way above it."""
    seen: list[Progress] = []
    plain = backends.get("highs").solve(compiled.model, SolveOptions(gap=1e-6))
    options = SolveOptions(gap=1e-6, on_progress=seen.append)
    found = run_strategy("links", compiled, backend or backends.get("highs"), options)
    assert found.status is plain.status
    if plain.objective is None:
        return
    slack = 2e-6 + 3e-6 * abs(plain.objective)
    assert found.objective == pytest.approx(plain.objective, abs=slack)
    assert all(p.bound is None or p.bound <= plain.objective + slack for p in seen)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", ASKED)
def test_one_optimum(name: str, seed: int, tmp_path: Path) -> None:
    compiled = _compiled(tmp_path, KINDS[name], seed)
    problem = recognise(compiled)
    assert (problem is not None) is KINDS[name].known
    if problem is not None:
        _agree(compiled)


@pytest.mark.parametrize("link", ["hull", "lifted", "logarithmic", "literal-tight"])
def test_one_optimum_for_every_table_encoding(link: str, tmp_path: Path) -> None:
    kind = replace(
        KINDS["station"], channels="channel radio { partition 3 x 3; {table} }", cells=9, steps=3
    )
    _agree(_compiled(tmp_path, kind, 0, CompileOptions(link=link)))


@pytest.mark.parametrize("solver", SOLVERS)
def test_one_optimum_with_every_solver(solver: str, tmp_path: Path) -> None:
    kind = replace(KINDS["plain"], channels="channel radio { partition 3 x 3; {table} }", cells=9)
    _agree(_compiled(tmp_path, replace(kind, steps=3), 0), SOLVERS[solver])


def test_negative_weights_given_by_program(tmp_path: Path) -> None:
    """The language refuses them; a mission made in Python may have one."""
    mission = write_kind(tmp_path, KINDS["two channels"], 3)
    effort, first, second = mission.objective
    changed = replace(mission, objective=(effort, first, replace(second, weight=-0.3)))
    _agree(compile_mission(changed))


def test_a_partition_with_a_hole_is_left_to_the_solver(tmp_path: Path) -> None:
    """At a step without a table an agent may be in the hole."""
    mission = write_kind(tmp_path, KINDS["window"], 1)
    radio = mission.channels["radio"]
    keep = np.arange(16) != 5
    holed = replace(
        radio, partition=Partition(radio.partition.boxes[keep]),
        tables={None: np.asarray(radio.tables[None])[np.ix_(keep, keep)]},
    )  # fmt: skip
    compiled = compile_mission(replace(mission, channels={"radio": holed}))
    assert recognise(compiled) is None


RATES = st.sampled_from([-1.0, -0.4, 0.0, 0.5, 1.0])
FULL_SPEED = [(1.0, -0.4), (1.0, 0.0), (-0.4, 0.5), (0.0, 0.0)]


@given(
    controls=st.lists(st.tuples(RATES, RATES), min_size=4, max_size=4),
    step=st.integers(1, 4),
    edge=st.sampled_from([0.0, 0.3, 1.0]),
)
@example(controls=FULL_SPEED, step=2, edge=0.0)
def test_reach_sets_hold_every_run(
    controls: list[tuple[float, float]], step: int, edge: float
) -> None:
    """A run of the integrators that meets the goal at its step lies in the tubes, also where the
    goal only touches what can be reached."""
    body = _body()
    states = [np.array([axis.start for axis in body.axes])]
    for u in controls:
        p, w = states[-1].T
        after = np.clip(w + np.array(u), -2.0, 2.0)
        states.append(np.stack([p + (w + after) / 2, after], 1))
    goal = states[step][:, :1] + np.array([[0.0, edge], [-edge, 0.0]])
    found = tubes(replace(body, places=(Place(0, step, goal),)), 4)
    for d, sets in zip(found.directions, found.sets, strict=True):
        for t, state in enumerate(states):
            p, w = d @ state
            assert boxes_meet(np.array([[p, p, w, w]]), sets[0][t])[0]


def _body() -> Body:
    """Two integrators with as much room at each step as they can use."""
    axes = []
    for d, start in enumerate((1.0, 6.0)):
        t = np.arange(5.0)
        far, fast = np.array([0.0, 0.5, 2.0, 4.0, 6.0]), np.minimum(t, 2.0)
        box = np.stack([start - far, start + far, -fast, fast], 1)
        axes.append(Axis(d, d + 2, 1.0, (start, 0.0), 0.5, 1.0, box, np.zeros(5), np.zeros(4)))
    angle = 2 * np.pi * np.arange(8) / 8
    faces = np.stack([np.sin(angle), np.cos(angle), np.full(8, 3.0)], 1)
    return Body("a", (axes[0], axes[1]), faces, {})
