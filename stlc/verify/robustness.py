"""Quantitative semantics of STL on sampled runs, with numpy.

Every formula is judged at the leading steps 0..L-1 of a run, where L depends on how far it looks
ahead: a bounded operator needs its whole window, an unbounded one ranges over the steps at which
its body can still be judged. Arrays are therefore shorter than the run; an empty one says that
the formula can't be judged at all.

Sliding extrema take O(L log w) by doubling; until takes O(L) by the decomposition
f U[a,b] g = G[0,a] f and F[a,b] g and F[a,a] (f U g), which is exact for robustness
(Donze, Ferrere and Maler, Efficient robust monitoring for STL, CAV 2013, lemma 1).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import reduce

import numpy as np
from numpy.typing import NDArray

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
    Timed,
    Until,
)
from stlc.ir.norms import Norms, Sum
from stlc.verify import networks
from stlc.verify.clocked import by_the_clock
from stlc.verify.trace import Array, Trace
from stlc.verify.windows import until, window_min

TOLERANCE = 1e-6
"""A formula is satisfied when its robustness is at least its margin minus this."""


Judged = tuple[Node, bool]  # a node, and whether it counts positively
Key = tuple[int, bool]
Override = Callable[[Node], Array | None]


class Evaluator:
    """Judges formulas on one run; what was judged is kept, so shared parts are judged once.

    `override(node)` may give the robustness of a node in place of its definition (None: it
    doesn't); it must depend on the node's structure and claims alone. `scales` divide the
    robustness of predicates by unit.
    """

    def __init__(
        self,
        trace: Trace,
        override: Override | None = None,
        scales: Mapping[str, float] | None = None,
        *,
        faces: bool = False,
    ) -> None:
        self._faces = faces
        self.trace = trace
        self._override = override
        self._scales = dict(scales or {})
        self._number: dict[tuple[object, ...], int] = {}  # structure -> class of equal nodes
        self._class: dict[Key, int] = {}  # id of a node, polarity -> its class
        self._given: dict[int, Array | None] = {}  # id of a node -> what its parts aren't asked for
        self._values: list[Array] = []
        self._alive: list[Node] = []  # keeps the ids above valid

    def robustness(self, node: Node) -> Array:
        """Robustness (L,) at the steps where `node` can be judged.

        Raises KeyError for a signal the run doesn't have, ValueError for a link predicate on a
        run without a radio.
        """
        return self.judged(node)

    def judged(self, node: Node, positive: bool = True) -> Array:
        """Robustness of a part of a formula, by its polarity there."""
        for part, sign in _postorder((node, positive), self._class, self._parts):
            self._judge(part, sign)
        return self._values[self._class[id(node), positive]]

    def _parts(self, node: Node, positive: bool) -> tuple[Judged, ...]:
        return () if self._known(node) is not None else _parts(node, positive)

    def _known(self, node: Node) -> Array | None:
        """The value of a node that doesn't come from those of its parts."""
        if id(node) not in self._given:
            self._alive.append(node)
            value = self._override(node) if self._override else None
            if value is None and isinstance(node, Timed) and not self.trace.spread:
                value = by_the_clock(node.cases, self.trace, self._scaled)
            self._given[id(node)] = value
        return self._given[id(node)]

    def _judge(self, node: Node, positive: bool) -> None:
        """Values `node` under its polarity, once for each class of equal nodes with equal parts."""
        # Hash-consing on the way: equality of deep nodes is recursive, equality of classes isn't.
        given = self._known(node)
        if given is not None:
            self._class[id(node), positive] = len(self._values)
            self._values.append(given)
            return
        parts = [self._class[id(child), sign] for child, sign in _parts(node, positive)]
        own = tuple(k for k in node.key if not isinstance(k, Node))
        told = isinstance(node, Link) or (bool(self.trace.spread) and not node.children)
        key = (type(node), node.norms, own, *parts, told and positive)
        number = self._number.get(key)
        if number is None:
            number = self._number[key] = len(self._values)
            self._values.append(self._value(node, parts, positive))
        self._class[id(node), positive] = number

    def _value(self, node: Node, parts: list[int], positive: bool) -> Array:
        if node.norms is not None and not self._faces and self._exact(node.norms):
            steps = min(len(self._values[k]) for k in parts)  # faces of a motion look ahead
            return self._scaled(_lengths(node.norms, self.trace)[:steps], node.norms.unit)
        value = _value(node, [self._values[k] for k in parts], self.trace, positive)
        return self._scaled(value, unit(node)) if isinstance(node, Linear | Link) else value

    def _exact(self, norms: Norms) -> bool:
        """Whether nobody who takes part is off its run; else the faces are judged."""
        return not norms.owners & {owner for owner, _ in self.trace.spread}

    def _scaled(self, value: Array, measured_in: str) -> Array:
        return np.asarray(value / self._scales.get(measured_in, 1.0)) if self._scales else value


def _parts(node: Node, positive: bool) -> tuple[Judged, ...]:
    """What the value of a node is made of: sub-formulas, each with its polarity."""
    match node:
        case Not(arg=arg):
            return ((arg, not positive),)
        case Implies(left=left, right=right):
            return ((left, not positive), (right, positive))
        case Iff(left=left, right=right):
            return tuple((x, sign) for sign in (positive, not positive) for x in (left, right))
        case _:
            return tuple((child, positive) for child in node.children)


def unit(node: Linear | Link) -> str:
    """Unit of a predicate's robustness."""
    if isinstance(node, Linear):
        return node.unit
    decibels = node.quantity in (Quantity.RSSI, Quantity.SNR)
    return "dB" if decibels or node.probability is not None else ""


def robustness(node: Node, trace: Trace) -> Array:
    """Robustness (L,) of one formula; see `Evaluator.robustness`."""
    return Evaluator(trace).robustness(node)


def satisfaction(node: Node, trace: Trace, margin: float = 0.0) -> NDArray[np.bool_]:
    """Whether the robustness reaches `margin` (less TOLERANCE) at each step that can be judged."""
    return robustness(node, trace) >= margin - TOLERANCE


def _postorder(
    root: Judged,
    done: Mapping[Key, int],
    parts: Callable[[Node, bool], tuple[Judged, ...]],
) -> Iterator[Judged]:
    """Parts not in `done`, children first, without recursion."""
    todo: list[tuple[Judged, bool]] = [(root, False)]
    while todo:
        judged, expanded = todo.pop()
        if (id(judged[0]), judged[1]) in done:
            continue
        if expanded:
            yield judged
            continue
        todo.append((judged, True))
        todo.extend((part, False) for part in parts(*judged))


def _value(node: Node, parts: list[Array], trace: Trace, positive: bool) -> Array:
    """Robustness at each step that can still be judged, from the children's; (steps[, runs])."""
    match node:
        case Const(value=value):
            return trace.filled(trace.length, np.inf if value else -np.inf)
        case Linear():
            found = _linear(node, trace)
            return np.asarray(found - trace.off(node.terms, positive)) if trace.spread else found
        case Link():
            return _link(node, trace, positive)
        case Timed():
            return _timed(parts, trace)
        case Always(start=a, end=b):
            return window_min(parts[0], a, b)
        case Eventually(start=a, end=b):
            return -window_min(-parts[0], a, b)
        case Until(start=a, end=b):
            return until(parts[0], parts[1], a, b)
        case Release(start=a, end=b):
            return -until(-parts[0], -parts[1], a, b)
        case _:
            return _boolean(node, parts, trace)


def _boolean(node: Node, parts: list[Array], trace: Trace) -> Array:
    """Connectives over steps; `parts` of Iff are both sides, then both under negation."""
    match node:
        case Count():
            return networks.counted(node, _leading(parts))
        case Network():
            return networks.network(node, _leading(parts))
        case Not():
            return -parts[0]
        case And():
            return minimum(parts, trace)
        case Or():
            return -minimum([-p for p in parts], trace)
        case Implies():
            left, right = _aligned(*parts)
            return np.asarray(np.maximum(-left, right))
        case Iff():
            left, right, not_left, not_right = (p[: min(map(len, parts))] for p in parts)
            return np.asarray(
                np.minimum(np.maximum(-not_left, right), np.maximum(-not_right, left))
            )
        case _:
            raise TypeError(f"no semantics for {type(node).__name__}")


def _leading(parts: list[Array]) -> list[Array]:
    shortest = min(map(len, parts))
    return [part[:shortest] for part in parts]


def _aligned(left: Array, right: Array) -> tuple[Array, Array]:
    length = min(len(left), len(right))
    return left[:length], right[:length]


def _lengths(norms: Norms, trace: Trace) -> Array:
    """rest + sum of coefficient * sqrt(x^2 + y^2 + ..) at the common leading steps."""
    parts = [_linear(norms.rest, trace)]
    for coefficient, components in norms.lengths:
        values = [_linear(c, trace) for c in components]
        count = min(map(len, values))
        parts.append(coefficient * reduce(np.hypot, [v[:count] for v in values]))
    shortest = min(map(len, parts))
    return np.asarray(sum(part[:shortest] for part in parts), dtype=np.float64)


def _linear(node: Linear | Sum, trace: Trace) -> Array:
    columns = [(trace.signal(signal), coefficient) for signal, coefficient in node.terms]
    length = min((len(column) for column, _ in columns), default=trace.length)
    total = trace.filled(length, float(node.constant))
    for column, coefficient in columns:
        total = total + coefficient * column[:length]
    return total


def _link(node: Link, trace: Trace, positive: bool) -> Array:
    if trace.link is None:
        raise ValueError(f"the run has no radio to judge {node.quantity.value} on")
    return trace.link(node, positive)[node.shift :]


def _timed(parts: list[Array], trace: Trace) -> Array:
    """The value of each step's own case, until one can't be judged."""
    judged: list[Array] = []
    for step in range(max(map(len, parts), default=0)):
        case = parts[min(step, len(parts) - 1)]
        if step >= len(case):
            break
        judged.append(case[step])
    if not judged:
        return trace.filled(0, 0.0)
    return np.stack(np.broadcast_arrays(*judged))


def minimum(parts: list[Array], trace: Trace) -> Array:
    """Minimum over the common leading steps; of nothing it is +inf at every step."""
    shortest = min(map(len, parts), default=trace.length)
    total = trace.filled(shortest, np.inf)
    for part in parts:
        total = np.minimum(total, part[:shortest])
    return total
