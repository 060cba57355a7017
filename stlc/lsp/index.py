"""Where the names of a file are declared and used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from stlc.record import Record
from stlc.source import Span
from stlc.syntax import ast

Declared = (
    ast.Param | ast.DynamicsDecl | ast.AgentDecl | ast.StationDecl | ast.RegionDecl
    | ast.ObstacleDecl | ast.WallDecl | ast.ChannelDecl | ast.Let
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Occurrence:
    """A name where it stands. `owner` is where it is bound: None for names of the whole file,
    else the place of the `let`, quantifier or family that binds it."""

    name: str
    span: Span
    declares: bool
    owner: Span | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Index:
    """All occurrences of a file, and its declarations by name."""

    occurrences: tuple[Occurrence, ...]
    declarations: Mapping[str, Declared | ast.Require | ast.Prefer]

    def at(self, offset: int) -> Occurrence | None:
        """The occurrence at an offset, its end included."""
        found = [o for o in self.occurrences if o.span.start <= offset <= o.span.end]
        return min(found, key=lambda o: o.span.end - o.span.start, default=None)

    def same(self, one: Occurrence) -> list[Occurrence]:
        """Every occurrence of the thing that `one` names, in the order of the text."""
        mine = [o for o in self.occurrences if (o.name, o.owner) == (one.name, one.owner)]
        return sorted(mine, key=lambda o: o.span.start)


def index(file: ast.File) -> Index:
    """The index of a parsed file; statements with mistakes are not in it."""
    walk = _Walk()
    found = [o for statement in file.statements for o in walk.statement(statement)]
    return Index(tuple(found), _declarations(file))


def _declarations(file: ast.File) -> dict[str, Declared | ast.Require | ast.Prefer]:
    """The first statement of each name."""
    found: dict[str, Declared | ast.Require | ast.Prefer] = {}
    for statement in file.statements:
        if isinstance(statement, Declared | ast.Require | ast.Prefer) and statement.name:
            found.setdefault(statement.name.text, statement)
    return found


Bound = Mapping[str, Span]


class _Walk:
    """Yields the occurrences below nodes; `bound` are names that something around binds."""

    def statement(self, statement: ast.Statement) -> Iterator[Occurrence]:
        """Those of one statement."""
        bound: dict[str, Span] = {}
        if isinstance(statement, ast.SignalDecl):
            yield from (Occurrence(n.text, n.span, True) for n in statement.names)
            return
        if isinstance(statement, Declared | ast.Require | ast.Prefer) and statement.name:
            yield Occurrence(statement.name.text, statement.name.span, True)
        if isinstance(statement, ast.Let):
            for parameter in statement.parameters:
                bound[parameter.text] = statement.span
                yield Occurrence(parameter.text, parameter.span, True, statement.span)
        if isinstance(statement, ast.AgentDecl):
            yield Occurrence(statement.dynamics.text, statement.dynamics.span, False)
            if statement.family is not None:
                bound["i"] = statement.span
        for field in type(statement).record_fields:
            if field not in ("name", "names", "parameters", "dynamics", "kind"):
                yield from self.anything(getattr(statement, field), bound)

    def anything(self, node: object, bound: Bound) -> Iterator[Occurrence]:
        """Those of a node, a tuple of nodes, or whatever else a field holds."""
        if isinstance(node, tuple):
            for item in node:
                yield from self.anything(item, bound)
        elif isinstance(node, Record) and not isinstance(node, Span):
            yield from self._node(node, bound)

    def _node(self, node: Record, bound: Bound) -> Iterator[Occurrence]:
        """Those of one node; what stands behind a dot is a member of what stands before it."""
        match node:
            case ast.Name():
                yield Occurrence(node.text, node.span, False, bound.get(node.text))
            case ast.NamedShape():
                yield Occurrence(node.name.text, node.name.span, False)
            case ast.Call():
                name = node.function
                yield Occurrence(name.text, name.span, False, bound.get(name.text))
                yield from self.anything(node.args, bound)
            case ast.Attribute():
                yield from self.anything(node.base, bound)
            case ast.Quantifier():
                yield from self._quantifier(node, bound)
            case ast.Property():
                yield from self._property(node, bound)
            case ast.Ident():
                return
            case _:
                for field in type(node).record_fields:
                    yield from self.anything(getattr(node, field), bound)

    def _quantifier(self, node: ast.Quantifier, bound: Bound) -> Iterator[Occurrence]:
        yield from self.anything(node.domain, bound)
        inner = dict(bound) | {v.text: node.span for v in node.variables}
        yield from (Occurrence(v.text, v.span, True, node.span) for v in node.variables)
        yield from self.anything(node.body, inner)

    def _property(self, node: ast.Property, bound: Bound) -> Iterator[Occurrence]:
        """Names of states and of words are no names of the file."""
        plain = node.key.text in (
            "states", "inputs", "position", "velocity", "state_units", "input_units",
        )  # fmt: skip
        if not plain:
            yield from self.anything(node.args, bound)
