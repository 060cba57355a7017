"""Unrolls temporal operators: what is left is `and`, `or` and predicates at absolute steps.

A predicate at step t carries t as its shift, so the result is an ordinary formula judged at step
0. With p_t the unrolled p:

    always[a,b] p at t        = p_{t+a} and ... and p_{t+b}             (eventually: or)
    p until[0,b] q at t       = or over k of (P_k and q_{t+k}),   P_k = P_{k-1} and p_{t+k}
    p until[a,b] q at t       = always[0,a-1] p at t and (p until[0,b-a] q) at t+a

Windows that are needed at many steps share their parts by doubling,
W_2w(s) = W_w(s) and W_w(s + w), so that a nested window costs log w nodes a step; a long until at
many steps does the same with U_2w(s) = U_w(s) or (A_w(s) and U_w(s + w)).

Needs: nnf, horizon. Guarantees: only and, or, constants, predicates, negated chance links; equal
nodes are shared; robustness unchanged.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace

from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Release,
    Timed,
    Until,
)
from stlc.ir.rewrite import postorder
from stlc.ir.verify import Stage
from stlc.passes.base import Pass, Program

_DIRECT = 8  # windows up to this many steps are written out


def run(program: Program) -> Program:
    """Unroll every requirement from step 0."""
    unroller = _Unroller()
    steps = _needed_steps(program.formulas)
    for node in postorder(program.formulas):
        for step in sorted(steps[node]):
            unroller.done[node, step] = unroller.unroll(node, step, len(steps[node]))
    return program.with_formulas([unroller.done[f, 0] for f in program.formulas])


def _needed_steps(roots: tuple[Node, ...]) -> dict[Node, set[int]]:
    """The steps at which each node's value is asked for, from the roots at step 0 downwards."""
    steps: dict[Node, set[int]] = defaultdict(set)
    for root in roots:
        steps[root].add(0)
    for node in reversed(list(postorder(roots))):
        here = steps[node]
        match node:
            case Timed():
                for t in here:
                    steps[node.at(t)].add(t)
            case Always(arg=arg) | Eventually(arg=arg):
                steps[arg].update(_shifted(here, node.start, _end(node)))
            case Until() | Release():
                steps[node.left].update(_shifted(here, 0, _end(node)))
                steps[node.right].update(_shifted(here, node.start, _end(node)))
            case _:
                for child in node.children:
                    steps[child].update(here)
    return steps


def _shifted(steps: set[int], start: int, end: int) -> set[int]:
    return {t + k for t in steps for k in range(start, end + 1)}


def _end(node: Always | Eventually | Until | Release) -> int:
    assert node.end is not None, "the horizon pass closes every interval"
    return node.end


@dataclass(slots=True)
class _Unroller:
    done: dict[tuple[Node, int], Node] = field(default_factory=dict)
    known: dict[Node, Node] = field(default_factory=dict)
    windows: dict[tuple[object, ...], Node] = field(default_factory=dict)

    def share(self, node: Node) -> Node:
        """The node equal to this one that was made first."""
        return self.known.setdefault(node, node)

    def unroll(self, node: Node, step: int, uses: int) -> Node:
        """The node at an absolute step; `uses` is at how many steps it is needed."""
        match node:
            case Const():
                return self.share(node)
            case Linear() | Link() | Not():
                return self.share(_moved(node, step))
            case Timed():
                return self.done[node.at(step), step]
            case And() | Or():
                parts = tuple(self.done[c, step] for c in node.children)
                return self.share(type(node)(parts, span=node.span))
            case Always(arg=arg) | Eventually(arg=arg):
                kind = And if isinstance(node, Always) else Or
                return self.window(kind, node, arg, step + node.start, step + _end(node), uses)
            case Until() | Release():
                return self.until(node, step, uses)
        raise TypeError(f"{type(node).__name__} in normal form")

    def window(
        self, kind: type[And] | type[Or], node: Node, arg: Node, first: int, last: int, uses: int
    ) -> Node:
        """`arg` joined over the steps first..last; by two overlapping blocks of a power of two
        where several windows can share them."""
        width = last - first + 1
        if uses == 1 or width <= _DIRECT:
            parts = tuple(self.done[arg, t] for t in range(first, last + 1))
            return self.share(kind(parts, span=node.span))
        size = 1 << (width.bit_length() - 1)
        if size == width:
            return self.block(kind, node, arg, first, size)
        halves = [self.block(kind, node, arg, s, size) for s in (first, last + 1 - size)]
        return self.share(kind(tuple(halves), span=node.span))

    def block(
        self, kind: type[And] | type[Or], node: Node, arg: Node, first: int, size: int
    ) -> Node:
        """`arg` joined over `size` steps, a power of two, from halves that are shared."""
        if size == 1:
            return self.done[arg, first]
        key = (kind, arg, first, size)
        if key not in self.windows:
            half = size // 2
            halves = [self.block(kind, node, arg, s, half) for s in (first, first + half)]
            self.windows[key] = self.share(kind(tuple(halves), span=node.span))
        return self.windows[key]

    def until(self, node: Until | Release, step: int, uses: int) -> Node:
        """An until or release at a step: a choice for each witness, or by doubling where it is
        asked for often."""
        outer, inner = (Or, And) if isinstance(node, Until) else (And, Or)
        first, last = step + node.start, step + _end(node)
        width = last - first + 1
        if uses == 1 or width <= _DIRECT:
            choices = self._chain(node, inner, first, last)
        else:
            choices = [self._doubled(node, outer, inner, first, width)]
        body = choices[0] if len(choices) == 1 else self.share(outer(tuple(choices)))
        if node.start == 0:
            return body
        before = self.window(inner, node, node.left, step, first - 1, uses)
        return self.share(inner((before, body), span=node.span))

    def _chain(
        self, node: Until | Release, inner: type[And] | type[Or], first: int, last: int
    ) -> list[Node]:
        choices, prefix = [], None
        for t in range(first, last + 1):
            here = self.done[node.left, t]
            prefix = here if prefix is None else self.share(inner((prefix, here)))
            choices.append(self.share(inner((prefix, self.done[node.right, t]), span=node.span)))
        return choices

    def _doubled(
        self,
        node: Until | Release,
        outer: type[And] | type[Or],
        inner: type[And] | type[Or],
        first: int,
        width: int,
    ) -> Node:
        """An until over `width` witnesses from `first` on: in the earlier half, or held through it
        and in the later."""
        if width == 1:
            pair = (self.done[node.left, first], self.done[node.right, first])
            return self.share(inner(pair, span=node.span))
        key = (outer, node.left, node.right, first, width)
        if key not in self.windows:
            size = 1 << ((width - 1).bit_length() - 1)
            early = self._doubled(node, outer, inner, first, size)
            held = self.block(inner, node, node.left, first, size)
            late = self._doubled(node, outer, inner, first + size, width - size)
            later = self.share(inner((held, late)))
            self.windows[key] = self.share(outer((early, later), span=node.span))
        return self.windows[key]


def _moved(node: Linear | Link | Not, step: int) -> Node:
    """A predicate judged `step` steps later."""
    if step == 0:
        return node
    match node:
        case Linear(terms=terms):
            moved = tuple((replace(s, shift=s.shift + step), v) for s, v in terms)
            return replace(node, terms=moved)
        case Link(shift=shift):
            return replace(node, shift=shift + step)
        case Not(arg=arg):
            assert isinstance(arg, Link)
            return replace(node, arg=_moved(arg, step))


PASS = Pass("unroll", run, after=("nnf", "horizon"), stage=Stage.STEPS, lowering=True)
