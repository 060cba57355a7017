"""Collects diagnostics: a mistake ends the smallest part that can't go on, never the analysis."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from difflib import get_close_matches

from stlc.diagnostics import Diagnostic, Fix, Note, Severity
from stlc.record import changed
from stlc.source import Span


class Mistake(Exception):
    """Ends the evaluation of one expression; caught where its statement is analysed."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(str(diagnostic))

    def noted(self, diagnostic: Diagnostic) -> Mistake:
        """The same kind of mistake, with more to say."""
        return type(self)(diagnostic)


class Reported(Exception):
    """Ends an expression whose mistakes are reported already."""


@dataclass(slots=True)
class Report:
    """Every diagnostic of one analysis, each once."""

    diagnostics: list[Diagnostic] = field(default_factory=list)
    _seen: set[tuple[str, str, int]] = field(default_factory=set)

    def add(self, diagnostic: Diagnostic) -> None:
        """Keep a diagnostic, unless the same one is known for this place."""
        span = diagnostic.span
        place = (span.source.name, span.start) if span else (diagnostic.title_text, -1)
        key = (diagnostic.code, *place)
        if key not in self._seen:
            self._seen.add(key)
            self.diagnostics.append(diagnostic)

    @contextmanager
    def guard(self) -> Iterator[None]:
        """Report what goes wrong inside, and go on after it."""
        try:
            yield
        except Mistake as mistake:
            self.add(mistake.diagnostic)
        except Reported:
            pass

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """The errors, in the order of the text."""
        return self._ordered(Severity.ERROR)

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """The warnings, in the order of the text."""
        return self._ordered(Severity.WARNING)

    def _ordered(self, severity: Severity) -> tuple[Diagnostic, ...]:
        chosen = [d for d in self.diagnostics if d.severity is severity]
        return tuple(sorted(chosen, key=lambda d: d.span.start if d.span else -1))


def with_note(diagnostic: Diagnostic, text: str, span: Span | None) -> Diagnostic:
    """The diagnostic with one more note, unless that place is its own."""
    if span is not None and diagnostic.span == span:
        return diagnostic
    return changed(diagnostic, notes=(*diagnostic.notes, Note(text, span)))


def nearest(name: str, known: Collection[str]) -> str | None:
    """The known name most like `name`, or None; one that goes on where it ends is most like it."""
    longer = [n for n in known if len(name) > 2 and n.startswith(f"{name}_")]
    if len(longer) == 1:
        return longer[0]
    found = get_close_matches(name, list(known), n=1, cutoff=0.6)
    return found[0] if found else None


def suggestion(name: str, known: list[str], otherwise: str) -> str:
    """`did you mean ..?`, or else what is known."""
    near = nearest(name, known)
    return f"did you mean `{near}`?" if near else otherwise


def suggested_fix(span: Span, name: str, known: list[str]) -> Fix | None:
    """Replace the name by the nearest known one."""
    near = nearest(name, known)
    return Fix(span, near) if near else None
