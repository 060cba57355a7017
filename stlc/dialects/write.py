"""The imported file as text: declarations, then named parts, then requirements."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from stlc.api import loads
from stlc.diagnostics import Diagnostic
from stlc.dialects.arithmetic import decimal
from stlc.dialects.errors import DialectUnsupported, ImportFailure, NoMeaning
from stlc.dialects.formulas import EQUAL_WITHIN, Formulas
from stlc.dialects.numbers import Numbers
from stlc.dialects.scope import ParamUse, Scope
from stlc.dialects.times import Times
from stlc.errors import MissionError
from stlc.source import Source, Span

_HEAD = "# Imported from {name} ({dialect})."


@dataclass(frozen=True, slots=True)
class Written:
    """The text, and for each of its lines the place it comes from."""

    text: str
    origins: tuple[Span | None, ...]


class _Lines:
    def __init__(self) -> None:
        self.texts: list[str] = []
        self.origins: list[Span | None] = []

    def add(self, text: str, origin: Span | None = None) -> None:
        self.texts.append(text)
        self.origins.append(origin)

    def gap(self) -> None:
        if self.texts and self.texts[-1]:
            self.add("")


def write(scope: Scope, source: Source, step: Fraction | None) -> Written:
    """The file. Raises MissionError with every definition that can't be imported, and why."""
    times = Times(scope, step)
    formulas = Formulas(scope, times)
    bodies = _bodies(scope, formulas, times)
    lines = _Lines()
    name = source.name.replace("\n", " ")
    lines.add(_HEAD.format(name=name, dialect=scope.dialect.name))
    lines.add(f"step {_seconds(times.step)}")
    lines.gap()
    for use in scope.params.values():
        lines.add(_param(use), use.span)
    if formulas.equal_within is not None:
        why = "recorded values differ by less than this where they are equal"
        lines.add(f"param {formulas.equal_within} = {EQUAL_WITHIN}  # {why}")
    lines.gap()
    for original, emitted in scope.signals.items():
        note = "" if original == emitted else f"  # {' '.join(original.split())}"
        lines.add(f"signal {emitted}{note}")
    lines.gap()
    for at, body in enumerate(bodies):
        lines.add(_statement(scope, at, body), scope.definitions[at].span)
    return Written("\n".join(lines.texts).rstrip("\n") + "\n", tuple(lines.origins))


def _bodies(scope: Scope, formulas: Formulas, times: Times) -> list[str]:
    """Each definition's text; the mistakes of all are told together."""
    bodies: list[str] = []
    mistakes: list[Diagnostic] = []
    for at, definition in enumerate(scope.definitions):
        try:
            if at in scope.used and not scope.is_formula(definition.body, at):
                bodies.append(Numbers(scope, times, at).number(definition.body).text)
            else:
                bodies.append(formulas.text(definition.body, at).text)
        except ImportFailure as failure:
            mistakes.append(failure.diagnostic)
        except RecursionError:
            what = "definitions that lead back to themselves"
            advice = "a definition may use those before it"
            found = DialectUnsupported(span=definition.span, what=what, advice=advice)
            raise MissionError([found]) from None
    if mistakes:
        raise MissionError(mistakes)
    return bodies


def _statement(scope: Scope, at: int, body: str) -> str:
    name = scope.emitted.get(at)
    if name is None:
        return f"require: {body}"
    return f"let {name} = {body}" if at in scope.used else f"require {name}: {body}"


def _param(use: ParamUse) -> str:
    number = use.value or Fraction(0)
    unit = " s" if use.is_time else ""
    notes = [] if use.emitted == use.name else [use.name]
    if use.no_value:
        notes.append("the file gives no value")
    comment = f"  # {'; '.join(notes)}" if notes else ""
    return f"param {use.emitted} = {_with_unit(number, unit)}{comment}"


def _with_unit(number: Fraction, unit: str) -> str:
    text = decimal(number)
    if "/" in text and unit:
        return f"({text}) * 1{unit}"
    return f"{text}{unit}"


def _seconds(step: Fraction) -> str:
    return _with_unit(step, " s")


def check_result(written: Written, source: Source, values_known: bool) -> None:
    """Read the text as everyone's files are read. Raises MissionError, at places of `source`.

    A formula that can't hold is no mistake of the file when a parameter still waits for its value.
    """
    from stlc.sema.objective_errors import NeverTrue

    try:
        loads(written.text, name=source.name)
    except MissionError as error:
        found = [d for d in error.diagnostics if values_known or not isinstance(d, NeverTrue)]
        whole = source.span(0, len(source.text.rstrip()))
        if found:
            raise MissionError([_traced(d, written, whole) for d in found]) from None


def _traced(diagnostic: Diagnostic, written: Written, whole: Span) -> Diagnostic:
    span = diagnostic.span
    known = span is not None and span.line <= len(written.origins)
    origin = written.origins[span.line - 1] if known and span is not None else None
    advice = diagnostic.help_text or "write it otherwise"
    return NoMeaning(span=origin or whole, reason=diagnostic.title_text, advice=advice)
