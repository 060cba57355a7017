"""Where the names of a file are declared and used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from stlc.record import Record
from stlc.source import Source, Span
from stlc.syntax import ast

Named = (
    ast.Param | ast.DynamicsDecl | ast.AgentDecl | ast.StationDecl | ast.RegionDecl
    | ast.ObstacleDecl | ast.WallDecl | ast.ChannelDecl | ast.Let | ast.Require | ast.Prefer
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
class Words:
    """Occurrences in some statements, and the first of these of each name."""

    occurrences: tuple[Occurrence, ...]
    declarations: Mapping[str, Named]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Words that stand `by` characters further on in `source` than their spans say."""

    source: Source
    by: int
    words: Words

    def occurrences(self) -> Iterator[Occurrence]:
        """Those of the words, where they stand."""
        for one in self.words.occurrences:
            owner = one.owner and self._place(one.owner)
            yield Occurrence(one.name, self._place(one.span), one.declares, owner)

    def declarations(self) -> Iterator[tuple[str, Declaration]]:
        """Those of the words, where they stand."""
        for name, statement in self.words.declarations.items():
            if statement.name is not None:
                where = self._place(statement.span), self._place(statement.name.span)
                yield name, Declaration(statement, *where)

    def _place(self, span: Span) -> Span:
        return Span(self.source, span.start + self.by, span.end + self.by)


@dataclass(frozen=True, slots=True, eq=False)
class Declaration:
    """A statement that declares a name, its place and the name's; spans within the statement may
    count from elsewhere."""

    statement: Named
    span: Span
    name: Span


@dataclass(frozen=True, eq=False)
class Index:
    """The names of a text, by the words of its parts; put together when they are asked for."""

    parts: tuple[Part, ...]

    @cached_property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """Every name where it stands."""
        return tuple(one for part in self.parts for one in part.occurrences())

    @cached_property
    def declarations(self) -> Mapping[str, Declaration]:
        """The first declaration of each name."""
        found: dict[str, Declaration] = {}
        for part in self.parts:
            for name, declaration in part.declarations():
                found.setdefault(name, declaration)
        return found

    def at(self, offset: int) -> Occurrence | None:
        """The occurrence at an offset, its end included."""
        found = [o for o in self.occurrences if o.span.start <= offset <= o.span.end]
        return min(found, key=lambda o: o.span.end - o.span.start, default=None)

    def same(self, one: Occurrence) -> list[Occurrence]:
        """Every occurrence of the thing that `one` names, in the order of the text."""
        mine = [o for o in self.occurrences if (o.name, o.owner) == (one.name, one.owner)]
        return sorted(mine, key=lambda o: o.span.start)


def words(file: ast.File) -> Words:
    """The words of a parsed text; statements with mistakes are not in it."""
    walk = _Walk()
    found = tuple(o for statement in file.statements for o in walk.statement(statement))
    return Words(found, _declarations(file))


def _declarations(file: ast.File) -> dict[str, Named]:
    """The first statement of each name."""
    found: dict[str, Named] = {}
    for statement in file.statements:
        if isinstance(statement, Named) and statement.name:
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
        if isinstance(statement, Named) and statement.name:
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
