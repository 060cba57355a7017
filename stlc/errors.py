"""Exceptions that end a command, each with its exit status.

| status | meaning |
|---|---|
| 0 | good |
| 1 | the file has errors |
| 2 | usage (unknown option, file that isn't there) |
| 3 | proven infeasible |
| 4 | no plan within the limits |
| 5 | solver missing or failed, or its answer was refused |
| 6 | `verify`: the plan violates the mission |
| 70 | our own disagreement: encoder and verifier differ |
| 74 | an output could not be written (disk full, no permission, standard output closed) |
| 130 | interrupted before there was a plan, or twice |
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import ClassVar

from stlc.diagnostics import Diagnostic


class StlcError(Exception):
    """Base of every error we raise on purpose; `str(error)` is one clear sentence."""

    exit_status: ClassVar[int] = 1


class MissionError(StlcError):
    """The text has mistakes; all that were found are in `diagnostics`."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(str(d) for d in self.diagnostics))


def hinted(name: str, known: Iterable[str]) -> str:
    """`did you mean 'highs'? known: ..`, or only what is known."""
    from difflib import get_close_matches

    names = list(known)
    near = get_close_matches(name, names, 1)
    hint = f"did you mean '{near[0]}'? " if near else ""
    return f"{hint}known: {', '.join(names)}"


class UsageError(StlcError):
    """The command or call is wrong, not the mission."""

    exit_status = 2


class InfeasibleError(StlcError):
    """Proven: no run satisfies the mission."""

    exit_status = 3


class NoPlanError(StlcError):
    """The limits were reached with no certified plan in hand; no plan is better than `bound`,
    which goes the mission's way."""

    exit_status = 4

    def __init__(self, message: str, bound: float | None = None) -> None:
        self.bound = bound
        super().__init__(message)


class InterruptedSolveError(NoPlanError):
    """Somebody asked to stop before there was a certified plan."""

    exit_status = 130


class SolverError(StlcError):
    """A solver is missing, failed, or gave an answer that certification refused."""

    exit_status = 5


class ViolationError(StlcError):
    """A plan violates its mission."""

    exit_status = 6


class DisagreementError(StlcError):
    """Encoder and verifier disagree: our own bug, always said so."""

    exit_status = 70


class OutputError(StlcError):
    """A file could not be written; nothing that existed was changed."""

    exit_status = 74
