"""What a diagnostic is. One frozen dataclass a mistake; `render.py` shows them.

A subclass gives `code` and the templates `title`, `label` and `help` (`str.format` over
its own fields), and its docstring is the long text of `stlc check --explain CODE`.
"""

from __future__ import annotations

from enum import Enum
from typing import Any, ClassVar

from stlc.record import NamedRecord, Record
from stlc.source import Span


class Severity(Enum):
    """How bad a diagnostic is."""

    ERROR = "error"
    WARNING = "warning"


class Note(Record):
    """A further remark, at a place of its own or at none."""

    text: str
    span: Span | None = None


class Fix(Record):
    """A replacement that would mend the mistake."""

    span: Span
    replacement: str


class Diagnostic(NamedRecord):
    """Base of all diagnostics."""

    code: ClassVar[str]
    severity: ClassVar[Severity] = Severity.ERROR
    title: ClassVar[str]
    label: ClassVar[str] = ""
    help: ClassVar[str] = ""

    span: Span | None = None
    notes: tuple[Note, ...] = ()
    fix: Fix | None = None

    def _fill(self, template: str) -> str:
        values: dict[str, Any] = {name: getattr(self, name) for name in type(self).record_fields}
        return template.format(**values)

    @property
    def title_text(self) -> str:
        """The headline."""
        return self._fill(self.title)

    @property
    def label_text(self) -> str:
        """What stands beside the carets."""
        return self._fill(self.label)

    @property
    def help_text(self) -> str:
        """What the person can do."""
        return self._fill(self.help)

    def __str__(self) -> str:
        place = f"{self.span}: " if self.span else ""
        return f"{place}{self.severity.value}[{self.code}]: {self.title_text}"


class Warn(Diagnostic):
    """Base of the diagnostics that don't stop the work."""

    severity: ClassVar[Severity] = Severity.WARNING


def catalogue() -> dict[str, type[Diagnostic]]:
    """Every diagnostic class by its code (those of the modules imported so far)."""
    found: dict[str, type[Diagnostic]] = {}
    todo: list[type[Diagnostic]] = list(Diagnostic.__subclasses__())
    while todo:
        cls = todo.pop()
        todo.extend(cls.__subclasses__())
        if "code" in cls.__dict__:
            found[cls.code] = cls
    return found
