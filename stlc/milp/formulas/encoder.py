"""Unrolled formulas as rows. Every node is met in positive polarity, so implications suffice.

    and, asserted            each argument is asserted: rows only
    predicate, asserted      mu(x) >= margin, mu(x) >= s rho
    or, asserted             alternatives of `choice.py`, their literals add up to 1
    or below literals z      the same, adding up to the sum of z
    count, network       see `networks.py`, over literals of its arguments
    a node that different disjunctions share     one literal w of its own, w >= z for each use

Sound and complete: a run satisfies the formula at its level exactly when literals exist.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stlc.analysis.goals import Goal, Level
from stlc.arrays import Ints
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import And, Const, Linear, Link, Node, Not, Or
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import postorder
from stlc.milp.context import Context
from stlc.milp.formulas.auto import choose
from stlc.milp.formulas.choice import Alternative, Faces
from stlc.milp.formulas.link_predicates import LinkEncoder
from stlc.milp.formulas.networks import NetworkRows
from stlc.milp.formulas.selectors import ONE_HOT, FormulaEncoding
from stlc.milp.layout import Encoded

_TOP = -1
_Visit = Generator[Any, Any, int]
"""A visit of a node: yields the visits it needs done, is sent the columns that they return."""
_NONE = np.empty(0, np.int64)


@dataclass(slots=True)
class FormulaEncoder:
    """Encodes requirements one after the other into a context's builder."""

    ctx: Context
    rho: Mapping[Goal, int]  # column of each robustness goal
    links: LinkEncoder
    encoding: FormulaEncoding | None = None  # None: chosen for each disjunction
    level: Level = field(default_factory=lambda: Level(0.0))
    reasons: Counter[str] = field(default_factory=Counter)
    _faces: Faces = field(init=False)
    _owners: dict[Node, frozenset[int]] = field(default_factory=dict)
    _literals: dict[Node, int] = field(default_factory=dict)
    _choices: list[tuple[Or, tuple[tuple[Node, int], ...]]] = field(default_factory=list)
    _derived: list[Ints] = field(default_factory=list)

    def require(self, requirement: Requirement, level: Level) -> Encoded:
        """Assert a requirement's unrolled formula at its level."""
        self.level = level
        self._owners = _owners(requirement.formula)
        self._literals = {}
        self._faces = Faces(self.ctx, self.rho, level)
        self._choices, self._derived = [], []
        self._assert(requirement.formula)
        self._faces.rows.flush(self.ctx.builder, f"stl_{requirement.name}")
        derived = np.concatenate([_NONE, *self._derived])
        choices = tuple(self._choices)
        return Encoded(requirement.formula, level, choices, dict(self._literals), derived)

    def _assert(self, root: Node) -> None:
        """Require a formula outright: predicates become rows, disjunctions choices, without
        literals above them."""
        todo = [root]
        while todo:
            node = todo.pop()
            match node:
                case Const(value=value):
                    if not value:
                        self._faces.rows.add([], [], 1.0)
                case And(args=args):
                    todo.extend(reversed(args))
                case Linear():
                    self._faces.hold([node])
                case Or():
                    _walk(self._choose(node, []))
                case Count() | Network():
                    _walk(self._network(node, None))
                case Link() | Not():
                    self.links.assert_link(node, self.level)
                case _:
                    raise TypeError(f"{type(node).__name__} after unrolling")

    def _choose(self, node: Or, parents: Sequence[int]) -> _Visit:
        """Alternatives of `node`, one of them taken when a parent literal is 1."""
        if any(_TOP in self._owners[a] for a in node.args):
            return _TOP  # one alternative is asserted elsewhere
        private = [a for a in node.args if not self._is_shared(a)]
        shared = [a for a in node.args if self._is_shared(a)]
        gathered = [self._gather(a) for a in private]
        z = self._encode([list(g.atoms) for g in gathered], parents, exclusive=not shared)
        cols = [int(column) for column in z]
        for a in shared:
            cols.append((yield self._literal(a)))
        signs = [*np.ones(len(cols)), *-np.ones(len(parents))]
        total = 0.0 if parents else 1.0
        self._faces.rows.add([*cols, *parents], signs, total, np.inf if shared else total)
        self._choices.append((node, tuple(zip(private, map(int, z), strict=True))))
        yield self._descend(z, gathered, exclusive=not shared)
        return _TOP

    def _encode(
        self, predicates: Sequence[Sequence[Linear]], parents: Sequence[int], *, exclusive: bool
    ) -> Ints:
        """Literals of the alternatives and the rows that they switch on."""
        if not exclusive:
            if not predicates:
                return _NONE
            z = ONE_HOT.literals(self.ctx.builder, len(predicates)).columns
            for column, own in zip(z, predicates, strict=True):
                self._faces.shared([int(column)], [own])
            return z
        encoding, reason = self.encoding, "asked for"
        if encoding is None:
            encoding, reason = choose(predicates)
        self.reasons[f"{encoding.name}, {reason}"] += 1
        literals = encoding.literals(self.ctx.builder, len(predicates))
        self._derived.append(literals.derived)
        encoding.add_rows(self._faces, literals.columns, predicates, parents)
        return literals.columns

    def _descend(
        self, z: Iterable[int], gathered: Sequence[Alternative], *, exclusive: bool
    ) -> _Visit:
        """Make literals z imply what their alternatives hold beside predicates. Where at most one
        of z is 1 (`exclusive`), one row serves all that need the same node."""
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
                yield self._choose(node, columns)
                continue
            literal = yield self._literal(node)
            groups = [columns] if exclusive else [[c] for c in columns]
            for group in groups:
                self._faces.rows.add([literal, *group], [1.0, *-np.ones(len(group))], 0.0)
        return _TOP

    def _is_shared(self, node: Node) -> bool:
        return len(self._owners[node]) > 1 or isinstance(node, Link | Not | Count | Network)

    def _literal(self, node: Node) -> _Visit:
        """Column w in {0, 1} with w = 1 => node; one for each node."""
        if node not in self._literals:
            self._literals[node] = yield self._new_literal(node)
        return self._literals[node]

    def _new_literal(self, node: Node) -> _Visit:
        """A column that is 1 only where the node holds to its level (the converse isn't needed)."""
        if isinstance(node, Link | Not):
            return self.links.literal(node, self.level)
        column = int(self.ctx.builder.binary("w", (1,))[0])
        if isinstance(node, Const):
            if not node.value:
                self._faces.rows.add([column], [-1.0], 0.0)
            return column
        if isinstance(node, Or):
            yield self._choose(node, [column])
            return column
        if isinstance(node, Count | Network):
            yield self._network(node, column)
            return column
        alternative = self._gather(node, inside=True)
        self._faces.shared([column], [list(alternative.atoms)])
        yield self._descend([column], [alternative], exclusive=True)
        return column

    def _network(self, node: Count | Network, z: int | None) -> _Visit:
        """Rows that make a count or network hold where z is 1 (always, for z None)."""
        rows = NetworkRows(self.ctx.builder, self._faces.rows)
        if isinstance(node, Network) and node.composed:
            self.links.compose(node, self.level, z, rows)
            return _TOP
        literals = []
        for arg in node.args:
            literals.append((yield self._literal(arg)))
        if isinstance(node, Count):
            rows.count(node, literals, z)
        else:
            rows.network(node, literals, z)
        return _TOP

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


def _walk(visit: _Visit) -> None:
    """Make a visit; those within it wait on a list, so that depth has no limit."""
    open_: list[_Visit] = [visit]
    answer: int | None = None  # of the visit that has just ended
    while open_:
        try:
            inner = open_[-1].send(answer)
        except StopIteration as end:
            open_.pop()
            answer = end.value
        else:
            open_.append(inner)
            answer = None


def _owners(root: Node) -> dict[Node, frozenset[int]]:
    """For each node the disjunctions (by number) that reach it through conjunctions only.

    At most two are kept: what matters is whether there is one or more.
    """
    order = list(postorder([root]))
    number = {node: k for k, node in enumerate(order)}
    owners: dict[Node, set[int]] = {node: set() for node in order}
    owners[root].add(_TOP)
    for node in reversed(order):
        given = {number[node]} if isinstance(node, Or | Count | Network) else owners[node]
        for child in node.children:
            if len(owners[child]) < 2 or _TOP in given:
                owners[child] |= given
    return {node: frozenset(found) for node, found in owners.items()}
