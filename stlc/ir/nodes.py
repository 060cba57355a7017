"""The intermediate representation: frozen STL nodes over linear and link predicates.

Semantics (discrete steps t = 0..T; rho is the robustness, satisfied means rho >= margin):

* `Linear`: rho = constant + sum of coefficient * signal(t + shift).
* `Link`: rho = factor (quantity - threshold) for `>=`, factor (threshold - quantity) for `<=`.
* `Always[a,b] f`: min over t' in [t+a, t+b]; `Eventually`: max.
* `Until[a,b] (f, g)`: max over t' in [t+a, t+b] of min(g at t', f at every step of [t, t']).
* `Release[a,b] (f, g)`: the dual, not(not f until[a,b] not g).
* `Timed(cases)`: at absolute step t it is `cases[t]` (the last case stays for ever); it states
  what changes with the clock, such as a moving obstacle.

An interval whose upper end is None is unbounded; the horizon pass closes it. Nodes compare by
structure and keep their hash, so that hash-consing costs one look-up a node; nodes that were found
to be equal remember it. `span` says where a node came from and takes no part in comparison.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from functools import partial

from stlc.ir.claims import Membership
from stlc.ir.claims import Motion as Motion
from stlc.ir.claims import Swept as Swept
from stlc.ir.equality import equal
from stlc.ir.norms import Norms
from stlc.ir.signals import Quantity as Quantity
from stlc.ir.signals import Relation as Relation
from stlc.ir.signals import Role as Role
from stlc.ir.signals import Signal as Signal
from stlc.source import Span


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """Base of all nodes; equality and hash are structural, over `key`.

    `span`, `swept`, `member` and `norms` take no part in them.
    """

    span: Span | None = field(default=None, repr=False, kw_only=True)
    swept: Swept | None = field(default=None, repr=False, kw_only=True)
    member: Membership | None = field(default=None, repr=False, kw_only=True)
    norms: Norms | None = field(default=None, repr=False, kw_only=True)
    _hash: int = field(default=0, init=False, repr=False, kw_only=True)
    _same: Node | None = field(default=None, init=False, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((type(self).__name__, self.key)))

    def __reduce__(self) -> tuple[object, ...]:
        """Made anew where it is read: hashes of strings differ from process to process."""
        values = {f.name: getattr(self, f.name) for f in fields(self) if f.init}
        return partial(type(self), **values), ()

    @property
    def key(self) -> tuple[object, ...]:
        """Everything that makes two nodes of one type equal."""
        return ()

    @property
    def own(self) -> tuple[object, ...]:
        """The key but for the parts, and how many of these there are."""
        return (len(self.children), *(part for part in self.key if not isinstance(part, Node)))

    @property
    def children(self) -> tuple[Node, ...]:
        """Direct sub-formulas, left to right."""
        return ()

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Node) or type(self) is not type(other):
            return False
        if self._hash != other._hash:
            return False
        key = other.key
        if self.key is key:
            return True  # the arguments of a copy with another span
        return equal(self, other) if self.children else self.key == key


@dataclass(frozen=True, slots=True, eq=False)
class Const(Node):
    """True or false at every step; its robustness is +inf or -inf."""

    value: bool

    @property
    def key(self) -> tuple[object, ...]:
        """The value."""
        return (self.value,)


Terms = tuple[tuple[Signal, float], ...]
"""Signals with their factors: sum factor * signal."""


@dataclass(frozen=True, slots=True, eq=False)
class Linear(Node):
    """`constant + sum(coefficient * signal) >= 0`; terms sorted by signal key, none zero."""

    terms: tuple[tuple[Signal, float], ...]
    constant: float
    unit: str = ""  # unit of the robustness: "m", "m/s", "" for a pure number

    @property
    def key(self) -> tuple[object, ...]:
        """Terms, constant and unit."""
        return (self.terms, self.constant, self.unit)


@dataclass(frozen=True, slots=True, eq=False)
class Link(Node):
    """`quantity(sender, receiver) relation threshold` on a channel, `shift` steps later.

    With `probability` p it is the chance form P(quantity relation threshold) >= p for one packet.
    `factor` > 0 is what the quantity is multiplied by in the file: it scales the robustness.
    `tight`: its robustness matters beyond the threshold too.
    """

    channel: str
    quantity: Quantity
    sender: str
    receiver: str
    relation: Relation
    threshold: float
    probability: float | None = None
    shift: int = 0
    factor: float = 1.0
    tight: bool = False

    @property
    def key(self) -> tuple[object, ...]:
        """All fields that have a meaning: the span is none of them."""
        return (
            self.channel, self.quantity, self.sender, self.receiver,
            self.relation, self.threshold, self.probability, self.shift, self.factor,
            self.tight,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Unary(Node):
    arg: Node

    @property
    def key(self) -> tuple[object, ...]:
        return (self.arg,)

    @property
    def children(self) -> tuple[Node, ...]:
        return (self.arg,)


@dataclass(frozen=True, slots=True, eq=False)
class _Nary(Node):
    args: tuple[Node, ...]

    @property
    def key(self) -> tuple[object, ...]:
        return self.args

    @property
    def children(self) -> tuple[Node, ...]:
        return self.args


@dataclass(frozen=True, slots=True, eq=False)
class _Binary(Node):
    left: Node
    right: Node

    @property
    def key(self) -> tuple[object, ...]:
        return (self.left, self.right)

    @property
    def children(self) -> tuple[Node, ...]:
        return (self.left, self.right)


@dataclass(frozen=True, slots=True, eq=False)
class Not(_Unary):
    """Negation."""


@dataclass(frozen=True, slots=True, eq=False)
class And(_Nary):
    """Conjunction; of nothing it is true."""


@dataclass(frozen=True, slots=True, eq=False)
class Or(_Nary):
    """Disjunction; of nothing it is false."""


@dataclass(frozen=True, slots=True, eq=False)
class Implies(_Binary):
    """`not left or right`."""


@dataclass(frozen=True, slots=True, eq=False)
class Iff(_Binary):
    """`(left implies right) and (right implies left)`."""


@dataclass(frozen=True, slots=True, eq=False)
class _TemporalUnary(_Unary):
    start: int
    end: int | None  # None: unbounded

    @property
    def key(self) -> tuple[object, ...]:
        return (self.arg, self.start, self.end)


@dataclass(frozen=True, slots=True, eq=False)
class _TemporalBinary(_Binary):
    start: int
    end: int | None

    @property
    def key(self) -> tuple[object, ...]:
        return (self.left, self.right, self.start, self.end)


@dataclass(frozen=True, slots=True, eq=False)
class Always(_TemporalUnary):
    """Minimum over the window."""


@dataclass(frozen=True, slots=True, eq=False)
class Eventually(_TemporalUnary):
    """Maximum over the window."""


@dataclass(frozen=True, slots=True, eq=False)
class Until(_TemporalBinary):
    """`left` at every step up to and including the one in the window at which `right` holds."""


@dataclass(frozen=True, slots=True, eq=False)
class Release(_TemporalBinary):
    """Dual of `Until`."""


@dataclass(frozen=True, slots=True, eq=False)
class Timed(Node):
    """`cases[t]` at absolute step t; the last case stays for ever."""

    cases: tuple[Node, ...]

    @property
    def key(self) -> tuple[object, ...]:
        """The cases, one a step."""
        return self.cases

    @property
    def children(self) -> tuple[Node, ...]:
        """The cases: case k is what holds when the formula is asked at step k."""
        return self.cases

    def at(self, step: int) -> Node:
        """The formula that holds at an absolute step."""
        return self.cases[min(step, len(self.cases) - 1)]


def walk(root: Node) -> Iterator[Node]:
    """Every distinct node below and with `root`, parents first, without recursion."""
    seen: set[Node] = set()
    todo = [root]
    while todo:
        node = todo.pop()
        if node in seen:
            continue
        seen.add(node)
        yield node
        todo.extend(reversed(node.children))
