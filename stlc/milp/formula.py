"""Unrolled formulas as rows. Every node is met in positive polarity, so implications suffice.

    and, asserted            each argument is asserted: rows only
    predicate, asserted      mu(x) >= margin, mu(x) >= s rho
    or, asserted             alternatives of `choice.py`, their literals add up to 1
    or below literals z      the same, adding up to the sum of z
    a node that different disjunctions share     one literal w of its own, w >= z for each use

Sound and complete: a run satisfies the formula at its level exactly when literals exist.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.errors import UsageError
from stlc.ir.nodes import And, Const, Linear, Link, Node, Not, Or, Role, Signal
from stlc.ir.rewrite import postorder
from stlc.milp.bounds import value_range
from stlc.milp.choice import Alternative, RowBlock, Terms
from stlc.milp.context import Context
from stlc.milp.goals import Goal, Level
from stlc.milp.links import LinkEncoder
from stlc.milp.model import Ints
from stlc.milp.selectors import Selector, add_selection
from stlc.mission import Requirement

_TOP = -1
_LARGEST_M = 1e6
_FEW = 4  # so few alternatives are always one-hot
_TINY = 1e-7  # coefficients below a solver's tolerance only harm


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """One requirement's formula and its literals, for reading a run back into the model.

    `choices[or_node]` are (alternative, column) of the exclusive literals made for it (one tuple
    for each place where it was expanded); `literals` are the nodes with a column of their own.
    """

    formula: Node
    level: Level
    choices: tuple[tuple[Or, tuple[tuple[Node, int], ...]], ...]
    literals: Mapping[Node, int]


@dataclass(slots=True)
class FormulaEncoder:
    """Encodes requirements one after the other into a context's builder."""

    ctx: Context
    rho: Mapping[Goal, int]  # column of each robustness goal
    links: LinkEncoder
    selector: Selector = Selector.ONE_HOT
    level: Level = field(default_factory=lambda: Level(0.0))
    _owners: dict[Node, frozenset[int]] = field(default_factory=dict)
    _literals: dict[Node, int] = field(default_factory=dict)
    _rows: RowBlock = field(default_factory=RowBlock)
    _choices: list[tuple[Or, tuple[tuple[Node, int], ...]]] = field(default_factory=list)

    def require(self, requirement: Requirement, level: Level) -> Encoded:
        """Assert a requirement's unrolled formula at its level."""
        self.level = level
        self._owners = _owners(requirement.formula)
        self._literals = {}
        self._rows, self._choices = RowBlock(), []
        self._assert(requirement.formula)
        self._rows.flush(self.ctx.builder, f"stl_{requirement.name}")
        return Encoded(requirement.formula, level, tuple(self._choices), dict(self._literals))

    def _assert(self, root: Node) -> None:
        todo = [root]
        while todo:
            node = todo.pop()
            match node:
                case Const(value=value):
                    if not value:
                        self._rows.add([], [], 1.0)
                case And(args=args):
                    todo.extend(reversed(args))
                case Linear():
                    self._demand({_TOP: [node]}, [])
                case Or():
                    self._choose(node, [])
                case Link() | Not():
                    self.links.assert_link(node, self.level)
                case _:
                    raise TypeError(f"{type(node).__name__} after unrolling")

    def _choose(self, node: Or, parents: Sequence[int]) -> None:
        """Alternatives of `node`, one of them taken when a parent literal is 1."""
        if any(_TOP in self._owners[a] for a in node.args):
            return  # one alternative is asserted elsewhere
        private = [a for a in node.args if not self._is_shared(a)]
        shared = [a for a in node.args if self._is_shared(a)]
        z = self._select(len(private), exclusive=not shared)
        cols = [*z, *(self._literal(a) for a in shared)]
        signs = [*np.ones(len(cols)), *-np.ones(len(parents))]
        total = 0.0 if parents else 1.0
        self._rows.add([*cols, *parents], signs, total, np.inf if shared else total)
        self._choices.append((node, tuple(zip(private, map(int, z), strict=True))))
        gathered = [self._gather(a) for a in private]
        if shared or self.selector is Selector.BIG_M:
            for column, alternative in zip(z, gathered, strict=True):
                self._demand({int(column): list(alternative.atoms)}, [])
        else:
            atoms = {int(c): list(a.atoms) for c, a in zip(z, gathered, strict=True)}
            self._demand(atoms, parents)
        self._descend(z, gathered, exclusive=not shared)

    def _select(self, size: int, *, exclusive: bool) -> Ints:
        if size == 0:
            return np.empty(0, np.int64)
        style = self.selector if exclusive and size > _FEW else Selector.ONE_HOT
        return add_selection(self.ctx.builder, "z", size, style)

    def _descend(
        self, z: Iterable[int], gathered: Sequence[Alternative], *, exclusive: bool
    ) -> None:
        needs: dict[Node, list[int]] = {}
        for column, alternative in zip(z, gathered, strict=True):
            for node in alternative.others:
                needs.setdefault(node, []).append(int(column))
        for node, columns in needs.items():
            if (
                isinstance(node, Or)
                and not self._is_shared(node)
                and (exclusive or len(columns) == 1)
            ):
                self._choose(node, columns)
                continue
            literal = self._literal(node)
            groups = [columns] if exclusive else [[c] for c in columns]
            for group in groups:
                self._rows.add([literal, *group], [1.0, *-np.ones(len(group))], 0.0)

    def _is_shared(self, node: Node) -> bool:
        return len(self._owners[node]) > 1 or isinstance(node, Link | Not)

    def _literal(self, node: Node) -> int:
        """Column w in {0, 1} with w = 1 => node; one for each node."""
        if node not in self._literals:
            self._literals[node] = self._new_literal(node)
        return self._literals[node]

    def _new_literal(self, node: Node) -> int:
        if isinstance(node, Link | Not):
            return self.links.literal(node, self.level)
        column = int(self.ctx.builder.binary("w", (1,))[0])
        if isinstance(node, Const):
            if not node.value:
                self._rows.add([column], [-1.0], 0.0)
            return column
        if isinstance(node, Or):
            self._choose(node, [column])
            return column
        alternative = self._gather(node, inside=True)
        self._demand({column: list(alternative.atoms)}, [])
        self._descend([column], [alternative], exclusive=True)
        return column

    def _gather(self, root: Node, *, inside: bool = False) -> Alternative:
        """What `root` demands, conjunctions opened down to shared nodes and disjunctions."""
        found = Alternative()
        todo = [root]
        while todo:
            node = todo.pop()
            if self._is_shared(node) and not (inside and node is root):
                if _TOP not in self._owners[node]:
                    found.others[node] = None
                continue
            match node:
                case Linear():
                    found.atoms[node] = None
                case And(args=args):
                    todo.extend(reversed(args))
                case Const(value=True):
                    continue
                case _:
                    found.others[node] = None
        return found

    def _demand(self, atoms: Mapping[int, Sequence[Linear]], parents: Sequence[int]) -> None:
        """Rows of the alternatives' predicates, grouped by direction and goal.

        `atoms[z]` are demanded by literal z, which exclude one another; `atoms[_TOP]` always.
        """
        groups: dict[tuple[Terms, str], dict[int, float]] = {}
        for column, predicates in atoms.items():
            for atom in predicates:
                group = groups.setdefault((atom.terms, atom.unit), {})
                group[column] = min(group.get(column, np.inf), atom.constant)
        for (terms, unit), constants in groups.items():
            least = value_range(Linear(terms, 0.0), self.ctx.ranges)[0]
            for goal in self.level.goals:
                self._row(terms, constants, least, goal, goal.scale(unit))
            if self.level.needs_margin(unit):
                self._row(terms, constants, least, None, 1.0)

    def _row(
        self,
        terms: Terms,
        constants: Mapping[int, float],
        least: float,
        goal: Goal | None,
        scale: float,
    ) -> None:
        base = self.level.margin if goal is None else 0.0
        slack = least - (0.0 if goal is None else scale * goal.high)
        cols = [self._signal(signal) for signal, _ in terms]
        values = [value for _, value in terms]
        if goal is not None:
            cols.append(self.rho[goal])
            values.append(-scale)
        if _TOP in constants:
            self._rows.add(cols, values, base - constants[_TOP])
            return
        demands = {z: base - constant for z, constant in constants.items()}
        binding = {z: v for z, v in demands.items() if v > slack + _TINY}
        if not binding:
            return
        self._check_size(max(v - slack for v in binding.values()), terms)
        self._rows.add([*cols, *binding], [*values, *(slack - v for v in binding.values())], slack)

    def _check_size(self, big: float, terms: Terms) -> None:
        if big >= _LARGEST_M or not np.isfinite(big):
            names = ", ".join(f"{s.owner}.{s.role.value}[{s.index}]" for s, _ in terms)
            raise UsageError(
                f"a predicate over {names} ranges over {big:.3g}: declare bounds for these signals"
            )

    def _signal(self, signal: Signal) -> int:
        block = self.ctx.states if signal.role is Role.STATE else self.ctx.inputs
        return int(block[signal.owner][signal.shift, signal.index])


def _owners(root: Node) -> dict[Node, frozenset[int]]:
    """For each node the disjunctions (by number) that reach it through conjunctions only.

    At most two are kept: what matters is whether there is one or more.
    """
    order = list(postorder([root]))
    number = {node: k for k, node in enumerate(order)}
    owners: dict[Node, set[int]] = {node: set() for node in order}
    owners[root].add(_TOP)
    for node in reversed(order):
        given = {number[node]} if isinstance(node, Or) else owners[node]
        for child in node.children:
            if len(owners[child]) < 2 or _TOP in given:
                owners[child] |= given
    return {node: frozenset(found) for node, found in owners.items()}
