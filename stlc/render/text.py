"""Diagnostics for people: the source line, carets under the mistake, notes and help."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from stlc.diagnostics import Diagnostic, Note, Severity
from stlc.render.columns import Excerpt, excerpt
from stlc.source import Span

_COLOURS: Final = {"error": "\033[1;31m", "warning": "\033[1;33m", "frame": "\033[1;34m"}
_BOLD: Final = "\033[1m"
_RESET: Final = "\033[0m"


@dataclass(frozen=True, slots=True)
class _Paint:
    """Puts colours around words, or leaves them as they are."""

    on: bool

    def __call__(self, text: str, style: str) -> str:
        return f"{style}{text}{_RESET}" if self.on and text else text

    def frame(self, text: str) -> str:
        return self(text, _COLOURS["frame"])


def render_text(diagnostic: Diagnostic, *, color: bool = False) -> str:
    """One diagnostic as several lines of text."""
    paint = _Paint(color)
    style = _COLOURS[diagnostic.severity.value]
    gutter = _gutter(diagnostic)
    head = paint(f"{diagnostic.severity.value}[{diagnostic.code}]", style)
    lines = [head + paint(f": {_flat(diagnostic.title_text)}", _BOLD)]
    if diagnostic.span is not None:
        mark = "^" if diagnostic.severity is Severity.ERROR else "~"
        label = diagnostic.label_text
        lines += _snippet(diagnostic.span, mark, label, gutter, paint, style)
    for note in diagnostic.notes:
        lines += _note(note, gutter, paint)
    if diagnostic.help_text:
        lines.append(_remark("help", diagnostic.help_text, gutter, paint))
    if diagnostic.fix is not None:
        lines += _fix(diagnostic, gutter, paint)
    return "\n".join(lines)


def _gutter(diagnostic: Diagnostic) -> int:
    """Width of the widest line number shown."""
    spans = [diagnostic.span, *(note.span for note in diagnostic.notes)]
    return max((len(str(span.line)) for span in spans if span is not None), default=1)


def _flat(text: str) -> str:
    """Control characters made visible, so that a message stays on its line."""
    return "".join(ch if ch.isprintable() else repr(ch)[1:-1] for ch in text)


def _remark(kind: str, text: str, gutter: int, paint: _Paint) -> str:
    return f"{' ' * gutter} {paint.frame('=')} {paint(kind, _BOLD)}: {_flat(text)}"


def _snippet(
    span: Span, mark: str, label: str, gutter: int, paint: _Paint, style: str
) -> list[str]:
    """Where it is: the place, the line, and marks under the characters."""
    part: Excerpt = excerpt(span)
    blank, bar = " " * gutter, paint.frame("|")
    marks = " " * part.offset + paint(mark * part.width, style)
    label = _flat(label)
    return [
        f"{blank}{paint.frame('-->')} {_flat(span.source.name)}:{span.line}:{span.column}",
        f"{blank} {bar}",
        f"{paint.frame(str(span.line).rjust(gutter))} {bar} {part.text}".rstrip(),
        f"{blank} {bar} {marks}{' ' + paint(label, style) if label else ''}",
    ]


def _note(note: Note, gutter: int, paint: _Paint) -> list[str]:
    if note.span is None:
        return [_remark("note", note.text, gutter, paint)]
    return _snippet(note.span, "-", note.text, gutter, paint, _COLOURS["frame"])


def _fix(diagnostic: Diagnostic, gutter: int, paint: _Paint) -> list[str]:
    """The first changed line as it would read with the fix."""
    fix = diagnostic.fix
    if fix is None:
        return []
    text = fix.span.source.text
    begin = text.rfind("\n", 0, fix.span.start) + 1
    finish = text.find("\n", fix.span.end)
    after = text[fix.span.end : finish if finish >= 0 else len(text)]
    mended = (text[begin : fix.span.start] + fix.replacement + after).split("\n")[0]
    line = mended.strip()
    if len(line) > 100 or not line:
        return [_remark("fix", f"write `{fix.replacement}`", gutter, paint)]
    return [_remark("fix", line, gutter, paint)]
