"""Mistakes about names, kinds and calls (E02xx)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class UnknownName(Diagnostic):
    """A name is used that nothing in the mission declares.

    Names come from declarations (`agent`, `station`, `region`, `obstacle`, `channel`, `param`,
    `signal`, `let`), from quantifiers and from the parameters of a `let`. The order of
    declarations doesn't matter. Upper and lower case differ.
    """

    code: ClassVar[str] = "E0201"
    title: ClassVar[str] = "unknown name `{name}`"
    label: ClassVar[str] = "not declared anywhere"
    help: ClassVar[str] = "{hint}"
    name: str
    hint: str


class Redeclared(Diagnostic):
    """Two declarations, or two requirements, have the same name.

    All declarations share one space of names, so that `goal` means one thing wherever it stands.
    Requirements have a space of their own. Properties of a block and frames of a moving obstacle
    are given once too.
    """

    code: ClassVar[str] = "E0202"
    title: ClassVar[str] = "`{name}` is declared twice"
    label: ClassVar[str] = "declared again here"
    help: ClassVar[str] = "{hint}"
    name: str
    hint: str = "rename one of the two"


class WrongKind(Diagnostic):
    """Something stands where something of another kind is needed.

    For example a region where a number is needed, or an agent where a formula is needed.
    """

    code: ClassVar[str] = "E0203"
    title: ClassVar[str] = "expected {expected}, found {found}"
    label: ClassVar[str] = "this is {found}"
    help: ClassVar[str] = "{hint}"
    expected: str
    found: str
    hint: str = ""


class WrongArity(Diagnostic):
    """A function or a `let` is used with the wrong number of arguments."""

    code: ClassVar[str] = "E0204"
    title: ClassVar[str] = "`{name}` takes {expected}, not {found}"
    label: ClassVar[str] = "{found} given"
    help: ClassVar[str] = "write `{usage}`"
    name: str
    expected: str
    found: int
    usage: str


class RecursiveLet(Diagnostic):
    """A `let` or a `param` is defined through itself.

    Definitions are expanded before solving, so each must end. State repetition over time with
    `always`, `eventually` or `until`, and over things with `forall` and `exists`.
    """

    code: ClassVar[str] = "E0205"
    title: ClassVar[str] = "`{name}` is defined through itself"
    label: ClassVar[str] = "leads back to `{name}`"
    help: ClassVar[str] = "use a temporal operator or a quantifier for repetition"
    name: str


class UnknownMember(Diagnostic):
    """A signal or property that the thing doesn't have.

    An agent has the states and inputs of its dynamics, the outputs declared there, and, if it has
    a position, `x` and `y`. Inputs and states can also be indexed: `r1.u[0]`, `r1.state[2]`.
    """

    code: ClassVar[str] = "E0206"
    title: ClassVar[str] = "{owner} has no `{name}`"
    label: ClassVar[str] = "unknown here"
    help: ClassVar[str] = "{hint}"
    owner: str
    name: str
    hint: str


class UnknownProperty(Diagnostic):
    """A block has a property that its kind doesn't know.

    Agents know `start control speed state turn_rate mass effort_state effort_input integer
    start_noise control_noise disturbance antenna` and the names of their states and inputs,
    unicycles and cars `heading lookahead period` besides; the language guide lists those of
    every kind.
    """

    code: ClassVar[str] = "E0207"
    title: ClassVar[str] = "{owner} has no property `{name}`"
    label: ClassVar[str] = "unknown property"
    help: ClassVar[str] = "{hint}"
    owner: str
    name: str
    hint: str


class BadProperty(Diagnostic):
    """The value of a property doesn't have the form that the property needs."""

    code: ClassVar[str] = "E0208"
    title: ClassVar[str] = "`{name}` {problem}"
    label: ClassVar[str] = "here"
    help: ClassVar[str] = "write it as `{usage}`"
    name: str
    problem: str
    usage: str


class Nonlinear(Diagnostic):
    """A predicate isn't (piecewise) linear, and a MILP can't hold it exactly.

    Sums, differences, products with constants, `abs`, `min`, `max`, `norm1` and `norminf` are
    linearised exactly; `distance(a, b)` by a polygon that is sound on both sides. Products and
    quotients of signals, powers, and functions such as `sin` aren't.
    """

    code: ClassVar[str] = "E0209"
    title: ClassVar[str] = "{what} is not linear"
    label: ClassVar[str] = "can't be written as linear constraints"
    help: ClassVar[str] = "{hint}"
    what: str
    hint: str


class NotNegatable(Diagnostic):
    """A `swept` condition stands under a negation.

    `swept` is a sufficient condition on the motion between two steps. Its negation would only be
    necessary, so a plan that satisfies it might not do what it says.
    """

    code: ClassVar[str] = "E0211"
    title: ClassVar[str] = "`swept` can't be negated"
    label: ClassVar[str] = "under a negation, or left of an implication"
    help: ClassVar[str] = "leave out `swept` here: the condition is then judged at the steps"


class TooDeep(Diagnostic):
    """An expression is nested more deeply than any mission needs."""

    code: ClassVar[str] = "E0212"
    title: ClassVar[str] = "nested more than {limit} levels deep"
    label: ClassVar[str] = "this level"
    help: ClassVar[str] = "name parts of it with `let`"
    limit: int


class TooManyPieces(Diagnostic):
    """A piecewise-linear comparison, or a quantifier, expands to too many parts.

    Each `abs`, `min` or `max` multiplies the number of linear pieces, and each quantifier the
    number of sub-formulas.
    """

    code: ClassVar[str] = "E0213"
    title: ClassVar[str] = "this expands to more than {limit} parts"
    label: ClassVar[str] = "too many combinations"
    help: ClassVar[str] = "split it into several requirements"
    limit: int


class TooLarge(Diagnostic):
    """A file says in few words what takes too long to write out.

    Quantifiers within quantifiers multiply, and definitions that use each other twice with other
    arguments double at each level; moving obstacles have their polygons at every step. All of it
    ends up in one model, so what is too large to check is far too large to solve.
    """

    code: ClassVar[str] = "E0224"
    title: ClassVar[str] = "this expands to {size}, too many to check"
    label: ClassVar[str] = "too large"
    help: ClassVar[str] = "{hint}"
    size: str
    hint: str = "use smaller domains, or state it for the instances that matter"


class NoPosition(Diagnostic):
    """An agent without a position is used where a position is needed.

    Regions, separation and radio links need to know where an agent is. Dynamics given by matrices
    have a position if two states are called `px` and `py`, or if `position` names two states.
    """

    code: ClassVar[str] = "E0214"
    title: ClassVar[str] = "agent `{name}` has no position"
    label: ClassVar[str] = "needs a position"
    help: ClassVar[str] = "say which states they are in its dynamics: `position px, py`"
    name: str


class CannotRead(Diagnostic):
    """A file that the mission names can't be read.

    Files are read from under the mission's folder only, unless `--allow-path` names another.
    """

    code: ClassVar[str] = "E0215"
    title: ClassVar[str] = "can't read `{path}`"
    label: ClassVar[str] = "{reason}"
    help: ClassVar[str] = "{hint}"
    path: str
    reason: str
    hint: str = "check the name; paths are relative to the file that names them"


class ImportCycle(Diagnostic):
    """Files import one another in a circle."""

    code: ClassVar[str] = "E0216"
    title: ClassVar[str] = "`{path}` imports itself in the end"
    label: ClassVar[str] = "closes the circle"
    help: ClassVar[str] = "move what both need into a third file"
    path: str


class NotHere(Diagnostic):
    """A statement stands in a place where it has no meaning, or stands there twice."""

    code: ClassVar[str] = "E0218"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "here"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str


class DivisionByZero(Diagnostic):
    """A constant is divided by zero, or grows beyond what a number can hold."""

    code: ClassVar[str] = "E0219"
    title: ClassVar[str] = "this is not a finite number"
    label: ClassVar[str] = "division by zero or overflow"
    help: ClassVar[str] = "check the parameters it uses"


class UnknownOverride(Diagnostic):
    """`-D name=value` names a parameter that the mission doesn't declare."""

    code: ClassVar[str] = "E0220"
    title: ClassVar[str] = "`-D {name}=..` names no `param` of this mission"
    help: ClassVar[str] = "{hint}"
    name: str
    hint: str


class BadOverride(Diagnostic):
    """`-D name=value` needs a number, with or without a unit."""

    code: ClassVar[str] = "E0222"
    title: ClassVar[str] = "`-D {name}={value}` is not a number with a known unit"
    help: ClassVar[str] = "write for example `-D {name}=3` or `-D {name}='3 m/s'`"
    name: str
    value: str


class EmptyDomain(Diagnostic):
    """A quantifier ranges over nothing, or over something that has no members.

    Domains are `agents`, `pairs`, `stations`, `regions`, `obstacles`, a family, a list such as
    `[goal1, goal2]`, and a range of whole numbers such as `0..8`.
    """

    code: ClassVar[str] = "E0221"
    title: ClassVar[str] = "there is nothing to range over: {problem}"
    label: ClassVar[str] = "empty or not a domain"
    help: ClassVar[str] = "use `agents`, `pairs`, `regions`, a list `[a, b]` or a range `0..8`"
    problem: str
