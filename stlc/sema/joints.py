"""Obstacles that touch, kept out of by one agent at the same time, leave no way between them.

`a outside p and a outside q` holds on a common border of p and q. Where both must hold at a step,
so must `a outside` each plug over a contact of the two (`seams.plugs_between`). A plug lies within
p and q, so it forbids nothing but the seam; a contact in one point takes a square of 2 mm. Where
the two move differently, one plug goes with p over what q covers all the time until the next step,
and one with q: together they cover a contact no shorter than what one moves past the other. Two
obstacles count together where a conjunction demands both: that of all requirements, `and`,
`forall`, with the windows of `always` intersected. Formulas under a negation are left alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from math import inf

import numpy as np

from stlc.ir.nodes import Always, And, Eventually, Implies, Node, Or, Release, Until
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import with_children
from stlc.places import Sweep
from stlc.sema.members import point
from stlc.sema.membership import keep
from stlc.sema.scope import Scope
from stlc.sema.seams import plugs_between
from stlc.sema.tracks import lasting
from stlc.sema.values import Place, Radio
from stlc.source import Span

Sweeps = tuple[Sweep, ...]


@dataclass(frozen=True, slots=True)
class _Avoided:
    """An agent keeps out of a place from step `start` to `end`, as seen from where it is said."""

    agent: Radio
    place: Place
    swept: bool
    span: Span | None
    start: float = 0.0
    end: float = 0.0

    def later(self, start: float, end: float) -> _Avoided:
        return replace(self, start=self.start + start, end=self.end + end)


def joined(requirements: Sequence[Requirement], scope: Scope) -> list[Requirement]:
    """The requirements, with the seams between touching obstacles closed."""
    joints = _Joints(scope, dict(_known(scope)))
    found = [replace(r, formula=joints.closed(r.formula)) for r in requirements]
    for k, item in enumerate(found):
        before = [a for r in found[:k] for a in joints.avoided(r.formula)]
        more = joints.between([before, list(joints.avoided(item.formula))])
        if more:
            formula = And((item.formula, *more), span=item.formula.span)
            found[k] = replace(item, formula=formula)
    return found


def _known(scope: Scope) -> Iterator[tuple[Node, _Avoided]]:
    """Formulas that keep an agent out of a place."""
    places = [Place(o) for o in scope.obstacles.values()]
    places += [Place(r) for r in scope.regions.values()]
    shapes = {id(p.shape): p for p in places}
    for key, node in scope.memo.items():
        if isinstance(key, tuple) and key[0] == "member" and key[3] == "outside":
            subject, place = key[1], shapes.get(key[2])
            if isinstance(subject, Radio) and place is not None:
                yield node, _Avoided(subject, place, key[4], node.span)


@dataclass(slots=True)
class _Joints:
    scope: Scope
    known: dict[Node, _Avoided]
    done: dict[Node, Node] = field(default_factory=dict)
    plugs: dict[tuple[int, int, bool], list[Sweeps]] = field(default_factory=dict)

    def closed(self, node: Node) -> Node:
        """The formula with plugs in every conjunction that demands two touching places."""
        if node not in self.done:
            self.done[node] = self._closed(node)
        return self.done[node]

    def _closed(self, node: Node) -> Node:
        if node in self.known:
            return node
        match node:
            case And(args=args):
                parts = [self.closed(a) for a in args]
                more = self.between([list(self.avoided(p)) for p in parts])
                return replace(node, args=(*parts, *more)) if more else with_children(node, parts)
            case Or() | Always() | Eventually() | Until() | Release():
                return with_children(node, [self.closed(c) for c in node.children])
            case Implies(left=left, right=right):
                return with_children(node, [left, self.closed(right)])
        return node

    def avoided(self, node: Node) -> Iterator[_Avoided]:
        """What a formula demands to keep out of, whatever else holds."""
        if node in self.known:
            yield self.known[node]
        elif isinstance(node, And):
            for arg in node.args:
                yield from self.avoided(arg)
        elif isinstance(node, Always):
            end = inf if node.end is None else node.end
            for found in self.avoided(node.arg):
                yield found.later(node.start, end)

    def between(self, groups: Sequence[Sequence[_Avoided]]) -> list[Node]:
        """Conditions on the seams of places from different groups."""
        found: dict[Node, None] = {}
        for one, other in combinations(groups, 2):
            for a in one:
                for b in other:
                    node = self._seam(a, b)
                    if node is not None:
                        found[node] = None
        return list(found)

    def _seam(self, a: _Avoided, b: _Avoided) -> Node | None:
        start, end = max(a.start, b.start), min(a.end, b.end)
        if a.agent != b.agent or a.place.shape is b.place.shape or start > end:
            return None
        swept = a.swept and b.swept
        plugs = self._plugs(a.place, b.place, swept)
        if not plugs:
            return None
        span = b.span or a.span
        assert span is not None, "a condition of the file has its place in it"
        where = point(a.agent, span)
        parts = tuple(keep(where, sweeps, False, swept, self.scope, span) for sweeps in plugs)
        node = parts[0] if len(parts) == 1 else And(parts, span=span)
        if start == end == 0.0:
            return node
        return Always(node, int(start), None if end == inf else int(end), span=span)

    def _plugs(self, a: Place, b: Place, swept: bool) -> list[Sweeps]:
        key = (id(a.shape), id(b.shape), swept)
        if key not in self.plugs:
            self.plugs[key] = _plugs(a, b, swept)
        return self.plugs[key]


def _plugs(a: Place, b: Place, swept: bool) -> list[Sweeps]:
    """Plugs at each step, in the frame of either where the two move differently until the next."""
    one, other = (
        p.sweeps if swept else tuple(Sweep(pieces) for pieces in p.barriers) for p in (a, b)
    )
    found = []
    for t in range(max(len(one), len(other))):
        x, y = one[min(t, len(one) - 1)], other[min(t, len(other) - 1)]
        if np.abs(np.subtract(x.move, y.move)).max() <= 1e-9:
            found.append((Sweep(plugs_between(x.pieces, y.pieces), x.move), Sweep(())))
        else:
            found.append((_carried(x, y), _carried(y, x)))
    return [sweeps for sweeps in zip(*found, strict=True) if any(s.pieces for s in sweeps)]


def _carried(one: Sweep, other: Sweep) -> Sweep:
    """Plugs that move with the first, over what stays in contact until the next step."""
    away = np.subtract(other.move, one.move)
    return Sweep(plugs_between(one.pieces, lasting(other.pieces, away)), one.move)
