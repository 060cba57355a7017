"""Unrolls temporal operators: what is left is `and`, `or` and predicates at absolute steps.

A predicate at step t carries t as its shift, so the result is an ordinary formula judged at step
0. With p_t the unrolled p:

    always[a,b] p at t        = p_{t+a} and ... and p_{t+b}             (eventually: or)
    p until[0,b] q at t       = or over k of (P_k and q_{t+k}),   P_k = P_{k-1} and p_{t+k}
    p until[a,b] q at t       = always[0,a-1] p at t and (p until[0,b-a] q) at t+a

Windows that are needed at many steps share their parts. A conjunction over w steps is made by
doubling, W_2w(s) = W_w(s) and W_w(s + w): log w nodes a step. A disjunction must not count a step
twice, which would weaken the relaxation: time is cut into blocks of w steps, and a window is the
end of one block and the beginning of the next (van Herk, Pattern Recognition Letters 13, 1992),

    S(s) = p_s or S(s + 1),    P(e) = P(e - 1) or p_e,    W_w(s) = S(s) or P(s + w - 1)

which costs three nodes a step. An until over a long window at many steps splits into a window and
one chain without an end of its own (Donze, Ferrere and Maler, CAV 2013, lemma 1; exact for
robustness),

    p until[0,b] q at t  =  eventually[0,b] q at t  and  U(t),    U(t) = p_t and (q_t or U(t + 1))

with U(last) = p_last and q_last at the last step that any window reaches. Release is the dual.

Needs: nnf, horizon. Guarantees: only and, or, counts, networks, constants,
predicates, negated chance links; equal nodes are shared; robustness unchanged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from stlc.analysis.sizes import needed_steps
from stlc.ir.networks import Count, Network
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
    Signal,
    Timed,
    Until,
)
from stlc.ir.rewrite import postorder, with_children
from stlc.ir.verify import Stage
from stlc.passes.base import Pass, Program

_DIRECT = 8  # windows up to this many steps are written out


def run(program: Program) -> Program:
    """Unroll every requirement from step 0."""
    unroller = _Unroller()
    masks = needed_steps(program.formulas, program.horizon)
    steps = {node: _steps(mask) for node, mask in masks.items()}
    for node in postorder(program.formulas):
        lasts = _lasts(node, steps[node])
        for step in steps[node]:
            unroller.done[node, step] = unroller.unroll(node, step, len(steps[node]), lasts)
    return program.with_formulas([unroller.done[f, 0] for f in program.formulas])


def _lasts(node: Node, steps: Sequence[int]) -> Mapping[int, int]:
    """For each step of an until the last one of the touching windows that its own belongs to."""
    found: dict[int, int] = {}
    if not isinstance(node, Until | Release):
        return found
    first, last = -1, -1  # of the window after this one, and of all that touch it
    for step in reversed(steps):
        end = step + _end(node)
        last = last if first >= 0 and end >= first - 1 else end
        found[step], first = last, step + node.start
    return found


def _steps(mask: int) -> list[int]:
    """Places of the bits of a mask."""
    return [step for step, bit in enumerate(reversed(f"{mask:b}")) if bit == "1"]


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

    def unroll(self, node: Node, step: int, uses: int, lasts: Mapping[int, int]) -> Node:
        """The node at an absolute step; `uses` is at how many steps it is needed, `lasts` tells how
        far its windows go on."""
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
            case Count(args=args) | Network(args=args):
                return self.share(with_children(node, [self.done[c, step] for c in args]))
            case Always(arg=arg) | Eventually(arg=arg):
                kind = And if isinstance(node, Always) else Or
                return self.window(kind, node, arg, step + node.start, step + _end(node), uses)
            case Until() | Release():
                return self.until(node, step, uses, lasts)
        raise TypeError(f"{type(node).__name__} in normal form")

    def window(
        self, kind: type[And] | type[Or], node: Node, arg: Node, first: int, last: int, uses: int
    ) -> Node:
        """`arg` joined over the steps first..last; where several windows can share them, out of
        two blocks: of a power of two and overlapping for a conjunction, else see `sliding`."""
        width = last - first + 1
        if uses == 1 or width <= _DIRECT:
            parts = tuple(self.done[arg, t] for t in range(first, last + 1))
            return self.share(kind(parts, span=node.span))
        if kind is Or:
            return self.sliding(node, arg, first, width)
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

    def sliding(self, node: Node, arg: Node, first: int, width: int) -> Node:
        """A disjunction over a window, out of the end of one block and the start of the next."""
        border = -(-first // width) * width  # where the next block starts
        end = first + width - 1
        if border == first:
            return self.run_of(node, arg, border + width - 1, first)
        early = self.run_of(node, arg, border - 1, first)
        late = self.run_of(node, arg, border, end)
        return self.share(Or((early, late), span=node.span))

    def run_of(self, node: Node, arg: Node, origin: int, to: int) -> Node:
        """The disjunction over the steps between two, one more than that of the step before."""
        back = 1 if origin > to else -1
        step = to
        while step != origin and (arg, origin, step) not in self.windows:
            step += back
        built = self.done[arg, step] if step == origin else self.windows[arg, origin, step]
        while step != to:
            step -= back
            built = self.share(Or((self.done[arg, step], built), span=node.span))
            self.windows[arg, origin, step] = built
        return built

    def until(self, node: Until | Release, step: int, uses: int, lasts: Mapping[int, int]) -> Node:
        """An until or release at a step: a choice for each witness, or a window and a chain where
        it is asked for often."""
        outer, inner = (Or, And) if isinstance(node, Until) else (And, Or)
        first, last = step + node.start, step + _end(node)
        if uses == 1 or last - first < _DIRECT:
            choices = self._chain(node, inner, first, last)
            body = choices[0] if len(choices) == 1 else self.share(outer(tuple(choices)))
        else:
            near = self.window(outer, node, node.right, first, last, uses)
            body = self.share(inner((near, self.endless(node, first, lasts[step]))))
        if node.start == 0:
            return body
        before = self.window(inner, node, node.left, step, first - 1, uses)
        return self.share(inner((before, body), span=node.span))

    def endless(self, node: Until | Release, first: int, last: int) -> Node:
        """U(first) of an until whose witness may come as late as `last`."""
        outer, inner = (Or, And) if isinstance(node, Until) else (And, Or)
        left, right = node.left, node.right
        step = first
        while step <= last and (outer, left, right, last, step) not in self.windows:
            step += 1
        later = self.windows.get((outer, left, right, last, step))
        while step > first:
            step -= 1
            here = self.done[right, step]
            rest = here if later is None else self.share(outer((here, later), span=node.span))
            later = self.share(inner((self.done[left, step], rest), span=node.span))
            self.windows[outer, left, right, last, step] = later
        assert later is not None
        return later

    def _chain(
        self, node: Until | Release, inner: type[And] | type[Or], first: int, last: int
    ) -> list[Node]:
        choices, prefix = [], None
        for t in range(first, last + 1):
            here = self.done[node.left, t]
            prefix = here if prefix is None else self.share(inner((prefix, here)))
            choices.append(self.share(inner((prefix, self.done[node.right, t]), span=node.span)))
        return choices


def _moved(node: Linear | Link | Not, step: int) -> Node:
    """A leaf `step` steps later; leaves are shared between steps, hence never changed in place."""
    if step == 0:
        return node
    match node:
        case Linear(terms=terms):
            moved = tuple((Signal(s.owner, s.role, s.index, s.shift + step), v) for s, v in terms)
            return Linear(
                moved, node.constant, node.unit, span=node.span, swept=node.swept,
                member=node.member, norms=node.norms,
            )  # fmt: skip
        case Link(shift=shift):
            return replace(node, shift=shift + step)
        case Not(arg=arg):
            assert isinstance(arg, Link)
            return replace(node, arg=_moved(arg, step))


PASS = Pass("unroll", run, after=("nnf", "horizon"), stage=Stage.STEPS, lowering=True)
