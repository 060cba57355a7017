"""Windows that many steps share: the written-out form's meaning, no looser bounds, few nodes."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from stlc.analysis.bounds import static_bounds
from stlc.analysis.reach import reach
from stlc.api import loads
from stlc.ir.nodes import Node, Role
from stlc.ir.printer import print_node
from stlc.ir.rewrite import postorder
from stlc.milp.compile import compile_mission
from stlc.mission import Mission
from stlc.passes import horizon, nnf, unroll
from stlc.passes.base import Program
from stlc.verify.robustness import Evaluator, Trace

AGENT = """workspace box [0, 100] x [0, 100]
agent r : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
"""
FORMULAS = [
    "always[0, 60] eventually[0, 40] r.x >= 2 m",
    "eventually[3, 50] always[2, 21] r.y >= 2 m",
    "always[0, 30] eventually[0, 17] always[0, 12] (r.x >= 1 m or r.y >= 2 m)",
    "always[0, 60] (r.x >= 0 m until[0, 40] r.y >= 1 m)",
    "eventually[0, 33] (r.x >= 0 m until[5, 19] r.y >= 1 m)",
    "eventually[5, 60] (r.x >= 2 m release[3, 30] r.y >= 1 m)",
    "always[2, 25] (r.x >= 2 m release[0, 9] r.y >= 1 m)",
    "always[0, 20] ((r.x >= 1 m until[0, 10] r.y >= 2 m) until[0, 15] r.x >= 3 m)",
    "always[4, 20] not (r.x >= 1 m until[2, 14] (r.y >= 2 m or eventually[0, 11] r.x <= 2 m))",
    # windows that don't touch: one chain of an until for each run of steps
    "(r.x >= 1 m until[0, 9] r.y >= 2 m) and next[40, 41] (r.x >= 1 m until[0, 9] r.y >= 2 m)",
    "always[0, 1] eventually[20, 40] (r.x >= 1 m until[30, 41] r.y >= 2 m)",
]


def _unrolled(mission: Mission) -> Program:
    program = Program(mission.requirements, mission, reach(mission))
    for step in (nnf, horizon, unroll):
        program = step.run(program)
    return program


def _loaded(formula: str) -> Mission:
    return loads(f"{AGENT}require a: {formula.replace('next[40, 41]', 'always[40, 41]')}\n")


@pytest.mark.parametrize("formula", FORMULAS)
def test_the_meaning_stays(formula: str) -> None:
    mission = _loaded(formula)
    node = _unrolled(mission).formulas[0]
    length = mission.horizon + 1
    for seed in range(12):
        random = np.random.default_rng(seed)
        steps = random.normal(0.0, [0.3, 1.0, 3.0][seed % 3], (length, 4))
        states = 1.5 + (np.cumsum(steps, axis=0) if seed % 2 else steps)
        signals = {("r", Role.STATE): states, ("r", Role.INPUT): np.zeros((length - 1, 2))}
        trace = Trace(length, signals)
        wanted = Evaluator(trace).robustness(mission.requirements[0].formula)[0]
        assert Evaluator(trace).robustness(node)[0] == wanted


@pytest.mark.parametrize("formula", FORMULAS)
def test_static_bounds_are_those_of_the_written_out_form(
    formula: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission = _loaded(formula)

    def bounds() -> tuple[float, float]:
        program = _unrolled(mission)
        return static_bounds(program.formulas, program.ranges)[program.formulas[0]]

    shared = bounds()
    monkeypatch.setattr(unroll, "_DIRECT", 10_000)
    assert shared == pytest.approx(bounds())


@pytest.mark.parametrize(
    "formula",
    [
        "always[0, {n}] (r.x >= 0.5 m until[0, {n}] r.y >= 1 m)",
        "eventually[0, {n}] (r.x >= 0.5 m release[0, {n}] r.y >= 1 m)",
        "always[0, {n}] eventually[0, {n}] r.y >= 1 m",
    ],
)
def test_nodes_grow_with_the_steps_alone(formula: str) -> None:
    def count(n: int) -> int:
        return sum(1 for _ in postorder(_unrolled(_loaded(formula.format(n=n))).formulas))

    small, large = count(200), count(800)
    assert large <= 4.8 * small  # a release keeps the logarithm of its conjunctions
    assert small <= 25 * 200


def test_a_chain_deeper_than_any_stack_compiles() -> None:
    deep = "r.x >= 0.5 m until[0, 1040] r.y >= 1 m"
    compiled = compile_mission(_loaded(f"always[0, 700] ({deep})"))
    assert compiled.model.rows < 40 * 1740
    (one,) = compiled.layout.encoded
    assert _depth(one.formula) > 1000
    (other,) = pickle.loads(pickle.dumps(compiled.layout)).encoded  # racers get it by pipe
    assert print_node(other.formula) == print_node(one.formula)
    assert other.literals == one.literals
    assert [(print_node(n), [c for _, c in p]) for n, p in other.choices[:9]] == [
        (print_node(n), [c for _, c in p]) for n, p in one.choices[:9]
    ]


def _depth(root: Node) -> int:
    depth: dict[Node, int] = {}
    for node in postorder([root]):
        depth[node] = 1 + max((depth[child] for child in node.children), default=0)
    return depth[root]
