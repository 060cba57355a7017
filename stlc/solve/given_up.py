"""What keeping a preference that was given up would have cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from stlc.errors import InfeasibleError, NoPlanError, SolverError
from stlc.ir.requirement import Requirement
from stlc.mission import Mission
from stlc.preferences import Preference
from stlc.solve.driver import solve_mission
from stlc.solve.events import ignore
from stlc.solve.outcome import Outcome, SolveSettings


@dataclass(frozen=True, slots=True)
class Price:
    """The objective with one preference kept, by a plan of its own; what is said where there is
    none: `proven` that no plan keeps it, or not found out in time. `others` are preferences that
    such a plan gives up instead and the plan at hand keeps."""

    name: str
    objective: float | None
    proven: bool
    others: tuple[str, ...] = ()

    def text(self, now: float) -> str:
        """For a person; `now` is the objective of the plan at hand."""
        if self.objective is None:
            unknown = "what keeping it costs wasn't found in time"
            why = "no plan keeps it" if self.proven else unknown
            return f"{self.name}: {why}"
        bound = "" if self.proven else " or better"
        instead = f", giving up {', '.join(self.others)}" if self.others else ""
        return (
            f"{self.name}: keeping it makes the objective {self.objective:.6g}{bound} in place of "
            f"{now:.6g}{instead}"
        )


def prices(
    mission: Mission,
    outcome: Outcome,
    settings: SolveSettings,
    seconds: float,
    should_stop: Callable[[], bool] | None = None,
) -> tuple[Price, ...]:
    """For each preference that the plan gives up, the best plan that keeps it: it becomes a
    requirement, everything else stays. Each takes `seconds` at most."""
    lost = [r.name for r in outcome.report.preferences if not r.kept]
    asked = replace(settings, start=None, save_to=None, confirm=False, time_limit=seconds)
    return tuple(
        _price(mission, p, outcome, asked, should_stop)
        for p in mission.preferences
        if p.name in lost and not (should_stop and should_stop())
    )


def _price(
    mission: Mission,
    kept: Preference,
    outcome: Outcome,
    settings: SolveSettings,
    should_stop: Callable[[], bool] | None,
) -> Price:
    """The mission with one preference required."""
    hard = Requirement(kept.name, kept.formula, kept.margin, kept.span)
    asked = replace(
        mission,
        requirements=(*mission.requirements, hard),
        preferences=tuple(p for p in mission.preferences if p is not kept),
        objective=tuple(t for t in mission.objective if t.requirement != kept.name),
    )
    try:
        found = solve_mission(asked, settings, ignore, should_stop)
    except InfeasibleError:
        return Price(kept.name, None, True)
    except (NoPlanError, SolverError):
        return Price(kept.name, None, False)
    held = {r.name for r in outcome.report.preferences if r.kept}
    others = tuple(r.name for r in found.report.preferences if not r.kept and r.name in held)
    info = found.plan.solve
    return Price(kept.name, info.objective, info.status == "optimal", others)
