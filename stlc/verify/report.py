"""What the verifier found, as dataclasses, as text and as JSON."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import Any

from stlc.certificate import Certificate
from stlc.plan import LinkSeries, Plan, RequirementValue
from stlc.sense import Sense
from stlc.source import Span
from stlc.verify.preference_report import PreferenceReport
from stlc.verify.requirement_report import RequirementReport as RequirementReport
from stlc.verify.requirement_report import by_motion, is_tight, slack_of, tight_words

_TOUCH = 1e-6  # m: what is nearer touches, by the tolerance that requirements are judged with


@dataclass(frozen=True, slots=True)
class Violation:
    """One thing that a plan breaks.

    `kind` is a short class name such as "dynamics" or "requirement"; `amount` says by how much,
    in the unit of what is broken; `step` is the worst one, fractional between samples.
    """

    kind: str
    message: str
    amount: float
    step: float | None = None
    agent: str | None = None
    span: Span | None = None

    def __str__(self) -> str:
        place = f"{self.span}: " if self.span else ""
        return f"{place}{self.message}"


@dataclass(frozen=True, slots=True)
class TermReport:
    """One term of the objective, weight left out; a tie at a cell border gives an interval.

    The weight is that of the mission's own sense.
    """

    name: str
    weight: float
    low: float
    high: float
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Clearance:
    """Closest approach in continuous time.

    `what` is "body" (an obstacle before inflation), "buffer" (after), "separation" (the larger of
    |dx| and |dy| between two agents) or "distance" (Euclidean). `value` [m] is negative inside an
    obstacle; outside it is the distance from the nearest face's line, a lower bound of the
    Euclidean one. `time` [s].
    """

    what: str
    agent: str
    other: str
    value: float
    time: float

    @property
    def is_cut(self) -> bool:
        """Within the body of an obstacle."""
        return self.what == "body" and self.value < -_TOUCH

    def __str__(self) -> str:
        if self.is_cut:
            return (
                f"{self.agent} cuts {-self.value:.4g} m into the body of {self.other} "
                f"at {self.time:.3g} s; a requirement with `swept` forbids that"
            )
        words = _CLEARANCE[self.what].format(self)
        value = 0.0 if abs(self.value) < _TOUCH else self.value
        return f"{words}: {value:.4g} m at {self.time:.3g} s, between samples included"


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """The verdict on a plan. `approximate` holds at the cell model but not at true positions."""

    mission: str
    violations: tuple[Violation, ...]
    approximate: tuple[Violation, ...]
    notes: tuple[str, ...]
    requirements: tuple[RequirementReport, ...]
    objective: tuple[float, float] | None  # lowest and highest over ties; None: can't be judged
    terms: tuple[TermReport, ...]
    residual: float  # largest dynamics residual
    clearances: tuple[Clearance, ...]
    links: tuple[LinkSeries, ...]
    sense: Sense = Sense.MINIMIZE  # which way `objective` and the weights of `terms` go
    preferences: tuple[PreferenceReport, ...] = ()

    @property
    def ok(self) -> bool:
        """No violation."""
        return not self.violations

    def annotate(self, plan: Plan, certificate: Certificate | None = None) -> Plan:
        """The plan with what was found: robustness, link quality, certificate, notes."""
        values = tuple(RequirementValue(r.name, r.robustness, r.margin) for r in self.requirements)
        info = (certificate or plan.certificate).judged(self.ok, tuple(self.notes))
        return replace(plan, requirements=values, links=self.links, certificate=info)

    def text(self) -> str:
        """The report for a person, in plain text."""
        lines = [f"{self.mission}: the plan {_verdict(self)}"]
        lines += [f"  violated: {v}" for v in self.violations]
        lines += [f"  approximate: {v}" for v in self.approximate]
        lines += _requirement_lines(self.requirements)
        lines += [f"  {p}" for p in self.preferences]
        lines += _objective_lines(self)
        lines += _clearance_lines(self.clearances)
        lines += [f"  note: {note}" for note in self.notes]
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values; infinite numbers are "inf" and "-inf"."""
        return {
            "mission": self.mission,
            "verified": self.ok,
            "violations": [_violation(v) for v in self.violations],
            "approximate": [_violation(v) for v in self.approximate],
            "requirements": [_requirement(r) for r in self.requirements],
            "preferences": [p.as_dict() for p in self.preferences],
            "sense": self.sense.value,
            "objective": _ends(self.objective),
            "terms": [
                {"name": t.name, "weight": t.weight, "value": _ends((t.low, t.high))}
                for t in self.terms
            ],
            "residual": _plain(self.residual),
            "clearances": [
                {"what": c.what, "agent": c.agent, "other": c.other,
                 "value": _plain(c.value), "time": c.time}
                for c in self.clearances
            ],
            "notes": list(self.notes),
        }  # fmt: skip

    def to_json(self) -> str:
        """`as_dict` as one JSON object."""
        return json.dumps(self.as_dict(), indent=2, allow_nan=False) + "\n"


def tidy(value: float, digits: int = 6) -> str:
    """A number for a person; rounding errors about zero are zero."""
    return f"{0.0 if abs(value) < 1e-9 else value:.{digits}g}"


def _verdict(report: Report) -> str:
    if not report.ok:
        count = len(report.violations)
        return f"violates the mission ({count} violation{'s' if count > 1 else ''})"
    return "satisfies the mission" + (" on the cell model only" if report.approximate else "")


def _requirement_lines(requirements: tuple[RequirementReport, ...]) -> list[str]:
    """A line for each requirement: verdict, robustness, critical step, margin."""
    if not requirements:
        return []
    width = max(len(r.name) for r in requirements)
    lines = ["  requirement" + " " * max(width - 9, 2) + "robustness"]
    for r in requirements:
        value = "can't be judged" if r.robustness is None else tidy(r.robustness)
        unit = f" {r.critical[1]}" if r.critical and r.critical[1] else ""
        step = f"  at step {r.critical[0]}" if r.critical else ""
        margin = f"  (margin {r.margin:g})" if r.margin else ""
        mark = "ok " if r.satisfied else "NO "
        lines.append(f"  {mark}{r.name:<{width}}  {value}{unit}{step}{margin}{_further(r)}")
    tight = tight_words(requirements)
    return [*lines, f"  {tight}"] if tight else lines


def _further(r: RequirementReport) -> str:
    parts = []
    if r.true is not None and r.robustness is not None:
        parts.append(f"at true positions {tidy(r.true)}")
    if r.swept is not None:
        counts = ", which counts" if by_motion(r) else ""
        parts.append(f"in continuous time {tidy(r.swept)}{counts}")
    if r.corners is not None:
        parts.append(f"by the corners in the file {tidy(r.corners)}")
    return f"  [{', '.join(parts)}]" if parts else ""


def _objective_lines(report: Report) -> list[str]:
    if report.objective is None or not report.terms:
        return []
    ends = report.objective
    best, worst = ends if report.sense is Sense.MINIMIZE else ends[::-1]
    tied = abs(worst - best) > 1e-9 * max(1.0, abs(worst))
    said = "best of tied cells and of what polygons leave open"
    remark = f" ({said}; {worst:.8g} with the worst)" if tied else ""
    lines = [f"  objective {best:.8g}{remark}"]
    return lines + [_term_line(t, report.sense) for t in report.terms]


def _term_line(term: TermReport, sense: Sense) -> str:
    """A term with its share of the objective's best value: the lines add up to it."""
    value = term.low if (term.weight > 0) is (sense is Sense.MINIMIZE) else term.high
    product = f"{term.weight:g} x {value:.8g} = {term.weight * value:.8g}"
    return f"    {term.weight:+g} x {term.name} = {product}"


def _clearance_lines(clearances: tuple[Clearance, ...]) -> list[str]:
    return [f"  {c}" for c in clearances if c.what in ("body", "distance")]


_CLEARANCE = {
    "body": "{0.agent} clears the body of {0.other} by",
    "buffer": "{0.agent} clears the buffer of {0.other} by",
    "separation": "{0.agent} and {0.other} are apart along an axis by",
    "distance": "{0.agent} and {0.other} are apart by",
}


def _violation(v: Violation) -> dict[str, Any]:
    place = None
    if v.span is not None:
        place = {"file": v.span.source.name, "line": v.span.line, "column": v.span.column}
    return {
        "kind": v.kind, "message": v.message, "amount": _plain(v.amount), "step": v.step,
        "agent": v.agent, "place": place,
    }  # fmt: skip


def _requirement(r: RequirementReport) -> dict[str, Any]:
    """A requirement as `stlc verify --json` prints it."""
    return {
        "name": r.name,
        "margin": r.margin,
        "satisfied": r.satisfied,
        "robustness": _plain(r.robustness),
        "true_positions": _plain(r.true),
        "continuous_time": _plain(r.swept),
        "step": r.critical[0] if r.critical else None,
        "decided_by": r.says or None,
        "slack": _plain(slack_of(r)),
        "tight": is_tight(r),
        "unit": r.critical[1] if r.critical else None,
    }


def _ends(interval: tuple[float, float] | None) -> Any:
    if interval is None:
        return None
    low, high = (_plain(x) for x in interval)
    return low if low == high else [low, high]


def _plain(value: float | None) -> Any:
    if value is None or math.isnan(value):
        return None
    return value if math.isfinite(value) else str(value)
