"""What a person asks of a solve, and what comes of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stlc.backends.base import Solution

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled, CompileOptions
    from stlc.plan import Plan
    from stlc.verify import Report


@dataclass(frozen=True, slots=True)
class SolveSettings:
    """How to solve. Limits in seconds, gap relative; the same words for every backend.

    `strategy` "auto" may bound and search ahead of the solver, "milp" is one plain solve.
    `save_to` is kept up to date with the best verified plan while the solver works. `grace` [s]
    is what a solver may overrun its time limit, or a wish to stop, before it is left behind in its
    thread; None waits for it. `threads` are those of the solver, and the processes that make the
    small solves of searches; `cluster` is the address of one that makes these instead.
    `tier_gap` is that of tiers of preferences before the last; None is `gap`. Without `doubted` a
    claim that there is no plan is passed on as it is, for whoever has a use for it either way.
    """

    backend: str = "highs"
    compile: CompileOptions | None = None
    strategy: str = "auto"
    time_limit: float | None = None
    gap: float = 1e-4
    threads: int | None = None
    seed: int | None = None
    start: Plan | None = None
    confirm: bool = False
    save_to: Path | None = None
    extra: dict[str, object] = field(default_factory=dict)
    grace: float | None = None
    cluster: str | None = None
    tier_gap: float | None = None
    doubted: bool = True


@dataclass(frozen=True, slots=True)
class Outcome:
    """A certified plan and how it was come by.

    `confirmation` is a second solver's word; `refused` says which solver's answer was refused when
    the plan is another's, found after it.
    """

    plan: Plan
    report: Report
    compiled: Compiled
    solution: Solution
    seconds: dict[str, float]
    confirmation: str | None = None
    refused: str | None = None

    def as_dict(self) -> dict[str, Any]:
        """What `stlc solve --json` prints."""
        info, m = self.plan.solve, self.compiled.model
        return {
            "status": info.status,
            "sense": info.sense.value,
            "objective": info.objective,
            "bound": info.bound,
            "gap": info.gap,
            "backend": info.backend,
            "solver_version": info.solver,
            "encoding": info.encoding,
            "columns": m.columns,
            "binaries": m.binaries,
            "rows": m.rows,
            "nonzeros": m.nonzeros,
            "nodes": self.solution.nodes,
            "seconds": self.seconds,
            "certified": self.plan.certificate.checked is not None,
            "verified": self.report.ok,
            "notes": list(self.report.notes),
            "robustness": {r.name: r.robustness for r in self.plan.requirements},
            "preferences": [p.as_dict() for p in self.report.preferences],
            "ignored": list(self.solution.ignored),
            "confirmation": self.confirmation,
            "refused": self.refused,
        }
