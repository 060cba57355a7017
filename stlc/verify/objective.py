"""The objective, recomputed term by term from the run alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from stlc.charges import Form
from stlc.ir.signals import Role
from stlc.mission import Cap, ObjectiveTerm, TermKind
from stlc.plan import SolveInfo
from stlc.scales import static_range, steps_of
from stlc.sense import Sense
from stlc.verify.link_models import CellModel
from stlc.verify.preferences import violation
from stlc.verify.report import TermReport, Violation
from stlc.verify.robustness import Evaluator
from stlc.verify.subject import Subject
from stlc.verify.trace import Trace


def term_reports(subject: Subject, cells: CellModel, trace: Trace) -> tuple[TermReport, ...]:
    """Every term of the objective; NaN where it can't be judged."""
    sense = subject.mission.sense
    return tuple(_term(subject, t, cells, trace, sense) for t in subject.mission.objective)


def cap_values(
    subject: Subject, cells: CellModel, trace: Trace
) -> list[tuple[Cap, tuple[float, float] | None]]:
    """What the terms of each cap add up to, least and greatest over ties."""
    return [
        (cap, total([_term(subject, term, cells, trace, Sense.MINIMIZE) for term in cap.terms]))
        for cap in subject.mission.caps
    ]


def total(terms: Sequence[TermReport]) -> tuple[float, float] | None:
    """Lowest and highest objective over ties, in the terms' sense; None if one can't be judged."""
    ends = [sorted((t.weight * t.low, t.weight * t.high)) for t in terms]
    low, high = math.fsum(e[0] for e in ends), math.fsum(e[1] for e in ends)
    return None if math.isnan(low + high) else (low, high)


def _term(
    subject: Subject, term: ObjectiveTerm, cells: CellModel, trace: Trace, sense: Sense
) -> TermReport:
    """A term's value: an interval where the polygon, tied cells or lengths leave one."""
    match term.kind:
        case TermKind.EFFORT:
            low = high = _effort(subject, term)
        case TermKind.LINK_COST:
            low, high = _link_cost(subject, term, cells)
        case TermKind.ROBUSTNESS:
            low, high = (_robustness(subject, term, trace, faces=f) for f in (True, False))
        case TermKind.TOTAL:
            low = high = _total(subject, term)
        case TermKind.VIOLATION:
            low, high = _violation(subject, term, trace)
    scale = static_range(subject.mission, term, subject.tables)
    weight = sense.own(term.weight)
    return TermReport(_name(term), weight, low / scale, high / scale, term.span)


def _name(term: ObjectiveTerm) -> str:
    """A term as missions write it."""
    inner = {
        TermKind.EFFORT: "effort",
        TermKind.LINK_COST: f"link_cost({term.channel})",
        TermKind.ROBUSTNESS: f"robustness({term.requirement})"
        if term.requirement
        else "robustness",
        TermKind.VIOLATION: _violated(term),
        TermKind.TOTAL: term.requirement or "total",
    }[term.kind]
    if term.kind is TermKind.TOTAL:
        return inner
    window = f"[{term.window[0]}, {term.window[1]}]" if term.window else ""
    return f"normalised({inner}{window})" if term.normalised else inner + window


def _violated(term: ObjectiveTerm) -> str:
    name = term.requirement or ""
    return name if name.startswith("time(") else f"violation({name})"


def _effort(subject: Subject, term: ObjectiveTerm) -> float:
    """sum q'|x_t| over t >= 1 and r'|u_t| over t <= T - 1, in the term's window."""
    mission = subject.mission
    states, inputs = steps_of(mission, term)
    parts = []
    for name in term.agents or mission.agents:
        agent, run = mission.agents[name], subject.plan.runs[name]
        parts.append(float((np.abs(run.states[states]) @ agent.effort_state).sum()))
        parts.append(float((np.abs(run.inputs[inputs]) @ agent.effort_input).sum()))
    return math.fsum(parts)


def _total(subject: Subject, term: ObjectiveTerm) -> float:
    """What the charges of a total add up to on the run."""
    runs = subject.plan.runs

    def value(form: Form) -> float:
        """A form on the run."""
        parts = [form.constant]
        for signal, factor in form.terms:
            run = runs[signal.owner]
            table = run.states if signal.role is Role.STATE else run.inputs
            parts.append(factor * float(table[signal.shift, signal.index]))
        return math.fsum(parts)

    return math.fsum(
        part
        for charge in term.charges
        for part in (
            value(charge.form),
            *(factor * max(map(value, forms)) for factor, forms in charge.peaks),
        )
    )


def _link_cost(subject: Subject, term: ObjectiveTerm, cells: CellModel) -> tuple[float, float]:
    assert term.channel is not None
    channel = subject.mission.channels[term.channel]
    states, _ = steps_of(subject.mission, term)
    low, high = (
        math.fsum(float(x) for p in term.pairs for x in cells.cost(channel, p, pick)[states])
        for pick in ("least", "greatest")
    )
    return low, high


def _violation(subject: Subject, term: ObjectiveTerm, trace: Trace) -> tuple[float, float]:
    """Violation of the preference meant, over its scale."""
    meant = next(p for p in subject.mission.preferences if p.name == term.requirement)
    low, high = violation(meant, trace)
    return low / meant.scale, high / meant.scale


def _robustness(subject: Subject, term: ObjectiveTerm, trace: Trace, *, faces: bool) -> float:
    """Least robustness of the requirements meant, each predicate divided by its unit's scale.

    A model that sees lengths by the faces of polygons proves its bound for those.
    """
    evaluator = Evaluator(trace, scales=term.scales, faces=faces)
    values = [
        evaluator.robustness(r.formula)[:1]
        for r in subject.mission.requirements
        if term.requirement in (None, r.name)
    ]
    firsts = [float(v[0]) if len(v) else math.nan for v in values]
    return float(np.min(firsts)) if firsts else math.nan  # NaN where any is


def objective_violations(
    claim: SolveInfo,
    found: tuple[float, float] | None,
    terms: Sequence[TermReport],
    sense: Sense,
) -> Iterator[Violation]:
    """A claimed objective that the run doesn't reach, or a bound that the run refutes.

    The run may be better than claimed (slack in a model's auxiliary columns), never worse; and no
    run is better than a proven bound. `found` goes the way of `sense`, the claim its own.
    """
    if found is None:
        lost = ", ".join(t.name for t in terms if math.isnan(t.low))
        yield Violation("objective", f"the objective can't be judged: {lost}", math.inf)
        return
    low, high = sorted(map(sense.own, found))
    claimed, bound = claim.sense.own(claim.objective), claim.sense.own(claim.bound)  # minimised
    if claimed is not None and low - claimed > _slack(claimed):
        told = f"{sense.own(low):.9g}, worse than the {sense.own(claimed):.9g} claimed"
        yield Violation("objective", f"the plan's objective is {told}", low - claimed)
    if bound is not None and bound - high > _slack(bound):
        side = "below" if sense is Sense.MINIMIZE else "above"
        told = f"{sense.own(high):.9g} is {side} the proven bound {sense.own(bound):.9g}"
        yield Violation("bound", f"the plan's objective {told}", bound - high)


def _slack(value: float) -> float:
    return 1e-5 * max(1.0, abs(value)) if math.isfinite(value) else math.inf
