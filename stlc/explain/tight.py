"""Why a plan is as it is: which requirements are tight, where, and what their margins cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stlc.explain.marginal_costs import prices
from stlc.explain.words import place
from stlc.mission import Mission
from stlc.plan import Plan, as_planned
from stlc.verify import Report, verify
from stlc.verify.report import tidy
from stlc.verify.requirement_report import RequirementReport, is_tight, slack_of

LABEL = "change of the objective per unit of margin, by the LP with the plan's integers fixed"


@dataclass(frozen=True, slots=True)
class Standing:
    """One requirement of a plan. `slack` is robustness less margin, in `unit`; `price` the marginal
    cost of the margin, None where it isn't known."""

    name: str
    robustness: float | None
    margin: float
    slack: float | None
    unit: str
    step: int | None
    decides: str
    tight: bool
    price: float | None
    report: RequirementReport

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "requirement": self.name, "robustness": self.robustness, "margin": self.margin,
            "slack": self.slack, "unit": self.unit, "step": self.step, "decided_by": self.decides,
            "place": place(self.report.decides), "tight": self.tight,
            "marginal_cost": self.price,
        }  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Explained:
    """A plan's requirements, the tightest first, and the verifier's report."""

    standings: tuple[Standing, ...]
    report: Report

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "verified": self.report.ok,
            "violations": self.report.as_dict()["violations"],
            "requirements": [s.as_dict() for s in self.standings],
            "marginal_cost": LABEL,
        }

    def text(self) -> str:
        """What is violated, and a table, for a person."""
        tight = sum(s.tight for s in self.standings)
        verdict = "satisfies" if self.report.ok else "violates"
        head = f"{self.report.mission}: the plan {verdict} the mission; {tight} of "
        head += f"{len(self.standings)} requirements are tight"
        rows = [("requirement", "slack", "marginal cost", "decided by")]
        rows += [_row(s) for s in self.standings]
        widths = [max(len(row[k]) for row in rows) for k in range(3)]
        lines = [
            "  " + "  ".join(word.ljust(w) for word, w in zip(row, widths, strict=False))
            + f"  {row[3]}"
            for row in rows
        ]  # fmt: skip
        note = [f"  marginal cost: {LABEL}"] if any(s.price for s in self.standings) else []
        broken = [f"  violated: {v}" for v in self.report.violations]
        return "\n".join([head, *broken, *lines, *note])


def explain_plan(mission: Mission, plan: Plan) -> Explained:
    """What of a plan is tight. UsageError when it doesn't fit the mission's shape."""
    mission = as_planned(mission, plan)
    report = verify(mission, plan)
    tight = [r.name for r in report.requirements if is_tight(r)]
    cost = prices(mission, plan, tight) if report.ok else {}
    standings = [_standing(r, cost) for r in report.requirements]
    return Explained(tuple(sorted(standings, key=_order)), report)


def _standing(r: RequirementReport, cost: dict[str, float]) -> Standing:
    step, unit = r.critical or (None, "")
    tight = is_tight(r)
    price = cost.get(r.name) if tight else None
    return Standing(
        r.name, r.robustness, r.margin, slack_of(r), unit, step, r.says, tight, price, r
    )


def _order(s: Standing) -> tuple[bool, float]:
    return not s.tight, float("inf") if s.slack is None else s.slack


def _row(s: Standing) -> tuple[str, str, str, str]:
    unit = f" {s.unit}" if s.unit else ""
    slack = "-" if s.slack is None else f"{tidy(s.slack)}{unit}"
    price = "-" if s.price is None else f"{tidy(s.price, 4)}{f' per {s.unit}' if s.unit else ''}"
    where = "" if s.step is None else f" at step {s.step}"
    return f"{s.name}{' (tight)' if s.tight else ''}", slack, price, f"`{s.decides}`{where}"
