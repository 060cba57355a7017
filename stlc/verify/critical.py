"""Which predicate decides a robustness, at which step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Motion,
    Node,
    Not,
    Or,
    Quantity,
    Release,
    Timed,
    Until,
)
from stlc.source import Span
from stlc.verify.robustness import Evaluator, unit


@dataclass(frozen=True, slots=True)
class Decider:
    """The predicate that decides a robustness: its step and unit, where it stands, what it says."""

    step: int
    unit: str
    span: Span | None
    says: str


_ALIKE = 1e-9  # values that the same plan has on another machine, or after it was read again

Visit = tuple[Node, int, bool]
"""A part of a formula, the step at which it is asked, and its polarity there."""


def descent(evaluator: Evaluator, root: Node) -> Iterator[tuple[Visit, list[Visit]]]:
    """From a judged formula at step 0 to the predicate that decides it: each part, with what its
    value was chosen from (nothing for the last).

    Follows the arguments at which each minimum or maximum is taken.
    """
    visit: Visit = root, 0, True
    while True:
        node, step, positive = visit
        found = isinstance(node, Linear | Link)
        options = [] if found else _options(evaluator, node, step, positive)
        yield visit, options
        if not options:
            return
        target = evaluator.judged(node, positive)[step]
        # The sign of a value turns exactly where the polarity does.
        values = [
            evaluator.judged(n, sign)[t] * (1.0 if sign is positive else -1.0)
            for n, t, sign in options
        ]
        visit = options[_nearest(values, float(target))]


def critical(evaluator: Evaluator, root: Node) -> Decider | None:
    """The predicate that decides the robustness of a judged formula at step 0.

    None for a constant.
    """
    says = ""
    for (node, step, _), _ in descent(evaluator, root):
        says = _claimed(node) or says
        if isinstance(node, Linear | Link):
            shift = node.shift if isinstance(node, Link) else 0
            text = "" if node.span is None else " ".join(node.span.text.split())
            return Decider(step + shift, unit(node), node.span, says or text)
    return None


def _claimed(node: Node) -> str:
    """What a node says of an agent and a place by their own names, if it does."""
    member, swept = node.member, node.swept
    if member is not None and isinstance(member.subject, str):
        return f"{member.subject} {'in' if member.inside else 'outside'} {member.place}"
    if swept is not None and swept.place is not None:
        return f"{swept.agent} {'in' if swept.motion is Motion.INSIDE else 'outside'} {swept.place}"
    if isinstance(node, Link) and node.probability is None:
        value = f"{node.quantity.value}({node.sender}, {node.receiver})"
        level = {Quantity.RSSI: " dBm", Quantity.SNR: " dB"}.get(node.quantity, "")
        return f"{value} {node.relation.value} {node.threshold:g}{level}"
    return ""


def _nearest(values: Sequence[float], target: float) -> int:
    """Index of the first value that equals the target but for rounding, or of the closest."""
    for k, value in enumerate(values):
        if value == target or abs(value - target) <= _ALIKE:
            return k
    return int(np.argmin(np.nan_to_num(np.abs(np.asarray(values) - target), nan=np.inf)))


def _options(
    evaluator: Evaluator, node: Node, step: int, positive: bool
) -> list[tuple[Node, int, bool]]:
    """(sub-formula, step, polarity); the node's value is one of theirs, up to sign."""
    match node:
        case Not(arg=arg):
            return [(arg, step, not positive)]
        case And(args=args) | Or(args=args) | Count(args=args) | Network(args=args):
            return [(arg, step, positive) for arg in args]
        case Implies(left=left, right=right):
            return [(left, step, not positive), (right, step, positive)]
        case Iff(left=left, right=right):
            return [(n, step, s) for n in (left, right) for s in (positive, not positive)]
        case Timed():
            return [(node.at(step), step, positive)]
        case Always(arg=arg, start=a, end=b) | Eventually(arg=arg, start=a, end=b):
            last = len(evaluator.judged(arg, positive)) - 1
            stop = last if b is None else min(step + b, last)
            return [(arg, t, positive) for t in range(step + a, stop + 1)]
        case _:
            return _until_options(evaluator, node, step, positive)


def _until_options(
    evaluator: Evaluator, node: Node, step: int, positive: bool
) -> list[tuple[Node, int, bool]]:
    """What an until's witness step is judged by comes first, then all else within its window.

    A release has the step that is worst for it.
    """
    if not isinstance(node, Until | Release):
        return []
    sign = 1.0 if isinstance(node, Until) else -1.0
    left, right = (sign * evaluator.judged(child, positive) for child in node.children)
    last = min(len(left), len(right)) - 1
    last = last if node.end is None else min(step + node.end, last)
    first = step + node.start
    held = np.minimum.accumulate(left[step : last + 1])[node.start :]
    found = np.minimum(held, right[first : last + 1])
    witness = first + int(np.flatnonzero(found >= found.max() - _ALIKE)[0])
    ways = [(node.right, witness), *((node.left, t) for t in range(step, witness + 1))]
    rest = [(node.left, t) for t in range(step, last + 1)]
    rest += [(node.right, t) for t in range(first, last + 1)]
    return [(part, t, positive) for part, t in dict.fromkeys(ways + rest)]
