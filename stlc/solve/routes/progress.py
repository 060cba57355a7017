"""The progress of a mission along a run: what an unrolled formula still asks for.

A formula over steps 0..T is rewritten by what holds at each step (formula progression: Bacchus and
Kabanza, Planning for temporally extended goals, 1998). *Atoms* are its largest parts that speak of
one step, or of the motion from one step to the next; what is left between them is a conjunction of
*obligations*. An obligation enters a progress when its first atom is judged, leaves it when it is
fulfilled, and goes where another one implies it, so that a periodic visit is one deadline and an
`until` one bit: the states of an automaton that is never written down.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.arrays import Bools
from stlc.ir.nodes import And, Const, Linear, Link, Node, Or, Role

TRUE, FALSE = 0, 1
Open = frozenset[int]
"""Obligations that are under way, as numbers of their formulas."""


@dataclass(frozen=True, slots=True, eq=False)
class Atom:
    """A part that is judged at `step`, of the states there, or `moving` from the step before."""

    node: Node
    step: int
    moving: bool
    source: int  # which requirement: its level is asked


def span_of(node: Node) -> tuple[int, int]:
    """First step that a formula speaks of, and the step at which all of it is known."""
    first, last, todo = 1 << 30, -1, [node]
    while todo:
        part = todo.pop()
        if isinstance(part, Linear):
            for signal, _ in part.terms:
                first = min(first, signal.shift)
                last = max(last, signal.shift + (signal.role is Role.INPUT))
        elif isinstance(part, Link):
            first, last = min(first, part.shift), max(last, part.shift)
        todo.extend(part.children)
    return first, last


def _is_of_steps(node: Node) -> bool:
    """Whether a formula is a conjunction of what is judged at different steps."""
    return isinstance(node, And) and len({span_of(part) for part in node.args}) > 1


def _by_step(node: Node) -> list[Node]:
    """The parts of a formula, those of a conjunction that ask of the same step as one: together
    they may keep an agent in a box where each keeps it on one side of a line."""
    if not isinstance(node, And):
        return list(node.children)
    groups: dict[tuple[int, int], list[Node]] = {}
    for part in node.args:
        groups.setdefault(span_of(part), []).append(part)
    found = list[Node]()
    for (start, end), parts in groups.items():
        joined = len(parts) > 1 and 0 <= end <= start + 1
        found.extend([And(tuple(parts))] if joined else parts)
    return found


@dataclass(slots=True, eq=False)
class Progress:
    """Formulas as numbers: TRUE, FALSE, atoms, conjunctions and disjunctions of numbers.

    `asserted[t]` are atoms that must hold at step t; `starting[t]` obligations whose first atom is
    judged there; `atoms_at[t]` the other atoms of step t, in a fixed order. `apart`: a conjunction
    of what is asked of a step and of the next is two atoms.
    """

    apart: bool = False
    parts: list[tuple[str, frozenset[int]]] = field(default_factory=list)
    first: list[int] = field(default_factory=list)
    atoms: dict[int, Atom] = field(default_factory=dict)
    asserted: dict[int, list[int]] = field(default_factory=dict)
    starting: dict[int, list[int]] = field(default_factory=dict)
    atoms_at: dict[int, list[int]] = field(default_factory=dict)
    _numbers: dict[tuple[object, ...], int] = field(default_factory=dict)

    @staticmethod
    def of(formulas: Iterable[tuple[Node, int]], *, apart: bool = False) -> Progress:
        """Of formulas that all hold, each with the number of its requirement."""
        made = Progress(apart)
        made._number(("true",), "true", frozenset(), 1 << 30)
        made._number(("false",), "false", frozenset(), 1 << 30)
        todo = list(formulas)
        while todo:
            node, source = todo.pop()
            if isinstance(node, And):
                todo.extend((arg, source) for arg in node.args)
            else:
                made._assert(node, source)
        for number, atom in made.atoms.items():
            if number not in made.asserted.get(atom.step, ()):
                made.atoms_at.setdefault(atom.step, []).append(number)
        return made

    def _assert(self, node: Node, source: int) -> None:
        number = self._formula(node, source, {})
        if number in self.atoms:
            self.asserted.setdefault(self.atoms[number].step, []).append(number)
        elif number != TRUE:
            first = 0 if number == FALSE else self.first[number]
            self.starting.setdefault(first, []).append(number)

    def _formula(self, node: Node, source: int, done: dict[Node, int]) -> int:
        """The number of a formula here: an atom where it asks of one step, else its parts."""
        if node in done:
            return done[node]
        start, end = span_of(node)
        if end < 0:
            found = self._settled(node, source, done)
        elif end - start <= 1 and not (self.apart and _is_of_steps(node)):
            key = ("atom", node, source)
            known = key in self._numbers
            found = self._number(key, "atom", frozenset(), end)
            if not known:
                self.atoms[found] = Atom(node, end, start < end, source)
        else:
            args = [self._formula(arg, source, done) for arg in _by_step(node)]
            found = self._joined("or" if isinstance(node, Or) else "and", args)
        done[node] = found
        return found

    def _settled(self, node: Node, source: int, done: dict[Node, int]) -> int:
        """A formula that speaks of no step: constants by their value, others judged at step 0."""
        if isinstance(node, Const):
            return TRUE if node.value else FALSE
        if isinstance(node, And | Or):
            kind = "or" if isinstance(node, Or) else "and"
            return self._joined(kind, [self._formula(arg, source, done) for arg in node.args])
        found = self._number(("atom", node, source), "atom", frozenset(), 0)
        self.atoms[found] = Atom(node, 0, False, source)
        return found

    def _number(self, key: tuple[object, ...], kind: str, args: frozenset[int], first: int) -> int:
        if key not in self._numbers:
            self._numbers[key] = len(self.parts)
            self.parts.append((kind, args))
            self.first.append(first)
        return self._numbers[key]

    def _joined(self, kind: str, args: Iterable[int]) -> int:
        """A conjunction or disjunction: flat, without neutral parts, absorbing parts at once."""
        neutral, absorbing = (TRUE, FALSE) if kind == "and" else (FALSE, TRUE)
        flat: set[int] = set()
        for arg in args:
            if arg == absorbing:
                return absorbing
            if self.parts[arg][0] == kind:
                flat |= self.parts[arg][1]
            elif arg != neutral:
                flat.add(arg)
        if len(flat) < 2:
            return flat.pop() if flat else neutral
        key = frozenset(flat)
        return self._number((kind, key), kind, key, min(self.first[a] for a in flat))

    def after(
        self, open_: Open, step: int, holds: Mapping[int, bool], done: dict[int, int]
    ) -> Open | None:
        """What is open after a step at which these atoms hold; None: it cannot be fulfilled.

        `done` is a memo of this step and these atoms.
        """
        left: set[int] = set()
        for number in (*open_, *self.starting.get(step, ())):
            rest = self._rest(number, step, holds, done)
            if rest == FALSE:
                return None
            if self.parts[rest][0] == "and":
                left |= self.parts[rest][1]
            elif rest != TRUE:
                left.add(rest)
        return self._without_implied(left)

    def eased(self, opens: Sequence[Open]) -> Bools:
        """(k, k): whether the first asks for nothing that the second does not ask for too."""
        numbers = sorted({n for open_ in opens for n in open_})
        place = {n: k for k, n in enumerate(numbers)}
        member = np.zeros((len(opens), len(numbers)), bool)
        for row, open_ in zip(member, opens, strict=True):
            row[[place[n] for n in open_]] = True
        implies = np.eye(len(numbers), dtype=bool)
        alternatives = [self._alternatives(n) for n in numbers]
        for i, all_ in enumerate(alternatives):
            implies[i] |= np.array([some <= all_ for some in alternatives], bool)
        given = (member.astype(np.float32) @ implies.T.astype(np.float32)) > 0
        missing = member.astype(np.float32) @ (~given).T.astype(np.float32)
        return np.asarray(missing == 0)

    def _alternatives(self, number: int) -> frozenset[int]:
        kind, args = self.parts[number]
        return args if kind == "or" else frozenset((number,))

    def _rest(self, number: int, step: int, holds: Mapping[int, bool], done: dict[int, int]) -> int:
        """What is left of formula `number` after `step`, given which atoms held (progression)."""
        if self.first[number] > step:
            return number
        if number not in done:
            kind, args = self.parts[number]
            if kind == "atom":
                done[number] = TRUE if holds[number] else FALSE
            else:
                rests = [self._rest(arg, step, holds, done) for arg in args]
                done[number] = self._joined(kind, rests)
        return done[number]

    def _without_implied(self, left: set[int]) -> Open:
        """Drop disjunctions that hold as soon as one with fewer alternatives does."""
        ors = sorted((len(self.parts[k][1]), k) for k in left if self.parts[k][0] == "or")
        kept: list[frozenset[int]] = []
        for _, number in ors:
            args = self.parts[number][1]
            if any(small <= args for small in kept) or not args.isdisjoint(left):
                left.discard(number)
            else:
                kept.append(args)
        return frozenset(left)
