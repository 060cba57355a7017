"""Diagnostics of reading and parsing: E01xx are errors, W01xx warnings."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic, Warn


class SyntaxMistake(Diagnostic):
    """The text doesn't follow the grammar at this place.

    The label says what was found or expected there, and the help how the statement is written.
    """

    code: ClassVar[str] = "E0101"
    title: ClassVar[str] = "{what}"
    label: ClassVar[str] = "{place}"
    help: ClassVar[str] = "{advice}"

    what: str
    place: str
    advice: str = ""


class UnknownCharacter(Diagnostic):
    """A character that has no meaning outside of strings and comments.

    Typical guests are curly quotes and other look-alikes that come with text copied from a
    document, and NUL bytes of a file that isn't text.
    """

    code: ClassVar[str] = "E0102"
    title: ClassVar[str] = "unknown character {shown}"
    label: ClassVar[str] = "this character means nothing here"
    help: ClassVar[str] = "{advice}"

    shown: str
    advice: str = "remove it"


class UnterminatedString(Diagnostic):
    """A string is opened by `"` and must be closed by `"` on the same line."""

    code: ClassVar[str] = "E0103"
    title: ClassVar[str] = "string without an end"
    label: ClassVar[str] = "opened here"
    help: ClassVar[str] = 'close the string with `"` on the same line'


class UnclosedBracket(Diagnostic):
    """A bracket is opened and the statement ends before it is closed.

    The statement ends where the next line starts with a statement keyword and its name.
    """

    code: ClassVar[str] = "E0104"
    title: ClassVar[str] = "`{opened}` is never closed"
    label: ClassVar[str] = "opened here"
    help: ClassVar[str] = "add `{closing}`"

    opened: str
    closing: str


class UnmatchedBracket(Diagnostic):
    """A bracket is closed that was not opened, or was opened by another kind of bracket."""

    code: ClassVar[str] = "E0105"
    title: ClassVar[str] = "`{closing}` closes nothing"
    label: ClassVar[str] = "no open bracket fits"
    help: ClassVar[str] = "{advice}"

    closing: str
    advice: str


class NestingTooDeep(Diagnostic):
    """Brackets, operators in a row and the like may be nested up to a fixed depth.

    The limit is far above what a person writes; it keeps a damaged or generated file from
    exhausting the machine.
    """

    code: ClassVar[str] = "E0106"
    title: ClassVar[str] = "nested too deeply"
    label: ClassVar[str] = "this is more than {limit} levels deep"
    help: ClassVar[str] = "name parts of it with `let`, or use `sum`, `forall` and `exists`"

    limit: int


class PastOperator(Diagnostic):
    """Formulas look forward in time: past operators (once, historically, since, previously) aren't.

    A plan is made from step 0 on, so most past formulas have a future form: `once[a,b] f` at step
    t is `eventually` over the steps t-b to t-a, and `always (q implies once[0,5] p)` mostly means
    that p holds before q, `not q until p`.
    """

    code: ClassVar[str] = "E0108"
    title: ClassVar[str] = "past operator `{word}`"
    label: ClassVar[str] = "formulas speak about now and later only"
    help: ClassVar[str] = "{advice}"

    word: str
    advice: str


class UnknownStatement(Diagnostic):
    """Each statement starts with its keyword at the start of a line.

    The keywords are import, param, signal, step, horizon, margin, workspace, dynamics, agent,
    station, region, obstacle, wall, channel, let, require, prefer, minimize and maximize. A line
    that starts with none of them continues the statement above it.
    """

    code: ClassVar[str] = "E0109"
    title: ClassVar[str] = "no statement starts with `{word}`"
    label: ClassVar[str] = "neither a statement nor a continuation of the line above"
    help: ClassVar[str] = "{advice}"

    word: str
    advice: str


class UnexpectedEnd(Diagnostic):
    """A statement stops before it is complete."""

    code: ClassVar[str] = "E0110"
    title: ClassVar[str] = "{what}"
    label: ClassVar[str] = "{place}"
    help: ClassVar[str] = "{advice}"

    what: str
    place: str
    advice: str = ""


class BadNumber(Diagnostic):
    """A number is followed directly by letters that are no known unit.

    Products need `*`; units are m, s, kg, N, rad, dB, dBm, Hz and their usual multiples, joined
    by `/` and `*` without blanks, with `^` for powers.
    """

    code: ClassVar[str] = "E0111"
    title: ClassVar[str] = "`{text}` is neither a number nor a number with a unit"
    label: ClassVar[str] = "`{tail}` is no unit that is known"
    help: ClassVar[str] = "{advice}"

    text: str
    tail: str
    advice: str


class NotText(Diagnostic):
    """The file isn't UTF-8 text, or it is something else than a mission.

    `.stl` is also the usual ending of three-dimensional meshes (stereolithography), and of STL
    files in other encodings. Missions are UTF-8 text.
    """

    code: ClassVar[str] = "E0112"
    title: ClassVar[str] = "`{name}` is not a mission file: {reason}"
    label: ClassVar[str] = "found here"
    help: ClassVar[str] = "{advice}"

    name: str
    reason: str
    advice: str


class TooLarge(Diagnostic):
    """The file, or one line of it, is larger than any mission a person or a program writes."""

    code: ClassVar[str] = "E0113"
    title: ClassVar[str] = "{what} is too long: {size} characters, at most {limit}"
    label: ClassVar[str] = "starts here"
    help: ClassVar[str] = "data such as samples and polygons can be read from files of their own"

    what: str
    size: int
    limit: int


class TooManyMistakes(Diagnostic):
    """Only the first mistakes are listed; mend them and check again."""

    code: ClassVar[str] = "E0114"
    title: ClassVar[str] = "more mistakes follow; the first {count} are shown"
    label: ClassVar[str] = "the rest of the file was not read"

    count: int


class SingleEquals(Diagnostic):
    """`=` gives a name or a property its value; values are compared by `==`."""

    code: ClassVar[str] = "E0115"
    title: ClassVar[str] = "`=` can't compare values"
    label: ClassVar[str] = "read as an assignment"
    help: ClassVar[str] = "compare with `==`, or better with `<=` and `>=`"


class AmbiguousMix(Warn):
    """Operators stand side by side whose order other STL tools read differently.

    Here the order is, tightest first: arithmetic, comparison, `in` and `outside`; `not`, `always`,
    `eventually`, `next`; `until` and `release` (to the right); `and`; `or`; `implies` (to the
    right); `iff`. So `always x > 0 and y > 0` is `(always x > 0) and y > 0`. Parentheses make it
    plain to every reader.
    """

    code: ClassVar[str] = "W0101"
    title: ClassVar[str] = "{what} without parentheses"
    label: ClassVar[str] = "read as `{reading}`"
    help: ClassVar[str] = "write the parentheses, around `{inner}` or around what you mean"

    what: str
    reading: str
    inner: str
