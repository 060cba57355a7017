"""What decides each requirement, over time: it meets the robustness where that is decided."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.ir.nodes import Always, Eventually, Linear, Link, Node, Release, Until, walk
from stlc.mission import Mission
from stlc.plan import Plan, as_planned
from stlc.verify.critical import descent
from stlc.verify.link_models import CellModel
from stlc.verify.robustness import Evaluator
from stlc.verify.subject import Array, make_subject
from stlc.verify.trace import Trace


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """The part of a requirement, below its temporal operators, that decides it.

    `values` (L,) are its robustness at steps 0..L-1, signed as the requirement counts it;
    `values[step]` is the requirement's own robustness. `window` are the first and last step that
    its temporal operators ask about. `deciders` are the predicate that decides and the
    parts around it that say what it is about.
    """

    values: Array
    step: int
    window: tuple[int, int]
    deciders: tuple[Node, ...]


def timelines(mission: Mission, plan: Plan) -> tuple[Timeline | None, ...]:
    """One for each requirement, links on their cells; None where it can't be judged.

    Raises UsageError when the plan doesn't fit the mission's shape.
    """
    mission = as_planned(mission, plan)
    subject = make_subject(mission, plan, None)
    cells = CellModel(subject)
    evaluator = Evaluator(Trace(mission.horizon + 1, subject.signals, cells.robustness))
    return tuple(_timeline(evaluator, r.formula) for r in mission.requirements)


def _timeline(evaluator: Evaluator, root: Node) -> Timeline | None:
    """Down to the first part that no temporal operator stands in, and from there to the end."""
    if not len(evaluator.robustness(root)):
        return None
    low = high = 0
    way = list(descent(evaluator, root))
    deciders = tuple(node for (node, _, _), _ in way if _claims(node))
    for (node, step, positive), options in way:
        if not _temporal(node):
            values = evaluator.judged(node, positive) * (1.0 if positive else -1.0)
            return Timeline(np.asarray(values), step, (low, high), deciders)
        steps = [t - step for _, t, _ in options]
        low, high = low + min(steps, default=0), high + max(steps, default=0)
    return None


def _claims(node: Node) -> bool:
    """Whether a part says by itself which agents and places it is about."""
    named = node.member is not None or node.swept is not None
    return named or isinstance(node, Linear | Link)


def _temporal(node: Node) -> bool:
    """Whether the value depends on more than one step; links may be asked for later."""
    if isinstance(node, Link):
        return False
    return any(isinstance(n, Always | Eventually | Until | Release) for n in walk(node))
