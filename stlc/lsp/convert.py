"""From what is known of a document to the types of the protocol."""

from __future__ import annotations

from typing import Any

from lsprotocol import types

from stlc.diagnostics import Diagnostic, Severity
from stlc.lsp.completion import Offer
from stlc.lsp.document import Document
from stlc.lsp.positions import place, position
from stlc.source import Span

_KINDS: dict[str, Any] = {
    "keyword": types.CompletionItemKind.Keyword, "function": types.CompletionItemKind.Function,
    "agent": types.CompletionItemKind.Variable, "place": types.CompletionItemKind.Constant,
    "channel": types.CompletionItemKind.Module, "dynamics": types.CompletionItemKind.Class,
    "value": types.CompletionItemKind.Value, "signal": types.CompletionItemKind.Field,
    "property": types.CompletionItemKind.Property,
}  # fmt: skip


def diagnostics(document: Document, uri: str) -> list[types.Diagnostic]:
    """Those of this file; of a mistake in an imported one its import is the place."""
    return [_diagnostic(d, document, uri) for d in document.diagnostics]


def _diagnostic(found: Diagnostic, document: Document, uri: str) -> types.Diagnostic:
    """One mistake or warning with its remedy, and notes at places of this file."""
    here = found.span is not None and _is_here(found.span, document)
    where = place(found.span) if here and found.span else _top(document)
    message = found.title_text if here else f"{found.span or ''} {found.title_text}".strip()
    parts = [message, found.label_text, f"help: {found.help_text}" if found.help_text else ""]
    parts += [note.text for note in found.notes if note.span is None]
    error = found.severity is Severity.ERROR
    return types.Diagnostic(
        where, "\n".join(p for p in parts if p),
        severity=types.DiagnosticSeverity.Error if error else types.DiagnosticSeverity.Warning,
        code=found.code, source="stlc", related_information=[
            types.DiagnosticRelatedInformation(types.Location(uri, place(n.span)), n.text)
            for n in found.notes if n.span is not None and _is_here(n.span, document)
        ],
    )  # fmt: skip


def _is_here(span: Span, document: Document) -> bool:
    return span.source.text == document.text


def _top(document: Document) -> types.Range:
    """The first line, for what has no place in the file."""
    end = document.text.find("\n")
    return types.Range(
        types.Position(0, 0),
        position(document.source, len(document.text) if end < 0 else end),
    )


def fixes(document: Document, uri: str, within: types.Range) -> list[types.CodeAction]:
    """Replacements that diagnostics offer on the lines of a range."""
    found = []
    for d, shown in zip(document.diagnostics, diagnostics(document, uri), strict=True):
        if d.fix is None or not _is_here(d.fix.span, document):
            continue
        lines = shown.range.start.line, shown.range.end.line
        if lines[1] < within.start.line or lines[0] > within.end.line:
            continue
        edit = types.TextEdit(place(d.fix.span), d.fix.replacement)
        found.append(types.CodeAction(
            f"replace by `{d.fix.replacement}`", kind=types.CodeActionKind.QuickFix,
            diagnostics=[shown], edit=types.WorkspaceEdit(changes={uri: [edit]}),
        ))  # fmt: skip
    return found


def item(offer: Offer) -> types.CompletionItem:
    """One offer."""
    return types.CompletionItem(offer.text, kind=_KINDS[offer.kind], detail=offer.detail or None)
