"""What each encoder put where: the receipts that searches around a Model read.

Encoders return or record these while a model is built; nothing about a Model is ever learnt from
names of its blocks or from the pattern of its matrix. Third-party encodings hand over the same
receipts (`Literals` for a choice, `PairColumns` for cell pairs), and the conformance suite of
encodings checks them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.analysis.goals import Level
from stlc.arrays import Ints
from stlc.ir.flat import Flat, flattened, restored
from stlc.ir.nodes import Node, Or

_NONE = np.empty(0, np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Literals:
    """Columns z (k,) of a choice, 0 or 1 at integer points, one for each alternative.

    `derived` are further integer columns that follow from z: whoever fixes z has fixed them.
    """

    columns: Ints
    derived: Ints = field(default_factory=lambda: _NONE)


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """One requirement's formula and its literals.

    `choices[or_node]` are (alternative, column) of the exclusive literals made for it (one tuple
    for each place where it was expanded); `literals` are the nodes with a column of their own;
    `derived` are integer columns that follow from those.
    """

    formula: Node
    level: Level
    choices: tuple[tuple[Or, tuple[tuple[Node, int], ...]], ...]
    literals: Mapping[Node, int]
    derived: Ints

    def __reduce__(self) -> tuple[object, ...]:
        """Formulas may be deeper than pickle follows: they travel as lists of nodes."""
        flat, number = flattened(self.formula)
        choices = [
            (number[node], [(number[a], column) for a, column in pairs])
            for node, pairs in self.choices
        ]
        literals = {number[node]: column for node, column in self.literals.items()}
        return _encoded, (flat, self.level, choices, literals, self.derived)

    def whole_choices(self) -> Iterable[tuple[Or, Ints]]:
        """Disjunctions each of whose alternatives has a literal here, with those literals."""
        for node, pairs in self.choices:
            if len(pairs) == len(node.args):
                yield node, np.array([column for _, column in pairs], np.int64)


def _encoded(
    flat: Flat,
    level: Level,
    choices: Sequence[tuple[int, Sequence[tuple[int, int]]]],
    literals: Mapping[int, int],
    derived: Ints,
) -> Encoded:
    """The receipt in nodes of the formula, not numbers in `flat` (whose last is the root)."""
    nodes = restored(flat)
    made = []
    for number, pairs in choices:
        node = nodes[number]
        assert isinstance(node, Or)
        made.append((node, tuple((nodes[k], column) for k, column in pairs)))
    named = {nodes[k]: column for k, column in literals.items()}
    return Encoded(nodes[-1], level, tuple(made), named, derived)


@dataclass(frozen=True, slots=True, eq=False)
class PairColumns:
    """The columns (k_a, k_b) of two ends' cells in reach at a step; cells number the partition.

    `beside`: ends that, on a border, may count as in another touching cell than the first link
    cost of that agent and step takes.
    """

    ends: tuple[str, str]
    step: int
    partition: bytes
    cells: tuple[Ints, Ints]
    columns: Ints
    beside: tuple[bool, bool]


@dataclass(slots=True, eq=False)
class Layout:
    """Receipts of one compiled mission.

    states[agent] (T+1, n) and inputs[agent] (T, m) are columns; dynamics[agent] (T, n) the rows
    of x(t+1) = A x(t) + B u(t) + drift; effort[agent] the columns that price its states and
    inputs and nothing else; `encoded` one entry for each requirement; `stand_ins` are agents that
    the compiler made up and no plan has.
    """

    states: dict[str, Ints] = field(default_factory=dict)
    inputs: dict[str, Ints] = field(default_factory=dict)
    dynamics: dict[str, Ints] = field(default_factory=dict)
    effort: dict[str, Ints] = field(default_factory=dict)
    encoded: tuple[Encoded, ...] = ()
    pairs: list[PairColumns] = field(default_factory=list)
    stand_ins: frozenset[str] = frozenset()

    def add_effort(self, agent: str, columns: Ints) -> None:
        """Note columns that price this agent alone."""
        known = self.effort.get(agent, _NONE)
        self.effort[agent] = np.union1d(known, columns).astype(np.int64)

    @property
    def derived(self) -> Ints:
        """Integer columns that follow from the literals of formulas."""
        return np.concatenate([_NONE, *(one.derived for one in self.encoded)])
