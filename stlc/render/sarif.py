"""Diagnostics as a SARIF 2.1.0 log (OASIS Static Analysis Results Interchange Format)."""

from __future__ import annotations

import inspect
import json
from collections.abc import Sequence
from typing import Any, Final
from urllib.parse import quote

from stlc.diagnostics import Diagnostic, Fix, Note
from stlc.source import Span
from stlc.version import __version__

_SCHEMA: Final = "https://json.schemastore.org/sarif-2.1.0.json"


def render_sarif(diagnostics: Sequence[Diagnostic]) -> str:
    """The log as JSON text."""
    rules = {d.code: type(d) for d in diagnostics}
    driver = {
        "name": "stlc",
        "version": __version__,
        "rules": [_rule(rules[code]) for code in sorted(rules)],
    }
    order = {code: index for index, code in enumerate(sorted(rules))}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(d, order[d.code]) for d in diagnostics],
    }
    log = {"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(log, ensure_ascii=False, indent=2)


def _rule(kind: type[Diagnostic]) -> dict[str, Any]:
    text = inspect.getdoc(kind) or kind.title
    return {
        "id": kind.code,
        "name": kind.__name__,
        "shortDescription": {"text": text.split("\n")[0]},
        "fullDescription": {"text": text},
        "defaultConfiguration": {"level": kind.severity.value},
    }


def _result(diagnostic: Diagnostic, rule: int) -> dict[str, Any]:
    """A `result` object of SARIF 2.1.0, section 3.27."""
    parts = (diagnostic.title_text, diagnostic.label_text, diagnostic.help_text)
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": rule,
        "level": diagnostic.severity.value,
        "message": {"text": "; ".join(part for part in parts if part)},
    }
    if diagnostic.span is not None:
        result["locations"] = [{"physicalLocation": _place(diagnostic.span)}]
    related = [_related(note, note.span) for note in diagnostic.notes if note.span is not None]
    if related:
        result["relatedLocations"] = related
    if diagnostic.fix is not None:
        result["fixes"] = [_fix(diagnostic.fix)]
    return result


def _related(note: Note, span: Span) -> dict[str, Any]:
    return {"physicalLocation": _place(span), "message": {"text": note.text}}


def _artifact(span: Span) -> dict[str, str]:
    return {"uri": quote(span.source.name.replace("\\", "/"))}


def _region(span: Span) -> dict[str, int]:
    end_line, end_column = span.source.position(span.end)
    return {
        "startLine": span.line,
        "startColumn": span.column,
        "endLine": end_line,
        "endColumn": end_column,
        "charOffset": span.start,
        "charLength": span.end - span.start,
    }


def _place(span: Span) -> dict[str, Any]:
    return {"artifactLocation": _artifact(span), "region": _region(span)}


def _fix(fix: Fix) -> dict[str, Any]:
    replacement = {
        "deletedRegion": _region(fix.span),
        "insertedContent": {"text": fix.replacement},
    }
    change = {"artifactLocation": _artifact(fix.span), "replacements": [replacement]}
    return {"artifactChanges": [change]}
