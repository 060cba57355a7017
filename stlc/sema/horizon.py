"""The mission's horizon: given, or the furthest step that a bounded interval looks at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from stlc.ir.nodes import (
    Always,
    Eventually,
    Linear,
    Link,
    Node,
    Release,
    Role,
    Until,
)
from stlc.ir.requirement import Requirement
from stlc.sema.report import Report
from stlc.sema.time_errors import NoHorizon, PastHorizon
from stlc.source import Span

Temporal = Always | Eventually | Until | Release


@dataclass(slots=True)
class Reach:
    """How far formulas look ahead, in steps; an unbounded operator needs its first step only."""

    known: dict[int, int] = field(default_factory=dict)
    kept: list[Node] = field(default_factory=list)
    unbounded: bool = False

    def of(self, node: Node) -> int:
        """Steps after the present one that the formula needs."""
        todo = [node]
        while todo:  # formulas may be deeper than Python's stack
            part = todo[-1]
            unknown = [c for c in part.children if id(c) not in self.known and c.children]
            todo += unknown
            if not unknown:
                for each in (*part.children, part):
                    self._keep(each)
                todo.pop()
        return self.known[id(node)]

    def _keep(self, node: Node) -> None:
        if id(node) not in self.known:
            self.known[id(node)] = self._compute(node)
            self.kept.append(node)

    def _compute(self, node: Node) -> int:
        """The same of a node whose parts are known."""
        parts = max((self.known[id(child)] for child in node.children), default=0)
        match node:
            case Linear(terms=terms):
                return max((s.shift + (s.role is Role.INPUT) for s, _ in terms), default=0)
            case Link(shift=shift):
                return shift
            case Always() | Eventually() | Until() | Release():
                return self._window(node) + parts
        return parts

    def _window(self, node: Temporal) -> int:
        if node.end is None:
            self.unbounded = True
            return node.start
        return node.end


def derive(
    requirements: Sequence[Requirement],
    given: int | None,
    least: int,
    agent: Span | None,
    report: Report,
) -> int:
    """T. Reports what looks past a given horizon, and a mission of unbounded operators alone.

    `least` is the furthest step that the objective's windows name; `agent` is where one is
    declared, None where the formulas are for recorded signals, whose length is the horizon.
    """
    reach = Reach()
    needed = [reach.of(r.formula) for r in requirements]
    longest = max([least, *needed])
    if given is None:
        if agent and longest == 0 and (reach.unbounded or not requirements):
            report.add(_no_horizon(requirements, agent))
        return max(longest, 1)
    for requirement, count in zip(requirements, needed, strict=True):
        if count > given:
            report.add(_past(requirement.formula, 0, given, reach))
    return given


def _no_horizon(requirements: Sequence[Requirement], agent: Span) -> NoHorizon:
    if requirements:
        return NoHorizon(span=requirements[0].formula.span)
    return NoHorizon(span=agent, reason="no requirement says how long it moves")


def _past(node: Node, at: int, horizon: int, reach: Reach) -> PastHorizon:
    """The innermost operator that alone carries the formula past the horizon."""
    while True:
        after = at + (reach._window(node) if isinstance(node, Temporal) else 0)
        if after > horizon:
            break
        beyond = [c for c in node.children if after + reach.of(c) > horizon]
        if not beyond:
            break
        node, at = max(beyond, key=reach.of), after
    return PastHorizon(span=node.span, needed=at + reach.of(node), horizon=horizon)
