"""Every requirement: on samples, at true link positions, and in continuous time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from stlc.ir.nodes import (
    Link,
    Motion,
    Node,
    Swept,
    walk,
)
from stlc.ir.requirement import Requirement
from stlc.mission import Bound, Mission
from stlc.plan import Run
from stlc.verify import clearance
from stlc.verify.chains import Chain
from stlc.verify.conditions import Motions
from stlc.verify.continuous import separation
from stlc.verify.critical import critical
from stlc.verify.paths import Path, placed, state_paths
from stlc.verify.prisms import levels_of
from stlc.verify.report import RequirementReport, Violation
from stlc.verify.robustness import Evaluator, Override
from stlc.verify.samples import Samples
from stlc.verify.shapes import Bodies, Body
from stlc.verify.subject import TOLERANCE, Array
from stlc.verify.trace import Trace
from stlc.verify.tubes import radii

TRUE_SLACK = 1e-4
"""A rigorous cell bound may be missed by this much: a position counts as in a cell 1e-6 m away."""


@dataclass(frozen=True, slots=True, eq=False)
class _Judges:
    """Evaluators: on samples, at the true positions, in continuous time, by corners."""

    sampled: Evaluator
    true: Evaluator
    dense: Evaluator
    corners: Evaluator
    samples: Samples


def judge(
    mission: Mission, cells: Trace, true: Trace, swept: SweptOverride, bodies: Bodies, past: int = 0
) -> tuple[RequirementReport, ...]:
    """Reports on all requirements; before step `past`, which was carried out, `swept` conditions
    are what the motion was, whatever is sufficient for them."""
    sampled = Evaluator(cells, _known(past, cells, swept))
    samples = Samples(mission, swept.chains, bodies, sampled)

    def by_corners(node: Node) -> Array | None:
        return swept(node) if node.swept is not None else samples(node)

    judges = _Judges(
        sampled,
        Evaluator(true, _known(past, true, swept)),
        Evaluator(cells, swept),
        Evaluator(cells, by_corners),
        samples,
    )
    return tuple(_report(r, judges) for r in mission.requirements)


def _known(past: int, trace: Trace, swept: SweptOverride) -> Override | None:
    """Judges `swept` conditions by the motion at the steps before `past`."""
    if not past:
        return None
    plain = Evaluator(trace)

    def override(node: Node) -> Array | None:
        moved = swept(node)
        if moved is None:
            return None
        values = plain.robustness(node).copy()
        values[:past] = moved[:past]
        return values

    return override


def _report(requirement: Requirement, judges: _Judges) -> RequirementReport:
    """One requirement by all judges that have a say in it."""
    formula, sampled = requirement.formula, judges.sampled
    has_link = has_swept = False
    for node in walk(formula):
        has_link = has_link or isinstance(node, Link)
        has_swept = has_swept or node.swept is not None
    value = _first(sampled.robustness(formula))
    decider = None if value is None else critical(sampled, formula)
    return RequirementReport(
        requirement.name,
        requirement.margin,
        value,
        _first(judges.true.robustness(formula)) if has_link else None,
        _first(judges.dense.robustness(formula)) if has_swept else None,
        None if decider is None else (decider.step, decider.unit),
        requirement.span,
        _first(judges.corners.robustness(formula)) if judges.samples.differ(formula) else None,
        None if decider is None else decider.span,
        "" if decider is None else decider.says,
    )


def _first(values: Array) -> float | None:
    return float(values[0]) if len(values) else None


class SweptOverride:
    """Robustness (T,) of a node that stands for a `swept` condition, None for others."""

    def __init__(
        self,
        mission: Mission,
        motion: Mapping[str, Path],
        chains: Mapping[str, Chain],
        motions: Motions,
        bodies: Bodies,
    ) -> None:
        self._mission = mission
        self._motion = motion
        self.chains = chains
        self._motions = motions
        self._bodies = bodies

    def __call__(self, node: Node) -> Array | None:
        swept = node.swept
        if swept is None:
            return None
        if swept.motion is Motion.CONDITION:
            assert swept.condition is not None
            return self._motions.least(swept.condition, self._mission.horizon)
        return self._clearance(swept)[:-1] if self._known(swept) else None

    def _known(self, swept: Swept) -> bool:
        return {swept.agent, swept.other or swept.agent} <= self._motion.keys() and (
            swept.place is None or swept.place in self._bodies
        )

    def _clearance(self, swept: Swept) -> Array:
        """Clearance [m] of the motion from each step to the next, (T,)."""
        match swept.motion:
            case Motion.OUTSIDE:
                space = self._mission.workspace
                levels = levels_of(self._mission, swept.agent, self._body(swept))
                chain = self.chains[swept.agent]
                return clearance.outside(chain, self._body(swept), space, levels).value
            case Motion.INSIDE:
                return clearance.inside(self.chains[swept.agent], self._body(swept)).value
            case Motion.SEPARATION:
                assert swept.other is not None
                relative = self._motion[swept.agent].minus(self._motion[swept.other])
                return separation(relative.plane, swept.distances).value
            case Motion.CONDITION:
                raise AssertionError("a condition is about no agent alone")

    def _body(self, swept: Swept) -> Body:
        assert swept.place is not None
        return self._bodies.of(swept.place)


def swept_override(mission: Mission, runs: Mapping[str, Run], past: int = 0) -> SweptOverride:
    """That of the agents' runs, which were carried out up to step `past`."""
    states = state_paths(mission, runs, past)
    motion = placed(mission, states)
    chains = {name: Chain.of(path) for name, path in motion.items()}
    motions = Motions(states, runs, radii(mission))
    return SweptOverride(mission, motion, chains, motions, Bodies(mission))


def requirement_violations(
    mission: Mission, reports: Sequence[RequirementReport]
) -> Iterator[Violation]:
    """Requirements that don't hold on the samples, or in continuous time."""
    for r in reports:
        if r.robustness is None:
            text = f"requirement {r.name} can't be judged: it looks past step {mission.horizon}"
            yield Violation("requirement", text, float("inf"), None, None, r.span)
        elif r.satisfied:
            continue
        elif not r.robustness >= r.margin - TOLERANCE:  # NaN too: what overflows is not met
            yield _failure(r, r.robustness, "requirement", "")
        elif r.corners is not None and not r.corners >= r.margin - TOLERANCE:
            yield _failure(r, r.corners, "corners", " by the corners in the file")
        elif r.swept is not None:
            yield _failure(r, r.swept, "swept", " between samples")


def _failure(r: RequirementReport, value: float, kind: str, where: str) -> Violation:
    step, of = r.critical or (None, "")
    when = "" if step is None or where else f" at step {step}"
    holds = r.true is not None and r.true >= r.margin and not where
    tail = "; it holds at the true positions" if holds else ""
    text = (
        f"requirement {r.name} fails{where}{when}: "
        f"robustness {value:.6g}{' ' + of if of else ''} < margin {r.margin:g}{tail}"
    )
    return Violation(kind, text, r.margin - value, step, None, r.span)


def position_findings(
    mission: Mission, reports: Sequence[RequirementReport]
) -> Iterator[tuple[bool, Violation]]:
    """Requirements that hold on the cells but not at the true positions.

    The flag tells whether the cell bounds promised to be rigorous: then it is a violation.
    """
    for r, requirement in zip(reports, mission.requirements, strict=True):
        if r.true is None or not r.satisfied or r.true >= r.margin - TOLERANCE:
            continue
        rigorous = _rigorous(mission, requirement.formula)
        if rigorous and r.true >= r.margin - TRUE_SLACK:
            continue
        text = (
            f"requirement {r.name} holds on the cell model ({r.robustness:.6g}) but not at the "
            f"true positions ({r.true:.6g})"
        )
        step = r.critical[0] if r.critical else None
        yield rigorous, Violation("link", text, r.margin - r.true, step, None, r.span)


def _rigorous(mission: Mission, formula: Node) -> bool:
    channels = {n.channel for n in walk(formula) if isinstance(n, Link)}
    return all(mission.channels[c].predicate_bound is Bound.WORST for c in channels)
