"""Import of other tools' STL: Breach, rtamt and FalCAuN files become files of the language here.

`import_text` gives the text of a file that means the same on sampled signals; what differs between
the tools is restated, and what has no counterpart is refused with its place and reason.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Protocol

from stlc.diagnostics import Diagnostic, Severity
from stlc.dialects.breach import BreachParser
from stlc.dialects.errors import ImportFailure
from stlc.dialects.falcaun import FalcaunParser
from stlc.dialects.rtamt import RtamtParser
from stlc.dialects.scope import Dialect
from stlc.dialects.survey import survey
from stlc.dialects.tokens import Token
from stlc.dialects.tree import Item
from stlc.dialects.write import check_result, write
from stlc.errors import MissionError
from stlc.source import Source
from stlc.syntax.screen import oversized


class _Reader(Protocol):
    @property
    def token(self) -> Token: ...
    @property
    def warnings(self) -> list[Diagnostic]: ...
    def items(self) -> list[Item]: ...
    def skip(self) -> None: ...
    def end_of_statement(self) -> None: ...


_DIALECTS: Final[dict[str, tuple[Dialect, Callable[[Source], _Reader]]]] = {
    "breach": (Dialect("breach", True, False, False, True, "s"), BreachParser),
    "rtamt": (Dialect("rtamt", False, True, True, False, "s"), RtamtParser),
    "falcaun": (Dialect("falcaun", None, False, True, True, ""), FalcaunParser),
}

DIALECTS: Final = tuple(_DIALECTS)
"""Names of the languages that can be imported."""

MOST_MISTAKES: Final = 50


@dataclass(frozen=True, slots=True)
class Imported:
    """The text of the file here, and what its reader should know."""

    text: str
    warnings: tuple[Diagnostic, ...]


def import_text(source: Source, dialect: str, step: Fraction | None = None) -> Imported:
    """Translate a file of another tool; `dialect` is one of DIALECTS, `step` in seconds.

    Without a step the largest one is taken that fits all times of the file and is not longer than
    1 s. Raises MissionError with every mistake that was found.
    """
    rules, reader = _DIALECTS[dialect]
    too_large = oversized(source)
    if too_large is not None:
        raise MissionError([too_large])
    items, found = _read(source, reader)
    if any(d.severity is Severity.ERROR for d in found):
        raise MissionError([d for d in found if d.severity is Severity.ERROR])
    try:
        scope = survey(items, rules)
    except ImportFailure as failure:
        raise MissionError([failure.diagnostic]) from None
    written = write(scope, source, step)
    check_result(written, source, all(not use.no_value for use in scope.params.values()))
    return Imported(written.text, (*found, *scope.warnings))


def _read(
    source: Source, reader: Callable[[Source], _Reader]
) -> tuple[list[Item], list[Diagnostic]]:
    """The statements of a file, the mistakes in those that can't be read, and warnings."""
    items: list[Item] = []
    mistakes: list[Diagnostic] = []
    try:
        parser = reader(source)
    except ImportFailure as failure:
        return items, [failure.diagnostic]
    while parser.token.kind != "end" and len(mistakes) < MOST_MISTAKES:
        try:
            items.extend(parser.items())
            parser.end_of_statement()
        except ImportFailure as failure:
            mistakes.append(failure.diagnostic)
            parser.skip()
    return items, [*mistakes, *parser.warnings]
