"""Makes statement nodes: one function for each production of the grammar."""

from __future__ import annotations

from typing import Any

from stlc.syntax import ast
from stlc.syntax.bounded import bounded_name
from stlc.syntax.build_expr import Children, ExprBuilder

Properties = tuple[ast.Property, ...]


class StatementBuilder(ExprBuilder):
    """Builders of statements, blocks and shapes."""

    def start(self, start: int, end: int, c: Children) -> ast.Statement:
        self.mixes.forget()
        node: ast.Statement = c[0]
        return node

    # --- parts -------------------------------------------------------------------------------

    def names(self, start: int, end: int, c: Children) -> tuple[ast.Ident, ...]:
        return tuple(self.ident(token) for token in c)

    def _first(self, start: int, end: int, c: Children) -> Any:
        return c[0]

    family = parameters = margin = inflate = velocity = loss = _first

    def feature(self, start: int, end: int, c: Children) -> ast.String:
        return self.text(c[0])

    def block(self, start: int, end: int, c: Children) -> Properties:
        return tuple(item for item in c if item is not None)

    def arguments(self, start: int, end: int, c: Children) -> tuple[ast.Expr, ...]:
        return tuple(c)

    def _property(
        self, start: int, end: int, key: Any, args: tuple[ast.Expr, ...], assigned: bool = False
    ) -> ast.Property:
        return ast.Property(self.ident(key), args, assigned, self.span(start, end))

    def property_bare(self, start: int, end: int, c: Children) -> ast.Property:
        return self._property(start, end, c[0], ())

    def property_assigned(self, start: int, end: int, c: Children) -> ast.Property:
        return self._property(start, end, c[0], (c[1],), True)

    def property_words(self, start: int, end: int, c: Children) -> ast.Property:
        return self._property(start, end, c[0], c[1])

    def property_compared(self, start: int, end: int, c: Children) -> ast.Property:
        key, tail, more = c
        name = self.name(key.start, key.end, [key])
        stop = tail[-1].span.end
        comparison = self.compared(start, stop, [name, tail])
        return self._property(start, end, key, (comparison, *(more or ())))

    def property_member(self, start: int, end: int, c: Children) -> ast.Property:
        key, place = c
        name = self.name(key.start, key.end, [key])
        return self._property(start, end, key, (self.inside(start, end, [name, place, None]),))

    def property_chain(self, start: int, end: int, c: Children) -> ast.Property:
        first, tail, more = c
        comparison = self.compared(start, tail[-1].span.end, [first, tail])
        name = bounded_name(comparison)
        span = comparison.span if name is None else name.span
        key = ast.Ident(span.text if name is None else name.text, span)
        return ast.Property(key, (comparison, *(more or ())), False, self.span(start, end))

    # --- shapes ------------------------------------------------------------------------------

    def extent(self, start: int, end: int, c: Children) -> tuple[ast.Expr, ast.Expr]:
        return c[0], c[1]

    def ring(self, start: int, end: int, c: Children) -> tuple[ast.Expr, ...]:
        return tuple(c)

    def frame(self, start: int, end: int, c: Children) -> tuple[ast.Expr, ast.Shape]:
        return c[0], c[1]

    def box(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.Box(self.span(start, end), c[0], c[1])

    def polygon(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.PolygonShape(self.span(start, end), c[0], tuple(c[1:]))

    def geojson(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.GeoJson(self.span(start, end), self.text(c[0]), c[1])

    def moving(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.Moving(self.span(start, end), tuple(c))

    def moving_linear(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.Moving(self.span(start, end), tuple(c), True)

    def named_shape(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.NamedShape(self.span(start, end), self.ident(c[0]))

    def group_shape(self, start: int, end: int, c: Children) -> ast.Shape:
        shape: ast.Shape = c[0]
        return shape

    def prism(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.Prism(self.span(start, end), c[0], c[1])

    def union(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.Union(self.span(start, end), tuple(c))

    # --- statements --------------------------------------------------------------------------

    def import_file(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Import(self.span(start, end), self.text(c[0]))

    def param(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Param(self.span(start, end), self.ident(c[0]), c[1])

    def signal(self, start: int, end: int, c: Children) -> ast.Statement:
        unit = c[1].text.replace(" ", "") if c[1] is not None else None
        file = self.text(c[2]) if c[2] is not None else None
        return ast.SignalDecl(self.span(start, end), c[0], unit, file)

    def step(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Step(self.span(start, end), c[0])

    def horizon(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Horizon(self.span(start, end), c[0])

    def margin_statement(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Margin(self.span(start, end), c[0])

    def workspace(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Workspace(self.span(start, end), c[0], None if c[1] is None else c[1].text)

    def dynamics(self, start: int, end: int, c: Children) -> ast.Statement:
        name, kind = self.ident(c[0]), self.ident(c[1])
        return ast.DynamicsDecl(self.span(start, end), name, kind, c[2] or ())

    def dynamics_matrices(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.DynamicsDecl(self.span(start, end), self.ident(c[0]), None, c[1])

    def agent(self, start: int, end: int, c: Children) -> ast.Statement:
        name, family, dynamics, block = c
        span = self.span(start, end)
        return ast.AgentDecl(span, self.ident(name), family, self.ident(dynamics), block or ())

    def station(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.StationDecl(self.span(start, end), self.ident(c[0]), c[1], c[2] or ())

    def region(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.RegionDecl(self.span(start, end), self.ident(c[0]), c[1])

    def obstacle(self, start: int, end: int, c: Children) -> ast.Statement:
        name, shape, velocity, inflate = c
        span = self.span(start, end)
        return ast.ObstacleDecl(span, self.ident(name), shape, inflate, velocity)

    def line(self, start: int, end: int, c: Children) -> ast.Shape:
        return ast.Line(self.span(start, end), c[0])

    def wall(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.WallDecl(self.span(start, end), self.ident(c[0]), c[1], c[2])

    def channel(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.ChannelDecl(self.span(start, end), self.ident(c[0]), c[1])

    def let(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Let(self.span(start, end), self.ident(c[0]), c[1] or (), c[2])

    def require(self, start: int, end: int, c: Children) -> ast.Statement:
        name = self.ident(c[0]) if c[0] is not None else None
        return ast.Require(self.span(start, end), name, c[2], c[1])

    def require_bare(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Require(self.span(start, end), None, c[0])

    def wish(self, start: int, end: int, c: Children) -> ast.Wish:
        span = self.span(start, end)
        return ast.Wish(span.text.split()[0], c[0] if c else None, span)

    def prefer(self, start: int, end: int, c: Children) -> ast.Statement:
        name, *wishes, formula = c
        named = self.ident(name) if name is not None else None
        return ast.Prefer(self.span(start, end), named, formula, tuple(wishes))

    def minimize(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Objective(self.span(start, end), "minimize", c[0])

    def maximize(self, start: int, end: int, c: Children) -> ast.Statement:
        return ast.Objective(self.span(start, end), "maximize", c[0])
