"""Closes unbounded intervals for the horizon T.

An unbounded operator ranges over the steps at which its body can still be judged: with `last(f)`
the last such step of f (T for a state predicate, T - 1 for an input, less b for an operator over
[a, b]), at step t

    op[a, inf) f   =   op[a, last(f) - t] f.

Where t is 0 that is an interval; under another temporal operator it depends on t, and the formula
becomes `timed(op[a, last(f)] f, op[a, last(f) - 1] f, ...)`.

Needs: nothing. Guarantees: every interval is bounded; the robustness is unchanged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stlc.errors import UsageError
from stlc.ir.nodes import (
    Always,
    Const,
    Eventually,
    Linear,
    Link,
    Node,
    Release,
    Role,
    Timed,
    Until,
)
from stlc.ir.rewrite import postorder, with_children
from stlc.ir.verify import Stage
from stlc.passes.base import Pass, Program


def run(program: Program) -> Program:
    """Close every interval; UsageError for a formula that cannot be judged at step 0."""
    last = last_steps(program.formulas, program.horizon)
    for requirement in program.requirements:
        if last[requirement.formula] < 0:
            raise UsageError(
                f"requirement '{requirement.name}' looks {-last[requirement.formula]} steps past "
                f"the horizon of {program.horizon} steps"
            )
    closed = _closed_below(program.formulas, last)
    started = _started([closed[f] for f in program.formulas])
    return program.with_formulas([started[closed[f]] for f in program.formulas])


def last_steps(roots: tuple[Node, ...], horizon: int) -> dict[Node, int]:
    """For each sub-formula the last step at which it can be judged (negative: never)."""
    last: dict[Node, int] = {}
    for node in postorder(roots):
        last[node] = _last(node, last, horizon)
    return last


def _last(node: Node, last: dict[Node, int], horizon: int) -> int:
    """The last step at which a node can be judged, from those of its children; negative where there
    is none."""
    match node:
        case Const():
            return horizon
        case Linear(terms=terms):
            late = [s.shift + (1 if s.role is Role.INPUT else 0) for s, _ in terms]
            return horizon - max(late, default=0)
        case Link(shift=shift):
            return horizon - shift
        case Timed():
            judged = [t for t in range(horizon + 1) if last[node.at(t)] < t]
            return min(judged, default=horizon + 1) - 1
        case Always(start=a, end=b) | Eventually(start=a, end=b):
            return last[node.arg] - (a if b is None else b)
        case Until(start=a, end=b) | Release(start=a, end=b):
            return min(last[node.left], last[node.right]) - (a if b is None else b)
    return min((last[c] for c in node.children), default=horizon)


def _end(node: Node, last: dict[Node, int]) -> int:
    return min(last[child] for child in node.children)


def _is_open(node: Node) -> bool:
    return isinstance(node, Always | Eventually | Until | Release) and node.end is None


def _closed_below(roots: tuple[Node, ...], last: dict[Node, int]) -> dict[Node, Node]:
    closed: dict[Node, Node] = {}
    for node in postorder(roots):
        built = with_children(node, [closed[c] for c in node.children])
        if _is_open(node):
            ends = range(_end(node, last), _start(node) - 1, -1)
            built = Timed(tuple(_ending(built, end) for end in ends), span=node.span)
        closed[node] = built
    return closed


def _started(roots: Sequence[Node]) -> dict[Node, Node]:
    """Formulas at step 0, which is known above the first temporal operator: no `timed` there."""
    done: dict[Node, Node] = {}
    todo = list(roots)
    while todo:
        node = todo[-1]
        below = _below_start(node)
        unknown = [part for part in below if part not in done]
        todo += unknown
        if not unknown:
            parts = [done[part] for part in below]
            done[node] = _rebuilt(node, parts)
            todo.pop()
    return done


def _below_start(node: Node) -> tuple[Node, ...]:
    """What is judged at step 0 where a node is."""
    if isinstance(node, Timed):
        return (node.at(0),)
    return () if isinstance(node, Always | Eventually | Until | Release) else node.children


def _rebuilt(node: Node, parts: Sequence[Node]) -> Node:
    if isinstance(node, Timed):
        return parts[0]
    return with_children(node, parts) if parts else node


def _start(node: Node) -> int:
    assert isinstance(node, Always | Eventually | Until | Release)
    return node.start


def _ending(node: Node, end: int) -> Node:
    assert isinstance(node, Always | Eventually | Until | Release)
    return replace(node, end=end)


PASS = Pass("horizon", run, stage=Stage.BOUNDED, lowering=True, after=("nnf",))
