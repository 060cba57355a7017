"""What a formula still asks for once its first steps are known: progression with robustness.

With the run known at steps 0..k (inputs up to k - 1), the formula g = progress(f) over the steps
from k on, judged at its own step 0, has on every continuation the robustness of f on the whole
run. At a step t:

    a predicate at t <= k     what it is worth there: a constant (of its signals those that are
                              known, if others lie ahead)
    f at t > k                always[t - k, t - k] f
    always[a,b] f at t <= k   f at each known step of t+a..t+b, and always[a', b'] f at k with
                              a' = max(1, t + a - k), b' = t + b - k       (eventually: or)
    f until[a,b] g at t <= k  or over known t' of t+a..t+b of (g at t', f at t..t'); or f at t..k
                              and the until of what is left at k + 1       (release: the dual)

Unbounded operators stay so: they range over the steps at which their body can be judged, before
and after. Bacchus and Kabanza, Annals of Mathematics and Artificial Intelligence 22, 1998, for
truth; min and max in place of `and` and `or` give robustness.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Quantity,
    Release,
    Role,
    Signal,
    Timed,
    Until,
    walk,
)
from stlc.ir.rewrite import rewrite, with_children

Known = Callable[[Node, int], float | None]
Value = Callable[[Signal, int], float]


@dataclass(slots=True)
class Progression:
    """Formulas at step `now`.

    `known(node, t)` is what a predicate (or a node that is judged whole) is worth at a step t up to
    now, None where it looks ahead; `value(signal, t)` is a signal then. `last` are the last
    steps at which formulas can be judged.
    """

    now: int
    known: Known
    value: Value
    last: dict[Node, int]
    _done: dict[tuple[Node, int], Node] = field(default_factory=dict)
    _later: dict[Node, Node] = field(default_factory=dict)

    def of(self, formula: Node) -> Node:
        """What the formula, judged at step 0, still asks for."""
        return self._at(formula, 0)

    def _at(self, node: Node, step: int) -> Node:
        if step > self.now:
            return _delayed(self._shifted(node), step - self.now)
        key = node, step
        if key not in self._done:
            self._done[key] = self._progressed(node, step)
        return self._done[key]

    def _shifted(self, node: Node) -> Node:
        """The same formula where steps are counted from now on."""
        if node not in self._later:
            (self._later[node],) = rewrite([node], self._recounted)
        return self._later[node]

    def _recounted(self, node: Node) -> Node:
        if not isinstance(node, Timed):
            return node
        first = min(self.now, len(node.cases) - 1)
        return replace(node, cases=node.cases[first:])

    def _progressed(self, node: Node, step: int) -> Node:
        """The node judged at a step that is past, or now."""
        if _is_whole(node):
            worth = self.known(node, step)
            if worth is not None:
                return _constant(worth, node)
            if step == self.now and not isinstance(node, Linear):
                return self._shifted(node)
        match node:
            case Const():
                return node
            case Linear():
                return self._partly(node, step)
            case Link(shift=shift):
                return replace(node, shift=step + shift - self.now)
            case Timed():
                return self._at(node.at(step), step)
            case Always() | Eventually():
                return self._window(node, step)
            case Until() | Release():
                return self._until(node, step)
        return self._connective(node, step)

    def _connective(self, node: Node, step: int) -> Node:
        """A node whose value comes from its parts at the same step."""
        parts = [self._at(child, step) for child in node.children]
        match node:
            case And() | Or():
                return _joined(type(node), parts, node)
            case Not():
                return _negated(parts[0], node)
            case Implies():
                return _joined(Or, (_negated(parts[0], node), parts[1]), node)
            case Iff():
                left, right = parts
                one = _joined(Or, (_negated(left, node), right), node)
                return _joined(And, (one, _joined(Or, (left, _negated(right, node)), node)), node)
            case Count() | Network():
                return with_children(node, parts)
        raise TypeError(f"no progression of {type(node).__name__}")

    def _partly(self, node: Linear, step: int) -> Node:
        """A predicate some of whose signals are known."""
        ahead, constant = [], node.constant
        for signal, factor in node.terms:
            at = step + signal.shift
            past = at < self.now or (at == self.now and signal.role is Role.STATE)
            if past:
                constant += factor * self.value(signal, at)
            else:
                ahead.append((signal._replace(shift=at - self.now), factor))
        terms = tuple(sorted(ahead, key=lambda item: item[0].key))
        return Linear(terms, constant, node.unit, span=node.span)

    def _window(self, node: Always | Eventually, step: int) -> Node:
        kind = And if isinstance(node, Always) else Or
        first, last = self._ends(node, step, self.last[node.arg])
        parts = [self._at(node.arg, t) for t in range(first, min(last, self.now) + 1)]
        if last > self.now:
            end = None if node.end is None else last - self.now
            start = max(first - self.now, 1)
            parts.append(replace(node, arg=self._shifted(node.arg), start=start, end=end))
        return _joined(kind, parts, node)

    def _until(self, node: Until | Release, step: int) -> Node:
        """A choice for each witness that is past, and one of those that lie ahead."""
        outer, inner = (Or, And) if isinstance(node, Until) else (And, Or)
        first, last = self._ends(node, step, min(self.last[c] for c in node.children))
        held = [self._at(node.left, t) for t in range(step, min(last, self.now) + 1)]
        choices = [
            _joined(inner, (*held[: t - step + 1], self._at(node.right, t)), node)
            for t in range(first, min(last, self.now) + 1)
        ]
        if last > self.now:
            end = None if node.end is None else last - self.now - 1
            rest = replace(
                node, left=self._shifted(node.left), right=self._shifted(node.right),
                start=max(first - self.now - 1, 0), end=end,
            )  # fmt: skip
            choices.append(_joined(inner, (*held, _delayed(rest, 1)), node))
        return _joined(outer, choices, node)

    def _ends(
        self, node: Always | Eventually | Until | Release, step: int, last: int
    ) -> tuple[int, int]:
        return step + node.start, last if node.end is None else step + node.end


def _is_whole(node: Node) -> bool:
    """Whether a node is judged as one: its parts stand for something else together."""
    if isinstance(node, Linear | Link) or node.swept is not None or node.norms is not None:
        return True
    return isinstance(node, Network) and node.composed


def _constant(worth: float, node: Node) -> Node:
    if worth in (float("inf"), -float("inf")):
        return Const(worth > 0, span=node.span)
    return Linear((), float(worth), unit_of(node), span=node.span)


def unit_of(node: Node) -> str:
    """Unit of a node's robustness; that of its first predicate where they differ."""
    if node.norms is not None:
        return node.norms.unit
    for part in walk(node):
        if isinstance(part, Linear):
            return part.unit
        if isinstance(part, Link):
            decibels = part.quantity in (Quantity.RSSI, Quantity.SNR)
            return "dB" if decibels or part.probability is not None else ""
    return ""


def _delayed(node: Node, steps: int) -> Node:
    if steps == 0 or isinstance(node, Const):
        return node
    return Always(node, steps, steps, span=node.span)


def _negated(node: Node, of: Node) -> Node:
    match node:
        case Const(value=value):
            return Const(not value, span=of.span)
        case Linear(terms=(), constant=constant):
            return replace(node, constant=-constant)
    return Not(node, span=of.span)


def _joined(kind: type[And] | type[Or], parts: Iterable[Node], of: Node) -> Node:
    """A conjunction or disjunction, flat, with one constant of each unit."""
    neutral = kind is And
    worst: dict[str, Linear] = {}
    kept: dict[Node, None] = {}
    for part in _flat(kind, parts):
        match part:
            case Const(value=value):
                if value is not neutral:
                    return Const(value, span=of.span)
            case Linear(terms=()):
                other = worst.get(part.unit)
                pick = min if neutral else max
                if other is None or pick(part.constant, other.constant) == part.constant:
                    worst[part.unit] = part
            case _:
                kept[part] = None
    args: Sequence[Node] = (*worst.values(), *kept)
    if not args:
        return Const(neutral, span=of.span)
    return args[0] if len(args) == 1 else kind(tuple(args), span=of.span)


def _flat(kind: type[And] | type[Or], parts: Iterable[Node]) -> Iterable[Node]:
    for part in parts:
        meant = _is_whole(part) or part.member is not None
        if isinstance(part, And | Or) and type(part) is kind and not meant:
            yield from _flat(kind, part.args)
        else:
            yield part
