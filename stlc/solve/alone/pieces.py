"""Requirements as conjuncts, with the names that each speaks of.

    always[a,b] (f and g)  =  always[a,b] f and always[a,b] g

Whoever asks what a mission asks of a few agents looks at their conjuncts alone: of many agents
that all keep apart, each has to do with few of the pairs.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

from stlc.ir.nodes import Always, And, Node, walk
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import named
from stlc.mission import Mission
from stlc.passes import nnf
from stlc.passes.base import Program


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Conjuncts (in negation normal form, with their names) of each requirement of a mission."""

    parts: tuple[tuple[Requirement, tuple[tuple[Node, frozenset[str]], ...]], ...]

    @staticmethod
    def of(mission: Mission) -> Pieces:
        """Those of a mission."""
        program = nnf.run(Program(mission.requirements, mission))
        return Pieces(tuple(
            (one, tuple((node, _names(node)) for node in _conjuncts(one.formula)))
            for one in program.requirements
        ))  # fmt: skip

    def about(self, team: Collection[str]) -> Iterator[Requirement]:
        """What the requirements ask that any agent of the team is named in."""
        for requirement, conjuncts in self.parts:
            kept = [node for node, names in conjuncts if not names.isdisjoint(team)]
            if len(kept) == len(conjuncts):
                yield requirement
            elif kept:
                formula = kept[0] if len(kept) == 1 else And(tuple(kept))
                yield replace(requirement, formula=formula)


def _names(root: Node) -> frozenset[str]:
    return frozenset(name for node in walk(root) for name in named(node))


def _conjuncts(root: Node) -> Iterator[Node]:
    """What has to hold together, in order; `always` of a conjunction falls apart."""
    todo = [root]
    while todo:
        node = todo.pop()
        match node:
            case And(args=args):
                todo.extend(reversed(args))
            case Always(arg=And(args=args)):
                todo.extend(replace(node, arg=arg) for arg in reversed(args))
            case _:
                yield node
