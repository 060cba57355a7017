"""What no MILP can say of a mission, found before or after it is built: located errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stlc.analysis.goals import Goal
from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError
from stlc.ir.nodes import Linear, Role, walk
from stlc.ir.requirement import Requirement
from stlc.milp.model import Block, Model
from stlc.mission import Mission
from stlc.source import Span

LARGEST_COEFFICIENT = 1e15
"""HiGHS refuses larger ones; beside a 1 they leave a double no digit."""

LARGEST_COST = 1e20
"""HiGHS takes this for infinity."""


class RecordedSignal(Diagnostic):
    """A requirement on a recorded signal is to be planned for.

    A `signal` is a column of a recording: nobody controls it, so no plan can be made for it.
    `stlc monitor` judges requirements on recordings. What a plan may choose is a state or an input
    of an agent.
    """

    code: ClassVar[str] = "E0804"
    title: ClassVar[str] = "nobody controls the recorded signal `{name}`"
    label: ClassVar[str] = "no plan can be made for it"
    help: ClassVar[str] = "judge a recording by `stlc monitor FILE TRACE.csv`, or declare an agent"
    name: str


class TooLargeNumber(Diagnostic):
    """A coefficient or a weight is so large that solvers refuse the model or lose its digits."""

    code: ClassVar[str] = "E0805"
    title: ClassVar[str] = "`{origin}` makes a {what} of {value:.3g}"
    label: ClassVar[str] = "too large for a solver's arithmetic, which ends at {limit:.0e}"
    help: ClassVar[str] = "choose a larger unit, or check the numbers"
    origin: str
    what: str
    value: float
    limit: float


class NoUpperBound(Diagnostic):
    """The robustness to maximise would be as large as one likes.

    What its requirements speak of has no limits: no workspace, and agents without bounds on their
    states and inputs. The best plan has them as far as can be, so there has to be a limit.
    """

    code: ClassVar[str] = "E0809"
    title: ClassVar[str] = "the robustness to maximise has no upper bound"
    label: ClassVar[str] = "holds by any margin"
    help: ClassVar[str] = (
        "add a `workspace`, or bounds to what it depends on, such as `control |u| <= 1`"
    )


def check_controlled(mission: Mission) -> None:
    """Raise MissionError for requirements on signals that nobody controls."""
    found: dict[str, Span | None] = {}
    for requirement in mission.requirements:
        for node in walk(requirement.formula):
            for signal, _ in node.terms if isinstance(node, Linear) else ():
                if signal.role is Role.FREE:
                    found.setdefault(signal.owner, node.span or requirement.span)
    if found:
        raise MissionError([RecordedSignal(span=span, name=name) for name, span in found.items()])


def check_bounded(goals: Sequence[Goal], requirements: Sequence[Requirement]) -> None:
    """Raise MissionError at what can hold by any margin and is to hold by the most."""
    for goal in goals:
        if not np.isfinite(goal.high):
            mine = (r for r in requirements if goal.requirement in (None, r.name))
            span = next((r.span for r in mine if r.span is not None), None)
            raise MissionError([NoUpperBound(span=span)])


def check_magnitudes(model: Model) -> None:
    """Raise MissionError at the origin of a coefficient, bound or cost that solvers can't take."""
    large = np.flatnonzero(~(np.abs(model.A.data) < LARGEST_COEFFICIENT))
    if len(large):
        row = int(np.searchsorted(model.A.indptr, large[0], side="right")) - 1
        value, limit = float(model.A.data[large[0]]), LARGEST_COEFFICIENT
        raise MissionError([_too_large(model.row_block(row), "coefficient", value, limit)])
    for ends in (model.row_lower, model.row_upper):
        large = np.flatnonzero(np.isfinite(ends) & (np.abs(ends) >= LARGEST_COEFFICIENT))
        if len(large):
            block, value = model.row_block(int(large[0])), float(ends[large[0]])
            raise MissionError([_too_large(block, "bound", value, LARGEST_COEFFICIENT)])
    large = np.flatnonzero(~(np.abs(model.c) < LARGEST_COST))
    if len(large):
        column = int(large[0])
        block = max((b for b in model.col_blocks if b.start <= column), key=lambda b: b.start)
        value = float(model.c[column])
        raise MissionError([_too_large(block, "weight", value, LARGEST_COST)])


def _too_large(block: Block, what: str, value: float, limit: float) -> TooLargeNumber:
    span, origin = block.origin.span, block.origin.label
    return TooLargeNumber(span=span, origin=origin, what=what, value=value, limit=limit)
