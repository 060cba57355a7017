"""The verdict on a plan."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations

from stlc.channels import ChannelTables
from stlc.grids import shapes, text
from stlc.mission import Mission
from stlc.plan import Plan, as_planned
from stlc.verify.chains import Chain
from stlc.verify.clearance import outside
from stlc.verify.conditions import Motions
from stlc.verify.continuous import Extremum, distance, separation
from stlc.verify.floors import floors
from stlc.verify.link_models import CellModel, TrueModel, link_series, since
from stlc.verify.lone import lone_samples
from stlc.verify.motion import motion_violations, norm_notes, residual
from stlc.verify.objective import cap_values, objective_violations, term_reports, total
from stlc.verify.paths import Path, is_known, placed, state_paths
from stlc.verify.preferences import cap_violations, preference_reports
from stlc.verify.prisms import levels_of
from stlc.verify.report import Clearance, Report, RequirementReport, Violation
from stlc.verify.requirements import SweptOverride, judge, position_findings, requirement_violations
from stlc.verify.robots import robot_notes, robot_violations
from stlc.verify.shapes import Bodies
from stlc.verify.subject import Subject, make_subject, stale, with_room
from stlc.verify.together import passages
from stlc.verify.trace import Trace
from stlc.verify.tubes import half_widths, radii, spread_of
from stlc.verify.workspace import workspace_notes, workspace_violations


def verify(mission: Mission, plan: Plan, tables: ChannelTables | None = None) -> Report:
    """Judge a plan against its mission, from the run's numbers alone.

    Checked: dynamics, start, bounds, norms (by the Euclidean norm; an `outer` one by its polygon),
    turning rate (Euclidean), integer inputs, workspace (in continuous time where the mission
    says or implies so), every requirement (robustness >= margin - 1e-6; links on the cell model),
    `swept` conditions in continuous time, the objective and the bound claimed. Links are judged at
    the true positions too: what fails only there is in `approximate`, unless the channel's bound
    promised to be rigorous. Of steps carried out already only what requirements say is judged.
    `tables` saves making a channel's tables again; grids that channels chose are the plan's.
    Raises UsageError when the plan doesn't fit the mission's shape.
    """
    subject = with_room(make_subject(as_planned(mission, plan), plan, tables))
    mission = subject.mission
    cells = CellModel(subject)
    true = TrueModel(subject, cells)
    on_cells = since(plan.executed, true.robustness, cells.robustness)
    off, discs = spread_of(mission, plan.executed), radii(mission)
    sampled = Trace(mission.horizon + 1, subject.signals, on_cells, spread=off, discs=discs)
    true_links = replace(sampled, link=true.robustness)
    states = state_paths(mission, plan.runs, plan.executed)
    motion = placed(mission, states)
    chains = {name: Chain.of(path) for name, path in motion.items()}
    bodies = Bodies(mission)
    override = SweptOverride(mission, motion, chains, Motions(states, plan.runs, discs), bodies)
    requirements = judge(mission, sampled, true_links, override, bodies, plan.executed)
    terms = term_reports(subject, cells, sampled)
    objective = total(terms)
    certain, approximate = _at_true_positions(mission, requirements)
    violations = (
        *_violations(subject, requirements, motion, chains, bodies), *certain,
        *objective_violations(plan.solve, objective, terms, mission.sense),
        *cap_violations(cap_values(subject, cells, sampled)),
    )  # fmt: skip
    return Report(
        mission.source.name, violations, approximate, tuple(_notes(subject, motion)), requirements,
        objective, terms, _residual(mission, plan),
        tuple(_clearances(mission, motion, chains, bodies)), link_series(subject, cells, true),
        mission.sense, preference_reports(mission, sampled),
    )  # fmt: skip


def _at_true_positions(
    mission: Mission, requirements: tuple[RequirementReport, ...]
) -> tuple[tuple[Violation, ...], tuple[Violation, ...]]:
    """What fails only there: where the channel's bound promised to be rigorous, and elsewhere."""
    findings = list(position_findings(mission, requirements))
    certain = tuple(v for rigorous, v in findings if rigorous)
    return certain, tuple(v for rigorous, v in findings if not rigorous)


def _violations(
    subject: Subject,
    requirements: tuple[RequirementReport, ...],
    motion: Mapping[str, Path],
    chains: Mapping[str, Chain],
    bodies: Bodies,
) -> Iterator[Violation]:
    """What the run itself violates: dynamics and bounds, the workspace, requirements, passages."""
    mission = subject.mission
    yield from motion_violations(subject)
    yield from robot_violations(mission, subject.drives, subject.plan.executed)
    yield from workspace_violations(mission, motion, subject.plan.executed)
    yield from requirement_violations(mission, requirements)
    yield from passages(mission, chains, bodies)
    yield from lone_samples(mission, chains, bodies)
    yield from floors(mission, chains, bodies)


def _residual(mission: Mission, plan: Plan) -> float:
    agents = mission.agents.items()
    each = (residual(agent, plan.runs[name])[plan.executed :] for name, agent in agents)
    return max((float(gap.max(initial=0.0)) for gap in each), default=0.0)


def _notes(subject: Subject, motion: Mapping[str, Path]) -> Iterator[str]:
    """What a reader should know of how the plan was judged."""
    if stale(subject.mission, subject.plan):
        yield "the mission's text has changed since the plan was made"
    if chosen := shapes(subject.mission):
        yield f"links are judged cell by cell, {text(chosen)}, chosen by `partition auto`"
    for channel, lesson in subject.plan.learned.items():
        anew = "; its parameters were fitted anew" if lesson.parameters else ""
        yield f"{channel} knows {len(lesson)} samples measured on the way, held by the plan{anew}"
    yield from norm_notes(subject)
    for name, agent in subject.mission.agents.items():
        widths = half_widths(agent, subject.mission.horizon)
        if widths is not None and agent.tube is not None:
            ends = zip(agent.dynamics.states, widths[0].max(axis=0), strict=True)
            listed = ", ".join(f"{state} {width:.3g}" for state, width in ends)
            yield f"{name} stays within {listed} of the plan, whatever its disturbance does"
    yield from robot_notes(subject.mission, subject.drives)
    yield from workspace_notes(subject.mission, motion, subject.plan.executed)
    models = {name: agent.dynamics for name, agent in subject.mission.agents.items()}
    if subject.plan.executed:
        yield f"steps before {subject.plan.executed} were carried out: they are as measured"
    for what, names in (
        ("straight lines, as the mission says", [n for n, m in models.items() if m.straight]),
        ("straight lines, for want of better", [n for n, m in models.items() if not is_known(m)]),
    ):
        moving = [name for name in names if models[name].position is not None]
        if moving:
            yield f"between samples {', '.join(moving)} is judged on {what}"


def _clearances(
    mission: Mission, motion: Mapping[str, Path], chains: Mapping[str, Chain], bodies: Bodies
) -> Iterator[Clearance]:
    """Closest approaches in continuous time to real obstacle bodies, buffers and other agents."""
    agents = [name for name in mission.agents if name in motion]
    for name in agents:
        for obstacle in mission.obstacles.values():
            for what in ("body", "buffer"):
                body = bodies.of(obstacle.name, what == "buffer")
                levels = levels_of(mission, name, body)
                found = outside(chains[name], body, levels=levels, steps=mission.horizon)
                yield _closest(what, name, obstacle.name, found, mission.step)
    for one, other in combinations(agents, 2):
        relative = motion[one].minus(motion[other])
        apart = separation(relative, (0.0,) * relative.c0.shape[1])
        yield _closest("separation", one, other, apart, mission.step)
        yield _closest("distance", one, other, distance(relative), mission.step)


def _closest(what: str, agent: str, other: str, found: Extremum, step: float) -> Clearance:
    row = int(found.value.argmin())
    time = (row + float(found.where[row])) * step
    return Clearance(what, agent, other, float(found.value[row]), time)
