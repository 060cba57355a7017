"""Blocks of properties as text, with their comments."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Final

from stlc.source import Source
from stlc.syntax import ast
from stlc.syntax.print_property import show_property

INDENT: Final = "  "
_WIDTH: Final = 100


def comment_text(comment: ast.Comment) -> str:
    """A comment as `# text`."""
    inner = comment.text.removeprefix("//") if comment.text[:2] == "//" else comment.text[1:]
    inner = inner.rstrip()
    blank = "" if not inner or inner[0] in " \t#!" else " "
    return f"#{blank}{inner}"


def show_block(
    properties: Sequence[ast.Property],
    comments: Sequence[ast.Comment],
    source: Source,
    extent: tuple[int, int],
    head: str,
) -> str:
    """`{ .. }` on one line if it was and fits behind `head`, else a line for each line it had."""
    if not properties and not comments:
        return "{}"
    line = "{ " + _row(properties) + " }"
    one_line = "\n" not in source.text[extent[0] : extent[1]] and not comments
    if one_line and len(head) + 1 + len(line) <= _WIDTH:
        return line
    rows = [[item] for item in properties] if one_line else _rows(properties)
    return "\n".join(["{", *_body(rows, list(comments), source), "}"])


def _rows(properties: Sequence[ast.Property]) -> list[list[ast.Property]]:
    """Properties by the line on which they start; a row that is too wide is taken apart."""
    groups = [list(group) for _, group in groupby(properties, lambda item: item.span.line)]
    rows: list[list[ast.Property]] = []
    for group in groups:
        fits = len(INDENT) + len(_row(group)) <= _WIDTH
        rows += [group] if fits else [[item] for item in group]
    return rows


def _row(properties: Sequence[ast.Property]) -> str:
    """Properties side by side; a bare word introduces the assignment that follows it."""
    text = ""
    for position, item in enumerate(properties):
        before = properties[position - 1] if position else None
        introduced = before is not None and not before.args and item.assigned
        separator = "" if before is None else " " if introduced else "; "
        text += separator + show_property(item)
    return text


def _body(rows: list[list[ast.Property]], comments: list[ast.Comment], source: Source) -> list[str]:
    """Lines of a block, each comment above, beside or within the row where it stood."""
    lines: list[str] = []
    for row in rows:
        while comments and comments[0].span.start < row[0].span.start:
            lines.append(INDENT + comment_text(comments.pop(0)))
        last = row[-1].span.end
        while comments and comments[0].span.start < last:
            lines.append(INDENT + comment_text(comments.pop(0)))
        text = INDENT + _row(row)
        if comments and "\n" not in source.text[last : comments[0].span.start]:
            text += f"  {comment_text(comments.pop(0))}"
        lines.append(text)
    lines += [INDENT + comment_text(comment) for comment in comments]
    return lines
