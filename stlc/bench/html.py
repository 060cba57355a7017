"""Tables in HTML that a reader can sort."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape


@dataclass(frozen=True, slots=True)
class Cell:
    """What is shown, and what it is sorted by."""

    text: str
    key: str | None = None
    css: str = ""


def number(value: float | None, style: str, prefix: str = "") -> Cell:
    """A number; nothing where it isn't known."""
    return Cell("") if value is None else Cell(prefix + format(value, style), repr(value))


def table(
    heads: Sequence[str], rows: Sequence[Sequence[Cell]], text: int, firsts: Sequence[bool] = ()
) -> str:
    """A sortable table; the first `text` columns (and the last, if a note) are left-aligned.

    `firsts` marks rows that begin a group. Columns in which no row says anything are left out.
    """
    filled = [k for k in range(len(heads)) if any(row[k].text for row in rows)]
    heads, rows = [heads[k] for k in filled], [[row[k] for k in filled] for row in rows]
    text = sum(k < text for k in filled)
    left = {*range(text), *(k for k, head in enumerate(heads) if head == "note")}
    head = "".join(
        f"<th{_class('text' if k in left else '')}>{escape(name)}</th>"
        for k, name in enumerate(heads)
    )
    body = "\n".join(
        f"<tr{_class('first' if firsts and firsts[i] else '')}>{_cells(row, left)}</tr>"
        for i, row in enumerate(rows)
    )
    return (
        f'<table class="sortable"><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>'
    )


def _cells(row: Sequence[Cell], left: set[int]) -> str:
    return "".join(
        f"<td{_class(' '.join(filter(None, ('text' if k in left else '', cell.css))))} "
        f'data-v="{escape(cell.text if cell.key is None else cell.key)}">{escape(cell.text)}</td>'
        for k, cell in enumerate(row)
    )


def _class(name: str) -> str:
    return f' class="{name}"' if name else ""
