"""Diagnostics as GitHub workflow commands, which annotate the lines of a pull request."""

from __future__ import annotations

from stlc.diagnostics import Diagnostic


def render_github(diagnostic: Diagnostic) -> str:
    """One `::error file=..,line=..::message` command."""
    fields: dict[str, str] = {}
    span = diagnostic.span
    if span is not None:
        end_line, end_column = span.source.position(span.end)
        fields = {"file": span.source.name, "line": str(span.line), "endLine": str(end_line)}
        if end_line == span.line:
            fields |= {"col": str(span.column), "endColumn": str(end_column)}
    fields["title"] = f"{diagnostic.code}: {diagnostic.title_text}"
    parts = [diagnostic.label_text, *(note.text for note in diagnostic.notes), diagnostic.help_text]
    message = "\n".join(part for part in parts if part) or diagnostic.title_text
    settings = ",".join(f"{key}={_property(value)}" for key, value in fields.items())
    return f"::{diagnostic.severity.value} {settings}::{_data(message)}"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
