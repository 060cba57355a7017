"""What a pass is: a named rewrite of a program, with a contract and its predecessors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from stlc.analysis.bounds import Interval
from stlc.analysis.goals import Goal, Level, goals_of
from stlc.analysis.link_tables import LinkTables
from stlc.analysis.ranges import Ranges
from stlc.ir.nodes import Link, Node, Not
from stlc.ir.requirement import Requirement
from stlc.ir.verify import Stage
from stlc.mission import Mission


@dataclass(frozen=True, slots=True, eq=False)
class Decided:
    """What is known of nodes over certain `ranges`: their static bounds, and for each level those
    in which nothing is left to decide."""

    ranges: Mapping[str, Ranges] = field(default_factory=dict)
    bounds: dict[Node, Interval] = field(default_factory=dict)
    settled: dict[Level, set[Node]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """The requirements on their way to the encoder.

    `ranges` are sound for every run that satisfies the mission (empty before they are known).
    """

    requirements: tuple[Requirement, ...]
    mission: Mission
    ranges: Mapping[str, Ranges] = field(default_factory=dict)
    tables: LinkTables | None = None
    goals: tuple[Goal, ...] = ()
    decided: Decided = field(default_factory=Decided)

    def known_goals(self) -> tuple[Goal, ...]:
        """Robustness columns with the best ends that the ranges and earlier passes give."""
        return goals_of(self.mission, self.requirements, self.ranges, self.link_bounds, self.goals)

    def with_formulas(self, formulas: Sequence[Node]) -> Program:
        """The same program over other formulas."""
        pairs = zip(self.requirements, formulas, strict=True)
        return replace(self, requirements=tuple(replace(r, formula=f) for r, f in pairs))

    @property
    def formulas(self) -> tuple[Node, ...]:
        """The formulas, one for each requirement."""
        return tuple(r.formula for r in self.requirements)

    def link_bounds(self, node: Link | Not) -> tuple[float, float]:
        """Static bounds of a link predicate's robustness."""
        if self.tables is None:
            return -math.inf, math.inf
        return self.tables.bounds(node, self.ranges)

    @property
    def horizon(self) -> int:
        """T: steps 0..T."""
        return self.mission.horizon


@dataclass(frozen=True, slots=True)
class Pass:
    """One rewrite. `after` names passes that must come earlier; `stage` is what it establishes.

    A `lowering` is needed by the encoder; the others can be switched off. `preserves` says what
    stays the same: "robustness" of each requirement at step 0 on every run, or the set of
    "optima" (robustness capped by what the objective can use).
    """

    name: str
    run: Callable[[Program], Program]
    after: tuple[str, ...] = ()
    stage: Stage = Stage.ANY
    lowering: bool = False
    preserves: str = "robustness"
