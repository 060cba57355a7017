"""Diagnostics of importing other tools' files: E09xx are errors, W09xx warnings."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic, Warn


class ImportFailure(Exception):
    """Ends the import of one definition; the diagnostic says why."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(str(diagnostic))


class DialectSyntax(Diagnostic):
    """The text doesn't follow the other tool's grammar at this place."""

    code: ClassVar[str] = "E0901"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "{place}"
    help: ClassVar[str] = "{advice}"
    problem: str
    place: str = "here"
    advice: str = ""


class DialectPast(Diagnostic):
    """A past operator: requirements of a mission look from now on into the future.

    Most uses can be turned around: `always (q implies once p)` says what `not q until p` says, and
    `p since q` what `until` says when it is judged at the moment of q.
    """

    code: ClassVar[str] = "E0902"
    title: ClassVar[str] = "`{word}` looks into the past"
    label: ClassVar[str] = "past operator"
    help: ClassVar[str] = "{advice}"
    word: str
    advice: str


class DialectNonlinear(Diagnostic):
    """A predicate must be piecewise linear in the signals.

    Products with constants, `abs`, `min` and `max` are; products of signals, quotients by a
    signal, powers, roots and exponentials of signals are not.
    """

    code: ClassVar[str] = "E0903"
    title: ClassVar[str] = "{what} is not linear"
    label: ClassVar[str] = "nonlinear in the signals"
    help: ClassVar[str] = "record the value as a signal of its own and compare that"
    what: str


class DialectUnsupported(Diagnostic):
    """Something of the other tool's language that has no counterpart here."""

    code: ClassVar[str] = "E0904"
    title: ClassVar[str] = "{what}"
    label: ClassVar[str] = "can't be imported"
    help: ClassVar[str] = "{advice}"
    what: str
    advice: str


class DialectTime(Diagnostic):
    """A time that isn't a whole number of steps, is negative, or an interval that is reversed.

    Times are never rounded. `--step` chooses the step; without it the largest step is taken that
    fits every time of the file and is not longer than a second.
    """

    code: ClassVar[str] = "E0905"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "{place}"
    help: ClassVar[str] = "{advice}"
    problem: str
    place: str = "this time"
    advice: str


class NoMeaning(Diagnostic):
    """The imported formula is refused by the checks that every file here goes through."""

    code: ClassVar[str] = "E0906"
    title: ClassVar[str] = "the imported text has a mistake: {reason}"
    label: ClassVar[str] = "comes from this"
    help: ClassVar[str] = "{advice}"
    reason: str
    advice: str


class NoValue(Warn):
    """A parameter to which the file gives no value.

    Breach takes 0 for it. So does the importer, but for factors and divisors (1), and for the end
    of an interval that would come before its start. The declaration says so in a comment.
    """

    code: ClassVar[str] = "W0901"
    title: ClassVar[str] = "no value for the parameter `{name}`"
    label: ClassVar[str] = "taken as {value}"
    help: ClassVar[str] = "write it into the imported file, or give `-D {name}=..` when using it"
    name: str
    value: str


class NotDefined(Warn):
    """A formula is used that the file doesn't define; its robustness is to be recorded."""

    code: ClassVar[str] = "W0902"
    title: ClassVar[str] = "no definition of the formula `{name}`"
    label: ClassVar[str] = "taken as a signal that is at least 0 where it holds"
    help: ClassVar[str] = "import the file that defines it, or record its robustness"
    name: str


class OddGrouping(Warn):
    """The other tool groups operators in a way that readers don't expect.

    rtamt 0.4 lets + bind tighter than -, and * tighter than /: it reads `a - b + c` as
    `a - (b + c)`. FalCAuN's unary operators bind more loosely than the binary ones: it reads
    `[] p -> q` as `[] (p -> q)`. The import keeps the tool's reading.
    """

    code: ClassVar[str] = "W0903"
    title: ClassVar[str] = "{tool} reads `{whole}` as `{reading}`"
    label: ClassVar[str] = "taken together, as by {tool}"
    help: ClassVar[str] = "write parentheses around what you mean"
    tool: str
    whole: str
    reading: str
