"""Diagnostics as one JSON document."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from stlc.diagnostics import Diagnostic, Fix, Note
from stlc.source import Span


def render_json(diagnostics: Iterable[Diagnostic]) -> str:
    """`{"version": 1, "diagnostics": [..]}`; lines and columns count characters from 1."""
    document = {"version": 1, "diagnostics": [as_dict(d) for d in diagnostics]}
    return json.dumps(document, ensure_ascii=False, indent=2)


def as_dict(diagnostic: Diagnostic) -> dict[str, Any]:
    """One diagnostic as plain data."""
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity.value,
        "title": diagnostic.title_text,
        "label": diagnostic.label_text,
        "help": diagnostic.help_text,
        "span": _span(diagnostic.span),
        "notes": [_note(note) for note in diagnostic.notes],
        "fix": _fix(diagnostic.fix),
    }


def _span(span: Span | None) -> dict[str, Any] | None:
    if span is None:
        return None
    end_line, end_column = span.source.position(span.end)
    return {
        "file": span.source.name,
        "start": {"offset": span.start, "line": span.line, "column": span.column},
        "end": {"offset": span.end, "line": end_line, "column": end_column},
    }


def _note(note: Note) -> dict[str, Any]:
    return {"text": note.text, "span": _span(note.span)}


def _fix(fix: Fix | None) -> dict[str, Any] | None:
    return None if fix is None else {"span": _span(fix.span), "replacement": fix.replacement}
