"""Obstacles that touch, kept out of by one agent at the same time, leave no way between them.

`a outside p and a outside q` holds on a common border of p and q. Where both must hold at a step,
so must `a outside` each plug over a contact of the two (`junctions.py`). A plug lies within
p and q, so it forbids nothing but the seam; a contact in one point takes a square of 2 mm. Where
the two move differently, one plug goes with p over what q covers all the time until the next step,
and one with q: together they cover a contact no shorter than what one moves past the other. Two
obstacles count together where a conjunction demands both: that of all requirements, `and`,
`forall`, with the windows of `always` intersected. Formulas under a negation are left alone.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

from stlc.ir.nodes import Always, And, Eventually, Implies, Node, Or, Release, Until
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import with_children
from stlc.mission import Agent
from stlc.sema.heights import EVERY, Levels, kept_from
from stlc.sema.junctions import touching
from stlc.sema.members import flies, point
from stlc.sema.membership import keep
from stlc.sema.plugs import Sweeps, box_of, plugs_of_three, plugs_of_two
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.space_errors import NotInSpace
from stlc.sema.stacks import meeting, stacked
from stlc.sema.values import Place, Radio
from stlc.sema.windows import Window, common, merged
from stlc.source import Span

_Key = tuple[str, int, bool]  # agent, shape, swept
_OPEN = And | Or | Always | Eventually | Until | Release  # as strong as their parts


@dataclass(frozen=True, slots=True)
class _Avoided:
    """An agent keeps out of a place."""

    agent: Radio
    place: Place
    swept: bool
    span: Span | None


def joined(requirements: Sequence[Requirement], scope: Scope) -> list[Requirement]:
    """The requirements, with the seams between touching obstacles closed.

    As they are where one of these can't be closed, which is reported.
    """
    with scope.report.guard():
        return _joined(requirements, scope)
    return list(requirements)


def _joined(requirements: Sequence[Requirement], scope: Scope) -> list[Requirement]:
    joints = _Joints(scope, dict(_known(scope)))
    found = [replace(r, formula=joints.closed(r.formula)) for r in requirements]
    seams = joints.between([joints.avoided(r.formula) for r in found])
    for k, more in enumerate(seams):
        if more:
            formula = found[k].formula
            found[k] = replace(found[k], formula=And((formula, *more), span=formula.span))
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


@dataclass(frozen=True, slots=True, eq=False)
class _Kept:
    """What is avoided, and the windows of steps, merged."""

    avoided: _Avoided
    windows: tuple[Window, ...]

    @property
    def shape(self) -> int:
        return id(self.avoided.place.shape)


@dataclass(slots=True)
class _Joints:
    scope: Scope
    known: dict[Node, _Avoided]
    done: dict[Node, Node] = field(default_factory=dict)
    kept: dict[Node, Mapping[_Key, _Kept]] = field(default_factory=dict)
    plugs: dict[tuple[tuple[int, ...], bool], list[Sweeps]] = field(default_factory=dict)
    made: dict[Hashable, Node] = field(default_factory=dict)
    neighbours: dict[int, frozenset[int]] = field(default_factory=dict)

    def closed(self, node: Node) -> Node:
        """The formula with plugs in every conjunction that demands two touching places."""
        for each in _new(node, self.done, self._parts):
            self.done[each] = self._closed(each)
        return self.done[node]

    def _parts(self, node: Node) -> Sequence[Node]:
        """Those parts of a formula whose seams count, which a negation's don't."""
        if isinstance(node, Implies):
            return (node.right,)
        return node.children if isinstance(node, _OPEN) and node not in self.known else ()

    def _closed(self, node: Node) -> Node:
        """The same of a node whose parts are closed already."""
        if node in self.known:
            return node
        match node:
            case And(args=args):
                parts = [self.done[a] for a in args]
                more = [n for seam in self.between(map(self.avoided, parts)) for n in seam]
                return replace(node, args=(*parts, *more)) if more else with_children(node, parts)
            case Implies(left=left, right=right):
                return with_children(node, [left, self.done[right]])
        parts = [self.done[c] for c in self._parts(node)]
        return with_children(node, parts) if parts else node

    def avoided(self, node: Node) -> Mapping[_Key, _Kept]:
        """What a formula demands to keep out of, whatever else holds."""
        for each in _new(node, self.kept, self._demanded):
            self.kept[each] = self._avoided(each)
        return self.kept[node]

    def _demanded(self, node: Node) -> Sequence[Node]:
        """The parts that hold wherever the formula does."""
        return node.children if isinstance(node, And | Always) and node not in self.known else ()

    def _avoided(self, node: Node) -> Mapping[_Key, _Kept]:
        """The same of a node whose parts are known already."""
        found: dict[_Key, _Kept] = {}
        if node in self.known:
            _add(found, self.known[node])
        elif isinstance(node, And):
            for arg in node.args:
                for kept in self.kept[arg].values():
                    _add(found, kept.avoided, kept.windows)
        elif isinstance(node, Always):
            end = inf if node.end is None else node.end
            for kept in self.kept[node.arg].values():
                later = [(a + node.start, b + end) for a, b in kept.windows]
                _add(found, kept.avoided, later)
        return found

    def between(self, groups: Iterable[Mapping[_Key, _Kept]]) -> Iterator[list[Node]]:
        """For each group, conditions on the seams of its places with those of groups before it."""
        before: dict[_Key, _Kept] = {}
        for own in groups:
            found: dict[Node, None] = {}
            for kept in own.values() if before else ():
                for nodes in self._seams(kept, before, own):
                    found |= dict.fromkeys(nodes)
            yield list(found)
            for kept in own.values():
                _add(before, kept.avoided, kept.windows)

    def _seams(
        self, a: _Kept, before: Mapping[_Key, _Kept], own: Mapping[_Key, _Kept]
    ) -> Iterator[list[Node]]:
        """Conditions on what a place has in common with one before it, and a third of any group."""
        near = self._near()
        for b in _kept(a, near[a.shape], before):
            yield self._conditions((a, b))
            if not self._touch(a, b):
                continue
            thirds = near[a.shape] & near[b.shape]
            later = [c for c in _kept(a, thirds, before) if id(c) > id(b)]
            for c in (*later, *_kept(a, thirds, own)):
                if self._touch(a, c):
                    yield self._conditions((a, b, c))

    def _touch(self, a: _Kept, b: _Kept) -> bool:
        """Whether two places touch, at their borders or as one stands on the other."""
        return stacked(_levels((a.avoided, b.avoided))) or bool(self._plugs((a, b)))

    def _near(self) -> Mapping[int, frozenset[int]]:
        """For each shape those whose boxes it touches at any time."""
        if not self.neighbours:
            shapes = {id(k.place.shape): k.place for k in self.known.values()}
            self.neighbours.update(touching({key: box_of(p) for key, p in shapes.items()}))
        return self.neighbours

    def _conditions(self, kept: Sequence[_Kept]) -> list[Node]:
        """Keep out of the plugs between places, in the windows that all have in common."""
        windows = kept[0].windows
        for other in kept[1:]:
            windows = common(windows, other.windows)
        if not windows:
            return []
        first, last = kept[0].avoided, kept[1].avoided
        span = first.span or last.span
        assert span is not None, "a condition of the file has its place in it"
        levels, plugs = _meeting([k.avoided for k in kept], lambda: self._plugs(kept))
        if not plugs:
            return []
        swept = all(k.avoided.swept for k in kept)
        parts = tuple(self._outside(sweeps, first.agent, swept, levels, span) for sweeps in plugs)
        node = parts[0] if len(parts) == 1 else And(parts, span=span)
        return [_within(node, *window) for window in windows]

    def _outside(
        self, plugs: Sweeps, agent: Radio, swept: bool, levels: Levels, span: Span
    ) -> Node:
        """Keep an agent out of plugs: the same node where two pairs meet in one point."""
        shape = tuple((s.move, *(p.vertices.tobytes() for p in s.pieces)) for s in plugs)
        key = (agent.name, shape, swept, levels)
        if key not in self.made:
            where = point(agent, span)
            self.made[key] = keep(where, plugs, False, swept, self.scope, span, levels)
        return self.made[key]

    def _plugs(self, kept: Sequence[_Kept]) -> list[Sweeps]:
        swept = all(k.avoided.swept for k in kept)
        key = (tuple(sorted(k.shape for k in kept)), swept)
        if key not in self.plugs:
            places = [k.avoided.place for k in kept]
            two = len(places) == 2
            self.plugs[key] = (
                plugs_of_two(places[0], places[1], swept) if two else plugs_of_three(places, swept)
            )
        return self.plugs[key]


def _new(
    root: Node, known: Mapping[Node, object], parts: Callable[[Node], Sequence[Node]]
) -> Iterator[Node]:
    """What isn't known of a formula, which may be deeper than Python's stack: parts first."""
    todo = [root]
    while todo:
        node = todo[-1]
        unknown = [part for part in parts(node) if part not in known]
        todo += unknown
        if not unknown:
            todo.pop()
            if node not in known:
                yield node


def _meeting(
    avoided: Sequence[_Avoided], plugs: Callable[[], list[Sweeps]]
) -> tuple[Levels, list[Sweeps]]:
    """Between which heights places leave a way for an agent [m], and what closes it.

    Mistake where one stands on another and one of them moves.
    """
    agent, each = avoided[0].agent, _levels(avoided)
    if not (isinstance(agent.thing, Agent) and flies(agent)):
        low, high = max(e[0] for e in each), min(e[1] for e in each)
        return (low, high), plugs() if low < high else []
    found = meeting([a.place for a in avoided], each, plugs)
    if found is None:
        names = " and ".join(f"`{a.place.shape.name}`" for a in avoided)
        where = f"touch at the height {max(e[0] for e in each):g} m"
        problem = f"{names} {where}, one of them moves, and `{agent.name}` keeps out of all"
        hint = "let their heights overlap by a millimetre or more, or leave a gap"
        span = avoided[-1].span or avoided[0].span
        raise Mistake(NotInSpace(span=span, problem=problem, hint=hint))
    return found


def _levels(avoided: Sequence[_Avoided]) -> list[Levels]:
    """The heights of each place that its agent keeps out of [m]."""
    return [kept_from(a.place.heights or EVERY, a.agent.thing) for a in avoided]


def _within(node: Node, start: float, end: float) -> Node:
    """A node at the steps of a window."""
    if start == end == 0.0:
        return node
    return Always(node, int(start), None if end == inf else int(end), span=node.span)


def _add(
    kept: dict[_Key, _Kept], avoided: _Avoided, windows: Sequence[Window] = ((0.0, 0.0),)
) -> None:
    """Count in what is avoided, within windows of steps."""
    key = (avoided.agent.name, id(avoided.place.shape), avoided.swept)
    known = kept.get(key)
    kept[key] = _Kept(avoided, merged([*(known.windows if known else ()), *windows]))


def _kept(a: _Kept, shapes: Iterable[int], among: Mapping[_Key, _Kept]) -> Iterator[_Kept]:
    """What the same agent keeps out of, of some shapes."""
    for shape in shapes:
        for swept in (False, True):
            found = among.get((a.avoided.agent.name, shape, swept))
            if found is not None:
                yield found
