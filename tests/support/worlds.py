"""Small systems with integer inputs, all of whose runs can be listed, and random formulas."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from hypothesis import strategies as st

from stlc.dynamics import Dynamics
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Node,
    Not,
    Or,
    Release,
    Role,
    Signal,
    Timed,
    Until,
)
from stlc.ir.requirement import Requirement
from stlc.mission import Agent, Mission, ObjectiveTerm, TermKind
from stlc.source import Source
from stlc.trajectories import Trajectories
from stlc.verify.robustness import robustness
from stlc.verify.trace import Trace

SINGLE = (np.array([[1.0]]), np.array([[1.0]]))
DOUBLE = (np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]))
SKEW = (np.array([[1.0, 0.5], [-0.5, 1.0]]), np.array([[1.0], [0.5]]))
SYSTEMS = {"single": SINGLE, "double": DOUBLE, "skew": SKEW}


def agent(name: str, system: str, start: float, limit: float = 50.0) -> Agent:
    """One input in {-1, 0, 1}, states within +-limit."""
    A, B = SYSTEMS[system]
    n = len(A)
    dynamics = Dynamics(
        system, A, B, np.zeros(n), tuple(f"x{k}" for k in range(n)), ("u",), ("",) * n, ("",)
    )
    ends = np.full(n, limit)
    first = np.zeros(n)
    first[0] = start
    return Agent(
        name, dynamics, first, -ends, ends, np.array([-1.0]), np.array([1.0]),
        np.zeros(n), np.ones(1), integer_inputs=True,
    )  # fmt: skip


def mission(
    agents: tuple[Agent, ...],
    horizon: int,
    requirements: tuple[Requirement, ...],
    objective: tuple[ObjectiveTerm, ...] = (),
) -> Mission:
    """A mission without space or radio."""
    return Mission(
        Source("random", ""), 1.0, horizon, None, {a.name: a for a in agents}, {}, {}, {}, {},
        requirements, objective,
    )  # fmt: skip


def runs(world: Mission) -> Iterator[Trajectories]:
    """Every run within the state bounds."""
    names = list(world.agents)
    choices = list(product([-1.0, 0.0, 1.0], repeat=world.horizon))
    for picked in product(choices, repeat=len(names)):
        states, inputs = {}, {}
        for name, sequence in zip(names, picked, strict=True):
            one, x = world.agents[name], [world.agents[name].start]
            for u in sequence:
                x.append(one.dynamics.A @ x[-1] + one.dynamics.B @ [u])
            states[name], inputs[name] = np.array(x), np.array(sequence).reshape(-1, 1)
        fits = [
            ((x >= world.agents[n].state_lower) & (x <= world.agents[n].state_upper)).all()
            for n, x in states.items()
        ]
        if all(fits):
            yield Trajectories(states, inputs)


def value(formula: Node, run: Trajectories) -> float:
    """Robustness at step 0 by the independent evaluator."""
    signals = {(n, Role.STATE): x for n, x in run.states.items()}
    signals |= {(n, Role.INPUT): u for n, u in run.inputs.items()}
    length = len(next(iter(run.states.values())))
    return float(robustness(formula, Trace(length, signals))[0])


def most_robust(scales: dict[str, float] | None = None) -> tuple[ObjectiveTerm, ...]:
    """Maximise the robustness of all requirements."""
    return (ObjectiveTerm(TermKind.ROBUSTNESS, -1.0, scales=scales or {}),)


def atoms(agents: tuple[Agent, ...]) -> st.SearchStrategy[Node]:
    """Predicates over up to two signals, thresholds between the reachable values."""
    signals = [
        Signal(a.name, role, k, shift)
        for a in agents
        for role, count in ((Role.STATE, len(a.dynamics.A)), (Role.INPUT, 1))
        for k in range(count)
        for shift in (0, 1)
        if role is Role.STATE or shift == 0
    ]
    terms = st.dictionaries(st.sampled_from(signals), st.sampled_from([-1.0, 1.0, 2.0]), max_size=2)
    levels = st.integers(-9, 9).map(lambda k: k / 3)
    return st.builds(
        lambda t, c: Linear(tuple(sorted(t.items(), key=lambda p: p[0].key)), c), terms, levels
    )


TRIANGLE = ((0, 1), (0, 2), (1, 2))


def formulas(base: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
    """Formulas with every operator."""
    bounded = st.tuples(st.integers(0, 2), st.integers(0, 2)).map(lambda w: (w[0], w[0] + w[1]))
    spans = bounded | st.tuples(st.integers(0, 1), st.none())

    def extend(inner: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
        few = st.lists(inner, min_size=2, max_size=3).map(tuple)
        three = st.lists(inner, min_size=3, max_size=3).map(tuple)
        return st.one_of(
            st.builds(Not, inner),
            st.builds(And, few),
            st.builds(Or, few),
            st.builds(Implies, inner, inner),
            st.builds(Iff, inner, inner),
            st.builds(Timed, few),
            st.builds(lambda args, k: Count(args, min(k, len(args))), few, st.integers(1, 3)),
            st.builds(
                lambda args, w, k: Count(args, min(k, sum(w[: len(args)])), w[: len(args)]),
                few, st.tuples(*3 * [st.integers(1, 3)]), st.integers(1, 9),
            ),
            st.builds(
                lambda args, hops, cut: Network(args, TRIANGLE, ("p", "q", "r"), hops, cut),
                three, st.sampled_from([None, 1, 2]), st.booleans(),
            ),
            st.builds(
                lambda k, a, w: k(a, *w), st.sampled_from([Always, Eventually]), inner, spans
            ),
            st.builds(
                lambda k, a, b, w: k(a, b, *w), st.sampled_from([Until, Release]), inner, inner,
                spans,
            ),
        )  # fmt: skip

    return st.recursive(base | base | st.builds(Const, st.booleans()), extend, max_leaves=6)
