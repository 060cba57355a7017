"""Changes of a file's numbers as edits of its text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stlc.explain.knobs import Knob
from stlc.explain.numbers import Of
from stlc.source import Source, Span


@dataclass(frozen=True, slots=True)
class Replacement:
    """`new` in place of the text of a span."""

    span: Span
    new: str

    def as_dict(self) -> dict[str, object]:
        """Plain JSON values; offsets count characters."""
        return {
            "line": self.span.line, "column": self.span.column, "start": self.span.start,
            "end": self.span.end, "old": self.span.text, "new": self.new,
        }  # fmt: skip


def patched(text: str, replacements: Sequence[Replacement]) -> str:
    """The text with the replacements made."""
    for change in sorted(replacements, key=lambda r: r.span.start, reverse=True):
        text = text[: change.span.start] + change.new + text[change.span.end :]
    return text


@dataclass(frozen=True, slots=True)
class Step:
    """One knob so many steps on; `replacements` are in the text of the file as it was."""

    knob: Knob
    count: int
    replacements: tuple[Replacement, ...]

    @property
    def cost(self) -> float:
        """How large the change is, from the number of the file as it was; see `Knob.cost`."""
        own = self.replacements[0]
        return self.knob.cost(number_in(own.span.text), float(own.new))

    def words(self) -> str:
        """`deadline of go 3 -> 4 (+1 step), line 12`."""
        knob, own = self.knob, self.replacements[: len(self.knob.spans)]
        line = own[0].span.line
        if knob.of is Of.PARTITION:
            old, new = (
                " x ".join(words)
                for words in zip(*((r.span.text, r.new) for r in own), strict=True)
            )
            return f"{knob.name} {old} -> {new}, line {line}"
        delta = float(own[0].new) - number_in(own[0].span.text)
        unit = _unit_of_change(knob.unit, delta)
        change = f"{delta:+.4g} {unit}".rstrip()
        return f"{knob.name} {own[0].span.text} -> {own[0].new} ({change}), line {line}"


def _unit_of_change(unit: str, delta: float) -> str:
    """Of the difference of two values: levels differ by decibels."""
    if unit == "steps" and abs(delta) == 1:
        return "step"
    return "dB" if unit == "dBm" else unit


def number_in(text: str) -> float:
    """A number of a text, with blanks behind its sign perhaps."""
    return float(text.replace(" ", ""))


@dataclass(frozen=True, slots=True)
class Change:
    """Steps that together give a verified plan; `text` is the whole file then."""

    steps: tuple[Step, ...]
    text: str

    @property
    def replacements(self) -> tuple[Replacement, ...]:
        """The edits, each place once."""
        return edits(self.steps)

    @property
    def words(self) -> tuple[str, ...]:
        """Each step in words."""
        return tuple(step.words() for step in self.steps)

    @property
    def kinds(self) -> tuple[str, ...]:
        """What each step changes."""
        return tuple(step.knob.of.value for step in self.steps)

    @property
    def cost(self) -> float:
        """How large the change is: what its steps cost together."""
        return sum(step.cost for step in self.steps)

    def __str__(self) -> str:
        return "; ".join(self.words)

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "edits": [r.as_dict() for r in self.replacements],
            "says": list(self.words),
            "kinds": list(self.kinds),
            "size": self.cost,
            "verified": True,
        }


def edits(steps: Sequence[Step]) -> tuple[Replacement, ...]:
    """The replacements of steps; of several for one place (a horizon) the largest number."""
    found: dict[Span, Replacement] = {}
    for change in (r for step in steps for r in step.replacements):
        known = found.get(change.span)
        if known is None or float(known.new) < float(change.new):
            found[change.span] = change
    return tuple(sorted(found.values(), key=lambda r: r.span.start))


def traced(span: Span, file: Source, made: Sequence[Replacement]) -> Span:
    """A span of the patched text as one of the file; what was replaced is traced as a whole."""
    return file.span(*(_traced(offset, made) for offset in (span.start, span.end)))


def _traced(offset: int, made: Sequence[Replacement]) -> int:
    """A place outside of what was replaced, or at one of its ends."""
    shift = 0
    for change in sorted(made, key=lambda r: r.span.start):
        start = change.span.start + shift
        if offset <= start:
            break
        if offset <= start + len(change.new):
            return change.span.end
        shift += len(change.new) - (change.span.end - change.span.start)
    return offset - shift
