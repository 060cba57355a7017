"""`stlc fmt`: a file in the one style. Idempotent; comments stay where they are.

One statement a line, at most one blank line in a row, blocks as the author laid them out (on one
line, or one line of properties each), formulas longer than a line broken before their outermost
connective.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from stlc.source import Source
from stlc.syntax import ast
from stlc.syntax.blocks import INDENT, comment_text, show_block
from stlc.syntax.print_expr import logical_parts, quoted, show
from stlc.syntax.print_shape import show_shape

WIDTH: Final = 100


@dataclass(frozen=True, slots=True)
class _Item:
    """Some lines of output and the lines of the source that they stand for."""

    first: int
    last: int
    text: str


def format_file(file: ast.File) -> str:
    """The file's text in the one style. The file must have been parsed without errors."""
    items = [item for statement in _placed(file) for item in statement]
    lines: list[str] = []
    before: _Item | None = None
    for item in items:
        if before is not None and item.first - before.last > 1:
            lines.append("")
        lines.append(item.text)
        before = item
    return "".join(f"{line}\n" for line in lines)


def _placed(file: ast.File) -> list[list[_Item]]:
    """Statements with the comments that belong before, in and after them."""
    source, comments = file.source, list(file.comments)
    placed: list[list[_Item]] = []
    for position, statement in enumerate(file.statements):
        follower = file.statements[position + 1 : position + 2]
        limit = follower[0].span.start if follower else len(source.text) + 1
        before = _take(comments, statement.span.start)
        inner = _take(comments, statement.span.end)
        trailing = _trailing(source, comments, statement.span.end, limit)
        placed.append([_own_line(comment) for comment in before])
        placed.append(_statement(source, statement, inner, trailing))
    placed.append([_own_line(comment) for comment in comments])
    return placed


def _take(comments: list[ast.Comment], end: int) -> list[ast.Comment]:
    """Removes and returns the comments before `end`."""
    count = 0
    while count < len(comments) and comments[count].span.start < end:
        count += 1
    taken = comments[:count]
    del comments[:count]
    return taken


def _trailing(
    source: Source, comments: list[ast.Comment], end: int, limit: int
) -> ast.Comment | None:
    """The comment on the line on which a statement ends, if nothing else follows there."""
    if not comments or comments[0].span.start >= limit:
        return None
    same_line = "\n" not in source.text[end : comments[0].span.start]
    return comments.pop(0) if same_line else None


def _own_line(comment: ast.Comment) -> _Item:
    line = comment.span.line
    return _Item(line, line, comment_text(comment))


def _statement(
    source: Source,
    statement: ast.Statement,
    inner: list[ast.Comment],
    trailing: ast.Comment | None,
) -> list[_Item]:
    """The statement on one line or broken at 100 columns, and comments that must go above it."""
    first, last = statement.span.line, source.position(statement.span.end)[0]
    properties = _properties(statement)
    opening = _opening(source, statement, properties)
    above = [comment for comment in inner if comment.span.start < opening]
    within = [comment for comment in inner if comment.span.start >= opening]
    text = _head(statement)
    if properties or within or _needs_block(statement):
        text += " " + show_block(properties, within, source, (opening, statement.span.end), text)
    elif len(text) > WIDTH:
        text = _broken(statement) or text
    if trailing is not None:
        text += f"  {comment_text(trailing)}"
    hoisted = [_Item(first, first, comment_text(comment)) for comment in above]
    return [*hoisted, _Item(first, last, text)]


def _properties(statement: ast.Statement) -> tuple[ast.Property, ...]:
    match statement:
        case ast.DynamicsDecl() | ast.AgentDecl() | ast.StationDecl() | ast.ChannelDecl():
            return statement.properties
        case _:
            return ()


def _needs_block(statement: ast.Statement) -> bool:
    match statement:
        case ast.ChannelDecl():
            return True
        case ast.DynamicsDecl():
            return statement.kind is None
        case _:
            return False


def _opening(source: Source, statement: ast.Statement, properties: tuple[ast.Property, ...]) -> int:
    """Where the statement's block opens; its end if it has none."""
    if properties:
        return source.text.rfind("{", statement.span.start, properties[0].span.start)
    if _needs_block(statement):
        return source.text.find("{", statement.span.start, statement.span.end)
    return statement.span.end


def _head(statement: ast.Statement) -> str:
    """The statement without its block."""
    match statement:
        case ast.Import():
            return f"import {quoted(statement.path)}"
        case ast.Param():
            return f"param {statement.name.text} = {show(statement.value)}"
        case ast.SignalDecl():
            names = ", ".join(name.text for name in statement.names)
            unit = f" [{statement.unit}]" if statement.unit else ""
            return f"signal {names}{unit}" + (
                f" from {quoted(statement.file)}" if statement.file else ""
            )
        case ast.Step():
            return f"step {show(statement.duration)}"
        case ast.Horizon():
            return f"horizon {show(statement.length)}"
        case ast.Margin():
            return f"margin {show(statement.value)}"
        case ast.Workspace():
            times = f" {statement.times}" if statement.times else ""
            return f"workspace {show_shape(statement.shape)}{times}"
        case ast.RegionDecl():
            return f"region {statement.name.text} = {show_shape(statement.shape)}"
        case ast.ObstacleDecl():
            inflate = f" inflate {show(statement.inflate)}" if statement.inflate else ""
            drift = f" velocity {show(statement.velocity)}" if statement.velocity else ""
            shape = show_shape(statement.shape)
            return f"obstacle {statement.name.text} = {shape}{drift}{inflate}"
        case ast.WallDecl():
            loss = f" loss {show(statement.loss)}" if statement.loss else ""
            return f"wall {statement.name.text} = {show_shape(statement.shape)}{loss}"
        case _:
            return _named_head(statement)


def _named_head(statement: ast.Statement) -> str:
    """What stands before the block of a statement with a name."""
    match statement:
        case ast.DynamicsDecl():
            kind = f" = {statement.kind.text}" if statement.kind else ""
            return f"dynamics {statement.name.text}{kind}"
        case ast.AgentDecl():
            family = f"[{show(statement.family)}]" if statement.family else ""
            return f"agent {statement.name.text}{family} : {statement.dynamics.text}"
        case ast.StationDecl():
            return f"station {statement.name.text} at {show(statement.position)}"
        case ast.ChannelDecl():
            return f"channel {statement.name.text}"
        case ast.Let() | ast.Require() | ast.Prefer():
            return f"{_formula_head(statement)} {show(_formula(statement))}"
        case ast.Objective():
            return f"{statement.sense} {show(statement.expression)}"
        case _:
            return statement.span.text


def _formula_head(statement: ast.Let | ast.Require | ast.Prefer) -> str:
    if isinstance(statement, ast.Let):
        names = ", ".join(name.text for name in statement.parameters)
        return f"let {statement.name.text}{f'({names})' if names else ''} ="
    name = f" {statement.name.text}" if statement.name else ""
    if isinstance(statement, ast.Prefer):
        wishes = (f" {w.word}{f' {show(w.value)}' if w.value else ''}" for w in statement.wishes)
        return f"prefer{name}{''.join(wishes)}:"
    margin = f" margin {show(statement.margin)}" if statement.margin else ""
    return f"require{name}{margin}:"


def _formula(statement: ast.Let | ast.Require | ast.Prefer) -> ast.Expr:
    return statement.body if isinstance(statement, ast.Let) else statement.formula


def _broken(statement: ast.Statement) -> str | None:
    """A statement that is too long, on several lines; None where no good break is known."""
    if not isinstance(statement, ast.Let | ast.Require | ast.Prefer):
        return None
    formula = _formula(statement)
    if not isinstance(formula, ast.Logical):
        return f"{_formula_head(statement)}\n{INDENT * 2}{show(formula)}"
    first, *rest = logical_parts(formula)
    lines = [_formula_head(statement), INDENT * 2 + first]
    lines += [f"{INDENT * 2}{formula.operator} {part}" for part in rest]
    return "\n".join(lines)
