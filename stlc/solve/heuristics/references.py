"""What alternatives runs of lattices take: guides for the search of `dive.py`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from stlc.analysis.goals import Level
from stlc.analysis.stages import LevelOf
from stlc.arrays import Floats
from stlc.ir.nodes import And, Linear, Node, Or, Role
from stlc.ir.rewrite import conjuncts
from stlc.solve.heuristics.lattice_runs import LatticeRun, Witness, find_run, parts_by_step

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled

_LESS = 0.99
_ROUNDING = 1e-6
_LATTICES = ((1.0, 0.0), (0.85, 0.3), (0.9, 0.5), (0.65, 0.4), (0.75, 0.5))
"""Share of the controls; share of the spacing by which predicates may be missed. Exact first."""


def reference_points(compiled: Compiled, level_of: Callable[[Level], LevelOf]) -> Iterator[Floats]:
    """How much each column (n,) is preferred by runs of lattices, exact runs first: 1 for the
    alternative of a disjunction that holds best on the run if it does (but for what the lattice
    misses), less for the others."""
    for tight, miss in _LATTICES:
        runs = _lattice_runs(compiled, level_of, tight, miss)
        if runs is None:
            continue
        preference = np.zeros(compiled.model.columns)
        room = -_ROUNDING - max(run.room for run in runs.values())
        states = {name: run.states for name, run in runs.items()}
        for one in compiled.layout.encoded:
            level = level_of(one.level)
            for _, pairs in one.choices:
                values = np.array([slack(part, states, level) for part, _ in pairs])
                best = values.max(initial=-np.inf)
                if np.isfinite(best):
                    columns = [column for _, column in pairs]
                    preference[columns] = _LESS / (1.0 + best - values)
                    if best >= room:  # elsewhere nothing asks for any of them
                        preference[columns[int(values.argmax())]] = 1.0  # one alone where they tie
        yield preference


def _lattice_runs(
    compiled: Compiled, level_of: Callable[[Level], LevelOf], tight: float, miss: float
) -> dict[str, LatticeRun] | None:
    """A run of every agent alone; None where one has none."""
    runs = {}
    for name, agent in compiled.mission.agents.items():
        asserted: dict[int, list[tuple[Node, LevelOf]]] = {}
        witnesses: list[tuple[Witness, LevelOf]] = []
        for one in compiled.layout.encoded:
            level = level_of(one.level)
            for step, nodes in parts_by_step(one.formula, name).items():
                asserted.setdefault(step, []).extend((n, level) for n in nodes)
            top = conjuncts(one.formula)
            for node in top:
                found = Witness.of(node.args, name) if isinstance(node, Or) else None
                if found is not None:
                    witnesses.append((found, level))
        run = find_run(agent, compiled.ranges[name], asserted, witnesses, miss, tight)
        if run is None:
            return None
        runs[name] = run
    return runs


def slack(node: Node, states: Mapping[str, Floats], level: LevelOf) -> float:
    """By how much runs (T+1, n) reach an unrolled formula's level; -inf for what is not about
    states."""
    match node:
        case And(args=args):
            return min((slack(a, states, level) for a in args), default=np.inf)
        case Or(args=args):
            return max((slack(a, states, level) for a in args), default=-np.inf)
        case Linear(terms=terms) if all(s.role is Role.STATE for s, _ in terms):
            reached = sum(v * states[s.owner][s.shift, s.index] for s, v in terms)
            return float(node.constant + reached) - level(node.unit)
    return -np.inf
