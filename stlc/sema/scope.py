"""What is known while a mission is analysed: declarations, their values, the report."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import prod
from typing import TYPE_CHECKING

from stlc.bezier import Curve
from stlc.dynamics import Dynamics
from stlc.ir.claims import Membership
from stlc.ir.nodes import Node, Signal
from stlc.mission import Agent, Array, Channel, Station
from stlc.places import Obstacle, Polytope, Region, Wall
from stlc.sema.name_errors import RecursiveLet, TooDeep, TooLarge, UnknownName, WrongKind
from stlc.sema.report import Mistake, Report, Reported, suggested_fix, suggestion
from stlc.sema.scalars import absolute, maximum
from stlc.sema.unit_errors import WrongUnit
from stlc.sema.units import Unit
from stlc.sema.values import (
    Chance,
    ChannelName,
    Env,
    Items,
    Members,
    Place,
    Radio,
    Scalar,
    Separation,
    Tally,
    Text,
    Truth,
    Value,
    describe,
)
from stlc.source import Span
from stlc.syntax import ast

if TYPE_CHECKING:
    from stlc.sema.signals import Need

MOST_LEVELS = 110
MOST_WORK = 600_000
"""Evaluations of one file: some three seconds and 300 MB. A file of 100 kB without quantifiers and
definitions needs 50 000 at most."""

DOMAINS = ("agents", "pairs", "stations", "regions", "obstacles")
"""Words that stand for all things of a kind, unless a declaration has the name."""

EMPTY = Env({})


@dataclass(slots=True)
class Scope:
    """State of one analysis. `evaluate` is the evaluator, handed in by who builds the scope."""

    report: Report
    evaluate: Callable[[ast.Expr, Env, Scope], Value]
    overrides: Mapping[str, Scalar] = field(default_factory=dict)
    declarations: dict[str, ast.Statement] = field(default_factory=dict)
    values: dict[str, Value] = field(default_factory=dict)
    broken: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)
    evaluating: list[str] = field(default_factory=list)
    memo: dict[Hashable, Node] = field(default_factory=dict)
    asked: dict[Membership, tuple[Value, Place, ast.Membership]] = field(default_factory=dict)
    curves: dict[tuple[str, int | None], Curve | None] = field(default_factory=dict)
    points: dict[Hashable, tuple[list[tuple[Signal, float]], float]] = field(default_factory=dict)
    numbers: dict[Hashable, Scalar] = field(default_factory=dict)
    uses: dict[Hashable, set[str]] = field(default_factory=dict)
    cost_lets: dict[str, bool] = field(default_factory=dict)
    work: int = 0  # evaluations so far
    placed: int = 0  # polygons of moving obstacles so far, over their steps
    instances: list[tuple[int, Span]] = field(default_factory=list)  # of the quantifiers around
    depth: int = 0
    step: float = 1.0
    last_step: int = 0  # T as far as it is known, for obstacles that move for ever
    workspace: Polytope | None = None
    space_levels: tuple[float, float] | None = None  # its floor and ceiling [m]
    unread_workspace: bool = False  # it is declared, with a mistake
    models: dict[str, Dynamics] = field(default_factory=dict)
    agents: dict[str, Agent] = field(default_factory=dict)
    stations: dict[str, Station] = field(default_factory=dict)
    regions: dict[str, Region] = field(default_factory=dict)
    obstacles: dict[str, Obstacle] = field(default_factory=dict)
    walls: dict[str, Wall] = field(default_factory=dict)
    channels: dict[str, Channel] = field(default_factory=dict)
    starts: dict[str, Span] = field(default_factory=dict)
    pairs: dict[str, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    requirements: list[str] = field(default_factory=list)
    times: dict[str, tuple[ast.Expr, Env]] = field(default_factory=dict)  # that cost
    signals: dict[str, Unit | None] = field(default_factory=dict)
    series: dict[str, Array] = field(default_factory=dict)  # values of signals known beforehand
    needs: list[Need] = field(default_factory=list)  # how far comparisons with them are known
    given_horizon: int | None = None
    totals: dict[str, tuple[ast.Expr, Env]] = field(default_factory=dict)  # that cost

    # --- evaluation, with the kind that is needed ---------------------------------------------

    def value(self, expr: ast.Expr, env: Env = EMPTY) -> Value:
        """Whatever the expression is. Raises Mistake or Reported."""
        if self.depth >= MOST_LEVELS:
            raise Mistake(TooDeep(span=expr.span, limit=MOST_LEVELS))
        if self.work >= MOST_WORK:
            raise self._too_large(expr.span)
        self.depth += 1
        self.work += 1
        try:
            return self.evaluate(expr, env, self)
        finally:
            self.depth -= 1

    def spend(self, work: int, span: Span, size: str = "") -> None:
        """Count in what takes as long as some evaluations. Raises Mistake or Reported."""
        if self.work > MOST_WORK:
            raise Reported
        self.work += work
        if self.work > MOST_WORK:
            raise Mistake(TooLarge(span=span, size=size or f"more than {MOST_WORK:,} parts"))

    def _too_large(self, span: Span) -> Mistake | Reported:
        if self.work > MOST_WORK:
            return Reported()
        self.work += 1
        counts = [count for count, _ in self.instances]
        size = f"{prod(counts):.3g} instances" if counts else f"more than {MOST_WORK:.3g} parts"
        place = self.instances[0][1] if counts else span
        return Mistake(TooLarge(span=place, size=size))

    @contextmanager
    def expanded(self, key: Hashable) -> Iterator[None]:
        """Notes which names a definition uses, for the times when its value is known already."""
        outer, self.used = self.used, set()
        try:
            yield
        finally:
            self.uses[key] = self.used
            self.used = outer | self.used

    def known(self, key: Hashable) -> Node | Scalar | None:
        """The value that a definition was found to have."""
        found = self.memo.get(key) or self.numbers.get(key)
        if found is not None:
            self.used |= self.uses.get(key, set())
        return found

    def keep(self, key: Hashable, value: Value) -> Value:
        """Keep a definition's value, if it is a formula or a number."""
        if isinstance(value, Truth):
            self.memo[key] = value.node
        elif isinstance(value, Scalar):
            self.numbers[key] = value
        return value

    def scalar(self, expr: ast.Expr, env: Env = EMPTY) -> Scalar:
        """The expression as a number or a piecewise-linear signal."""
        return as_scalar(self.value(expr, env), expr.span)

    def constant(self, expr: ast.Expr, env: Env = EMPTY) -> Scalar:
        """The expression as a number known now."""
        scalar = self.scalar(expr, env)
        if not scalar.is_constant:
            raise Mistake(
                WrongKind(span=expr.span, expected="a constant", found="a signal of the run")
            )
        return scalar

    def number(self, expr: ast.Expr, unit: Unit, env: Env = EMPTY) -> float:
        """The value of a constant in the given unit; a bare number is taken to be in it."""
        scalar = self.constant(expr, env)
        if scalar.unit is not None and scalar.unit != unit:
            raise Mistake(wrong_unit(expr.span, unit, scalar.unit))
        return scalar.constant

    def whole(self, expr: ast.Expr, env: Env = EMPTY) -> int:
        """A whole number without a unit."""
        scalar = self.constant(expr, env)
        if scalar.unit is not None or scalar.constant != int(scalar.constant):
            found = "a quantity with a unit" if scalar.unit is not None else "a fraction"
            raise Mistake(WrongKind(span=expr.span, expected="a whole number", found=found))
        return int(scalar.constant)

    def formula(self, expr: ast.Expr, env: Env = EMPTY) -> Node:
        """The expression as a formula."""
        value = self.value(expr, env)
        if isinstance(value, Truth):
            return value.node
        hint = "compare it with something, for example `>= 0.5`"
        if isinstance(value, Chance):
            hint = "compare the probability: `P(..) >= 0.95`"
        if isinstance(value, Tally):
            hint = "compare the count: `count(..) >= 2`"
        if isinstance(value, Place | Radio):
            hint = "say where the agent should be: `r1 in goal`, `r1 outside pillar`"
        raise Mistake(
            WrongKind(span=expr.span, expected="a formula", found=describe(value), hint=hint)
        )

    def radio(self, expr: ast.Expr, env: Env = EMPTY) -> Agent | Station:
        """The expression as an agent or a station."""
        value = self.value(expr, env)
        if isinstance(value, Radio):
            return value.thing
        wanted, found = "an agent or a station", describe(value)
        raise Mistake(WrongKind(span=expr.span, expected=wanted, found=found))

    # --- names ----------------------------------------------------------------------------------

    def lookup(self, name: str, span: Span) -> Value | ast.Statement:
        """Value of a declared name, or its declaration if it has none yet."""
        if name in self.broken:
            raise Reported
        self.used.add(name)
        if name in self.values:
            return self.values[name]
        if name in self.declarations:
            return self.declarations[name]
        count = len(self.agents) * (len(self.agents) - 1) // 2
        if name == "pairs" and count > MOST_WORK:
            raise Mistake(TooLarge(span=span, size=f"{count:.3g} pairs"))
        domain = self.domain(name)
        if domain is not None:
            return domain
        raise Mistake(self.unknown(name, span))

    def unknown(self, name: str, span: Span) -> UnknownName:
        """The diagnostic for a name that isn't declared."""
        known = [*self.declarations, *DOMAINS]
        otherwise = f"declare it, such as `agent {name} : ..` or `region {name} = ..`"
        hint = suggestion(name, known, otherwise)
        return UnknownName(span=span, name=name, hint=hint, fix=suggested_fix(span, name, known))

    def domain(self, name: str) -> Items | None:
        """All things of a kind."""
        match name:
            case "agents":
                return Items(tuple(Radio(a) for a in self.agents.values()), "list of agents")
            case "stations":
                self.used.update(self.stations)
                return Items(tuple(Radio(s) for s in self.stations.values()), "list of stations")
            case "regions":
                self.used.update(self.regions)
                return Items(tuple(Place(r) for r in self.regions.values()), "list of regions")
            case "obstacles":
                self.used.update(self.obstacles)
                things = tuple(Place(o) for o in self.obstacles.values())
                return Items(things, "list of obstacles")
            case "pairs":
                return Items(self._pairs(), "list of pairs")
        return None

    def _pairs(self) -> tuple[Items, ...]:
        agents = [Radio(a) for a in self.agents.values()]
        return tuple(Items((a, b), "pair") for k, a in enumerate(agents) for b in agents[k + 1 :])

    @contextmanager
    def expanding(self, name: str, span: Span) -> Iterator[None]:
        """Guards against definitions that lead back to themselves."""
        if name in self.evaluating:
            raise Mistake(RecursiveLet(span=span, name=name))
        self.evaluating.append(name)
        try:
            yield
        finally:
            self.evaluating.pop()

    def channel_name(self, value: Value, span: Span) -> str:
        """The value as the name of a channel."""
        if isinstance(value, ChannelName):
            return value.name
        raise Mistake(WrongKind(span=span, expected="a channel", found=describe(value)))

    def text(self, expr: ast.Expr) -> str:
        """The expression as a string."""
        value = self.value(expr)
        if isinstance(value, Text):
            return value.text
        raise Mistake(WrongKind(span=expr.span, expected="a text", found=describe(value)))


def wrong_unit(span: Span, expected: Unit, found: Unit) -> WrongUnit:
    """The diagnostic for a value in the wrong unit."""
    names = [str(u) or "a plain number" for u in (expected, found)]
    return WrongUnit(span=span, expected=names[0], found=names[1])


def as_scalar(value: Value, span: Span) -> Scalar:
    """The value as a scalar, or a Mistake."""
    if isinstance(value, Scalar):
        return value
    if isinstance(value, Separation):
        return maximum(tuple(absolute(axis, span) for axis in value.axes), span)
    hint = ""
    if isinstance(value, Radio):
        hint = "an agent's signals are written `r1.x`, `r1.vx`"
    elif isinstance(value, Members):
        hint = "take one of them, as in `r1.v[0]`, or `norm(..)`, `norm1(..)`, `norminf(..)` of all"
    raise Mistake(WrongKind(span=span, expected="a number", found=describe(value), hint=hint))
