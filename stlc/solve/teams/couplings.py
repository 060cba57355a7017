"""Which agents of a team have to do with each other, and which runs get along.

Read off the unrolled formulas of the receipts: a requirement falls into conjuncts, and each of
them speaks of some agents. Two agents that share nothing but predicates on their states and inputs
(separation) matter to each other only where their runs violate those; links, link costs and
conjuncts about three agents and more bind agents whatever their runs are.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import And, Const, Linear, Link, Node, Or, Role, walk
from stlc.ir.rewrite import named
from stlc.milp.compile import Compiled
from stlc.mission import TermKind
from stlc.solve.alone.run import Run

_BINDING = Link | Count | Network
MISS = 1e-6  # what a certified plan may miss a predicate by

Pair = frozenset[str]


@dataclass(frozen=True, slots=True, eq=False)
class Couplings:
    """`apart[{a, b}]`: conjuncts over the states of two agents, with their margins.
    `bound[a]`: the agents that a is bound to."""

    apart: Mapping[Pair, tuple[tuple[Node, float], ...]]
    bound: Mapping[str, frozenset[str]]

    @staticmethod
    def of(compiled: Compiled) -> Couplings:
        """Those of a compiled mission."""
        agents = frozenset(compiled.mission.agents)
        apart: dict[Pair, list[tuple[Node, float]]] = {}
        bound: dict[str, frozenset[str]] = dict.fromkeys(agents, frozenset())
        for names, node, margin in _conjuncts(compiled):
            known = names & agents
            if len(known) == 2 and not any(isinstance(n, _BINDING) for n in walk(node)):
                apart.setdefault(known, []).append((node, margin))
            else:
                _bind(bound, known)
        for pair in _priced(compiled):
            _bind(bound, pair & agents)
        return Couplings({pair: tuple(nodes) for pair, nodes in apart.items()}, bound)

    def partners(self, name: str) -> frozenset[str]:
        """Everyone an agent shares a conjunct or a cost with."""
        near = {other for pair in self.apart if name in pair for other in pair}
        return (self.bound[name] | near) - {name}

    def get_along(self, one: str, other: str, runs: Mapping[str, Run]) -> bool:
        """Whether two runs satisfy what the two agents share of predicates on their states."""
        parts = self.apart.get(frozenset((one, other)), ())
        return all(value(node, runs) >= margin - MISS for node, margin in parts)


def groups_of(compiled: Compiled) -> list[tuple[str, ...]]:
    """The team's groups, agents in their order, the group of the first agent first."""
    couplings = Couplings.of(compiled)
    found: list[tuple[str, ...]] = []
    left = dict.fromkeys(compiled.mission.agents)
    while left:
        group, todo = set[str](), [next(iter(left))]
        while todo:
            name = todo.pop()
            if name not in group:
                group.add(name)
                todo.extend(couplings.partners(name))
        found.append(tuple(name for name in left if name in group))
        left = {name: None for name in left if name not in group}
    return found


def _bind(bound: dict[str, frozenset[str]], names: Pair) -> None:
    for name in names:
        bound[name] |= names - {name}


def _conjuncts(compiled: Compiled) -> Iterator[tuple[Pair, Node, float]]:
    """Conjuncts of all requirements, with the names they speak of."""
    for encoded in compiled.layout.encoded:
        todo = [encoded.formula]
        while todo:
            node = todo.pop()
            if isinstance(node, And):
                todo.extend(node.args)
            else:
                names = frozenset(name for n in walk(node) for name in named(n))
                yield names, node, encoded.level.margin


def _priced(compiled: Compiled) -> Iterable[Pair]:
    """Pairs whose link costs; everyone together where robustness is worth something."""
    for term in compiled.mission.objective:
        if term.kind is TermKind.LINK_COST and term.weight != 0:
            yield from (frozenset(pair) for pair in term.pairs)
        if term.kind is TermKind.ROBUSTNESS:
            yield frozenset(compiled.mission.agents)


def value(node: Node, runs: Mapping[str, Run]) -> float:
    """Robustness on these runs of an unrolled formula of predicates on states and inputs."""
    match node:
        case And(args=args):
            return min(value(a, runs) for a in args)
        case Or(args=args):
            return max(value(a, runs) for a in args)
        case Const(value=truth):
            return math.inf if truth else -math.inf
        case Linear(terms=terms, constant=constant):
            return constant + sum(
                float(v * runs[s.owner][0 if s.role is Role.STATE else 1][s.shift, s.index])
                for s, v in terms
            )
    raise TypeError(f"{type(node).__name__} among predicates on states and inputs")
