"""Numbers of a file that the members of a conflict are made of, where they stand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum

from stlc.explain.conflict import Conflict
from stlc.explain.givens import Given, Kind
from stlc.explain.places import statements
from stlc.ir.nodes import Node, walk
from stlc.mission import Mission
from stlc.source import Source, Span
from stlc.syntax import ast


class Of(Enum):
    """What a number is of."""

    BEGIN = "begin"
    DEADLINE = "deadline"
    THRESHOLD = "threshold"
    COUNT = "count"
    PROBABILITY = "probability"
    MARGIN = "margin"
    PARAMETER = "parameter"
    REGION = "region"
    OBSTACLE = "obstacle"
    BOUND = "bound"
    PARTITION = "partition"
    WORKSPACE = "workspace"
    START = "start"


@dataclass(frozen=True, slots=True)
class Number:
    """A number of the text, its sign included."""

    of: Of
    span: Span
    value: float
    unit: str
    name: str = ""


def numbers_of(mission: Mission, conflict: Conflict) -> Iterator[Number]:
    """Numbers of its clauses, of the places that they name, and of what is given."""
    file = mission.source
    for clause in conflict.clauses:
        for n in _Reader(file, mission).requirement(clause.span):
            yield _called(n, f"{n.of.value} of {clause.name}")
        yield from _places(file, mission, clause.formula)
    for given in conflict.givens:
        yield from _given(file, mission, given)


def _called(number: Number, name: str) -> Number:
    """With a name, unless it is that of a parameter, which may stand elsewhere too."""
    return number if number.name else replace(number, name=name)


# --- requirements ------------------------------------------------------------------------------


@dataclass(slots=True)
class _Reader:
    """Numbers of formulas, through definitions and parameters."""

    file: Source
    mission: Mission

    def requirement(self, span: Span | None) -> Iterator[Number]:
        for statement in statements(self.file):
            if isinstance(statement, ast.Require) and statement.span == span:
                yield from self._in(statement.formula)
                if statement.margin is not None:
                    yield from self._number(statement.margin, Of.MARGIN)
                else:
                    yield from self._margins()

    def _margins(self) -> Iterator[Number]:
        for statement in statements(self.file):
            if isinstance(statement, ast.Margin):
                yield from self._number(statement.value, Of.MARGIN)

    def _in(self, expr: ast.Expr) -> Iterator[Number]:
        """Numbers of a formula; of what it defines by name, those of the definition."""
        match expr:
            case ast.Temporal(interval=interval, arg=arg):
                yield from self._interval(interval)
                yield from self._in(arg)
            case ast.TemporalPair(interval=interval, left=left, right=right):
                yield from self._interval(interval)
                yield from self._in(left)
                yield from self._in(right)
            case ast.Logical(args=args):
                for arg in args:
                    yield from self._in(arg)
            case ast.Not(arg=arg) | ast.Swept(arg=arg) | ast.Quantifier(body=arg):
                yield from self._in(arg)
            case ast.Comparison(operands=operands):
                yield from self._comparison(operands)
            case ast.Call(function=function, args=args):
                yield from self._definition(function.text)
                for arg in args:
                    yield from self._in(arg)  # of `route` and `connected`
                    yield from self._number(arg, Of.PARAMETER)
            case ast.Name(text=text):
                yield from self._definition(text)

    def _interval(self, interval: ast.Interval | None) -> Iterator[Number]:
        if interval is not None:
            yield from self._number(interval.start, Of.BEGIN)
            if interval.end is not None:
                yield from self._number(interval.end, Of.DEADLINE)

    def _comparison(self, operands: tuple[ast.Expr, ...]) -> Iterator[Number]:
        """What something is compared with, and what stands in a chance or a count."""
        of = _compared(operands)
        for operand in operands:
            if isinstance(operand, ast.Call) and operand.function.text == "P":
                for arg in operand.args:
                    yield from self._in(arg)
            elif isinstance(operand, ast.Quantifier):
                yield from self._in(operand.body)
            elif isinstance(operand, ast.Tuple):
                for item in operand.items:
                    yield from self._number(item, Of.THRESHOLD)
            else:
                yield from self._number(operand, of)

    def _definition(self, name: str) -> Iterator[Number]:
        for statement in statements(self.file):
            if isinstance(statement, ast.Let) and statement.name.text == name:
                yield from self._in(statement.body)

    def _number(self, expr: ast.Expr, of: Of) -> Iterator[Number]:
        return _named(self.file, self.mission, expr, of)


def _compared(operands: tuple[ast.Expr, ...]) -> Of:
    """What a number is of beside these: a chance, a count of instances or of hops, or a value."""
    for operand in operands:
        if isinstance(operand, ast.Call) and operand.function.text == "P":
            return Of.PROBABILITY
        if isinstance(operand, ast.Quantifier) and operand.kind == "count":
            return Of.COUNT
        if isinstance(operand, ast.Name) and operand.text == "hops":
            return Of.COUNT
    return Of.THRESHOLD


def _named(file: Source, mission: Mission, expr: ast.Expr, of: Of) -> Iterator[Number]:
    """A number as it stands, or that of a parameter which `-D` hasn't set."""
    if not isinstance(expr, ast.Name):
        yield from number(expr, of)
    elif expr.text not in mission.params:
        for statement in statements(file):
            if isinstance(statement, ast.Param) and statement.name.text == expr.text:
                for n in number(statement.value, of):
                    yield replace(n, name=f"parameter {expr.text}")


def number(expr: ast.Expr, of: Of) -> Iterator[Number]:
    """A number of the text, if the expression is one."""
    negative = isinstance(expr, ast.Negate)
    inner = expr.arg if isinstance(expr, ast.Negate) else expr
    if isinstance(inner, ast.Number):
        end = inner.span.start + len(inner.text)
        span = Span(expr.span.source, expr.span.start, end)
        yield Number(of, span, -inner.value if negative else inner.value, inner.unit or "")


# --- places, and what is given -----------------------------------------------------------------


def _places(file: Source, mission: Mission, formula: Node) -> Iterator[Number]:
    """Sides of boxes that a formula is in or out of, and how far obstacles are inflated."""
    names: dict[str, None] = {}
    for node in walk(formula):
        claims = (node.member, node.swept)
        names |= {c.place: None for c in claims if c is not None and c.place is not None}
    for statement in statements(file):
        if isinstance(statement, ast.RegionDecl) and statement.name.text in names:
            name = f"region {statement.name.text}"
            yield from _box(file, mission, statement.shape, Of.REGION, name)
        if isinstance(statement, ast.ObstacleDecl) and statement.name.text in names:
            name = f"obstacle {statement.name.text}"
            yield from _box(file, mission, statement.shape, Of.OBSTACLE, name)
            if statement.inflate is not None:
                for n in _named(file, mission, statement.inflate, Of.OBSTACLE):
                    yield _called(n, f"inflate of {name}")


def _box(file: Source, mission: Mission, shape: ast.Shape, of: Of, name: str) -> Iterator[Number]:
    """The edges of a box, named `lower x of region dock`."""
    sides: dict[str, tuple[ast.Expr, ast.Expr]] = {}
    if isinstance(shape, ast.Prism):
        yield from _box(file, mission, shape.base, of, name)
        sides = {"z": shape.z}
    elif isinstance(shape, ast.Box):
        sides = {"x": shape.x, "y": shape.y}
    for axis, ends in sides.items():
        for side, end in zip(("lower", "upper"), ends, strict=True):
            for n in _named(file, mission, end, of):
                yield _called(n, f"{side} {axis} of {name}")


def _given(file: Source, mission: Mission, given: Given) -> Iterator[Number]:
    """Numbers of a bound, of a start or of the workspace."""
    if given.kind is Kind.WORKSPACE:
        for statement in statements(file):
            if isinstance(statement, ast.Workspace):
                yield from _box(file, mission, statement.shape, Of.WORKSPACE, "the workspace")
    for item in properties(file) if given.kind in _KINDS else ():
        if item.span == given.span and given.kind is Kind.START:
            yield from _start(file, mission, item, given.owner)
        elif item.span in (given.span, *given.others):
            for n in (n for arg in item.args for n in _bound(file, mission, arg, Of.BOUND)):
                yield _called(n, f"{item.key.text} of {given.owner}")


def _start(file: Source, mission: Mission, item: ast.Property, owner: str) -> Iterator[Number]:
    """What a start is made of, each by the state that it is of."""
    states = mission.agents[owner].dynamics.states
    for arg in item.args:
        parts = arg.items if isinstance(arg, ast.Tuple | ast.List) else (arg,)
        for state, part in zip(states, parts, strict=False):
            for n in _named(file, mission, part, Of.START):
                yield _called(n, f"start {state} of {owner}")


_KINDS = (
    Kind.SPEED, Kind.CONTROL, Kind.STATE, Kind.START, Kind.DISTURBANCE, Kind.TUBE, Kind.STEERING,
)  # fmt: skip


def properties(file: Source) -> Iterator[ast.Property]:
    """Properties of all blocks of a file."""
    for statement in statements(file):
        if isinstance(statement, ast.AgentDecl | ast.DynamicsDecl | ast.ChannelDecl):
            yield from statement.properties


def _bound(file: Source, mission: Mission, expr: ast.Expr, of: Of) -> Iterator[Number]:
    match expr:
        case ast.Comparison(operands=parts) | ast.Tuple(items=parts) | ast.List(items=parts):
            for part in parts:
                yield from _named(file, mission, part, of)
        case ast.Membership(place=place):
            yield from _bound(file, mission, place, of)
        case _:
            yield from _named(file, mission, expr, of)
