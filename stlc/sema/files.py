"""Files that a mission names, with mistakes located at the name."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from stlc.loader import Loader, LoadError
from stlc.sema.name_errors import CannotRead
from stlc.sema.report import Mistake
from stlc.source import Source, Span


@dataclass(frozen=True, slots=True)
class Files:
    """A loader that reports in diagnostics. `known` maps the source of each imported file to its
    resolved name, which what it names is relative to."""

    loader: Loader
    known: dict[Source, str] = field(default_factory=dict)

    def resolve(self, name: str, span: Span) -> str:
        """One spelling of the file's name."""
        try:
            return self.loader.resolve(name, self.known.get(span.source, ""))
        except LoadError as error:
            raise Mistake(_cannot(name, span, error)) from None

    def path(self, name: str, span: Span) -> Path:
        """Where the file is on disk."""
        try:
            return self.loader.path(name, self.known.get(span.source, ""))
        except LoadError as error:
            raise Mistake(_cannot(name, span, error)) from None

    def bytes(self, name: str, span: Span) -> bytes:
        """Content of the file."""
        try:
            return self.loader.read_bytes(name, self.known.get(span.source, ""))
        except LoadError as error:
            raise Mistake(_cannot(name, span, error)) from None

    def text(self, name: str, span: Span) -> str:
        """Content of a UTF-8 text file."""
        try:
            return self.bytes(name, span).decode("utf-8-sig")
        except UnicodeDecodeError as error:
            reason = f"not UTF-8 text (byte {error.start})"
            raise Mistake(CannotRead(span=span, path=name, reason=reason)) from None


def _cannot(name: str, span: Span, error: LoadError) -> CannotRead:
    return CannotRead(span=span, path=name, reason=error.reason, hint=error.hint)
