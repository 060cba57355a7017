"""What a pass is: a named rewrite of a program, with a contract and its predecessors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from stlc.ir.nodes import Node
from stlc.ir.verify import Stage
from stlc.milp.context import Ranges
from stlc.mission import ObjectiveTerm, Requirement, TermKind


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """The requirements on their way to the encoder.

    `ranges` are sound for every run that satisfies the mission; `objective` only its robustness
    terms matter here.
    """

    requirements: tuple[Requirement, ...]
    horizon: int
    ranges: Mapping[str, Ranges] = field(default_factory=dict)
    objective: tuple[ObjectiveTerm, ...] = ()

    def with_formulas(self, formulas: Sequence[Node]) -> Program:
        """The same program over other formulas."""
        pairs = zip(self.requirements, formulas, strict=True)
        return replace(
            self, requirements=tuple(replace(r, formula=f) for r, f in pairs)
        )

    @property
    def formulas(self) -> tuple[Node, ...]:
        """The formulas, one for each requirement."""
        return tuple(r.formula for r in self.requirements)

    @property
    def robust_terms(self) -> tuple[ObjectiveTerm, ...]:
        """Objective terms that speak of robustness."""
        return tuple(t for t in self.objective if t.kind is TermKind.ROBUSTNESS)


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
